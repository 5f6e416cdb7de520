"""What is discretised: ring edges, the radial pressure space, the truncated half-space.

The names below are loaded when they are first used: runs without finite elements load no
scikit-fem. The meshers are `quads.graded`, `triangles.mesh` (both by gmsh) and `bisection.mesh`.
"""

from importlib import import_module
from typing import Any

_FILES = {
    "compliance": "Compliance",
    "contact_cells": "ContactCells fitted_space",
    "errors": "MeshError RingwearError SceneError SolverError",
    "half_space": "areas as_half_space contact_radii quality segments truncation turned",
    "pressure_space": "PressureSpace shape_slopes shapes",
    "radial": "Array Indices alternating_edges graded_breakpoints layer_degrees ring_areas ring_of",
    "sizes": "SizeField",
}
_PLACES = {name: file for file, names in _FILES.items() for name in names.split()}
__all__ = list(_PLACES)


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(import_module(f"{__name__}.{_PLACES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
