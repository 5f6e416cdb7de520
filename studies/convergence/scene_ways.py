"""Ways to refine a scene whose face is in full contact: finite elements, MDR, boundary elements.

Finite elements of degree 1 to 4 on triangles and of degree 1 and 2 on quadrilaterals, on meshes of
one size and on graded ones, each a base mesh that is subdivided: an order is only as clean as its
sequence of meshes. Raised degrees on quadrilaterals in layers. Pressures of MDR and of boundary
elements of each degree, on cells of one size and graded to every edge.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial

import numpy as np
from skfem import Element, Mesh

from ...fem.elasticity import AxisymmetricElasticity
from ...fem.half_space import HalfSpace, pressure_space
from ...mdr import energy, ring_kernel
from ...meshes import bisection
from ...meshes.by_gmsh.quads import graded
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, graded_breakpoints
from ...meshes.sizes import SizeField
from ..methods.base import Discretised
from ..numerics.subdivision import subdivided, triangulated
from ..problem.problem import Problem
from ..progress import Stages
from ..sizes.defaults import GROWTH, QUAD_GRADING
from ..study.levels import Theory
from . import theories
from .flat_start import QUAD_DEGREES, RING_EDGE, ellipses
from .measures import PRESSURE_PART
from .way import Way

Levels = dict[int, tuple[int, ...]]
"""Settings of the levels by degree, from coarse to fine."""
RIM, RING = 1e-8, 1e-4
"""Sizes of the elements of graded base meshes at the rim and at ring edges, in punch radii."""
TRIANGLE_GROWTH, QUADRILATERAL_GROWTH, GRADED_REACH = 0.7, 1.0, 20.0
"""Growth of elements with the distance from an edge, by kind, and truncation of graded meshes."""
UNIFORM_SIZE, UNIFORM_REACH = 1.2, 5.0
"""Greatest size of elements, and truncation, of meshes of one size before they are halved."""
POLES = (0, 2, 4)
"""Orders of the poles on all these meshes: of the energy 1e-9 is left out at 5 radii."""
FLOOR_OF_ELEMENTS = {"d0": 3e-10, "d(t)": 5e-10, "relaxation time": 5e-10}
"""Errors that graded elements do not go below: some parts of the sizes at edges."""
RADIAL_RIM = 1e-13
"""Size of the smallest cell of graded radii, at the rim."""
FLOOR_OF_RADII = {"d0": 1e-13, "d(t)": 2e-10, "relaxation time": 2e-10, "pressure": 1e-7}
"""Errors that graded radii do not go below: roundoff, and what the smallest cells cost."""
SLOW_UNKNOWNS, SLOW_PRESSURES = 1.1e-5, 1.5e-10
"""Seconds per unknown of finite elements, and per cube of the number of pressures."""

UNIFORM_LEVELS: Levels = {1: (2, 3, 4, 5), 2: (1, 2, 3, 4), 3: (1, 2, 3, 4), 4: (0, 1, 2, 3)}
"""Halvings of uniform triangles by degree, of which the last is left out of the quick version."""
GRADED_LEVELS: Levels = {1: (2, 4, 6, 8), 2: (2, 3, 4, 5), 3: (1, 2, 3, 4), 4: (1, 2, 3)}
"""Parts of each side of graded triangles by degree, of which the last is left out then, too."""
QUAD_UNIFORM_LEVELS: Levels = {1: (1, 2, 3, 4), 2: (0, 1, 2, 3)}
QUAD_GRADED_LEVELS: Levels = {1: (1, 2, 3, 4), 2: (1, 2, 3)}
"""The same of quadrilaterals, three of which are in a triangle."""
RADIAL_COUNTS: tuple[int, ...] = (4, 8, 16, 32, 64)
"""Cells of each ring by the radius, of one size."""
RADIAL_GRADINGS: dict[int, tuple[float, ...]] = {
    1: (0.6, 0.7, 0.78, 0.84),
    2: (0.5, 0.6, 0.7, 0.78),
    3: (0.3, 0.4, 0.5, 0.6),
    4: (0.2, 0.3, 0.4, 0.5),
}
"""Ratios of neighbouring sizes of radial meshes graded to every edge, by the pressure's degree."""

HALVED = "element size over the base mesh's, $1/n$"
RATE = r"$(1-\sqrt{q})/(1+\sqrt{q})$, $q$ the ratio of sizes"
BY_DEGREE = "$10^{-k}$, $k$ the degree on quadrilaterals"
CELLS = "1 / cells of each ring"

UNIFORM, GRADED, LAYERED = "uniform meshes", "graded meshes", "layers of rising degree"
RADIAL_UNIFORM, RADIAL_GRADED = "uniform radii", "graded radii"
"""Groups of ways, each drawn in a figure of its own."""


