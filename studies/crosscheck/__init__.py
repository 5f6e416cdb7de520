"""The core: a scene is solved by several methods, and judged.

Rooms, from below: `problem/` and `scene/` (what a user writes, and its problem without
units), `sizes/` of elements, `wear/` (contact and wear), `methods/`, `anchors/` (closed
forms and balances), `verdict/` (agreement, and what is not promised), and `result/` (runs,
and what they give).

The names below are public: the applications in `studies/` import these, as a user's own
script imports them from `ringwear`. Each is loaded at its first use.

A scene, and its result
-----------------------
`Scene`, `Source`
    a scene, and what is accepted as one: a Scene, a name, a file, a table
`run`, `plan`
    compute a scene by its methods; predict sizes and cost of that
`Result`, `load`
    the result of a run, and reading it from the folder that it was saved to
`SceneError`, `MeshError`, `SolverError`, `RingwearError`
    exceptions, and the base of them and of all others

Quantities, and differences of results
--------------------------------------
`QUANTITIES`, `ANSWER`, `FIELDS`
    definitions of histories and states; of the numbers of the answer; names of fields
`error_name`, `SYMBOLS`, `UnitNames`
    the name of an estimate; names of quantities by symbols; names of the units of a scene
`Results`, `differences`
    values by quantity; relative differences of two of these

The problem without units
-------------------------
`Problem`, `Rings`, `InitialProfile`, `Loading`, `Ground`
    a problem, and its parts: rings, unworn face, load over time, elastic layers
`alternating_edges`, `ring_areas`
    edges of rings whose widths alternate; areas of rings

Methods
-------
`METHODS`, `method`
    names of the bundled methods, and the method of a name
`Method`, `ComplianceMethod`, `Discretised`, `Solution`
    a method, one that only computes a compliance, what it discretises, and its solution
`Stages`, `LOG`
    seconds of a method by stage; the logger `ringwear`
`output_folder`
    a folder that has all files of a command, or none

The half-space, contact and wear
--------------------------------
`Array`, `Indices`
    types of arrays of numbers, and of integers
`PressureSpace`, `pressure_spaces`, `ContactCells`
    polynomials that represent pressures; those that resolve a problem; cells of the face
`Compliance`, `energy`, `ring_kernel`, `even_half_space`
    what turns pressures into displacements: by the MDR energy, by boundary elements, by finite
    elements
`direct`, `flat_punch`
    closed forms for pressures constant on each ring; for a flat punch
`HalfSpace`, `AxisymmetricElasticity`
    the half-space by finite elements, and its solid
`SizeField`, `bisection`
    sizes of elements, and meshes without gmsh
`press_flat`, `moments`, `Load`
    a pressed flat punch; integrals of a face; force or depth
`ContactMarch`, `RunningIn`
    wear while contact opens and spreads; wear in full contact
"""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...fem.contact_meshes import even_half_space
    from ...fem.elasticity import AxisymmetricElasticity
    from ...fem.half_space import HalfSpace
    from ...mdr import direct, energy, ring_kernel
    from ...mdr.flat_punch import flat_punch
    from ...meshes import bisection
    from ...meshes.compliance import Compliance
    from ...meshes.contact_cells import ContactCells
    from ...meshes.errors import MeshError, RingwearError, SceneError, SolverError
    from ...meshes.ground.ground import Ground
    from ...meshes.pressure_space import PressureSpace
    from ...meshes.radial import Array, Indices, alternating_edges, ring_areas
    from ...meshes.sizes import SizeField
    from .methods.base import Discretised, Method, Solution, method
    from .methods.pipeline import ComplianceMethod
    from .methods.spaces import pressure_spaces
    from .problem.face import Rings
    from .problem.loading import Loading
    from .problem.norms import Results
    from .problem.problem import Problem
    from .problem.profile import InitialProfile
    from .problem.quantities import (
        ANSWER,
        FIELDS,
        QUANTITIES,
        SYMBOLS,
        differences,
        error_name,
    )
    from .problem.unit_names import UnitNames
    from .progress import LOG, Stages
    from .registry import METHODS
    from .result.output.folder import output_folder
    from .result.predictions.plan import plan
    from .result.results import Result, load, run
    from .scene.scene import Scene, Source
    from .wear.flat_contact import press_flat
    from .wear.full_contact import RunningIn
    from .wear.march import ContactMarch
    from .wear.moments import moments
    from .wear.unilateral import Load

