"""Accuracy: which discretisation is how accurate, and what it costs.

Three studies answer it over three axes: `convergence` over the size that theory refers to,
`refinement` over the unknowns of finite elements, and `tradeoff` over the seconds of a run. They
have the same options, and differ in the ways that they select and in the cases.

Theory, for displacements of degree k and pressures of degree q: energies (indentations, relaxation
times) have order 2k on graded meshes. On uniform meshes the singular rim limits their order to 1.
In MDR, the energy norm of a pressure is half an order weaker than the mean square: the start has
order 2q+3, a history, which involves mean squares, has order 2q+2, and the RMS slope of the steady
state has order 2q. `study/ways/theories.py` has the sources.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from ..fem import is_on_quadrilaterals
from ..meshes import SceneError
from ..meshes.by_gmsh import unavailable
from .crosscheck import GROUPS, METHODS, Problem, Scene, Source, method, shown
from .study.declared import Declared, conduct
from .study.errors import DEFAULT, EIGENVALUE, ENERGY, STRESS
from .study.own import (
    Methods,
    Quantities,
    accept,
    degree_of,
    element_name,
    length_of,
    read_elements,
    read_meshes,
    read_methods,
    read_quantities,
    steps_of,
    with_times,
)
from .study.record import Record
from .study.reference import reference
from .study.study import Study
from .study.way import ONE_RING, Case, Way
from .study.ways import runs
from .study.ways.finite_elements import (
    EVEN,
    EVEN_UNDER_ONE_RING,
    GRADED,
    GRADED_TO_RIM,
    adaptive,
    by_tolerance,
    degree_on,
    halved,
    layered,
    own_meshes,
    raised_degree,
    subdivisions,
)
from .study.ways.radial import cells, graded_radii, uniform_radii

if TYPE_CHECKING:
    from skfem import Element, Mesh

Levels = Mapping[int, Sequence[int]]
"""Levels from coarse to fine, by degree."""
HALVINGS: dict[bool, Levels] = {
    False: {1: range(2, 6), 2: range(1, 5), 3: range(1, 5), 4: range(4)},
    True: {1: range(1, 5), 2: range(4)},
}
PARTS: dict[bool, Levels] = {
    False: {1: (2, 4, 6, 8), 2: range(2, 6), 3: range(1, 5), 4: range(1, 4)},
    True: {1: range(1, 5), 2: range(1, 4)},
}
"""Halvings of uniform meshes and parts of each side of graded ones, by quadrilaterals or not."""
HALVINGS_OF_ONE_RING: dict[bool, Levels] = {False: {2: range(1, 5), 3: range(4), 4: range(4)}}
PARTS_OF_ONE_RING: dict[bool, Levels] = {
    False: {2: (3, 4, 6, 8), 3: range(2, 6), 4: range(1, 5)},
}
"""The same for triangles under one ring."""
RADIAL = [("mdr", 1), ("mdr", 2), ("bem", 1)]
"""Methods and degrees of the pressure on uniform cells; boundary elements are graded, too."""
COUNTS: tuple[int, ...] = (4, 8, 16, 32, 64)
"""Numbers of cells along the radius of each ring."""
GRADINGS: dict[int, tuple[float, ...]] = {
    1: (0.6, 0.7, 0.78, 0.84),
    2: (0.5, 0.6, 0.7, 0.78),
    3: (0.3, 0.4, 0.5, 0.6),
    4: (0.2, 0.3, 0.4, 0.5),
}
"""Ratios of neighbouring cell sizes on cells graded to every edge, by pressure degree."""
GRADINGS_OF_ONE_RING: dict[int, tuple[float, ...]] = {
    1: (0.5, 0.6, 0.7, 0.8),
    2: (0.7, 0.78, 0.84, 0.88),
    3: (0.3, 0.4, 0.5, 0.6),
    4: (0.4, 0.5, 0.6, 0.65),
}
"""Ratios of neighbouring cell sizes on cells graded to the rim, by pressure degree."""
OF_RINGS = (EVEN, HALVINGS), (GRADED, PARTS)
OF_ONE_RING = (EVEN_UNDER_ONE_RING, HALVINGS_OF_ONE_RING), (GRADED_TO_RIM, PARTS_OF_ONE_RING)
"""Base meshes with their levels: of one size, and graded."""
CELL_FACTORS, QUICK_CELL_FACTORS = (0.25, 0.5, 1.0, 2.0), (0.125, 0.25, 0.5)
"""Numbers of cells of a moving contact, over the number for rtol 1e-4."""
DEGREES = {False: range(2, 5), True: range(2, 17)}
"""Degrees of the displacement for which stable multipliers exist, by quadrilaterals or not."""
DEGREE_MESH_RTOL = 1e-7
"""Tolerance of the mesh on which the degree is raised."""
TOLERANCES = {
    (True, False): tuple(10.0**-digits for digits in range(1, 9)),
    (True, True): (1e-1, 1e-2, 1e-3),
    # a run at 1e-1 is refined to a tenth of that at most
    (False, False): (1e-1, 1e-2, 3e-3, 1e-3),
    (False, True): (1e-1, 1e-2),
}
"""Tolerances of methods, by whether the punch is in full contact, and whether it is quick."""
ABSCISSAS = ("size", "unknowns", "seconds")
"""Abscissas that a user can choose: the size that theory refers to, and costs."""
BY_TOLERANCE = ("mdr", "bem", "fem")
"""Methods whose sizes follow the tolerance."""
CASES = {
    "d(t), F, relaxation times": frozenset({"indentation", "normal_force", "relaxation_time"}),
    "whole history": GROUPS["history"],
    "p, f, u along the radius": GROUPS["fields"],
    "steady state": GROUPS["steady"],
}
"""Groups of quantities of `tradeoff`; each group is computed by itself."""
REFERENCE, REFERENCE_QUICK, RUNS, QUICK_RUNS = 1e-9, 1e-6, 3, 2
"""Tolerances of the reference, that of a quick `tradeoff`, and how often it solves each level."""


def accuracy(
    scene: Source = "five_rings",
    *,
    study: str = "convergence",
    methods: Methods = None,
    meshes: "Sequence[str | Mesh]" = (),
    degree: int | None = None,
    units: str = "",
    elements: "Sequence[str | Element]" = (),
    steps: Sequence[float] = (),
    quantities: Quantities = None,
    against: str | None = None,
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Tell which discretisation of a scene is how accurate, and at which cost.

    Parameters
    ----------
    scene : a scene, a file, the name of a bundled scene, or nested dictionaries
    study : `convergence`, `refinement` or `tradeoff`
    methods : names of methods, and methods of your own, which are refined by tolerances
    meshes : your own mesh files or meshes of scikit-fem, from coarse to fine
    degree : polynomial degree of the finite elements on them
    units : unit of lengths in mesh files, such as "mm", or a factor on them, such as 0.1, if they
        are not those of the scene
    elements : your own elements, or those of scikit-fem, in place of the study's selection
    steps : time steps of implicit Euler in the unit of the scene, from coarse to fine
    quantities : names as in results.nc, and functions of a result that return a number; the named
        ones are in the answer and the figure
    against : abscissa of the figure: `size`, `unknowns` or `seconds`
    quick : whether to leave out the finest level of each way, and some degrees
    record : rows so far, and the file that they are written to

    Raises
    ------
    SceneError
        if the scene or an option does not fit the study
    RingwearError
        if the reference cannot be computed
    """
    selection, timed = SELECTIONS[study], study == "tradeoff"
    scene = accept(study, scene, study != "refinement", layered=timed)
    axis = against or selection.axis
    if axis not in ABSCISSAS:
        raise SceneError(
            f"against = {shown(axis)} is not an abscissa of the figures: give one of "
            f"{', '.join(ABSCISSAS)}"
        )
    names, functions = read_quantities(quantities, selection.known)
    offered = BY_TOLERANCE if timed and functions else selection.methods
    named, own_methods = read_methods(methods, offered, study)
    for name in named if timed and methods else ():
        if name in METHODS and (reason := method(name).refusal(scene.problem)):
            raise SceneError(reason)
    scene = with_times(scene) if timed else scene
    if degree is not None and not meshes:
        raise SceneError(
            "degree is that of the finite elements on meshes of your own: give --mesh FILE, in "
            "Python meshes=[...], or leave it out"
        )
    refuse_moving_contact(scene, meshes, elements)
    whole, lengths = Case.of(scene), steps_of(scene, steps)
    problem, rtols = whole.problem, TOLERANCES[scene.problem.full_contact, quick]
    own_elements = read_elements(elements) if elements else ()
    by_name = read_meshes(problem, meshes, length_of(scene, units)) if meshes else {}
    own = [
        *(ways_of_meshes(problem, by_name, own_elements, degree) if by_name else []),
        *(ways_of_elements(own_elements, quick) if not meshes else []),
        *([runs.steps("implicit", lengths, problem, 1e-6)] if lengths else []),
        *(runs.tolerances(each, rtols) for each in own_methods),
    ]
    # meshes of a user are compared with ours; other things replace them unless these are named
    bundled = named if methods or not own or study == "refinement" else ()
    wanted = names if names or (timed and functions) else selection.quantities
    if quick and not names and problem.full_contact:
        # they need a second factorisation
        wanted = tuple(name for name in wanted if name != STRESS)
    wanted = (*wanted, EIGENVALUE) if by_name and not names else wanted
    cases = [whole]
    if timed and not quantities:
        cases = list(groups_of(scene))
    elif timed and not functions:
        cases = [Case.of(scene, "your quantities", frozenset(names))]
    elif (
        study == "convergence"
        and not own
        and problem.full_contact
        and len(problem.merged.widths) > 1
    ):
        cases = [whole.with_one_ring(), whole]
    declared = Declared(
        *(study, selection.question, scene, cases),
        ways=lambda case: [*selection.ways(case, bundled, quick), *own],
        quantities=wanted,
        exact=partial(
            reference,
            names=wanted,
            functions=functions,
            rtol=REFERENCE_QUICK if timed and quick else REFERENCE,
            quick=quick,
            confirmed=not quick,
        ),
        axis=axis,
        shown=names,
        functions=functions,
        worst=timed and not quantities,
        runs=(QUICK_RUNS if quick else RUNS) if timed else 1,
    )
    return conduct(declared, record, quick)