def ways_of_scene(problem: Problem, quick: bool) -> Iterator[Way]:
    """Yield every way to refine a scene in full contact, from coarse to fine."""
    shown = slice(-1 if quick else None)
    for degree, halvings in UNIFORM_LEVELS.items():
        yield uniform_way(problem, degree, False, halvings[shown])
    for degree, halvings in QUAD_UNIFORM_LEVELS.items():
        yield uniform_way(problem, degree, True, halvings[shown])
    for degree, counts in GRADED_LEVELS.items():
        yield graded_way(problem, degree, False, counts[shown])
    for degree, counts in QUAD_GRADED_LEVELS.items():
        yield graded_way(problem, degree, True, counts[shown])
    yield layered_way(problem, range(4, 8) if quick else QUAD_DEGREES)
    for degree in (1, 2):
        yield radial_uniform_way(problem, "mdr", degree, RADIAL_COUNTS[shown])
    yield radial_uniform_way(problem, "bem", 1, RADIAL_COUNTS[shown])
    for degree in (1, 2) if quick else (1, 2, 3, 4):
        yield radial_graded_way(problem, "mdr", degree, RADIAL_GRADINGS[degree][shown])
    yield radial_graded_way(problem, "bem", 1, RADIAL_GRADINGS[1][shown])


@cache
def graded_base(edges: tuple[float, ...], quads: bool) -> Mesh:
    """Return triangles graded to the rim and to every ring edge.

    Those that are divided into quadrilaterals are right-angled, so that these are convex.
    """
    growth, reach = QUADRILATERAL_GROWTH if quads else TRIANGLE_GROWTH, GRADED_REACH
    field = SizeField(edges, RIM, RING, growth, truncation=reach, centre_size=reach)
    return bisection.mesh(field) if quads else triangulated(field)


@cache
def uniform_base(edges: tuple[float, ...]) -> Mesh:
    """Return triangles of one size, smaller only where a ring edge would be no vertex."""
    size = UNIFORM_SIZE
    return bisection.mesh(SizeField(edges, size, size, 0.0, UNIFORM_REACH, size))


def discretised_on(
    problem: Problem,
    make: Callable[[], Mesh],
    degree: int,
    stages: Stages,
    element: Element | None = None,
    poles: tuple[int, ...] | None = None,
) -> Discretised:
    """Return the finite elements of a degree on a mesh, condensed.

    Parameters
    ----------
    problem : whose ring edges and Poisson's ratio they have
    make : returns the mesh
    degree : of the displacement along a side
    stages : tells of the seconds
    element : of scikit-fem or of the user; by default Lagrange's of that degree
    poles : orders of the far field; by default three

    Raises
    ------
    RingwearError
        if the mesh cannot be made, or its stiffness is singular
    """
    rings = problem.merged
    with stages("meshing"):
        mesh = make()
    with stages("condensing"):
        solid = AxisymmetricElasticity(mesh, degree, problem.poisson_ratio, element)
        space = pressure_space(solid, rings.ring_edges, rings.hollow)
        half_space = HalfSpace(solid, space, POLES if poles is None else poles)
        compliance = half_space.compliance()
    return Discretised(compliance, lambda: compliance, half_space.unknowns, half_space=half_space)


def uniform_mesh(edges: Array, quads: bool, halvings: int) -> Mesh:
    """Return elements of one size, halved so many times."""
    base = uniform_base(tuple(edges.tolist()))
    return subdivided(base, 2**halvings, edges, quads, log_polar=False)


def graded_mesh(edges: Array, quads: bool, count: int) -> Mesh:
    """Return graded elements, each side of the base mesh in so many parts."""
    return subdivided(graded_base(tuple(edges.tolist()), quads), count, edges, quads)


def uniform_way(
    problem: Problem,
    degree: int,
    quads: bool,
    halvings: Iterable[int],
    element: Element | None = None,
    name: str = "",
) -> Way:
    """Return finite elements of one size, ever halved."""
    edges = problem.merged.ring_edges

    def discretise(setting: int, stages: Stages) -> Discretised:
        make = partial(uniform_mesh, edges, quads, setting)
        return discretised_on(problem, make, degree, stages, element)

    def work(setting: int) -> float:
        elements = uniform_base(tuple(edges.tolist())).nelements * (3 if quads else 1)
        return seconds_of_elements(elements * 4**setting, degree, quads)

    label = f"FEM {name or ('Q' if quads else 'P') + str(degree)}"
    name, sizes = f"{label}, uniform, scene", {setting: 0.5**setting for setting in halvings}
    theory, parts = theories.of_uniform, (PRESSURE_PART,)
    return Way(name, label, UNIFORM, "fem", sizes, discretise, theory, HALVED, work, parts=parts)


