"""Ways to refine the cells of the contact face: MDR and boundary elements of one degree.

In full contact, cells are uniform on each ring or graded to every edge. In moving contact,
pressures are linear on cells that follow the contact, and finite elements can lie below the cells.
Higher degrees of the pressure are left out there, because the sign of the pressure is enforced only
at nodes and a contact edge inside an element makes them inaccurate.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....fem import (
    TRIANGLE_GROWTH,
    AxisymmetricElasticity,
    HalfSpace,
    enough_poles,
    even_half_space,
    pressure_space,
)
from ....mdr import energy, ring_kernel
from ....meshes import (
    Array,
    Compliance,
    ContactCells,
    PressureSpace,
    SizeField,
    bisection,
    graded_breakpoints,
)
from ...crosscheck import Problem, Solution, scaled_cells, with_rtol
from ..way import Way, inverse, without_order
from . import theories
from .subdivision import subdivided
from .wear import wear_on

RIM_SIZE, RING_SIZE = 1e-13, 1e-7
"""Sizes of the smallest cells of graded meshes, at the rim and at ring edges, in punch radii."""
CELLS_RTOL = 1e-4
"""Tolerance to which the numbers of cells refer, and by which steps in time are chosen."""
TRUNCATION, NEGLIGIBLE_ENERGY = 5.0, 1e-10
"""Truncation radius of quadrilaterals in punch radii; relative energy error of the far field."""
COUNTED = "1 / cells on each ring"
RATE = r"$(1-\sqrt{q})/(1+\sqrt{q})$ (graded)"
SCALED = "cell size / that at rtol 1e-4"


def compliance_on(method: str, space: PressureSpace, problem: Problem) -> Compliance:
    """Return the compliance of MDR or of boundary elements on a pressure space."""
    return (ring_kernel if method == "bem" else energy).compliance(space, problem.ground)


def on_radii(problem: Problem, method: str, breakpoints: Array, degree: int) -> Solution:
    """Return the solution with pressures of one degree on cells."""
    degrees = np.full(len(breakpoints) - 1, degree)
    space = PressureSpace(breakpoints, degrees, problem.merged.ring_edges)
    return wear_on(problem, compliance_on(method, space, problem))


def uniform_radii(method: str, degree: int, counts: Sequence[int]) -> Way:
    """Return the way through equal cells on each ring."""

    def solve(problem: Problem, level: int) -> Solution:
        edges = problem.merged.ring_edges
        inside = (edges[:-1, None] + np.diff(edges)[:, None] * np.arange(level) / level).ravel()
        return on_radii(problem, method, np.append(inside, 1.0), degree)

    name = f"{method.upper()} degree {degree}, uniform"
    return Way(name, method, counts, solve, COUNTED, inverse, theories.FOR_UNIFORM_MESHES)


def graded_radii(method: str, degree: int, gradings: Sequence[float]) -> Way:
    """Return the way through cells graded to every edge, whose ratio of sizes approaches 1.

    With each degree, the error of a polynomial on a cell is multiplied by (1 - q) / (1 + q), q the
    square root of the ratio (Bernstein ellipse); this is the size of a level.
    """

    def solve(problem: Problem, level: float) -> Solution:
        edges = problem.merged.ring_edges
        sizes = np.append(np.full(np.count_nonzero(edges) - 1, RING_SIZE), RIM_SIZE)
        radii, _low_parts = graded_breakpoints(edges, sizes, level)
        return on_radii(problem, method, radii, degree)

    def size(level: float) -> float:
        return float((1 - level**0.5) / (1 + level**0.5))

    theory = theories.for_graded_pressures(degree)
    return Way(
        f"{method.upper()} degree {degree}, graded", method, gradings, solve, RATE, size, theory
    )


def cells(method: str, factors: Sequence[float], degree: int = 0, quads: bool = False) -> Way:
    """Return the way through cells of a moving contact, or through finite elements below them.

    Parameters
    ----------
    method : `mdr`, `bem` or `fem`
    factors : numbers of cells over the number for rtol 1e-4
    degree, quads : of the finite elements
    """

    def solve(problem: Problem, level: float) -> Solution:
        # the same object for all levels, which share the search for the first contact
        problem = with_rtol(problem, CELLS_RTOL)
        at_level = scaled_cells(problem, level)
        if method != "fem":
            return wear_on(problem, compliance_on(method, at_level.space(), problem))
        half_space = elements_on(problem, at_level, level, degree, quads)
        return wear_on(problem, half_space.compliance(), half_space)

    theory = without_order(theories.MOVING_EDGES)
    name = f"{'Q' if quads else 'P'}{degree} below cells" if method == "fem" else method.upper()
    return Way(name, method, factors, solve, SCALED, inverse, theory)


def elements_on(
    problem: Problem, at_level: ContactCells, factor: float, degree: int, quads: bool
) -> HalfSpace:
    """Return finite elements whose facets on the contact are no larger than the cells.

    Each quadrilateral mesh is made from triangles: a triangle becomes three quadrilaterals, and
    each of its facets two facets. These triangles are therefore made for cells twice as large.

    Parameters
    ----------
    problem : problem with its ring edges and Poisson's ratio
    at_level : cells of the contact
    factor : number of cells over the number for rtol 1e-4
    degree : polynomial degree of the displacement
    quads : whether the elements are quadrilaterals, not triangles
    """
    if not quads:
        half_space = even_half_space(at_level, problem.ground, degree=degree)
    else:
        larger = scaled_cells(problem, factor / 2)
        edges, size = larger.ring_edges, larger.edge_size
        field = SizeField(
            edges, size, size, TRIANGLE_GROWTH, TRUNCATION, larger.largest, 0.125, larger
        )
        mesh = subdivided(
            bisection.mesh(field), 1, np.array(edges), into_quads=True, log_polar=False
        )
        solid = AxisymmetricElasticity(mesh, degree, problem.ground)
        space = pressure_space(solid, np.array(edges))
        linear = replace(space, degrees=np.minimum(space.degrees, 1))
        half_space = HalfSpace(solid, linear, enough_poles(TRUNCATION, NEGLIGIBLE_ENERGY))
    if degree == 1:
        # linear pressures on single facets, discontinuous at ring edges, would outnumber the nodes
        # on the contact, and so be unstable
        half_space = replace(half_space, space=half_space.space.coarser())
    return half_space
