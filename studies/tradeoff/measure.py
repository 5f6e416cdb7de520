"""Seconds, true error and stated error of one solution.

Seconds are those of the processor, of one thread, for everything that a run delivers: the solution
with its error estimates, and refined if these fall short. Each level is solved at least `RUNS`
times; its seconds are their median, and the least and the greatest are kept.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ...meshes.errors import SolverError
from ..crosscheck.accuracy import solved_to_accuracy
from ..crosscheck.agreement import compare
from ..extremes import naive
from ..methods.base import Solution, method
from ..problem.problem import Problem
from ..progress import Stages
from ..sampling.norms import Results, differences
from ..tables import Row

RUNS = 3
"""Least number of runs of a level."""
MOST_RUNS = 5
"""Greatest number of runs of a level that takes little time."""
ENOUGH_SECONDS = 0.25
"""Seconds of all runs of a level beyond which it has only `RUNS` runs."""

SAME_PRESSURES = ("mdr", "bem")
"""Methods on pressures of one kind: on the same pressures they agree, however few these are."""
TOO_FINE = "as fine as the reference: its true error cannot be told"
"""Remark of levels whose error would be that of the theory alone."""
UNSTABLE = 1e3
"""Relative errors of the naive finite elements beyond which their march is unstable."""

Value = TypeVar("Value")


@dataclass(frozen=True)
class Timing:
    """Processor seconds of the runs of a level.

    Parameters
    ----------
    seconds : of each run
    """

    seconds: tuple[float, ...]

    @property
    def row(self) -> Row:
        """The columns of the table: the median, the least, the greatest, and how many runs."""
        return {
            "seconds": float(np.median(self.seconds)),
            "least seconds": min(self.seconds),
            "greatest seconds": max(self.seconds),
            "runs": len(self.seconds),
        }


def time_runs(solve: Callable[[], Value]) -> tuple[Value, Timing]:
    """Return what a function returns, and the processor seconds of several calls."""
    seconds = list[float]()
    while len(seconds) < RUNS or (len(seconds) < MOST_RUNS and sum(seconds) < ENOUGH_SECONDS):
        start = time.process_time()
        value = solve()
        seconds.append(time.process_time() - start)
    return value, Timing(tuple(seconds))


def measure_method(name: str, problem: Problem, reference: Solution) -> Row:
    """Return seconds, true error, estimate and unknowns of a method, refined as `run` does it.

    Parameters
    ----------
    name : of the method
    problem : with the quantities that are asked for, compared at the radii of the reference
    reference : solution by another theory, to a finer accuracy

    Raises
    ------
    SolverError
        if the method gives none of these quantities
    """
    solver = method(name)
    solution, timing = time_runs(
        lambda: solved_to_accuracy(solver, [problem], Stages(name))[0],
    )
    row = {"unknowns": solution.unknowns, **timing.row}
    if name in SAME_PRESSURES and solution.unknowns >= reference.unknowns:
        return {**row, "remark": TOO_FINE}
    compared = compare(problem, (solution, reference))
    if not compared:
        raise SolverError(f"{name} gives none of the quantities of this group: leave it out")
    errors = {quantity: float(np.max(of.size)) for quantity, of in compared.items()}
    worst = max(errors, key=lambda quantity: errors[quantity])
    estimate = max(float(np.max(of.first)) for of in compared.values())
    return {
        **row,
        **row_of_accuracy(errors[worst], estimate),
        "worst quantity": worst,
        "estimate of the reference": float(np.max(compared[worst].second)),
    }


def measure_naive(problem: Problem, reference: Solution, cells: int, step: float) -> Row:
    """Return seconds and true error of the naive finite elements, in what they give of a group.

    Parameters
    ----------
    problem : with the quantities that are asked for, compared at the radii of the reference
    reference : solution by another theory, to a finer accuracy
    cells : elements on the radius of the punch
    step : of explicit Euler, non-dimensional

    Raises
    ------
    SolverError
        if the march overflows
    """

    def solve() -> Results:
        # each run has to assemble and to condense
        naive.press.cache_clear()
        return naive.solve(problem, cells=cells, step=step * problem.units.time)

    values, timing = time_runs(solve)
    given = {
        name: value[problem.checked] if name != "time" else value for name, value in values.items()
    }
    with np.errstate(all="ignore"):
        found = differences(given, reference.checked, problem.face)
    errors = {name: float(np.max(of)) for name, of in found.items() if problem.wants(name)}
    worst = max(errors, key=lambda name: errors[name])
    if not all(np.isfinite(list(errors.values()))) or errors[worst] > UNSTABLE:
        raise SolverError(
            "the explicit march of the naive finite elements is unstable: leave them out, or end "
            "wear.times earlier"
        )
    return {**timing.row, **row_of_accuracy(errors[worst], np.nan), "worst quantity": worst}


def stable_naive_step(problem: Problem, cells: int) -> float:
    """Return the greatest stable step of the naive finite elements, in units of the problem.

    It is two over the greatest rate at which pressures decay by wear, at a fixed indentation.
    """
    units, hole = problem.units, problem.inner_radius
    face = naive.press(
        units.length,
        hole * units.length,
        units.modulus,
        problem.poisson_ratio,
        naive.OUTER,
        cells,
    )
    wear = problem.merged.at(np.clip(face.radii / units.length, hole, 1.0))
    pressures = np.linalg.solve(face.mass, face.stiffness) * units.displacement / units.pressure
    return float(2 / np.abs(np.linalg.eigvals(pressures * wear[:, None])).max())


def row_of_accuracy(error: float, estimate: float) -> Row:
    """Return the columns of the table about an error and its estimate, relative.

    The effectivity is the estimate over the error; NaN without an estimate or an error.
    """
    effectivity = estimate / error if error > 0 else np.nan
    return {"estimate": estimate, "error": error, "effectivity": effectivity}