__all__ = [
    "ANSWER",
    "FIELDS",
    "LOG",
    "METHODS",
    "QUANTITIES",
    "SYMBOLS",
    "Array",
    "AxisymmetricElasticity",
    "Compliance",
    "ComplianceMethod",
    "ContactCells",
    "ContactMarch",
    "Discretised",
    "Ground",
    "HalfSpace",
    "Indices",
    "InitialProfile",
    "Load",
    "Loading",
    "MeshError",
    "Method",
    "PressureSpace",
    "Problem",
    "Result",
    "Results",
    "Rings",
    "RingwearError",
    "RunningIn",
    "Scene",
    "SceneError",
    "SizeField",
    "Solution",
    "SolverError",
    "Source",
    "Stages",
    "UnitNames",
    "alternating_edges",
    "bisection",
    "differences",
    "direct",
    "energy",
    "error_name",
    "even_half_space",
    "flat_punch",
    "load",
    "method",
    "moments",
    "output_folder",
    "plan",
    "press_flat",
    "pressure_spaces",
    "ring_areas",
    "ring_kernel",
    "run",
]

# modules of the public names, which are imported at their first use
_LATER = {
    "fem.contact_meshes": ["even_half_space"],
    "fem.elasticity": ["AxisymmetricElasticity"],
    "fem.half_space": ["HalfSpace"],
    "mdr": ["direct", "energy", "ring_kernel"],
    "mdr.flat_punch": ["flat_punch"],
    "meshes": ["bisection"],
    "meshes.compliance": ["Compliance"],
    "meshes.contact_cells": ["ContactCells"],
    "meshes.errors": ["MeshError", "RingwearError", "SceneError", "SolverError"],
    "meshes.ground.ground": ["Ground"],
    "meshes.pressure_space": ["PressureSpace"],
    "meshes.radial": ["Array", "Indices", "alternating_edges", "ring_areas"],
    "meshes.sizes": ["SizeField"],
    "studies.crosscheck.methods.base": ["Discretised", "Method", "Solution", "method"],
    "studies.crosscheck.methods.pipeline": ["ComplianceMethod"],
    "studies.crosscheck.methods.spaces": ["pressure_spaces"],
    "studies.crosscheck.problem.face": ["Rings"],
    "studies.crosscheck.problem.loading": ["Loading"],
    "studies.crosscheck.problem.norms": ["Results"],
    "studies.crosscheck.problem.problem": ["Problem"],
    "studies.crosscheck.problem.profile": ["InitialProfile"],
    "studies.crosscheck.problem.quantities": [
        "ANSWER",
        "FIELDS",
        "QUANTITIES",
        "SYMBOLS",
        "differences",
        "error_name",
    ],
    "studies.crosscheck.problem.unit_names": ["UnitNames"],
    "studies.crosscheck.progress": ["LOG", "Stages"],
    "studies.crosscheck.registry": ["METHODS"],
    "studies.crosscheck.result.output.folder": ["output_folder"],
    "studies.crosscheck.result.predictions.plan": ["plan"],
    "studies.crosscheck.result.results": ["Result", "load", "run"],
    "studies.crosscheck.scene.scene": ["Scene", "Source"],
    "studies.crosscheck.wear.flat_contact": ["press_flat"],
    "studies.crosscheck.wear.full_contact": ["RunningIn"],
    "studies.crosscheck.wear.march": ["ContactMarch"],
    "studies.crosscheck.wear.moments": ["moments"],
    "studies.crosscheck.wear.unilateral": ["Load"],
}
_MODULES = {name: module for module, names in _LATER.items() for name in names}


def __dir__() -> list[str]:
    return __all__


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = f"ringwear.{_MODULES[name]}"
    if module in ("ringwear.mdr", "ringwear.meshes"):
        # the name is that of a module
        return _import_module(f"{module}.{name}")
    return getattr(_import_module(module), name)
