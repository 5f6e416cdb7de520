"""Ways to refine a scene whose face is in full contact: finite elements, MDR, boundary elements.

Finite elements have degree 1 to 4 on triangles, and degree 1 and 2 on quadrilaterals, on uniform
and on graded meshes. Each sequence of meshes subdivides one base mesh, because observed orders are
accurate only if the meshes of a sequence are similar. On quadrilaterals in layers, the degree is
raised. Pressures of MDR and of boundary elements have each degree on uniform radial cells and on
radial cells graded to every edge.
"""

from collections.abc import Callable, Iterable, Iterator
from functools import cache, partial

import numpy as np
from skfem import Element, Mesh

from ...fem.half_space import pressure_space
from ...meshes.by_gmsh.quads import graded
from ...meshes.radial import graded_breakpoints
from ..crosscheck import (
    Array,
    AxisymmetricElasticity,
    Discretised,
    HalfSpace,
    PressureSpace,
    Problem,
    SizeField,
    Stages,
    bisection,
    energy,
    ring_kernel,
)
from ..crosscheck.sizes.defaults import GROWTH, QUAD_GRADING
from ..numerics.subdivision import subdivided, triangulated
from ..study.levels import Theory
from . import theories
from .flat_start import QUAD_DEGREES, RING_EDGE_SIZE, convergence_rates
from .measures import PRESSURE_PART
from .way import Way

Levels = dict[int, tuple[int, ...]]
"""Settings of the levels, from coarse to fine, by degree."""
GRADED_RIM_SIZE, GRADED_RING_SIZE = 1e-8, 1e-4
"""Sizes of the elements of graded base meshes at the rim and at ring edges, in punch radii."""
TRIANGLE_GROWTH, QUADRILATERAL_GROWTH, GRADED_TRUNCATION = 0.7, 1.0, 20.0
"""Growth of the element size with the distance from an edge; truncation radius of graded meshes."""
UNIFORM_SIZE, UNIFORM_TRUNCATION = 1.2, 5.0
"""Greatest element size of uniform base meshes, and their truncation radius, in punch radii."""
POLES = (0, 2, 4)
"""Orders of the far-field poles on these meshes: relative energy error 1e-9 at 5 punch radii."""
ELEMENT_FLOORS = {"d0": 3e-10, "d(t)": 5e-10, "relaxation time": 5e-10}
"""Lowest relative errors of graded elements, which are fractions of the sizes at the edges."""
RADIAL_RIM_SIZE = 1e-13
"""Size of the smallest cell of graded radial meshes, at the rim, in punch radii."""
RADIAL_FLOORS = {"d0": 1e-13, "d(t)": 2e-10, "relaxation time": 2e-10, "pressure": 1e-7}
"""Lowest relative errors of graded radial meshes, due to roundoff and the smallest cells."""
SECONDS_PER_UNKNOWN, SECONDS_PER_PRESSURE_CUBED = 1.1e-5, 1.5e-10
"""Seconds for each unknown of finite elements, and over the cube of the number of pressures."""

UNIFORM_LEVELS: Levels = {1: (2, 3, 4, 5), 2: (1, 2, 3, 4), 3: (1, 2, 3, 4), 4: (0, 1, 2, 3)}
"""Halvings of uniform triangles by degree. The quick version leaves out the last of each."""
GRADED_LEVELS: Levels = {1: (2, 4, 6, 8), 2: (2, 3, 4, 5), 3: (1, 2, 3, 4), 4: (1, 2, 3)}
"""Parts of each side of graded triangles by degree. The quick version leaves out the last."""
QUAD_UNIFORM_LEVELS: Levels = {1: (1, 2, 3, 4), 2: (0, 1, 2, 3)}
QUAD_GRADED_LEVELS: Levels = {1: (1, 2, 3, 4), 2: (1, 2, 3)}
"""The same for quadrilaterals; each triangle contains three of them."""
RADIAL_COUNTS: tuple[int, ...] = (4, 8, 16, 32, 64)
"""Numbers of cells along the radius of each ring, on uniform radial meshes."""
RADIAL_GRADINGS: dict[int, tuple[float, ...]] = {
    1: (0.6, 0.7, 0.78, 0.84),
    2: (0.5, 0.6, 0.7, 0.78),
    3: (0.3, 0.4, 0.5, 0.6),
    4: (0.2, 0.3, 0.4, 0.5),
}
"""Ratios of neighbouring cell sizes on radial meshes graded to every edge, by pressure degree."""