def graded_way(
    problem: Problem,
    degree: int,
    quads: bool,
    counts: Iterable[int],
    element: Element | None = None,
    name: str = "",
) -> Way:
    """Return finite elements graded to every edge, ever subdivided."""
    edges = problem.merged.ring_edges

    def discretise(setting: int, stages: Stages) -> Discretised:
        make = partial(graded_mesh, edges, quads, setting)
        return discretised_on(problem, make, degree, stages, element)

    def work(setting: int) -> float:
        elements = graded_base(tuple(edges.tolist()), quads).nelements * (3 if quads else 1)
        return seconds_of_elements(elements * setting**2, degree, quads)

    def theory(measure: str) -> Theory:
        if element is not None:
            return Theory(reason=theories.OWN_ELEMENT)
        return theories.of_graded_elements(measure, degree, FLOOR_OF_ELEMENTS)

    label = f"FEM {name or ('Q' if quads else 'P') + str(degree)}"
    name, sizes = f"{label}, graded, scene", {setting: 1 / setting for setting in counts}
    return Way(name, label, GRADED, "fem", sizes, discretise, theory, HALVED, work)


def seconds_of_elements(elements: int, degree: int, quads: bool) -> float:
    """Return the seconds that so many elements of a degree are expected to take."""
    unknowns = elements * degree**2 * (2 if quads else 1)
    return 0.05 + SLOW_UNKNOWNS * unknowns * (1 + unknowns / 1e5) ** 0.5


def layered_way(problem: Problem, degrees: Iterable[int]) -> Way:
    """Return quadrilaterals in geometric layers, the smallest a tenth with each degree."""
    edges = problem.merged.ring_edges

    def make(degree: int) -> Mesh:
        smallest = max(0.1 ** (degree + 1), RING_EDGE)
        return graded(edges, smallest, smallest, QUAD_GRADING, GROWTH, outer=2.5).mesh

    def discretise(setting: int, stages: Stages) -> Discretised:
        poles = tuple(range(0, 16, 2))
        return discretised_on(problem, partial(make, setting), setting, stages, poles=poles)

    def theory(measure: str) -> Theory:
        reason = theories.ANALYTIC if measure == "d0" else theories.LAYERS
        return Theory(floor=1e-13, reason=reason, floor_cause=theories.REFERENCE)

    def work(setting: int) -> float:
        return 0.05 + 1e-4 * len(edges) * setting**3.5 / 4

    label, sizes = "FEM quads", {degree: 0.1**degree for degree in degrees}
    name = f"{label}, scene, digits per degree"
    return Way(name, label, LAYERED, "fem", sizes, discretise, theory, BY_DEGREE, work)


def radial_compliance(method: str, space: PressureSpace) -> Discretised:
    """Return the compliance of MDR or of boundary elements on a space."""
    compliance = (ring_kernel if method == "bem" else energy).compliance(space)
    return Discretised(compliance, lambda: compliance)


def radial_space(problem: Problem, breakpoints: Array, degree: int) -> PressureSpace:
    """Return pressures of one degree on a radial mesh, none in a hole."""
    rings = problem.merged
    in_hole = (breakpoints[1:] <= rings.ring_edges[1]) & rings.hollow
    return PressureSpace(breakpoints, np.where(in_hole, 0, degree), rings.ring_edges)


def radial_uniform_way(problem: Problem, method: str, degree: int, counts: Iterable[int]) -> Way:
    """Return cells of one size in each ring, ever halved."""
    edges = problem.merged.ring_edges

    def discretise(setting: int, stages: Stages) -> Discretised:
        fractions = np.arange(setting) / setting
        inside = (edges[:-1, None] + np.diff(edges)[:, None] * fractions).ravel()
        with stages("condensing"):
            space = radial_space(problem, np.append(inside, 1.0), degree)
            return radial_compliance(method, space)

    def work(setting: int) -> float:
        return 0.03 + SLOW_PRESSURES * (setting * len(edges) * degree) ** 3

    label = f"{method.upper()} degree {degree}"
    name, sizes = f"{label}, uniform, scene", {count: 1 / count for count in counts}
    theory = theories.of_uniform
    return Way(name, label, RADIAL_UNIFORM, method, sizes, discretise, theory, CELLS, work)


def radial_graded_way(problem: Problem, method: str, degree: int, gradings: Iterable[float]) -> Way:
    """Return cells graded to every edge, whose neighbours become ever more alike in size."""
    edges = problem.merged.ring_edges

    def discretise(setting: float, stages: Stages) -> Discretised:
        breakpoints = graded_breakpoints(edges, RING_EDGE, RADIAL_RIM, setting)
        with stages("condensing"):
            return radial_compliance(method, radial_space(problem, breakpoints, degree))

    def work(setting: float) -> float:
        cells = 2 * len(edges) * np.log(RING_EDGE) / np.log(setting)
        return 0.03 + SLOW_PRESSURES * (cells * degree) ** 3

    def theory(measure: str) -> Theory:
        return theories.of_graded_pressures(measure, degree, FLOOR_OF_RADII)

    label = f"{method.upper()} degree {degree}"
    name, sizes = f"{label}, graded, scene", ellipses(gradings)
    return Way(name, label, RADIAL_GRADED, method, sizes, discretise, theory, RATE, work)
