"""Convergence: the order of every quantity of a scene for every way to refine, and its theory.

Theory, for displacements of degree k and pressures of degree q: energies (indentations, relaxation
times) have order 2k on graded meshes. On uniform meshes the singular rim limits their order to 1.
In MDR, the energy norm of a pressure is half an order weaker than the mean square: the start has
order 2q+3, a history, which involves mean squares, has order 2q+2, and the RMS slope of the steady
state has order 2q. `study/ways/theories.py` has the sources.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ..fem import is_on_quadrilaterals
from ..meshes import SceneError
from .crosscheck import Problem, Source
from .study.accept import accept, refuse_abscissa, refuse_degree_without_mesh, steps_of
from .study.draw import draw, titled
from .study.errors import BY_PRESSURES, DEFAULT, ENERGY, STRESS
from .study.extrapolation import order_of_errors
from .study.measure import measure
from .study.own import (
    Methods,
    Quantities,
    degree_of,
    length_of,
    name_of,
    read_elements,
    read_meshes,
    read_methods,
    read_quantities,
)
from .study.record import Record
from .study.reference import Reference, reference
from .study.study import Study, remarks
from .study.theory import conclude_orders, observed_orders
from .study.way import ONE_RING, START, Case, Way
from .study.ways import finite_elements, radial, runs
from .study.ways.finite_elements import (
    EVEN_UNDER_ONE_RING,
    GRADED_TO_RIM,
    graded_to_edges,
    layered,
    own_meshes,
    uniform,
)
from .study.ways.radial import cells, graded_radii, uniform_radii
from .study.ways.runs import steps as time_steps, tolerances

if TYPE_CHECKING:
    from skfem import Element, Mesh

Levels = dict[int, tuple[int, ...]]
"""Levels from coarse to fine, by degree."""
HALVINGS: Levels = {1: (2, 3, 4, 5), 2: (1, 2, 3, 4), 3: (1, 2, 3, 4), 4: (0, 1, 2, 3)}
PARTS: Levels = {1: (2, 4, 6, 8), 2: (2, 3, 4, 5), 3: (1, 2, 3, 4), 4: (1, 2, 3)}
"""Halvings of uniform triangles, and parts of each side of graded ones, by degree."""
QUICK_WITHOUT = 3
"""Degree of triangles that the quick study leaves out for several rings."""
QUAD_HALVINGS: Levels = {1: (1, 2, 3, 4), 2: (0, 1, 2, 3)}
QUAD_PARTS: Levels = {1: (1, 2, 3, 4), 2: (1, 2, 3)}
"""The same for quadrilaterals; each triangle contains three of them."""
PARTS_OF_ONE_RING: Levels = {2: (3, 4, 6, 8), 3: (2, 3, 4, 5), 4: (1, 2, 3, 4)}
HALVINGS_OF_ONE_RING: Levels = {2: (1, 2, 3, 4), 3: (0, 1, 2, 3), 4: (0, 1, 2, 3)}
"""The same for triangles under one ring."""
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
CELL_FACTORS, QUICK_CELL_FACTORS = (0.25, 0.5, 1.0, 2.0), (0.125, 0.25, 0.5)
"""Numbers of cells of a moving contact, over the number for rtol 1e-4."""
TOLERANCES, QUICK_TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5), (1e-1, 1e-2, 1e-3)
"""Tolerances of methods of the user."""
METHODS = ("mdr", "bem", "fem")
"""Methods that have levels of sizes."""
NOT_IN_MOVING_CONTACT = (
    "study convergence accepts your own meshes and elements only for flat punches under a "
    "force that never decreases, because other punches need cells that follow the contact; "
    "leave the meshes and elements out"
)


def convergence(
    scene: Source = "five_rings",
    *,
    methods: Methods = None,
    meshes: "Sequence[str | Mesh]" = (),
    degree: int | None = None,
    units: str = "",
    elements: "Sequence[str | Element]" = (),
    steps: Sequence[float] = (),
    quantities: Quantities = None,
    against: str = "size",
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Refine a scene in every way, fit the order of every quantity, and compare it with theory.

    Parameters
    ----------
    scene : a scene, a file, the name of a bundled scene, or nested dictionaries
    methods : names of methods to refine, and methods of your own, which are refined by tolerances
    meshes : your own mesh files or meshes of scikit-fem, from coarse to fine
    degree : polynomial degree of the finite elements on them
    units : unit of lengths in mesh files, such as "mm", or a factor on them, such as 0.1, if they
        are not those of the scene
    elements : your own elements, or those of scikit-fem, in place of the study's selection
    steps : time steps of implicit Euler in the unit of the scene, from coarse to fine
    quantities : names as in results.nc, and functions of a result that return a number; the named
        ones are drawn, instead of all
    against : abscissa of the figures: `size`, `unknowns` or `seconds`
    quick : whether to leave out the finest level of each way, and some degrees
    record : rows so far, and the file that they are written to

    Raises
    ------
    SceneError
        if the scene or an option does not fit the study
    RingwearError
        if the reference cannot be computed
    """
    scene = accept("convergence", scene, any_punch=True, radial_wear=True)
    refuse_abscissa(against)
    names, functions = read_quantities(quantities, (*DEFAULT, STRESS, ENERGY))
    named, own_methods = read_methods(methods, METHODS, "convergence")
    record, moving = record or Record(), not scene.problem.full_contact
    if moving and not scene.wear.times:
        raise SceneError(
            "the steady state of this punch equals that of a flat punch: give wear.times for a "
            "history, or study a flat punch"
        )
    if moving and (meshes or elements):
        raise SceneError(NOT_IN_MOVING_CONTACT)
    case = Case.of(scene)
    own_meshes_by_name = (
        read_meshes(case.problem, meshes, length_of(scene, units)) if meshes else {}
    )
    own_elements = read_elements(elements) if elements else ()
    refuse_degree_without_mesh(degree, bool(meshes))
    lengths = steps_of(scene, steps)
    own_ways = [
        *ways_of_meshes(own_meshes_by_name, own_elements, degree),
        *(ways_of_elements(own_elements, quick) if not meshes else []),
        *([time_steps("implicit", lengths, case.problem, 1e-6)] if lengths else []),
        *(tolerances(each, QUICK_TOLERANCES if quick else TOLERANCES) for each in own_methods),
    ]

    def ways(case: Case) -> list[Way]:
        if own_ways:
            return own_ways
        if case.name == ONE_RING:
            listed = ways_of_one_ring(quick)
        else:
            listed = ways_of_cells(quick) if moving else all_ways(case.problem, quick)
        return [way for way in listed if way.method in named]

    def exact(case: Case) -> Reference:
        return reference(case, wanted, functions, quick=quick, confirmed=not quick)

    several_rings = len(case.problem.merged.widths) > 1 and not moving
    cases = [case.with_one_ring()] if several_rings and not own_ways else []
    wanted = names or (*DEFAULT, STRESS, BY_PRESSURES)
    table = measure([*cases, case], ways, wanted, record, functions, exact)
    fits = observed_orders(table, {each.name: ways(each) for each in (*cases, case)})
    shown = [*names, *functions] if names else [*DEFAULT, STRESS, *functions]
    drawn = table[table["quantity"].isin(shown)]
    fits = fits[fits["quantity"] != BY_PRESSURES]
    figures = {}
    for (name, refined), rows in drawn.groupby(["case", "refined"], sort=False):
        title = titled(scene.title, str(name) if cases else "")
        words = ("convergence", "one_ring" if name == ONE_RING else "", FILES[str(refined)])
        file = "_".join(filter(None, words))
        figures[file] = draw(rows, against, ("quantity", "when"), orders=fits, title=title)
    sentences = (*conclude_orders(fits), *explain_start(fits, table), *remarks(record, quick))
    return Study("convergence", scene, table, fits, sentences, figures)


