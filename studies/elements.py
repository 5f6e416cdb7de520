"""Elements: which pair of spaces is stable, displacements by elements, pressures by multipliers.

One graded mesh is halved repeatedly. For each pair, the study computes the least generalised
eigenvalue of the compliance by finite elements relative to the compliance by MDR. It is the square
of the inf-sup constant in the norm of the half-space, and small if some pressure displaces almost
nothing. The study also computes errors of the flat start and of wear, and lets Poisson's ratio tend
to 1/2.

Theory: eigenvalues of stable pairs do not depend on the element size h. If checkerboard pressures
cause displacements proportional to h, eigenvalues fall as h^2. The singular pressure of the flat
start excites checkerboards and is then wrong. For stable pairs it converges as h^(1/2), whatever
the degree, because it is singular at the rim.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ..mdr import P0
from ..meshes import Array, SceneError, contact_facets
from .crosscheck import Problem, Solution, Source
from .figures.style import complete, in_style, new_panels
from .study.accept import accept
from .study.draw import draw, titled
from .study.errors import CONDITION, EIGENVALUE
from .study.measure import measure
from .study.own import read_elements
from .study.record import REFUSED, SOLVED, Record
from .study.reference import Reference, exact_start, reference
from .study.study import Study, remarks
from .study.theory import observed_orders
from .study.way import START, Case, Theory, Way
from .study.ways.pairs import (
    Condensed,
    Displacement,
    Meshes,
    Pressures,
    basis,
    choose_displacements,
    condense,
    displacement_by_name,
    press,
    pressure_spaces,
    pressures_of_runs,
    solution_on,
)

if TYPE_CHECKING:
    from skfem import Element

LOCKING_RATIOS = (0.3, 0.4, 0.45, 0.49, 0.499, 0.4999, 0.49999, 0.499999)
"""Poisson's ratios at which locking is measured."""
LEVELS, QUICK_LEVELS = 5, 3
"""Number of meshes; each is halved once more than the one before it."""
MOST_FACETS = 400
"""Greatest number of facets on the contact of the finest mesh.

Punches of many rings have fewer levels for it, or are refused.
"""
SIZE, COMPRESSIBILITY = "element size / coarsest", r"$1 - 2 \nu$"
STABLE, UNSTABLE, SINGULAR = "yes", "no", "singular"
"""Values of the column `stable` of the table of pairs."""
UNSTABLE_ORDER = 1.0
"""A pair is unstable if its least eigenvalue falls with this order of the element size or faster.

In theory the order is 0 for stable pairs and 2 for pairs with checkerboards.
"""
LOCKING, LOCKING_GROWTH = "towards nu = 1/2", 3.0
"""Name of the case near incompressibility, and growth of the error of a displacement that locks."""
STABLE_ORDERS = {
    (EIGENVALUE, "all"): Theory(0.0, reason="The inf-sup constant does not depend on the size."),
    ("pressure", START): Theory(
        0.5, reason="The pressure is singular at the rim as an inverse square root."
    ),
}
"""Theoretical orders of stable pairs."""
UNSTABLE_ORDERS = {
    (EIGENVALUE, "all"): Theory(
        2.0, reason="Checkerboards cause displacements proportional to the size."
    ),
    ("pressure", START): Theory(-0.5, reason="The singularity at the rim excites checkerboards."),
}
"""Orders of pairs with checkerboards: of the eigenvalue by theory, of the pressure as measured."""
FIGURES = {
    "elements": (EIGENVALUE, "all", "least eigenvalue, finite elements over MDR"),
    "start_pressure": ("pressure", START, "error of the pressure of the flat start"),
    "start_indentation": ("indentation", START, "error of the indentation of the flat start"),
    "worn_pressure": ("pressure", "later", "error of the pressure while the punch wears"),
}
"""Quantity, `when` and title of each figure with a panel for each displacement."""


