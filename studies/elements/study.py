"""Which pair of spaces is stable: displacements by scikit-fem's elements, pressures by multipliers.

One graded mesh is halved repeatedly. For each pair, the study computes the least generalised
eigenvalue of the compliance by finite elements relative to the compliance by MDR. It is the square
of the inf-sup constant in the norm of the half-space, and small if some pressure displaces almost
nothing. The study also computes errors of the flat start and of wear. A last family for each
displacement lets Poisson's ratio tend to 1/2.

Theory: eigenvalues of stable pairs do not depend on the element size h. If checkerboard pressures
cause displacements proportional to h, eigenvalues fall as h^2. The singular pressure of the flat
start excites checkerboards and is then wrong. For stable pairs it converges as h^(1/2) in the
weighted mean square, whatever the degree, because it is singular at the rim.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import pandas as pd

from ...meshes.half_space import contact_facets
from ..crosscheck import Problem, Scene, SceneError
from ..study.levels import Family, Record, Theory
from ..study.options import Options
from ..study.orders import sequences_of
from ..study.study import Study
from ..tables import Row
from .choice import choose, conclude
from .figure import DrawnPressure, draw
from .measures import Condensed, WearHistory, condense, exact_wear, measure, press, start_error
from .pairs import (
    Displacement,
    Meshes,
    Pressures,
    basis,
    choose_displacements,
    displacement_by_name,
    pressure_spaces,
    pressures_of_runs,
)

LOCKING_RATIOS = (0.3, 0.4, 0.45, 0.49, 0.499, 0.4999, 0.49999, 0.499999)
"""Poisson's ratios at which locking is measured."""
LEVELS, QUICK_LEVELS = 5, 3
"""Number of meshes; each is halved once more than the one before it."""
MOST_FACETS = 400
"""Greatest number of facets on the contact of the finest mesh.

Punches of many rings have fewer levels for it, or are refused.
"""
SETUP_SECONDS = 1.0
"""Expected seconds for the coarsest mesh and the exact history, before the first level."""
COLUMNS = [
    *("family", "setting", "size", "displacement", "degree", "pressure", "pressure degree"),
    *("poisson ratio", "facets", "unknowns", "pressures", "on the contact", "least eigenvalue"),
    *("d0", "p at the start", "d(t)", "p(t)", "condition number", "seconds of condensing"),
]
STABLE_ORDERS = {
    "least eigenvalue": Theory(0.0, reason="the inf-sup constant does not depend on the size"),
    "p at the start": Theory(
        0.5, reason="the pressure is singular at the rim as an inverse square root"
    ),
}
"""Theoretical orders of stable pairs."""
UNSTABLE_ORDERS = {
    "least eigenvalue": Theory(
        2.0, reason="checkerboards cause displacements proportional to the size"
    ),
    "p at the start": Theory(-0.5, reason="the singularity at the rim excites checkerboards"),
}
"""Orders of pairs with checkerboards: of the eigenvalue by theory, of the pressure as measured."""
FITTED_ORDERS = dict.fromkeys(("d0", "d(t)", "p(t)"), Theory())
"""Quantities whose orders are fitted but have no theory to compare with."""


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
    displacements = tuple(choose_displacements(options.elements, options.quick))
    bench = Bench(problem, displacements, options.quick)
    if len(bench.levels) < QUICK_LEVELS:
        raise SceneError(
            f"study elements takes punches of few rings: this one has {bench.facets} facets on the "
            f"coarsest mesh, and {MOST_FACETS} are the most on the finest; give fewer punch.rings"
        )
    families = list(bench.families())
    table = record.solve("elements", families, COLUMNS)
    orders = pd.DataFrame(each.summary() for each in sequences_of(families, table))
    # a family that was interrupted has no finest level, so nothing is concluded from it
    levels = table.groupby("family").size()
    complete = [each.name for each in families if levels.get(each.name, 0) == len(each.sizes)]
    compared = table[table.family.isin(complete)]
    study = Study("elements", scene, table, orders=orders, conclusions=tuple(record.conclusions))
    if compared.empty:
        return study
    choice = choose(compared, orders, several_rings=len(problem.merged.widths) > 1)
    return replace(
        study,
        conclusions=(*conclude(choice, compared), *bench.notes, *record.conclusions),
        figures={"elements": draw(compared, choice, bench.drawn_pressures())},
        tables={"choice": choice},
    )


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
    def exact(self) -> WearHistory:
        """The reference history that wear is compared with."""
        return exact_wear(self.problem.merged)

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

    def families(self) -> Iterator[Family]:
        """Yield a family for each pair, then one for each displacement near incompressibility."""
        for displacement in self.compared:
            for number, pressures in enumerate(pressure_spaces(displacement, self.problem.merged)):
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
            locking.append(displacement_by_name("Q6"))
        for displacement in locking:
            yield Family(
                f"locking, {displacement.name}",
                {ratio: 1 - 2 * ratio for ratio in LOCKING_RATIOS},
                partial(self.solve_nearly_incompressible, displacement),
                xlabel=r"$1 - 2 \nu$",
                work=partial(self._seconds_of_ratio, displacement),
            )

    def _theory(self, displacement: Displacement, pressures: Pressures) -> dict[str, Theory]:
        """Return the theoretical orders of a pair; a singular pair has none."""
        if pressures.is_singular_with(displacement.degree):
            return {}
        checkerboards = pressures.has_checkerboards_with(displacement.degree)
        return (UNSTABLE_ORDERS if checkerboards else STABLE_ORDERS) | FITTED_ORDERS

    def _seconds_of_ratio(self, displacement: Displacement, ratio: float) -> float:
        """Return the expected seconds of a level near incompressibility."""
        return self._seconds(displacement, 1, condensing=True)

    def _seconds(
        self, displacement: Displacement, halvings: int, condensing: bool, first: bool = False
    ) -> float:
        """Return the expected seconds of a level, from measurements on one core.

        Parameters
        ----------
        condensing : whether the level condenses the half-space for the pairs that follow
        first : whether the family is the first one; its first level makes the mesh and the exact
            history
        """
        size = (displacement.degree + 1) * self.facets * 2**halvings
        pair_seconds = 0.006 + 0.04 * (size / 420) ** 2.7
        setup_seconds = SETUP_SECONDS if first and not halvings else 0.0
        return setup_seconds + pair_seconds + condensing * (0.01 + 0.25 * (size / 420) ** 2.3)

    def solve(self, displacement: Displacement, pressures: Pressures, halvings: int) -> Row:
        """Return the row of a pair on the mesh after a number of halvings."""
        condensed = self.condensed(displacement, halvings)
        return self._row(condensed, displacement, pressures, self.problem.poisson_ratio, self.exact)

    def solve_nearly_incompressible(self, displacement: Displacement, ratio: float) -> Row:
        """Return the row of a displacement at a Poisson's ratio, with the pressures of runs."""
        condensed = self._condense(displacement, 1, ratio)
        return self._row(condensed, displacement, pressures_of_runs(displacement), ratio, None)

    def _row(
        self,
        condensed: Condensed,
        displacement: Displacement,
        pressures: Pressures,
        ratio: float,
        exact: WearHistory | None,
    ) -> Row:
        """Return the row of the table for a pair; without an exact history, wear is left out."""
        pressure_basis = basis(
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
            **measure(condensed, pressure_basis, self.problem.merged, exact),
        }

    def drawn_pressures(self) -> list[DrawnPressure]:
        """Return the pressure of the flat start by an unstable and a stable pair, coarsest mesh.

        The displacement is the first one of degree 2, or else the first one. The list is empty if
        there is no displacement to compare.
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
            pressure_basis = basis(
                condensed.space, pressures, self.problem.merged, condensed.half_space.solid
            )
            factor, _ = condensed.factors_of(pressure_basis)
            depth, solution, _ = press(factor, pressure_basis.T @ condensed.space.weights)
            coefficients = pressure_basis @ solution
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