ELEMENT_SIZE_LABEL = "element size over that of the base mesh, $1/n$"
RATE_LABEL = r"$(1-\sqrt{q})/(1+\sqrt{q})$, $q$ the ratio of sizes"
DEGREE_LABEL = "$10^{-k}$, $k$ the degree on quadrilaterals"
CELL_COUNT_LABEL = "1 / number of cells of each ring"

UNIFORM, GRADED, LAYERED = "uniform meshes", "graded meshes", "layers of rising degree"
RADIAL_UNIFORM, RADIAL_GRADED = "uniform radii", "graded radii"
"""Groups of ways; each group is drawn in one figure."""


def ways_of_scene(problem: Problem, quick: bool) -> Iterator[Way]:
    """Yield all ways to refine a scene in full contact, each from coarse to fine."""
    shown_levels = slice(-1 if quick else None)
    for degree, halvings in UNIFORM_LEVELS.items():
        yield uniform_way(problem, degree, False, halvings[shown_levels])
    for degree, halvings in QUAD_UNIFORM_LEVELS.items():
        yield uniform_way(problem, degree, True, halvings[shown_levels])
    for degree, counts in GRADED_LEVELS.items():
        yield graded_way(problem, degree, False, counts[shown_levels])
    for degree, counts in QUAD_GRADED_LEVELS.items():
        yield graded_way(problem, degree, True, counts[shown_levels])
    yield layered_way(problem, range(4, 8) if quick else QUAD_DEGREES)
    for degree in (1, 2):
        yield radial_uniform_way(problem, "mdr", degree, RADIAL_COUNTS[shown_levels])
    yield radial_uniform_way(problem, "bem", 1, RADIAL_COUNTS[shown_levels])
    for degree in (1, 2) if quick else (1, 2, 3, 4):
        yield radial_graded_way(problem, "mdr", degree, RADIAL_GRADINGS[degree][shown_levels])
    yield radial_graded_way(problem, "bem", 1, RADIAL_GRADINGS[1][shown_levels])


@cache
def graded_base(edges: tuple[float, ...], quads: bool) -> Mesh:
    """Return triangles graded to the rim and to every ring edge.

    Triangles that are to be divided into quadrilaterals are made by bisection: they are
    right-angled, so that the quadrilaterals are convex.
    """
    growth, radius = QUADRILATERAL_GROWTH if quads else TRIANGLE_GROWTH, GRADED_TRUNCATION
    field = SizeField(
        edges, GRADED_RIM_SIZE, GRADED_RING_SIZE, growth, truncation=radius, centre_size=radius
    )
    return bisection.mesh(field) if quads else triangulated(field)


@cache
def uniform_base(edges: tuple[float, ...]) -> Mesh:
    """Return triangles of one size, which are smaller only where a ring edge has to be a vertex."""
    size = UNIFORM_SIZE
    return bisection.mesh(SizeField(edges, size, size, 0.0, UNIFORM_TRUNCATION, size))