def refuse_moving_contact(scene: Scene, meshes: object, elements: object) -> None:
    """Raise an error if a punch whose contact moves has no times, or meshes of its own."""
    if scene.problem.full_contact:
        return
    if not scene.wear.times:
        raise SceneError(
            "the steady state of this punch equals that of a flat punch: give wear.times for a "
            "history, or study a flat punch"
        )
    if meshes or elements:
        raise SceneError(
            "studies accept your own meshes and elements only for flat punches under a force that "
            "never decreases, because other punches need cells that follow the contact; leave the "
            "meshes and elements out"
        )


def groups_of(scene: Scene) -> Iterable[Case]:
    """Yield a case for each group of quantities that the scene has."""
    for name, quantities in CASES.items():
        try:
            case = Case.of(scene, name, quantities)
        except SceneError:  # the scene has none of these quantities
            continue
        # there is no steady state at a fixed indentation
        if not method("mdr").refusal(case.problem):
            yield replace(case, only=quantities)


def ways_of_sizes(case: Case, named: Sequence[str], quick: bool) -> list[Way]:
    """Return every way to refine sizes, each from coarse to fine."""
    if not case.problem.full_contact:
        factors = QUICK_CELL_FACTORS if quick else CELL_FACTORS
        ways = [
            *(cells(name, factors) for name in ("mdr", "bem")),
            *(cells("fem", factors, degree) for degree in (1, 2, 3, 4)),
            *(cells("fem", factors, degree, quads=True) for degree in (1, 2)),
        ]
        return [way for way in ways if way.method in named]
    one, cut = case.name == ONE_RING, slice(-1 if quick else None)
    # elements below one ring have their order from the coarsest meshes on
    element_cut = slice(-2) if quick and one else cut
    meshes, gradings = (OF_ONE_RING, GRADINGS_OF_ONE_RING) if one else (OF_RINGS, GRADINGS)
    graded_radial = [("mdr", degree) for degree in gradings if not quick or degree < 3]
    graded_radial += RADIAL[3 if one else 2 :]
    ways = [
        *(
            subdivisions(bases[quads], k, levels[quads][k][element_cut], quads)
            for bases, levels in meshes
            for quads in bases
            for k in levels[quads]
            # the quick study leaves out some degrees
            if quads or one or not quick or k != 3
        ),
        layered(range(4, 8 if quick and not one else 12), len(case.problem.merged.widths)),
        *(uniform_radii(*radial, COUNTS[cut]) for radial in RADIAL[: 0 if one else 3]),
        *(graded_radii(*radial, gradings[radial[1]][cut]) for radial in graded_radial),
    ]
    return [way for way in ways if way.method in named]


