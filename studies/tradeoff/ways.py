"""The ways to compute a group of quantities: methods and marches, each with its levels.

The levels of a way go from coarse to fine, by tolerance, by time step or by number of elements.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..crosscheck import Problem, SceneError, Solution, Stages, method
from ..crosscheck.problem.quantities import GROUPS
from ..crosscheck.problem.sections import MdrAccuracy
from ..extremes.oracles import other_theory, solve_reference
from ..study.levels import Family
from ..tables import Row
from . import measure
from .tolerances import TOLERANCES

QUANTITY_GROUPS = {
    "indentation, force, relaxation times": frozenset(
        ["indentation", "normal_force", "relaxation_time"]
    ),
    "history": GROUPS["history"],
    "fields": GROUPS["fields"],
    "steady state": GROUPS["steady"],
}
"""Groups of quantities; each group is computed by itself."""
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
"""All methods and marches, by their names in the option `methods`."""

IMPLICIT_STEPS = (0.1, 0.01, 0.001)
"""Time steps of the implicit march in a/(E* k_max v0)."""
EXPLICIT_STEPS = (0.9, 0.3, 0.1)
"""Time steps of the explicit march, relative to the greatest stable one."""
EXPLICIT_SIZES = MdrAccuracy(degree=2, rim_size=0.02, ring_size=0.02, grading=0.5)
"""Elements of the explicit march: so coarse that a few thousand stable steps are enough."""
NAIVE_CELLS = (5, 10, 20, 40)
"""Numbers of elements on the radius of the punch in the naive finite elements."""
NAIVE_STEP = 0.8
"""Time step of the naive finite elements, relative to the greatest stable one on their mesh."""


@dataclass(frozen=True, eq=False)
class Ways:
    """The methods and marches to measure on one problem, and their references.

    Parameters
    ----------
    problem : problem of the scene, with the radii at which solutions are compared
    references : reference solutions, by the name of their method
    names : methods and marches to measure, out of `WAYS`
    quick : whether fewer levels are enough
    """

    problem: Problem
    references: Mapping[str, Solution]
    names: tuple[str, ...]
    quick: bool

    @classmethod
    def with_references(cls, problem: Problem, names: tuple[str, ...], quick: bool) -> "Ways":
        """Create the ways of a problem, and solve the references that they need.

        Raises
        ------
        RingwearError
            if a reference cannot be computed
        """
        rtol = TOLERANCES[problem.full_contact].of_reference(quick)
        problem = replace(problem, march="modal", step=None)
        problem = replace(problem, compared_on=replace(problem, rtol=rtol).face)
        reference_methods = dict.fromkeys(other_theory(name.split()[0]) for name in names)
        references = {name: solve_reference(problem, name, rtol) for name in reference_methods}
        return cls(problem, references, names, quick)

    def families(self) -> Iterator[Family]:
        """Yield a family for each group of quantities and each way that can compute it."""
        for group, quantities in QUANTITY_GROUPS.items():
            try:
                group_problem = self.problem.with_quantities(quantities)
            except SceneError:
                # the scene has none of these quantities
                continue
            # there is no steady state at a fixed indentation
            if method("mdr").refusal(group_problem):
                continue
            for name in self.names:
                if levels := self._levels(name, group_problem, quantities):
                    yield self._family(group, name, levels)

    def _levels(
        self, name: str, group_problem: Problem, quantities: frozenset[str]
    ) -> "dict[str, Callable[[], Row]]":
        """Return the levels of a method or a march, from coarse to fine.

        The levels are functions that solve one level each, by the text of its setting. There are
        none if the way cannot compute the group.
        """
        if name == NAIVE:
            return self._naive_levels(group_problem)
        problems: dict[str, Problem] = {}
        tolerances = TOLERANCES[self.problem.full_contact]
        can_march = tolerances.with_full_contact_methods and quantities <= GROUPS["history"]
        if name in BY_TOLERANCE:
            problems = {
                f"rtol {rtol:.0e}": replace(group_problem, rtol=rtol)
                for rtol in tolerances.asked(self.quick)
            }
        elif name == DIRECT and quantities <= GROUPS["steady"]:
            problems = {"closed form": group_problem}
        elif name == IMPLICIT and can_march:
            stepped = replace(group_problem, march="implicit", rtol=1e-4)
            problems = {f"step {step:g}": replace(stepped, step=step) for step in IMPLICIT_STEPS}
        elif name == EXPLICIT and can_march:
            problems = _explicit_problems(group_problem)
        elif name == GRID and can_march:
            problems = {
                f"n = {count}": replace(group_problem, mdr=MdrAccuracy(grid=count))
                for count in ((50, 100, 200) if self.quick else (50, 100, 200, 400))
            }
        solver = name.split()[0]
        reference = self.references[other_theory(solver)]
        return {
            setting: partial(measure.measure_method, solver, problem, reference)
            for setting, problem in problems.items()
            if not method(solver).refusal(problem)
        }

    def _naive_levels(self, group_problem: Problem) -> "dict[str, Callable[[], Row]]":
        """Return the levels of the naive finite elements.

        They cannot solve contact that opens or spreads, because their nodes stick to the whole
        face, and they have no layers.
        """
        # they compute the pressure and the indentation; a given indentation has no error
        computed = {"pressure", group_problem.response} - {"normal_force"}
        solvable = (
            TOLERANCES[group_problem.full_contact].with_full_contact_methods
            and not group_problem.ground.layered
        )
        if not solvable or not any(map(group_problem.wants, computed)):
            return {}
        reference = self.references[other_theory(NAIVE)]
        problem = group_problem.with_quantities(
            frozenset(name for name in computed if group_problem.wants(name))
        )
        return {
            f"{cells} elements": partial(
                measure.measure_naive,
                problem,
                reference,
                cells,
                NAIVE_STEP * measure.stable_naive_step(problem, cells),
            )
            for cells in (NAIVE_CELLS[:-1] if self.quick else NAIVE_CELLS)
        }

    def _family(self, group: str, name: str, levels: "dict[str, Callable[[], Row]]") -> Family:
        """Return the family of a group and a method or a march."""

        def solve(setting: str) -> Row:
            level = {"group": group, "method": name, "tolerance": tolerance_of(setting)}
            return {**level, **levels[setting]()}

        def work(setting: str) -> float:
            return expected_seconds(self.problem, name, setting)

        return Family(f"{group}, {name}", dict.fromkeys(levels, np.nan), solve, work=work)


def tolerance_of(setting: str) -> float:
    """Return the tolerance of a setting; NaN if the setting gives sizes or steps instead."""
    return float(setting.removeprefix("rtol ")) if setting.startswith("rtol ") else np.nan


def expected_seconds(problem: Problem, name: str, setting: str) -> float:
    """Return the expected seconds of all runs of a level."""
    return measure.RUNS * TOLERANCES[problem.full_contact].seconds(name, tolerance_of(setting))


def _explicit_problems(group_problem: Problem) -> dict[str, Problem]:
    """Return the problems of the explicit march: coarse elements, steps below the stable limit."""
    coarse = replace(group_problem, mdr=EXPLICIT_SIZES)
    solution = method("mdr").solve(coarse, Stages("mdr"))
    if solution.wear is None:
        return {}
    limit = solution.wear.stability_limit()
    return {
        f"step {part:g} of the limit": replace(coarse, march="explicit", step=part * limit)
        for part in EXPLICIT_STEPS
    }