def elements(
    scene: Source = "five_rings",
    *,
    elements: "Sequence[str | Element]" = (),
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Measure pairs of spaces on ever finer meshes, and displacements near incompressibility.

    Parameters
    ----------
    scene : a scene of a flat, full punch of few rings
    elements : elements of scikit-fem by name, or your own, in place of the study's selection
    quick : whether fewer elements and levels are enough
    record : rows so far, and the file that they are written to

    Raises
    ------
    SceneError
        if the scene or an element does not fit the study
    """
    scene, record = accept("elements", scene), record or Record()
    if scene.problem.inner_radius:
        raise SceneError("study elements is about full punches: leave out punch.inner_radius")
    if scene.problem.loading.varies:
        raise SceneError("study elements is about a constant load: give load.normal_force a number")
    own = read_elements(elements) if elements else ()
    case = Case.of(scene)
    bench = Bench(case.problem, tuple(choose_displacements(own, quick)), quick)
    if len(bench.levels) < QUICK_LEVELS:
        raise SceneError(
            f"study elements takes punches of few rings: this one has {bench.facets} facets on the "
            f"coarsest mesh, and {MOST_FACETS} are the most on the finest; give fewer punch.rings"
        )
    start = case.with_one_ring().problem
    cases = [
        *(replace(case, name=each.name) for each in bench.compared),
        Case(LOCKING, None, start, only=frozenset({"indentation"})),
    ]
    wanted, references = ("indentation", "pressure", EIGENVALUE, CONDITION), list[Reference]()

    def exact(of_case: Case) -> Reference:
        if of_case.name == LOCKING:
            return exact_start(start)
        # all displacements are compared with one reference
        references.append(references[0] if references else reference(case, wanted))
        return references[0]

    table = measure(cases, bench.ways, wanted, record, exact=exact)
    fits = observed_orders(
        table, {each.name: bench.ways(each) for each in cases if each.name != LOCKING}
    )
    # a way that was interrupted has no finest level, so nothing is concluded from it
    counts = table.groupby(["case", "way"])["level"].nunique()
    expected = {(each.name, way.name): way.count for each in cases for way in bench.ways(each)}
    complete_ways = {
        key for key, count in counts.items() if count == expected[key] or key in _singular(table)
    }
    keys = zip(table["case"], table["way"], strict=True)
    rows = table[np.array([key in complete_ways for key in keys], dtype=bool)]
    choice = choose(rows, fits, bench)
    sentences = (*conclude(choice, rows), *bench.notes, *_without_singular(remarks(record, quick)))
    tables = {"choice": choice} if len(choice) else {}
    figures = figures_of(titled(scene.title), rows, bench)
    return Study("elements", scene, table, fits, sentences, figures, tables)


def _singular(table: pd.DataFrame) -> set[tuple[str, str]]:
    """Return case and way of the pairs that are refused because they are singular."""
    refused = table[table["outcome"] == REFUSED]
    return set(zip(refused["case"], refused["way"], strict=True))


def _without_singular(texts: list[str]) -> list[str]:
    """Return remarks without those on singular pairs, which one conclusion lists."""
    return [text for text in texts if "is singular" not in text]


@dataclass(frozen=True, eq=False)
class Bench:
    """The punch and the displacements of a study, with meshes and compliances that pairs share.

    Parameters
    ----------
    problem : of the scene
    displacements : displacements to compare
    quick : whether fewer levels are enough
    """

    problem: Problem
    displacements: tuple[Displacement, ...]
    quick: bool

    @cached_property
    def meshes(self) -> Meshes:
        """The coarsest mesh and its halvings."""
        return Meshes(self.problem.merged)

    @cached_property
    def compared(self) -> tuple[Displacement, ...]:
        """The displacements for which there is a mesh."""
        if self.meshes.has_quadrilaterals:
            return self.displacements
        return tuple(each for each in self.displacements if not each.on_quadrilaterals)

    @property
    def notes(self) -> list[str]:
        """Remarks to the user in addition to the conclusions."""
        missing = [each.name for each in self.displacements if each not in self.compared]
        if not missing:
            return []
        return [f"Left out, because gmsh makes no quadrilaterals here: {', '.join(missing)}."]

    @cached_property
    def facets(self) -> int:
        """Number of facets on the contact of the coarsest mesh."""
        return len(contact_facets(self.meshes.halved(0, on_quadrilaterals=False)))

    @property
    def levels(self) -> range:
        """Numbers of halvings of the meshes."""
        count = QUICK_LEVELS if self.quick else LEVELS
        return range(sum(self.facets * 2**halvings <= MOST_FACETS for halvings in range(count)))

    @cached_property
    def condensed(self) -> Callable[[Displacement, int], Condensed]:
        """Function (displacement, halvings) -> condensed half-space; it caches the last levels."""

        @lru_cache(maxsize=len(self.levels) + 1)
        def condensed(displacement: Displacement, halvings: int) -> Condensed:
            return self._condense(displacement, halvings, self.problem.poisson_ratio)

        return condensed

    def _condense(self, displacement: Displacement, halvings: int, ratio: float) -> Condensed:
        """Return the condensed half-space for a number of halvings and a Poisson's ratio."""
        mesh = self.meshes.halved(halvings, displacement.on_quadrilaterals)
        return condense(mesh, displacement, self.problem.merged, ratio)

    def pairs(self, displacement: Displacement) -> dict[str, Pressures]:
        """Return the pressure spaces that are compared under a displacement, by their names."""
        spaces = pressure_spaces(displacement, self.problem.merged)
        return {each.name_under(displacement.degree): each for each in spaces}

    def ways(self, case: Case) -> list[Way]:
        """Return a way for each pair of a displacement, or for each displacement that may lock."""
        if case.name == LOCKING:
            locking = list(self.compared)
            if not self.quick and any(each.name == "Q4" for each in locking):
                locking.append(displacement_by_name("Q6"))
            return [self._locking(each) for each in locking]
        (displacement,) = (each for each in self.compared if each.name == case.name)
        return [
            self._pair(name, displacement, pressures)
            for name, pressures in self.pairs(displacement).items()
        ]

    def _pair(self, name: str, displacement: Displacement, pressures: Pressures) -> Way:
        """Return the way of a pair through ever finer meshes."""
        orders = STABLE_ORDERS
        if pressures.has_checkerboards_with(displacement.degree):
            orders = UNSTABLE_ORDERS

        def solve(problem: Problem, level: int, _: Solution | None) -> Solution:
            condensed = self.condensed(displacement, level)
            return solution_on(problem, condensed, self.basis(condensed, pressures))

        def theory(quantity: str, when: str) -> Theory:
            return orders.get((quantity, when), Theory())

        return Way(name, "fem", self.levels, solve, SIZE, _size, theory)

    def basis(self, condensed: Condensed, pressures: Pressures) -> Any:
        """Return the basis of a pressure space within the full one."""
        solid = condensed.half_space.solid
        return basis(condensed.space, pressures, self.problem.merged, solid)

    def _locking(self, displacement: Displacement) -> Way:
        """Return the way of a displacement, with the pressures of runs, towards nu = 1/2."""
        pressures = pressures_of_runs(displacement)

        def solve(problem: Problem, level: float, _: Solution | None) -> Solution:
            condensed = self._condense(displacement, 1, level)
            return solution_on(problem, condensed, self.basis(condensed, pressures))

        def size(level: float) -> float:
            return 1 - 2 * level

        name = displacement.name
        return Way(name, "fem", LOCKING_RATIOS, solve, COMPRESSIBILITY, size)

    def drawn_pressures(self) -> dict[str, tuple[Array, Array]]:
        """Return radii and pressures of the flat start by an unstable and by a stable pair.

        The displacement is the first one of degree 2, or else the first one.
        """
        quadratic = [each for each in self.compared if each.degree == 2]
        displacement = (quadratic or list(self.compared))[0]
        lower = displacement.degree - 1
        condensed, drawn = self.condensed(displacement, 0), {}
        space, ends = condensed.space, condensed.space.breakpoints
        inside = np.sort(np.concatenate([ends[:-1] + 1e-9, ends[1:] - 1e-9]))
        for pressures in (
            Pressures("broken everywhere", lower),
            Pressures("continuous", max(lower, 1)),
        ):
            of_pressures = self.basis(condensed, pressures)
            factor = (of_pressures.T @ condensed.fem_factor.T).T
            _, solution, _ = press(factor, of_pressures.T @ space.weights)
            name = f"{displacement.name}, pressures {pressures.name_under(displacement.degree)}"
            drawn[name] = inside, space.matrix(inside) @ (of_pressures @ solution)
        return drawn


def _size(level: int) -> float:
    """Return the size of the elements after a number of halvings."""
    return 0.5**level


def choose(table: pd.DataFrame, fits: pd.DataFrame, bench: Bench) -> pd.DataFrame:
    """Return one row per pair: whether it is stable, and its errors on the finest mesh.

    Parameters
    ----------
    table : rows of complete ways
    fits : observed orders
    bench : displacements and pressures
    """
    rows, displacements = [], {each.name: each for each in bench.compared}
    several_rings = len(bench.problem.merged.widths) > 1
    for (name, way), levels in table[table["case"] != LOCKING].groupby(["case", "way"], sort=False):
        displacement = displacements[str(name)]
        pressures = bench.pairs(displacement)[str(way)]
        of_pair = fits[(fits["case"] == name) & (fits["way"] == way)]
        orders = dict(
            zip(
                zip(of_pair["quantity"], of_pair["when"], strict=True),
                of_pair["order"],
                strict=True,
            )
        )
        finest = levels[levels["level"] == levels["level"].iloc[-1]]
        errors = {
            (row["quantity"], row["when"]): abs(row["error"]) for row in finest.to_dict("records")
        }
        stable = STABLE if orders.get((EIGENVALUE, "all"), 0.0) < UNSTABLE_ORDER else UNSTABLE
        if (levels["outcome"] != SOLVED).any():
            stable = SINGULAR
        rows.append(
            {
                "displacement": name,
                "degree": displacement.degree,
                "pressure": pressures.kind,
                "pressure degree": pressures.degree,
                "stable": stable,
                "suits": suitable_use(stable, pressures.kind, several_rings),
                "least eigenvalue": errors.get((EIGENVALUE, "all"), np.nan),
                "order of eigenvalue": orders.get((EIGENVALUE, "all"), np.nan),
                "start indentation": errors.get(("indentation", START), np.nan),
                "start pressure": errors.get(("pressure", START), np.nan),
                "order of start pressure": orders.get(("pressure", START), np.nan),
                "worn indentation": errors.get(("indentation", "later"), np.nan),
                "worn pressure": errors.get(("pressure", "later"), np.nan),
                "order of worn pressure": orders.get(("pressure", "later"), np.nan),
                "condition number": errors.get((CONDITION, "all"), np.nan),
            }
        )
    return pd.DataFrame(rows)


def suitable_use(stable: str, kind: str, several_rings: bool) -> str:
    """Return the computations that a pair may be used for, in words."""
    if stable == SINGULAR:
        return "nothing: it is refused"
    if stable == UNSTABLE:
        return "indentations and wear, but no pressure before wear"
    if kind == "continuous" and several_rings:
        return "the start, and punches of one material"
    return "the start and wear"


def conclude(choice: pd.DataFrame, table: pd.DataFrame) -> Iterator[str]:
    """Yield the conclusions: stability, continuity at ring edges, condition numbers, locking."""
    if not len(choice):
        return
    pairs = dict(tuple(choice.groupby("stable")))
    if STABLE in pairs:
        eigenvalues = pairs[STABLE]["least eigenvalue"]
        yield (
            f"{len(eigenvalues)} of {len(choice)} pairs are stable: their least eigenvalues on the "
            f"finest mesh lie between {eigenvalues.min():.2g} and {eigenvalues.max():.2g}, and the "
            f"start indentation errs by at most {pairs[STABLE]['start indentation'].max():.1e}."
        )
    if UNSTABLE in pairs:
        unstable = pairs[UNSTABLE]
        yield (
            f"{len(unstable)} pairs have checkerboards ({_names(unstable)}): their least "
            f"eigenvalues fall with order {_span(unstable['order of eigenvalue'], '.2f')}. The "
            "pressure of the flat start is wrong by "
            f"{_span(unstable['start pressure'], '.2g')} times its norm. The indentation (errors "
            f"up to {unstable['start indentation'].max():.1e}) and the worn pressure (up to "
            f"{unstable['worn pressure'].max():.1e}) do not show it."
        )
    if SINGULAR in pairs:
        yield (
            f"{len(pairs[SINGULAR])} pairs are singular ({_names(pairs[SINGULAR])}): condensing "
            "them raises an error."
        )
    yield from _conclude_ring_edges(choice)
    if {STABLE, UNSTABLE} <= pairs.keys():
        stable, unstable_numbers = (pairs[kind]["condition number"] for kind in (STABLE, UNSTABLE))
        yield (
            f"The condition number of the compliance is at most {stable.max():.0e} for stable "
            f"pairs, and at least {unstable_numbers.min():.0e} for pairs with checkerboards."
        )
    yield from _conclude_locking(table)


def _conclude_ring_edges(choice: pd.DataFrame) -> Iterator[str]:
    """Yield how large the error of a worn pressure is if it is continuous over ring edges."""
    continuous = choice[choice["suits"].str.contains("one material")]
    broken = choice[choice["suits"] == "the start and wear"]
    if len(continuous) and len(broken):
        yield (
            "Pressures that are continuous over ring edges are stable, but wear makes the pressure "
            f"jump there: the worn pressure errs by {_span(continuous['worn pressure'], '.1e')} "
            f"and converges with order {_span(continuous['order of worn pressure'], '.2f')}; "
            "pressures that may jump there err by "
            f"{_span(broken['worn pressure'], '.1e')}, order "
            f"{_span(broken['order of worn pressure'], '.2f')}."
        )


def _conclude_locking(table: pd.DataFrame) -> Iterator[str]:
    """Yield which displacements lock as Poisson's ratio tends to 1/2."""
    rows = table[(table["case"] == LOCKING) & table["error"].notna()]
    names_by_locking = {True: list[str](), False: list[str]()}
    for name, levels in rows.groupby("way", sort=False):
        errors = levels["error"].abs().to_numpy(float)
        names_by_locking[bool(errors[-1] > LOCKING_GROWTH * errors[0])].append(
            f"{name} ({errors[0]:.1e} to {errors[-1]:.1e})"
        )
    for locks, names in names_by_locking.items():
        if names:
            growth = "more than threefold (locking)" if locks else "at most threefold"
            yield (
                f"From nu = 0.3 to {LOCKING_RATIOS[-1]:g} the error of the start indentation grows "
                f"{growth}: {', '.join(names)}."
            )


def _names(pairs: pd.DataFrame) -> str:
    """Return pairs as a list: each displacement with its pressures, their kind and degree."""
    return "; ".join(
        f"{name} with pressures "
        + ", ".join(
            f"{row['pressure']} of degree {row['pressure degree']}"
            for row in group.to_dict("records")
        )
        for name, group in pairs.groupby("displacement", sort=False)
    )


def _span(values: pd.Series, form: str) -> str:
    """Return the least and the greatest value as a text, or one value if both have one text."""
    low, high = (f"{value:{form}}" for value in (np.nanmin(values), np.nanmax(values)))
    return low if low == high else f"{low} to {high}"


def figures_of(title: str, table: pd.DataFrame, bench: Bench) -> dict[str, Figure]:
    """Return the figures with a panel for each displacement, and those of start and locking."""
    figures = {}
    solved = table[(table["outcome"] == SOLVED) & (table["case"] != LOCKING)]
    for name, (quantity, when, words) in FIGURES.items():
        rows = solved[(solved["quantity"] == quantity) & (solved["when"] == when)]
        if len(rows):
            ylabel = "eigenvalue" if quantity == EIGENVALUE else "relative error"
            heading = titled(title, words)
            figures[name] = draw(
                rows, panels=("case",), title=heading, ylabel=ylabel, same_axes=True
            )
    locking = table[(table["case"] == LOCKING) & table["error"].notna()]
    if len(locking):
        words = "error of the start indentation towards incompressibility"
        figures["locking"] = draw(locking, panels=("case",), title=titled(title, words))
    if figures:
        figures["checkerboards"] = draw_start(title, bench)
    return figures


def draw_start(title: str, bench: Bench) -> Figure:
    """Draw the pressure of the flat start by an unstable and by a stable pair."""
    with in_style():
        figure, ((axes,),) = new_panels(4.6, 3.4)
        for number, (name, (radii, pressures)) in enumerate(bench.drawn_pressures().items()):
            color, width = ("#c0392b", 0.7) if number == 0 else ("#1f4e79", 1.6)
            axes.plot(radii, pressures, color=color, linewidth=width, label=name)
        radii = np.linspace(0.0, 0.9995, 2001)
        axes.plot(radii, P0 / np.sqrt(1 - radii**2), "k:", linewidth=1.0, label="exact")
        axes.set(xlim=(0, 1), ylim=(-1.7, 1.9), xlabel="r / a", ylabel="$p\\,a^2/F$, flat start")
        return complete(figure, [titled(title, "pressures of a flat start")], [axes])
