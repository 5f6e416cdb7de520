"""Ways that a user has: a tolerance, a time step, the paper's grid; and a naive solver."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ....mdr import energy
from ....meshes import SolverError
from ...crosscheck import (
    METHODS,
    MdrAccuracy,
    Method,
    Problem,
    Solution,
    Stages,
    method,
    radial_sizes,
    solved_to_accuracy,
)
from ..way import Level, Way, inverse
from . import naive, theories
from .wear import wear_on

STEP = r"time step / $a/(E^*k_{max}v_0)$"
LONGEST_STEP_FRACTION = 0.25
"""Longest step, over the earliest time, for which the error there is proportional to the step."""
STABLE_PART = 0.8
"""Time step of the naive finite elements, relative to the greatest stable one on their mesh."""
COARSE_SPACE = MdrAccuracy.model_validate(
    {"degree": 2, "rim_size": 0.02, "ring_size": 0.02, "grading": 0.5}
)
"""Pressure space of explicit marches: so coarse that a few thousand stable steps are enough."""


def solved_by(entry: Method, problem: Problem) -> Solution:
    """Return the solution of a problem by a method, refined as a run refines it.

    Raises
    ------
    SolverError
        if the method refuses the problem
    """
    if refusal := entry.refusal(problem):
        raise SolverError(refusal)
    return solved_to_accuracy(entry, [problem], Stages(entry.name))[0]


def runs(
    name: str,
    entry: Method,
    levels: Sequence[Level],
    changed: Callable[[Problem, Level], Problem],
    refined: str,
    size: Callable[[Level], float] = float,
) -> Way:
    """Return the way through runs of one method.

    Parameters
    ----------
    name, levels, refined, size : as of the way
    entry : the method
    changed : function of a problem and a level that returns the problem to solve
    """

    def solve(problem: Problem, level: Level) -> Solution:
        return solved_by(entry, changed(problem, level))

    return Way(name, entry.name, levels, solve, refined, size)


def tolerances(entry: Method, rtols: Sequence[float]) -> Way:
    """Return the way through tolerances of a method, one of ringwear or of the user."""
    name = entry.name.upper() if entry.name in METHODS else entry.name
    way = runs(
        name, entry, rtols, lambda problem, level: replace(problem, rtol=level), "tolerance rtol"
    )
    return replace(way, promises=True, largest=0.0)


def closed_form() -> Way:
    """Return the way of direct integration, which has one level."""
    direct = method("direct")
    return runs("direct integration", direct, (1,), lambda problem, _: problem, "one level")


def paper_grid(springs: Sequence[int]) -> Way:
    """Return the way through the uniform grids of the paper."""

    def changed(problem: Problem, level: int) -> Problem:
        return replace(problem, mdr=MdrAccuracy(grid=level))

    grid = method("mdr-grid")
    return runs("the paper's grid", grid, springs, changed, "1 / number of springs", inverse)


def explicit_steps(parts: Sequence[float]) -> Way:
    """Return the way through stable explicit steps of MDR, on coarse elements.

    Parameters
    ----------
    parts : steps over the greatest stable one
    """

    def changed(problem: Problem, level: float) -> Problem:
        step = level * coarse_stability_limit(problem)
        return replace(problem, mdr=COARSE_SPACE, march="explicit", step=step)

    entry = method("mdr")
    return runs("MDR, explicit Euler", entry, parts, changed, "step / greatest stable one")


def steps(march: str, lengths: Sequence[float], case: Problem, rtol: float | None = None) -> Way:
    """Return the way through time steps of an Euler march on one space of MDR.

    Parameters
    ----------
    march : `implicit` or `explicit`
    lengths : steps in a / (E* k_max v0), from coarse to fine
    case : problem of the case, which tells whether steps are short enough to have an order
    rtol : tolerance of the space; None for the coarse one of explicit marches
    """

    def solve(problem: Problem, level: float) -> Solution:
        marched = replace(problem, march=march, step=level)
        if rtol is None:
            return on_coarse_space(marched)
        return solved_by(method("mdr"), replace(marched, rtol=rtol))

    theory = theories.for_steps(why_no_order(case, lengths))
    name = f"{march} Euler" if rtol is None else f"MDR, {march} Euler"
    return Way(name, "mdr", lengths, solve, STEP, float, theory)


def why_no_order(problem: Problem, lengths: Sequence[float]) -> str:
    """Return why errors of time steps have no order in theory; empty if they have."""
    if not problem.full_contact:
        return theories.STEP_WITH_CONTACT
    short = max(lengths) <= LONGEST_STEP_FRACTION * problem.earliest
    return "" if short else theories.LONG_STEPS


@lru_cache(maxsize=4)
def coarse_stability_limit(problem: Problem) -> float:
    """Return the greatest stable explicit step on the coarse space."""
    wear = on_coarse_space(problem).wear
    assert wear is not None
    return wear.stability_limit()


def on_coarse_space(problem: Problem) -> Solution:
    """Return the solution by the march of the problem on the coarse space of explicit marches."""
    space = radial_sizes(replace(problem, mdr=COARSE_SPACE)).space(problem)
    return wear_on(problem, energy.compliance(space, problem.ground))


@dataclass(frozen=True)
class NaiveSizes:
    """The two numbers that a user of a naive solver chooses; a level.

    Parameters
    ----------
    cells : elements on the radius of the punch
    steps : equal time steps until the last time; 0 for steps that are as long as is stable
    """

    cells: int
    steps: int = 0

    def __str__(self) -> str:
        """Return the level in the table."""
        return f"{self.cells} elements" + (f", {self.steps} steps" if self.steps else "")


def naive_elements(sizes: Sequence[NaiveSizes]) -> Way:
    """Return the way of naive finite elements: uniform, clamped at 10 radii, explicit Euler.

    They compute the indentation and the pressure of a face whose nodes all stick to the punch.
    """

    def solve(problem: Problem, level: NaiveSizes) -> Solution:
        if problem.ground.layered:
            raise SolverError("the naive finite elements have no layers: leave them out")
        naive.press.cache_clear()  # every run has to condense anew, as the first one does
        step = STABLE_PART * naive.stable_step(problem, level.cells)
        if level.steps:
            step = float(problem.times[-1]) / level.steps or 1.0
        values = naive.solve(problem, cells=level.cells, step=step)
        compared = {"time": values["time"][problem.compared_rows]}
        for name in {"pressure", problem.response} & values.keys():
            rows = values[name][problem.compared_rows]
            # values that overflow are an infinite error
            compared[name] = np.nan_to_num(rows, nan=np.inf)
        return Solution({}, compared, {}, {}, level.cells * 2 + 1)

    def size(level: NaiveSizes) -> float:
        return 1 / level.cells

    return Way("naive finite elements", "naive", sizes, solve, "1 / elements on the radius", size)