def discretised_on(
    problem: Problem,
    make_mesh: Callable[[], Mesh],
    degree: int,
    stages: Stages,
    element: Element | None = None,
    poles: tuple[int, ...] | None = None,
) -> Discretised:
    """Return condensed finite elements of one degree on a mesh.

    Parameters
    ----------
    problem : problem with the ring edges and Poisson's ratio
    make_mesh : function that returns the mesh
    degree : polynomial degree of the displacement along a side
    stages : timer of the stages
    element : element of scikit-fem or of the user; by default the Lagrange element of the degree
    poles : orders of the poles of the far field; by default `POLES`

    Raises
    ------
    RingwearError
        if the mesh cannot be made, or its stiffness is singular
    """
    rings = problem.merged
    with stages("meshing"):
        mesh = make_mesh()
    with stages("condensing"):
        solid = AxisymmetricElasticity(mesh, degree, problem.ground, element)
        space = pressure_space(solid, rings.ring_edges)
        half_space = HalfSpace(solid, space, POLES if poles is None else poles)
        compliance = half_space.compliance()
    return Discretised(compliance, lambda: compliance, half_space.unknowns, half_space=half_space)


def uniform_mesh(edges: Array, quads: bool, halvings: int) -> Mesh:
    """Return the uniform base mesh, as triangles or quadrilaterals, after a number of halvings."""
    base = uniform_base(tuple(edges.tolist()))
    return subdivided(base, 2**halvings, edges, quads, log_polar=False)


def graded_mesh(edges: Array, quads: bool, count: int) -> Mesh:
    """Return the graded base mesh with each side divided into `count` parts."""
    return subdivided(graded_base(tuple(edges.tolist()), quads), count, edges, quads)


def uniform_way(
    problem: Problem,
    degree: int,
    quads: bool,
    halvings: Iterable[int],
    element: Element | None = None,
    name: str = "",
) -> Way:
    """Return the way through uniform meshes of finite elements, halved from level to level."""
    edges = problem.merged.ring_edges

    def discretise(setting: int, stages: Stages) -> Discretised:
        make_mesh = partial(uniform_mesh, edges, quads, setting)
        return discretised_on(problem, make_mesh, degree, stages, element)

    def work(setting: int) -> float:
        elements = uniform_base(tuple(edges.tolist())).nelements * (3 if quads else 1)
        return seconds_of_elements(elements * 4**setting, degree, quads)

    label = f"FEM {name or ('Q' if quads else 'P') + str(degree)}"
    name, sizes = f"{label}, uniform, scene", {setting: 0.5**setting for setting in halvings}
    theory, error_parts = theories.for_uniform_meshes, (PRESSURE_PART,)
    return Way(
        name,
        label,
        UNIFORM,
        "fem",
        sizes,
        discretise,
        theory,
        ELEMENT_SIZE_LABEL,
        work,
        error_parts=error_parts,
    )


def graded_way(
    problem: Problem,
    degree: int,
    quads: bool,
    counts: Iterable[int],
    element: Element | None = None,
    name: str = "",
) -> Way:
    """Return the way through subdivisions of a mesh of finite elements graded to every edge."""
    edges = problem.merged.ring_edges

    def discretise(setting: int, stages: Stages) -> Discretised:
        make_mesh = partial(graded_mesh, edges, quads, setting)
        return discretised_on(problem, make_mesh, degree, stages, element)

    def work(setting: int) -> float:
        elements = graded_base(tuple(edges.tolist()), quads).nelements * (3 if quads else 1)
        return seconds_of_elements(elements * setting**2, degree, quads)

    def theory(measure: str) -> Theory:
        if element is not None:
            return Theory(reason=theories.OWN_ELEMENT)
        return theories.for_graded_elements(measure, degree, ELEMENT_FLOORS)

    label = f"FEM {name or ('Q' if quads else 'P') + str(degree)}"
    name, sizes = f"{label}, graded, scene", {setting: 1 / setting for setting in counts}
    return Way(name, label, GRADED, "fem", sizes, discretise, theory, ELEMENT_SIZE_LABEL, work)


def seconds_of_elements(elements: int, degree: int, quads: bool) -> float:
    """Return the expected seconds of a level with a number of elements of one degree."""
    unknowns = elements * degree**2 * (2 if quads else 1)
    return 0.05 + SECONDS_PER_UNKNOWN * unknowns * (1 + unknowns / 1e5) ** 0.5


