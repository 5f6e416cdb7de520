"""Ways to refine finite elements: uniform, graded, layered, adaptive, by tolerance, and one's own.

Each sequence of uniform or graded meshes subdivides one base mesh, because observed orders are
accurate only if the meshes of a sequence are similar. All lengths are in punch radii.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from skfem import Element, Mesh, MeshQuad, MeshTri

from ....fem import (
    AxisymmetricElasticity,
    HalfSpace,
    fewest_with_share,
    pressure_space,
    squared_indicators,
)
from ....meshes import FAR_TRUNCATION, Array, SizeField, bisection, truncation
from ....meshes.by_gmsh import graded
from ...crosscheck import (
    GROWTH,
    QUAD_GRADING,
    FemAccuracy,
    Problem,
    Solution,
    fem_sizes,
    half_space_on,
    pole_orders,
    triangle_degree,
)
from ..errors import ENERGY, states
from ..way import Way, inverse, without_order
from . import theories
from .subdivision import subdivided, triangulated
from .wear import wear_on


class Base(NamedTuple):
    """Sizes of a base mesh, which the levels of a way subdivide.

    Parameters
    ----------
    rim_size, ring_size : sizes of the elements at the rim and at ring edges
    growth : growth of the size with the distance from an edge; 0 for elements of one size
    truncation : radius of the mesh
    """

    rim_size: float
    ring_size: float
    growth: float
    truncation: float


EVEN = dict.fromkeys((False, True), Base(1.2, 1.2, 0.0, 5.0))
GRADED = {False: Base(1e-8, 1e-4, 0.7, 20.0), True: Base(1e-8, 1e-4, 1.0, 20.0)}
"""Base meshes of any punch, by whether they become quadrilaterals."""
EVEN_UNDER_ONE_RING = {False: Base(0.35, 0.35, 0.0, 4.0)}
GRADED_TO_RIM = {False: Base(4e-9, 4e-9, 0.7, 1e4)}
"""Base meshes of one ring, on which orders are the most regular."""
SMALLEST_LAYER = 1e-7
"""Size of the smallest layer of quadrilaterals; in smaller ones gradients are roundoff."""
POLES, LAYERED_POLES = (0, 2, 4), tuple(range(0, 16, 2))
"""Orders of the far-field poles: relative energy error 1e-9 at 5 punch radii; and on layers."""
COARSEST_SIZE = 1.2
"""Size of the coarsest adaptive mesh, which is smaller only where a ring edge is a vertex."""
MARKED_SHARE = 0.5
"""Fraction of the sum of the squared indicators in the marked triangles (Dörfler)."""
POLES_RTOL = 1e-12
"""Tolerance for the number of poles if the truncation error has to be negligible."""
FLOOR_OVER_RIM_SIZE, HISTORY_FLOOR = 0.06, 5e-10
"""Lowest relative errors of graded elements: at the start over the size at the rim, and later."""
DIGITS_PER_DEGREE = float(2 * np.log10((1 + QUAD_GRADING**0.5) / (1 - QUAD_GRADING**0.5)))
"""Digits of an energy that each degree on quadrilaterals adds (Bernstein ellipse)."""
DEGREE_ON_OWN_QUADRILATERALS = 2
"""Degree on quadrilaterals of the user, if neither an option nor the scene gives one."""

HALVED = "element size (uniform)"
PARTED = "element size (graded)"
RAISED = "$10^{-k}$, $k$ the degree"
COUNTED = r"1 / $\sqrt{\mathrm{unknowns}}$"
OWN_MESHES = "your meshes"
"""Name of the way through the meshes of the user."""


@dataclass(frozen=True, eq=False)
class Estimated(Solution):
    """A solution on triangles with the error indicator of each triangle.

    Parameters
    ----------
    indicators : (m,) squared indicator of each triangle relative to the energy of the state, the
        greatest over the states. The flat start alone would never refine ring edges
    """

    indicators: Array | None = None


def on_mesh(
    problem: Problem,
    mesh: Mesh,
    degree: int,
    poles: tuple[int, ...],
    element: Element | None = None,
) -> Solution:
    """Return the solution by finite elements of one degree on a mesh.

    Parameters
    ----------
    problem : problem of the case
    mesh : mesh of the half-space, with its boundaries named
    degree : polynomial degree of the displacement along a side
    poles : orders of the poles of the far field
    element : element of scikit-fem or of the user; by default the Lagrange element of the degree
    """
    solid = AxisymmetricElasticity(mesh, degree, problem.ground, element)
    space = pressure_space(solid, problem.merged.ring_edges)
    half_space = HalfSpace(solid, space, poles)
    return wear_on(problem, half_space.compliance(), half_space)


def indicated(problem: Problem, solution: Solution) -> Solution:
    """Return a solution with the error indicators of its triangles, if it has triangles."""
    half_space = solution.half_space
    assert half_space is not None
    if not isinstance(half_space.solid.mesh, MeshTri):
        return solution
    pressures = states(problem, solution)
    assert solution.wear is not None
    energies = np.sum((pressures @ solution.wear.compliance.factor.T) ** 2, axis=1)
    # states before the load rises have no energy
    pressures, energies = pressures[energies > 0], energies[energies > 0]
    squares = squared_indicators(
        half_space.solid, half_space.displacements(pressures), half_space.space, pressures
    )
    relative = squares / energies[:, None]
    return Estimated(
        **vars(solution) | {"errors": {ENERGY: np.sqrt(relative.sum(axis=1).max())}},
        indicators=relative.max(axis=0),
    )


def kind(degree: int, quads: bool) -> str:
    """Return the usual name of an element, such as P2 or Q1."""
    return f"{'Q' if quads else 'P'}{degree}"


@lru_cache(maxsize=16)
def base_mesh(edges: tuple[float, ...], base: Base, quads: bool) -> Mesh:
    """Return triangles of one size, or triangles graded to the rim and to every ring edge.

    Those of one size are smaller only where a ring edge has to be a vertex. Graded triangles that
    are to be divided into quadrilaterals are made by bisection: they are right-angled, so that the
    quadrilaterals are convex.
    """
    rim, ring, growth, radius = base
    field = SizeField(edges, rim, ring, growth, radius, radius if growth else rim)
    return triangulated(field) if growth and not quads else bisection.mesh(field)


def subdivisions(
    base: Base,
    degree: int,
    levels: Sequence[int],
    quads: bool = False,
    element: Element | None = None,
    name: str = "",
) -> Way:
    """Return the way through subdivisions of a base mesh.

    Parameters
    ----------
    base : meshes of one size are halved, a level is the number of halvings; if the base is graded,
        it is the number of parts of each side
    degree : polynomial degree of the displacement
    levels : levels from coarse to fine
    quads : whether the elements are quadrilaterals
    element, name : element of scikit-fem or of the user, in place of the Lagrange element
    """
    graded = base.growth > 0

    def solve(problem: Problem, level: int) -> Solution:
        edges = problem.merged.ring_edges
        coarse = base_mesh(tuple(edges.tolist()), base, quads)
        mesh = subdivided(coarse, level if graded else 2**level, edges, quads, log_polar=graded)
        return on_mesh(problem, mesh, degree, POLES, element)

    label = f"{name or kind(degree, quads)}, {'graded' if graded else 'uniform'}"
    if not graded:
        sizes = HALVED, lambda level: 0.5**level
        return Way(label, "fem", levels, solve, *sizes, theories.FOR_UNIFORM_MESHES)
    floor = FLOOR_OVER_RIM_SIZE * base.rim_size
    theory = theories.for_graded_elements(degree, floor, HISTORY_FLOOR)
    if element:
        theory = without_order(theories.OWN_ELEMENT)
    return Way(label, "fem", levels, solve, PARTED, inverse, theory)


def layered(degrees: Sequence[int], rings: int) -> Way:
    """Return the way through rising degrees on quadrilaterals in geometric layers.

    With each degree the smallest layer shrinks to a tenth. Without ring edges, the number of digits
    gained with each degree is known.

    Parameters
    ----------
    degrees : degrees of the displacement
    rings : number of rings of the punch
    """

    def solve(problem: Problem, level: int) -> Solution:
        edges = problem.merged.ring_edges
        smallest = max(0.1 ** (level + 1), SMALLEST_LAYER if rings > 1 else 0.0)
        mesh = graded(edges, smallest, smallest, QUAD_GRADING, GROWTH, outer=2.5).mesh
        return on_mesh(problem, mesh, level, LAYERED_POLES)

    def size(level: int) -> float:
        return 0.1**level

    theory = theories.for_layers(DIGITS_PER_DEGREE if rings == 1 else np.nan)
    name = "quadrilaterals in layers"
    return Way(name, "fem", degrees, solve, RAISED, size, theory)


def by_tolerance(name: str, tolerances: Sequence[float], settings: Mapping[str, object]) -> Way:
    """Return the way through the meshes that ringwear makes for a tolerance.

    Parameters
    ----------
    name : name of the way
    tolerances : values of rtol, from coarse to fine
    settings : keys of accuracy.fem, such as the mesher; a degree of None is that for triangles
    """

    def solve(problem: Problem, level: float) -> Solution:
        chosen = dict(settings)
        if "degree" in chosen:
            chosen["degree"] = chosen["degree"] or triangle_degree(problem)
        at_level = replace(problem, rtol=level, fem=FemAccuracy.model_validate(chosen))
        half_space = half_space_on(at_level, fem_sizes(at_level))
        return wear_on(problem, half_space.compliance(), half_space)

    return Way(name, "fem", tolerances, solve, COUNTED, largest=0.0)


def raised_degree(degrees: Sequence[int], rtol: float) -> Way:
    """Return the way through rising degrees on the one mesh that ringwear makes for a tolerance."""

    def solve(problem: Problem, level: int) -> Solution:
        settings = FemAccuracy.model_validate({"mesher": "quads"})
        at_rtol = replace(problem, rtol=rtol, fem=settings)
        mesh = fem_sizes(at_rtol).mesh
        return on_mesh(problem, mesh, level, pole_orders(at_rtol, truncation(mesh)))

    return Way("rising degree", "fem", degrees, solve, COUNTED, largest=0.0)


def coarsest(problem: Problem) -> MeshTri:
    """Return the coarsest mesh of halved and of adaptive triangles.

    Its outer boundary is refined once, because the error indicator does not include the difference
    between the nodal values there and the poles that they interpolate.
    """
    edges, size = problem.merged.ring_edges, COARSEST_SIZE
    field = SizeField(tuple(edges.tolist()), size, size, 0.0, FAR_TRUNCATION, size)
    mesh = bisection.mesh(field)
    return bisection.refined(mesh, mesh.f2t[0, mesh.boundaries["far"]], edges)


def halved(halvings: Sequence[int]) -> Way:
    """Return the way through triangles that are all divided into four."""

    def solve(problem: Problem, level: int) -> Solution:
        mesh = coarsest(problem)
        for _halving in range(level):
            mesh = bisection.refined(mesh, np.arange(mesh.nelements), problem.merged.ring_edges)
        return on_mesh(problem, mesh, triangle_degree(problem), poles_without_error(problem, mesh))

    return Way("uniform triangles", "fem", halvings, solve, COUNTED)


def adaptive(levels: Sequence[int]) -> Way:
    """Return the way through triangles that are refined where the error indicator is greatest.

    Each level refines the mesh of the level before, to about 1.15 times the unknowns.
    """

    def solve(problem: Problem, __: int, previous: Solution | None) -> Solution:
        mesh = coarsest(problem)
        if isinstance(previous, Estimated) and previous.half_space is not None:
            assert previous.indicators is not None
            marked = fewest_with_share(previous.indicators, MARKED_SHARE)
            before = previous.half_space.solid.mesh
            mesh = bisection.refined(before, marked, problem.merged.ring_edges)
        poles, degree = poles_without_error(problem, mesh), triangle_degree(problem)
        return indicated(problem, on_mesh(problem, mesh, degree, poles))

    theory = theories.FOR_ADAPTIVE_MESHES
    return Way("adaptive triangles", "fem", levels, solve, COUNTED, None, theory, sequential=True)


def poles_without_error(problem: Problem, mesh: Mesh) -> tuple[int, ...]:
    """Return the orders of so many poles that the truncation error is negligible."""
    return pole_orders(replace(problem, rtol=POLES_RTOL), truncation(mesh))


@dataclass(frozen=True, eq=False)
class OwnMesh:
    """A mesh of the user, which is a level; its text is the name.

    Parameters
    ----------
    name : name of the file, or "mesh 1", "mesh 2", ...
    mesh : the mesh in punch radii
    """

    name: str
    mesh: Mesh

    def __str__(self) -> str:
        """Return the name."""
        return self.name


def own_meshes(
    meshes: Mapping[str, Mesh],
    degree: int | None = None,
    element: Element | None = None,
    name: str = OWN_MESHES,
) -> Way:
    """Return the way through the user's own meshes, from coarse to fine.

    On triangles with Lagrange elements, error indicators are computed.

    Parameters
    ----------
    meshes : the meshes by their names
    degree : polynomial degree; by default that of the scene or of runs
    element : element of scikit-fem or of the user, in place of the Lagrange element
    name : name of the way
    """
    levels = [OwnMesh(name, mesh) for name, mesh in meshes.items()]

    def solve(problem: Problem, level: OwnMesh) -> Solution:
        poles = pole_orders(problem, truncation(level.mesh))
        chosen = degree or degree_on(problem, level.mesh)
        solution = on_mesh(problem, level.mesh, chosen, poles, element)
        return solution if element else indicated(problem, solution)

    return Way(name, "fem", levels, solve, COUNTED, theory=without_order(theories.OWN_MESH))


def degree_on(problem: Problem, mesh: Mesh) -> int:
    """Return the degree of Lagrange elements on a mesh of the user, if no option gives one."""
    if isinstance(mesh, MeshQuad):
        return problem.fem.degree or DEGREE_ON_OWN_QUADRILATERALS
    return triangle_degree(problem)