FILES = {
    finite_elements.HALVED: "uniform_meshes",
    finite_elements.PARTED: "graded_meshes",
    finite_elements.RAISED: "layers",
    finite_elements.COUNTED: "your_meshes",
    radial.COUNTED: "uniform_radii",
    radial.RATE: "graded_radii",
    radial.SCALED: "cells",
    runs.STEP: "steps",
    runs.TOLERANCE: "tolerances",
}
"""Names of the figures, by what is refined."""


def explain_start(fits: pd.DataFrame, table: pd.DataFrame) -> Iterator[str]:
    """Yield explanations why the start on uniform meshes has another order than in theory.

    The error of the indentation has two parts of opposite signs. Pressures that are too smooth at
    the rim increase it, displacements that are too stiff decrease it. Each part has the theoretical
    order, but while they nearly cancel, their sum has another observed order.
    """
    if fits.empty:
        return
    differing = fits[(fits["agrees"] == "no") & (fits["quantity"] == "indentation")]
    for fit in differing[differing["when"] == START].to_dict("records"):
        levels = table[(table["case"] == fit["case"]) & (table["way"] == fit["way"])]
        whole = levels[(levels["quantity"] == "indentation") & (levels["when"] == START)]
        by_pressures = levels[levels["quantity"] == BY_PRESSURES]["error"].to_numpy(float)
        sizes, errors = whole[["size", "error"]].to_numpy(float).T
        if "uniform" not in fit["way"] or len(by_pressures) < len(errors) or len(errors) < 2:
            continue
        parts = []
        for name, part in (("pressures", by_pressures), ("displacements", errors - by_pressures)):
            order = order_of_errors(sizes[-2:], np.abs(part[-2:])).order
            parts.append(f"{part[-1]:+.1e} due to the {name} (order {order:.2f})")
        yield (
            f"{fit['case']}, {fit['way']}, indentation, start: the order differs from theory "
            f"because the error has two parts of opposite signs: {' and '.join(parts)} on the "
            "finest level, with orders between the last two levels."
        )