def layered_way(problem: Problem, degrees: Iterable[int]) -> Way:
    """Return the way through rising degrees on quadrilaterals in geometric layers.

    With each degree the smallest layer shrinks to a tenth.
    """
    edges = problem.merged.ring_edges

    def make_mesh(degree: int) -> Mesh:
        smallest = max(0.1 ** (degree + 1), RING_EDGE_SIZE)
        return graded(edges, smallest, smallest, QUAD_GRADING, GROWTH, outer=2.5).mesh

    def discretise(setting: int, stages: Stages) -> Discretised:
        poles = tuple(range(0, 16, 2))
        return discretised_on(problem, partial(make_mesh, setting), setting, stages, poles=poles)

    def theory(measure: str) -> Theory:
        reason = theories.ANALYTIC if measure == "d0" else theories.LAYERS
        return Theory(floor=1e-13, reason=reason, floor_cause=theories.REFERENCE)

    def work(setting: int) -> float:
        return 0.05 + 1e-4 * len(edges) * setting**3.5 / 4

    label, sizes = "FEM quads", {degree: 0.1**degree for degree in degrees}
    name = f"{label}, scene, digits per degree"
    return Way(name, label, LAYERED, "fem", sizes, discretise, theory, DEGREE_LABEL, work)


def radial_compliance(method: str, space: PressureSpace) -> Discretised:
    """Return the compliance of MDR or of boundary elements on a pressure space."""
    compliance = (ring_kernel if method == "bem" else energy).compliance(space)
    return Discretised(compliance, lambda: compliance)


def radial_space(problem: Problem, breakpoints: Array, degree: int) -> PressureSpace:
    """Return pressures of one degree on a radial mesh."""
    degrees = np.full(len(breakpoints) - 1, degree)
    return PressureSpace(breakpoints, degrees, problem.merged.ring_edges)


def radial_uniform_way(problem: Problem, method: str, degree: int, counts: Iterable[int]) -> Way:
    """Return the way through uniform cells in each ring, halved from level to level."""
    edges = problem.merged.ring_edges

    def discretise(setting: int, stages: Stages) -> Discretised:
        fractions = np.arange(setting) / setting
        inside = (edges[:-1, None] + np.diff(edges)[:, None] * fractions).ravel()
        with stages("condensing"):
            space = radial_space(problem, np.append(inside, 1.0), degree)
            return radial_compliance(method, space)

    def work(setting: int) -> float:
        return 0.03 + SECONDS_PER_PRESSURE_CUBED * (setting * len(edges) * degree) ** 3

    label = f"{method.upper()} degree {degree}"
    name, sizes = f"{label}, uniform, scene", {count: 1 / count for count in counts}
    theory = theories.for_uniform_meshes
    return Way(
        name, label, RADIAL_UNIFORM, method, sizes, discretise, theory, CELL_COUNT_LABEL, work
    )


def radial_graded_way(problem: Problem, method: str, degree: int, gradings: Iterable[float]) -> Way:
    """Return the way through meshes of cells graded to every edge, with gradings closer to 1."""
    edges = problem.merged.ring_edges

    def discretise(setting: float, stages: Stages) -> Discretised:
        breakpoints = graded_breakpoints(edges, RING_EDGE_SIZE, RADIAL_RIM_SIZE, setting)
        with stages("condensing"):
            return radial_compliance(method, radial_space(problem, breakpoints, degree))

    def work(setting: float) -> float:
        cells = 2 * len(edges) * np.log(RING_EDGE_SIZE) / np.log(setting)
        return 0.03 + SECONDS_PER_PRESSURE_CUBED * (cells * degree) ** 3

    def theory(measure: str) -> Theory:
        return theories.for_graded_pressures(measure, degree, RADIAL_FLOORS)

    label = f"{method.upper()} degree {degree}"
    name, sizes = f"{label}, graded, scene", convergence_rates(gradings)
    return Way(name, label, RADIAL_GRADED, method, sizes, discretise, theory, RATE_LABEL, work)
