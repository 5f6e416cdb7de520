"""Which pair of spaces is stable: displacements by scikit-fem's elements, pressures by multipliers.

One graded mesh is halved again and again. For each pair, the least generalised eigenvalue of the
compliance by finite elements over that by MDR tells whether displacements see every pressure; it is
the square of the inf-sup constant in the norm of the half-space. Errors are those of the flat start
and of wear. A last family for each displacement lets Poisson's ratio tend to 1/2.

Theory: eigenvalues of stable pairs do not depend on the size h. Where checkerboards are displaced
by h alone, eigenvalues fall as h^2, so that the pressure of the flat start, whose singularity
excites them, is lost. With a singular rim, that pressure converges as h^(1/2) in the weighted mean
square, whatever the degree.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import pandas as pd

from ...meshes.errors import SceneError
from ...meshes.half_space import contact_facets
from ..problem.problem import Problem
from ..scene.scene import Scene
from ..study.levels import Family, Record, Theory
from ..study.options import Options
from ..study.orders import sequences_of
from ..study.study import Study
from ..tables import Row
from .choice import choose, conclude
from .figure import DrawnPressure, draw
from .measures import Condensed, Worn, condense, exact_wear, measure, press, start_error
from .pairs import Displacement, Meshes, Pressures, basis, displacements, of_name, of_runs
from .pairs import pressures_beneath as pressures_of

LOCKING = (0.3, 0.4, 0.45, 0.49, 0.499, 0.4999, 0.49999, 0.499999)
"""Poisson's ratios that tend to 1/2."""
LEVELS, QUICK_LEVELS = 5, 3
"""Meshes, each halved once more than the one before."""
MOST_FACETS = 400
"""On the contact of the finest mesh; punches of many rings have fewer levels, or are refused."""
BEFORE_FIRST = 1.0
"""Seconds that the coarsest mesh and the exact history take."""
COLUMNS = [
    *("family", "setting", "size", "displacement", "degree", "pressure", "pressure degree"),
    *("poisson ratio", "facets", "unknowns", "pressures", "on the contact", "least eigenvalue"),
    *("d0", "p at the start", "d(t)", "p(t)", "condition number", "seconds of condensing"),
]
STABLE = {
    "least eigenvalue": Theory(0.0, reason="the inf-sup constant does not depend on the size"),
    "p at the start": Theory(0.5, reason="the pressure is infinite at the rim as a root"),
}
"""Orders of stable pairs, in theory."""
UNSTABLE = {
    "least eigenvalue": Theory(2.0, reason="checkerboards are displaced in proportion to the size"),
    "p at the start": Theory(-0.5, reason="the root at the rim excites checkerboards"),
}
"""Orders of pairs with checkerboards: the first in theory, the second as measured."""
UNKNOWN = dict.fromkeys(("d0", "d(t)", "p(t)"), Theory())
"""Quantities whose orders are fitted without a theory."""


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Measure every pair on ever finer meshes, and every displacement near incompressibility.

    Raises
    ------
    SceneError
        if the punch is hollow or has too many rings, or if the half-space cannot take an element
    """
    problem = scene.problem
    if problem.inner_radius:
        raise SceneError("study elements is about full punches: leave out punch.inner_radius")
    bench = Bench(problem, tuple(displacements(options.elements, options.quick)), options.quick)
    if len(bench.levels) < QUICK_LEVELS:
        raise SceneError(
            f"study elements takes punches of few rings: this one has {bench.facets} facets on the "
            f"coarsest mesh, and {MOST_FACETS} are the most on the finest; give fewer punch.rings"
        )
    families = list(bench.families())
    table = record.solve("elements", families, COLUMNS)
    orders = pd.DataFrame(each.summary() for each in sequences_of(families, table))
    # what an interruption has left of a family tells nothing of its pair
    levels = table.groupby("family").size()
    whole = [each.name for each in families if levels.get(each.name, 0) == len(each.sizes)]
    compared = table[table.family.isin(whole)]
    found = Study("elements", scene, table, orders=orders, conclusions=tuple(record.conclusions))
    if compared.empty:
        return found
    choice = choose(compared, orders, several_rings=len(problem.merged.wear_coefficients) > 1)
    return replace(
        found,
        conclusions=(*conclude(choice, compared), *bench.notes, *record.conclusions),
        figures={"elements": draw(compared, choice, bench.drawn_pressures())},
        tables={"choice": choice},
    )


@dataclass(frozen=True, eq=False)
class Bench:
    """The punch and the displacements of a study, with what is computed once for many pairs.

    Parameters
    ----------
    problem : of the scene
    given : displacements to compare
    quick : whether fewer levels will do
    """

    problem: Problem
    given: tuple[Displacement, ...]
    quick: bool

    @cached_property
    def meshes(self) -> Meshes:
        """The mesh of the punch, and those halved from it."""
        return Meshes(self.problem.merged)

    @cached_property
    def compared(self) -> tuple[Displacement, ...]:
        """The displacements for which there is a mesh."""
        if self.meshes.has_quadrilaterals:
            return self.given
        return tuple(each for each in self.given if not each.on_quadrilaterals)

    @property
    def notes(self) -> list[str]:
        """What the user should know besides the conclusions."""
        missing = [each.name for each in self.given if each not in self.compared]
        if not missing:
            return []
        return [f"Left out, because gmsh makes no quadrilaterals here: {', '.join(missing)}."]

    @cached_property
    def exact(self) -> Worn:
        """The history that wear is compared with."""
        return exact_wear(self.problem.merged)

    @cached_property
    def facets(self) -> int:
        """Number of facets on the contact of the coarsest mesh."""
        return len(contact_facets(self.meshes.halved(0, on_quadrilaterals=False)))

    @property
    def levels(self) -> range:
        """How many times the meshes are halved."""
        wanted = QUICK_LEVELS if self.quick else LEVELS
        return range(sum(self.facets * 2**halvings <= MOST_FACETS for halvings in range(wanted)))

    @cached_property
    def condensed(self) -> Callable[[Displacement, int], Condensed]:
        """The function (displacement, halvings) -> what is condensed, the last levels kept."""

        @lru_cache(maxsize=len(self.levels) + 1)
        def condensed(displacement: Displacement, halvings: int) -> Condensed:
            return self._condense(displacement, halvings, self.problem.poisson_ratio)

        return condensed

    def _condense(self, displacement: Displacement, halvings: int, ratio: float) -> Condensed:
        mesh = self.meshes.halved(halvings, displacement.on_quadrilaterals)
        return condense(mesh, displacement, self.problem.merged, ratio)

    def families(self) -> Iterator[Family]:
        """Yield a family for each pair, then one for each displacement near incompressibility."""
        for displacement in self.compared:
            for number, pressures in enumerate(pressures_of(displacement, self.problem.merged)):
                first = number == 0 and displacement == self.compared[0]
                yield Family(
                    f"{displacement.name}, {pressures.name}",
                    {halvings: 0.5**halvings for halvings in self.levels},
                    partial(self.solve, displacement, pressures),
                    self._theory(displacement, pressures),
                    "facets on the contact",
                    partial(self._seconds, displacement, condensing=number == 0, first=first),
                )
        locking = list(self.compared)
        if not self.quick and any(each.name == "Q4" for each in locking):
            locking.append(of_name("Q6"))
        for displacement in locking:
            yield Family(
                f"locking, {displacement.name}",
                {ratio: 1 - 2 * ratio for ratio in LOCKING},
                partial(self.solve_nearly_incompressible, displacement),
                xlabel=r"$1 - 2 \nu$",
                work=partial(self._seconds_of_ratio, displacement),
            )

    def _theory(self, displacement: Displacement, pressures: Pressures) -> dict[str, Theory]:
        if pressures.is_singular_beneath(displacement.degree):
            return {}
        checkerboards = pressures.has_checkerboards_beneath(displacement.degree)
        return (UNSTABLE if checkerboards else STABLE) | UNKNOWN

    def _seconds_of_ratio(self, displacement: Displacement, ratio: float) -> float:
        """Return the seconds that a level near incompressibility is expected to take."""
        return self._seconds(displacement, 1, condensing=True)

    def _seconds(
        self, displacement: Displacement, halvings: int, condensing: bool, first: bool = False
    ) -> float:
        """Return the seconds that a level is expected to take, as measured on one core.

        The first level of all also takes the mesh and the exact history.
        """
        size = (displacement.degree + 1) * self.facets * 2**halvings
        of_pair = 0.006 + 0.04 * (size / 420) ** 2.7
        before = BEFORE_FIRST if first and not halvings else 0.0
        return before + of_pair + condensing * (0.01 + 0.25 * (size / 420) ** 2.3)

    def solve(self, displacement: Displacement, pressures: Pressures, halvings: int) -> Row:
        """Return the row of a pair on a mesh that is halved so many times."""
        condensed = self.condensed(displacement, halvings)
        return self._row(condensed, displacement, pressures, self.problem.poisson_ratio, self.exact)

    def solve_nearly_incompressible(self, displacement: Displacement, ratio: float) -> Row:
        """Return the row of a displacement with the pressures of runs, by Poisson's ratio."""
        condensed = self._condense(displacement, 1, ratio)
        return self._row(condensed, displacement, of_runs(displacement), ratio, None)

    def _row(
        self,
        condensed: Condensed,
        displacement: Displacement,
        pressures: Pressures,
        ratio: float,
        exact: Worn | None,
    ) -> Row:
        of_pressures = basis(
            condensed.space, pressures, self.problem.merged, condensed.half_space.solid
        )
        return {
            "displacement": displacement.name,
            "degree": displacement.degree,
            "pressure": pressures.kind,
            "pressure degree": pressures.degree,
            "poisson ratio": ratio,
            "facets": len(condensed.space.degrees),
            "unknowns": condensed.half_space.unknowns,
            "seconds of condensing": round(condensed.seconds, 4),
            **measure(condensed, of_pressures, self.problem.merged, exact),
        }

    def drawn_pressures(self) -> list[DrawnPressure]:
        """Return the flat start by a stable and by an unstable pair on the coarsest mesh.

        The displacement is the first of degree 2, or the first of all; there may be none.
        """
        if not self.compared:
            return []
        quadratic = [each for each in self.compared if each.degree == 2]
        displacement = (quadratic or self.compared)[0]
        lower = displacement.degree - 1
        condensed, drawn = self.condensed(displacement, 0), list[DrawnPressure]()
        for pressures in (
            Pressures("broken everywhere", lower),
            Pressures("continuous", max(lower, 1)),
        ):
            of_pressures = basis(
                condensed.space, pressures, self.problem.merged, condensed.half_space.solid
            )
            factor, _ = condensed.factors_of(of_pressures)
            depth, found, _ = press(factor, of_pressures.T @ condensed.space.weights)
            coefficients = of_pressures @ found
            drawn.append(
                DrawnPressure(
                    displacement.name,
                    pressures,
                    condensed.space,
                    coefficients,
                    depth,
                    start_error(condensed.space, coefficients),
                )
            )
        return drawn
