"""Sequences of levels given by the user: meshes, elements, and time steps."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from skfem import Element, ElementH1, Mesh, MeshQuad

from ...fem.elements import is_on_quadrilaterals
from ...meshes.half_space import truncation
from ..crosscheck import Discretised, MeshError, Problem, SceneError, Stages
from ..crosscheck.methods.mdr import METHOD as MDR
from ..crosscheck.sizes.defaults import pole_orders
from ..study.levels import Theory
from ..study.options import Options
from ..study.own_mesh import named_meshes, own_mesh
from . import theories
from .contact_kinds import CONTACT_KINDS
from .scene_ways import (
    GRADED_LEVELS,
    QUAD_GRADED_LEVELS,
    QUAD_UNIFORM_LEVELS,
    UNIFORM_LEVELS,
    discretised_on,
    graded_way,
    seconds_of_elements,
    uniform_way,
)
from .way import Way

OWN_MESHES, STEPS = "your meshes", "steps in time"
"""Groups of ways; each group is drawn in one figure."""
MESH_LABEL = r"1 / $\sqrt{\mathrm{number\ of\ elements}}$"
STEP_LABEL = "time step, in the unit of the scene"
LONGEST_STEP_FRACTION = 0.25
"""Longest step, over the earliest time, for which the error there is proportional to the step."""
QUAD_DEGREE, TRIANGLE_DEGREE = 2, 2
"""Default degrees of the displacement on meshes of the user."""


def own_ways(problem: Problem, options: Options) -> Iterator[Way]:
    """Yield the user's sequences, which replace those of the study.

    Raises
    ------
    SceneError
        if a mesh, an element or a step does not fit the scene
    """
    if options.meshes:
        yield from ways_of_meshes(problem, options)
    for element in options.elements if not options.meshes else ():
        degree, quads = degree_of(element, options.degree), is_on_quadrilaterals(element)
        shown_levels, name = slice(-1 if options.quick else None), name_of(element)
        levels = QUAD_UNIFORM_LEVELS if quads else UNIFORM_LEVELS
        halvings = levels[min(degree, max(levels))][shown_levels]
        yield uniform_way(problem, degree, quads, halvings, element, name)
        levels = QUAD_GRADED_LEVELS if quads else GRADED_LEVELS
        counts = levels[min(degree, max(levels))][shown_levels]
        yield graded_way(problem, degree, quads, counts, element, name)
    if options.steps:
        yield way_of_steps(problem, options.steps)


def ways_of_meshes(problem: Problem, options: Options) -> Iterator[Way]:
    """Yield the user's meshes with each of the user's elements, or with Lagrange elements.

    Raises
    ------
    SceneError
        if a mesh is not a mesh of the scene's half-space, or if an element does not fit the meshes
    """
    if refusal := CONTACT_KINDS[problem.full_contact].elements_refusal:
        raise SceneError(refusal)
    meshes = {
        name: mesh_of_option(problem, source)
        for name, source in named_meshes(options.meshes).items()
    }
    on_quads = {isinstance(mesh, MeshQuad) for mesh in meshes.values()}
    if len(on_quads) > 1:
        raise SceneError(
            "--mesh: the meshes of a sequence are all triangles or all quadrilaterals, not both"
        )
    (quads,) = on_quads
    elements: Sequence[Element | None] = options.elements or (None,)
    for element in elements:
        if element is not None and is_on_quadrilaterals(element) != quads:
            kind = "quadrilaterals" if quads else "triangles"
            raise SceneError(f"--element {name_of(element)}: your meshes consist of {kind}")
        degree = options.degree or (QUAD_DEGREE if quads else TRIANGLE_DEGREE)
        label = f"FEM {'Q' if quads else 'P'}{degree}"
        if element is not None:
            degree, label = degree_of(element, options.degree), f"FEM {name_of(element)}"
        yield way_of_meshes(problem, meshes, degree, element, label)


def way_of_meshes(
    problem: Problem, meshes: dict[str, Mesh], degree: int, element: Element | None, label: str
) -> Way:
    """Return the way through the user's meshes, from coarse to fine, with elements of one degree.

    If `element` is None, elements are Lagrange elements of the degree.
    """

    def discretise(setting: str, stages: Stages) -> Discretised:
        mesh = meshes[setting]
        poles = pole_orders(problem, truncation(mesh))
        return discretised_on(problem, lambda: mesh, degree, stages, element, poles)

    def work(setting: str) -> float:
        mesh = meshes[setting]
        return seconds_of_elements(mesh.nelements, degree, isinstance(mesh, MeshQuad))

    sizes = {name: float(mesh.nelements**-0.5) for name, mesh in meshes.items()}
    theory = partial(_without_order, theories.OWN_MESH)
    return Way(
        f"{label}, your meshes",
        label,
        OWN_MESHES,
        "fem",
        sizes,
        discretise,
        theory,
        MESH_LABEL,
        work,
    )


def way_of_steps(problem: Problem, steps: Sequence[float]) -> Way:
    """Return the way through time steps of the implicit march, on an accurate MDR discretisation.

    Raises
    ------
    SceneError
        if the scene has no history or a load that varies, or if a step is not positive
    """
    if not len(problem.times) or min(steps) <= 0 or problem.loading.varies:
        raise SceneError(
            "--steps: give positive steps, and a scene with wear.times under a constant load"
        )
    accurate = replace(problem, rtol=min(problem.rtol, 1e-5))

    def discretise(_: float, stages: Stages) -> Discretised:
        with stages("condensing"):
            compliance = MDR.discretise(accurate, stages).compliance
        return Discretised(compliance, lambda: compliance)

    def problem_at(setting: float) -> Problem:
        return replace(problem, march="implicit", step=setting / problem.units.time)

    short = max(steps) / problem.units.time <= LONGEST_STEP_FRACTION * problem.earliest
    theory = CONTACT_KINDS[problem.full_contact].theory_of_steps(short)
    sizes = {step: step for step in steps}
    name = "MDR, implicit march"
    return Way(
        name, name, STEPS, "mdr", sizes, discretise, theory, STEP_LABEL, problem_at=problem_at
    )


def mesh_of_option(problem: Problem, source: str | Path | Mesh) -> Mesh:
    """Return a mesh of the user: a mesh of scikit-fem, or one read from a file.

    Raises
    ------
    SceneError
        if it is not a mesh of the scene's half-space
    """
    try:
        return own_mesh(problem, source)
    except MeshError as error:
        raise SceneError(f"--mesh {error}") from error


def name_of(element: Element) -> str:
    """Return the name of an element's class, without the prefix "Element"."""
    return type(element).__name__.removeprefix("Element")


def degree_of(element: Element, chosen_degree: int | None) -> int:
    """Return the degree chosen by the user, or else the degree of the element along a side.

    Raises
    ------
    SceneError
        if the element is not continuous, or does not have one function for each vertex
    """
    if not isinstance(element, ElementH1) or element.nodal_dofs != 1:
        raise SceneError(
            f"--element {name_of(element)}: the displacement has to be continuous, with one "
            "function for each vertex: give an element such as ElementTriP2 or ElementQuad2"
        )
    return chosen_degree or 1 + int(element.facet_dofs)


def _without_order(reason: str, _: str) -> Theory:
    return Theory(order=np.nan, reason=reason)
