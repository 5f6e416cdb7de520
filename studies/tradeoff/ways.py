"""The ways to compute a group of quantities, each with its levels, from coarse to fine."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...meshes.errors import SceneError
from ..extremes.oracles import other_theory, solve_reference
from ..methods.base import Solution, method
from ..problem.problem import Problem
from ..problem.quantities import GROUPS
from ..problem.sections import MdrAccuracy
from ..progress import Stages
from ..study.levels import Family
from ..tables import Row
from . import measure
from .tolerances import TOLERANCES

ASKED = {
    "indentation, force, relaxation times": frozenset(
        ["indentation", "normal_force", "relaxation_time"]
    ),
    "history": GROUPS["history"],
    "fields": GROUPS["fields"],
    "steady state": GROUPS["steady"],
}
"""Groups of quantities, each of which is asked for alone."""
BY_TOLERANCE = ("mdr", "bem", "fem")
"""Methods whose sizes follow the tolerance."""
DIRECT, IMPLICIT, EXPLICIT, GRID, NAIVE = (
    "direct",
    "mdr implicit",
    "mdr explicit",
    "mdr-grid",
    "naive",
)
WAYS = (*BY_TOLERANCE, DIRECT, IMPLICIT, EXPLICIT, GRID, NAIVE)
"""All methods and marches, as the option `methods` names them."""

IMPLICIT_STEPS = (0.1, 0.01, 0.001)
"""Steps of the implicit march, non-dimensional."""
STABLE_PARTS = (0.9, 0.3, 0.1)
"""Steps of the explicit march, over the greatest that is stable."""
EXPLICIT_SIZES = MdrAccuracy(degree=2, rim_size=0.02, ring_size=0.02, grading=0.5)
"""Elements so coarse that the explicit march is stable in a few thousand steps."""
NAIVE_CELLS = (5, 10, 20, 40)
"""Elements of the naive finite elements on the radius of the punch."""
NAIVE_STEP = 0.8
"""Step of the naive finite elements, over the greatest that is stable on their mesh."""


@dataclass(frozen=True, eq=False)
class Ways:
    """All methods and marches for one problem, measured by references of another theory.

    Parameters
    ----------
    problem : with the radii at which it is compared
    references : solutions by the name of their method
    names : of the methods and marches that are measured
    quick : whether fewer tolerances will do
    """

    problem: Problem
    references: Mapping[str, Solution]
    names: tuple[str, ...]
    quick: bool

    @classmethod
    def of(cls, problem: Problem, names: tuple[str, ...], quick: bool) -> "Ways":
        """Solve the references that the names need.

        Raises
        ------
        RingwearError
            if a reference cannot be computed
        """
        rtol = TOLERANCES[problem.contact].of_reference(quick)
        problem = replace(problem, march="modal", step=None)
        problem = replace(problem, compared_on=replace(problem, rtol=rtol).face)
        needed = dict.fromkeys(other_theory(name.split()[0]) for name in names)
        references = {name: solve_reference(problem, name, rtol) for name in needed}
        return cls(problem, references, names, quick)

    def families(self) -> Iterator[Family]:
        """Yield a family for each group of quantities and each method or march that gives it."""
        for group, quantities in ASKED.items():
            try:
                alone = self.problem.with_quantities(quantities)
            except SceneError:
                # the scene has none of them
                continue
            # nothing is steady at a fixed indentation
            if method("mdr").refusal(alone):
                continue
            for name in self.names:
                if levels := self._levels(name, alone, quantities):
                    yield self._family(group, name, levels)

    def _levels(
        self, name: str, alone: Problem, quantities: frozenset[str]
    ) -> "dict[str, Callable[[], Row]]":
        """Return the levels of a method or a march, from coarse to fine; empty if it has none."""
        if name == NAIVE:
            return self._naive_levels(alone)
        problems: dict[str, Problem] = {}
        tolerances = TOLERANCES[self.problem.contact]
        marched = tolerances.knows_others and quantities <= GROUPS["history"]
        if name in BY_TOLERANCE:
            problems = {
                f"rtol {rtol:.0e}": replace(alone, rtol=rtol)
                for rtol in tolerances.asked(self.quick)
            }
        elif name == DIRECT and quantities <= GROUPS["steady"]:
            problems = {"closed form": alone}
        elif name == IMPLICIT and marched:
            stepped = replace(alone, march="implicit", rtol=1e-4)
            problems = {f"step {step:g}": replace(stepped, step=step) for step in IMPLICIT_STEPS}
        elif name == EXPLICIT and marched:
            problems = _explicit_problems(alone)
        elif name == GRID and marched:
            problems = {
                f"n = {count}": replace(alone, mdr=MdrAccuracy(grid=count))
                for count in ((50, 100, 200) if self.quick else (50, 100, 200, 400))
            }
        solver = name.split()[0]
        reference = self.references[other_theory(solver)]
        return {
            setting: partial(measure.measure_method, solver, problem, reference)
            for setting, problem in problems.items()
            if not method(solver).refusal(problem)
        }

    def _naive_levels(self, alone: Problem) -> "dict[str, Callable[[], Row]]":
        """Return the levels of the naive finite elements.

        Their nodes stick to the whole face, so they know no contact that opens and spreads.
        """
        # of a given indentation there is no error, and they know no layers
        given = {"pressure", alone.load_regime.response} - {"normal_force"}
        solvable = TOLERANCES[alone.contact].knows_others and alone.ground is None
        if not solvable or not any(map(alone.wants, given)):
            return {}
        reference = self.references[other_theory(NAIVE)]
        only = alone.with_quantities(frozenset(name for name in given if alone.wants(name)))
        return {
            f"{cells} elements": partial(
                measure.measure_naive,
                only,
                reference,
                cells,
                NAIVE_STEP * measure.stable_naive_step(only, cells),
            )
            for cells in (NAIVE_CELLS[:-1] if self.quick else NAIVE_CELLS)
        }

    def _family(self, group: str, name: str, levels: "dict[str, Callable[[], Row]]") -> Family:
        """Return the family of a group and a method."""

        def solve(setting: str) -> Row:
            asked = {"group": group, "method": name, "tolerance": tolerance_of(setting)}
            return {**asked, **levels[setting]()}

        def work(setting: str) -> float:
            return expected_seconds(self.problem, name, setting)

        return Family(f"{group}, {name}", dict.fromkeys(levels, np.nan), solve, work=work)


def tolerance_of(setting: str) -> float:
    """Return the tolerance that a setting asks for; NaN if it sets sizes or steps."""
    return float(setting.removeprefix("rtol ")) if setting.startswith("rtol ") else np.nan


def expected_seconds(problem: Problem, name: str, setting: str) -> float:
    """Return the seconds that all runs of a level are expected to take."""
    return measure.RUNS * TOLERANCES[problem.contact].seconds(name, tolerance_of(setting))


def _explicit_problems(alone: Problem) -> dict[str, Problem]:
    """Return the explicit march on coarse elements, in steps below the greatest stable one."""
    coarse = replace(alone, mdr=EXPLICIT_SIZES)
    solution = method("mdr").solve(coarse, Stages("mdr"))
    if solution.wear is None:
        return {}
    limit = solution.wear.stability_limit()
    return {
        f"step {part:g} of the limit": replace(coarse, march="explicit", step=part * limit)
        for part in STABLE_PARTS
    }