def ways_of_unknowns(_: Case, named: Sequence[str], quick: bool) -> list[Way]:
    """Return every way to refine the mesh of a flat punch, from coarse to fine."""
    rtols = [10.0 ** (-half / 2) for half in range(2, 13, 2 if quick else 1)]
    triangles = {"mesher": "gmsh", "degree": None}
    ways = [
        halved(range(3 if quick else 4)),
        by_tolerance("triangles graded before solving", rtols, triangles),
        adaptive(range(18 if quick else 24)),
    ]
    if not unavailable():  # gmsh makes the layered meshes
        ways.append(by_tolerance("the default: layers and degrees", rtols, {"mesher": "quads"}))
        ways.append(raised_degree(range(4, 8 if quick else 10), DEGREE_MESH_RTOL))
    return ways if named else []


def ways_of_seconds(case: Case, named: Sequence[str], quick: bool) -> Iterator[Way]:
    """Yield the ways of some methods that can compute a case."""
    problem, last = case.problem, slice(-1 if quick else None)
    wanted, rtols = problem.quantities or frozenset(), TOLERANCES[problem.full_contact, quick]
    timed = problem.full_contact and len(problem.times) > 0
    history = timed and wanted <= GROUPS["history"]
    constant = history and not problem.loading.varies
    # naive elements compute the pressure and the indentation; a given indentation has no error
    naive = timed and not problem.ground.layered
    naive = naive and bool(wanted & ({"pressure", problem.response} - {"normal_force"}))

    def accepts(name: str) -> bool:
        return not method(name).refusal(problem)

    for name in BY_TOLERANCE:
        if name in named and accepts(name):
            yield runs.tolerances(method(name), rtols)
    if not wanted:
        return
    if "direct" in named and wanted <= GROUPS["steady"] and accepts("direct"):
        yield runs.closed_form()
    if "mdr implicit" in named and constant:
        yield runs.steps("implicit", (0.1, 0.01, 0.001), problem, 1e-4)
    if "mdr explicit" in named and constant:
        yield runs.explicit_steps((0.9, 0.3, 0.1))
    if "mdr-grid" in named and history and accepts("mdr-grid"):
        yield runs.paper_grid([50, 100, 200, 400][last])
    if "naive" in named and naive:
        yield runs.naive_elements([runs.NaiveSizes(count) for count in [5, 10, 20, 40][last]])