def all_ways(problem: Problem, quick: bool) -> list[Way]:
    """Return every way to refine a flat punch, each from coarse to fine."""
    last, rings = slice(-1 if quick else None), len(problem.merged.widths)
    degrees = [degree for degree in PARTS if not quick or degree != QUICK_WITHOUT]
    uniform_ways = [
        *(uniform(degree, HALVINGS[degree][last]) for degree in degrees),
        *(uniform(degree, levels[last], quads=True) for degree, levels in QUAD_HALVINGS.items()),
    ]
    if quick:
        # stresses inside need a second factorisation
        uniform_ways = [replace(way, without=way.without | {STRESS}) for way in uniform_ways]
    return [
        *uniform_ways,
        *(graded_to_edges(degree, PARTS[degree][last]) for degree in degrees),
        *(
            graded_to_edges(degree, levels[last], quads=True)
            for degree, levels in QUAD_PARTS.items()
        ),
        layered(range(4, 8 if quick else 12), rings),
        *(uniform_radii("mdr", degree, COUNTS[last]) for degree in (1, 2)),
        uniform_radii("bem", 1, COUNTS[last]),
        *(
            graded_radii("mdr", degree, levels[last])
            for degree, levels in GRADINGS.items()
            if not quick or degree < 3
        ),
        graded_radii("bem", 1, GRADINGS[1][last]),
    ]


def ways_of_one_ring(quick: bool) -> list[Way]:
    """Return the ways to refine a punch of one ring whose orders are the most regular."""
    last = slice(-1 if quick else None)
    return [
        *(
            uniform(degree, levels[last], base=EVEN_UNDER_ONE_RING)
            for degree, levels in HALVINGS_OF_ONE_RING.items()
        ),
        *(
            graded_to_edges(degree, levels[last], base=GRADED_TO_RIM)
            for degree, levels in PARTS_OF_ONE_RING.items()
        ),
        layered(range(4, 12), rings=1),
        *(
            graded_radii("mdr", degree, levels)
            for degree, levels in GRADINGS_OF_ONE_RING.items()
            if not quick or degree < 3
        ),
    ]


def ways_of_cells(quick: bool) -> list[Way]:
    """Return every way to refine the cells of a contact whose edges move."""
    factors = QUICK_CELL_FACTORS if quick else CELL_FACTORS
    return [
        *(cells(name, factors) for name in ("mdr", "bem")),
        *(cells("fem", factors, degree) for degree in (1, 2, 3, 4)),
        *(cells("fem", factors, degree, quads=True) for degree in (1, 2)),
    ]


def ways_of_meshes(
    meshes: "Mapping[str, Mesh]", elements: "Sequence[Element]", degree: int | None
) -> list[Way]:
    """Return the user's meshes with each of the user's elements, or with Lagrange elements.

    Raises
    ------
    SceneError
        if meshes are of two kinds, or if an element does not fit them
    """
    from skfem import MeshQuad

    kinds = {isinstance(mesh, MeshQuad) for mesh in meshes.values()}
    if len(kinds) > 1:
        raise SceneError(
            "--mesh: the meshes of a sequence are all triangles or all quadrilaterals, not both"
        )
    if not kinds:
        return []
    if not elements:
        return [own_meshes(meshes, degree)]
    ways = []
    for element in elements:
        if is_on_quadrilaterals(element) not in kinds:
            kind = "quadrilaterals" if True in kinds else "triangles"
            raise SceneError(f"--element {name_of(element)}: your meshes consist of {kind}")
        name = f"your meshes, {name_of(element)}"
        ways.append(own_meshes(meshes, degree or degree_of(element), element, name))
    return ways


def ways_of_elements(elements: "Sequence[Element]", quick: bool) -> list[Way]:
    """Return uniform and graded meshes with each of the user's elements."""
    ways, last = list[Way](), slice(-1 if quick else None)
    for element in elements:
        order, quads, name = degree_of(element), is_on_quadrilaterals(element), name_of(element)
        for way, levels in (
            (uniform, QUAD_HALVINGS if quads else HALVINGS),
            (graded_to_edges, QUAD_PARTS if quads else PARTS),
        ):
            ways.append(way(order, levels[min(order, max(levels))][last], quads, element, name))
    return ways