class Selection(NamedTuple):
    """What one of the three studies selects.

    Parameters
    ----------
    question : what it asks
    axis : abscissa of its figure
    methods : names of methods that it has ways for
    quantities : what it measures, if the user names nothing
    known : names of the quantities that it can measure
    ways : function (case, names of methods, quick) -> ways
    """

    question: str
    axis: str
    methods: tuple[str, ...]
    quantities: tuple[str, ...]
    known: tuple[str, ...]
    ways: Callable[[Case, Sequence[str], bool], Iterable[Way]]


OF_MESHES = ("indentation", "pressure", "rms_slope", "steady_rms_slope", "steady_profile", ENERGY)
OF_GROUPS = tuple(sorted(frozenset.union(*CASES.values())))
ALL = (*DEFAULT, STRESS, ENERGY)
ALL_METHODS = (*BY_TOLERANCE, "direct", "mdr implicit", "mdr explicit", "mdr-grid", "naive")
SELECTIONS = {
    "convergence": Selection(
        "which order has each quantity, and is it that of theory?",
        "size",
        BY_TOLERANCE,
        (*DEFAULT, STRESS),
        ALL,
        ways_of_sizes,
    ),
    "refinement": Selection(
        "which mesh needs the fewest unknowns for an accuracy?",
        "unknowns",
        ("fem",),
        OF_MESHES,
        ALL,
        ways_of_unknowns,
    ),
    "tradeoff": Selection(
        "which method needs the fewest seconds for an accuracy?",
        "seconds",
        ALL_METHODS,
        OF_GROUPS,
        OF_GROUPS,
        ways_of_seconds,
    ),
}
"""The three studies of accuracy."""


def ways_of_meshes(
    problem: Problem,
    meshes: "Mapping[str, Mesh]",
    elements: "Sequence[Element]",
    degree: int | None,
) -> list[Way]:
    """Return the user's meshes with each of the user's elements, or with Lagrange elements.

    Raises
    ------
    SceneError
        if meshes are of two kinds, or if an element or a degree does not fit them
    """
    (quads, mesh), *others = {len(mesh.t) == 4: mesh for mesh in meshes.values()}.items()
    if others:
        raise SceneError(
            "--mesh: the meshes of a sequence are all triangles or all quadrilaterals, not both"
        )
    kind, degrees = "quadrilaterals" if quads else "triangles", DEGREES[quads]
    chosen = degree or degree_on(problem, mesh)
    if not elements and chosen not in degrees:
        raise SceneError(
            f"--degree {chosen}: does not fit your meshes of {kind}: give {degrees[0]} to "
            f"{degrees[-1]}"
        )
    ways = list[Way]()
    for element in elements:
        name = element_name(element)
        if is_on_quadrilaterals(element) != quads:
            raise SceneError(f"--element {name}: your meshes consist of {kind}")
        label = f"your meshes, {name}"
        ways.append(own_meshes(meshes, degree or degree_of(element), element, label))
    return ways or [own_meshes(meshes, degree)]


def ways_of_elements(elements: "Sequence[Element]", quick: bool) -> list[Way]:
    """Return uniform and graded meshes with each of the user's elements."""
    ways, cut = list[Way](), slice(-1 if quick else None)
    for element in elements:
        order, quads = degree_of(element), is_on_quadrilaterals(element)
        for bases, levels in OF_RINGS:
            chosen = levels[quads][min(order, max(levels[quads]))][cut]
            name = element_name(element)
            ways.append(subdivisions(bases[quads], order, chosen, quads, element, name))
    return ways
