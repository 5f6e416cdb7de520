"""Seconds, true error and error estimate of one level.

Seconds are processor time of one thread for everything that a run delivers: the solution with its
error estimates, refined if the estimates exceed the tolerance. Each level is solved at least `RUNS`
times; the table has the median, the least and the greatest seconds.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ..crosscheck import Problem, Results, Solution, SolverError, Stages, differences, method
from ..crosscheck.verdict.accuracy import solved_to_accuracy
from ..crosscheck.verdict.agreement import compare
from ..extremes import naive
from ..tables import Row

RUNS = 3
"""Least number of runs of a level."""
MOST_RUNS = 5
"""Greatest number of runs of a level that takes little time."""
ENOUGH_SECONDS = 0.25
"""A level whose runs take longer than this in all has only `RUNS` runs."""

SAME_PRESSURES = ("mdr", "bem")
"""Methods with one kind of pressure space: on the same space they agree, however coarse it is."""
TOO_FINE_REMARK = "as fine as the reference: its true error cannot be measured"
"""Remark on levels whose pressure space is at least as large as that of the reference.

The difference between the two would not show the error of the discretisation.
"""
DIVERGED_ERROR = 1e3
"""Relative error of the naive finite elements beyond which their march counts as unstable."""

Value = TypeVar("Value")


@dataclass(frozen=True)
class Timing:
    """Processor seconds of the runs of a level.

    Parameters
    ----------
    seconds : one value for each run
    """

    seconds: tuple[float, ...]

    @property
    def row(self) -> Row:
        """Columns of the table: median, least and greatest seconds, and the number of runs."""
        return {
            "seconds": float(np.median(self.seconds)),
            "least seconds": min(self.seconds),
            "greatest seconds": max(self.seconds),
            "runs": len(self.seconds),
        }


def time_runs(solve: Callable[[], Value]) -> tuple[Value, Timing]:
    """Return the value of a function, and the processor seconds of several calls of it."""
    seconds = list[float]()
    while len(seconds) < RUNS or (len(seconds) < MOST_RUNS and sum(seconds) < ENOUGH_SECONDS):
        start = time.process_time()
        value = solve()
        seconds.append(time.process_time() - start)
    return value, Timing(tuple(seconds))


def measure_method(name: str, problem: Problem, reference: Solution) -> Row:
    """Return seconds, true error, estimate and unknowns of a method, refined as by `run`.

    Parameters
    ----------
    name : name of the method
    problem : with the quantities of one group, compared at the radii of the reference
    reference : solution by another theory to a finer tolerance

    Raises
    ------
    SolverError
        if the method computes none of these quantities
    """
    solver = method(name)
    solution, timing = time_runs(
        lambda: solved_to_accuracy(solver, [problem], Stages(name))[0],
    )
    row = {"unknowns": solution.unknowns, **timing.row}
    if name in SAME_PRESSURES and solution.unknowns >= reference.unknowns:
        return {**row, "remark": TOO_FINE_REMARK}
    compared = compare(problem, (solution, reference))
    if not compared:
        raise SolverError(f"{name} computes no quantity of this group: leave it out")
    errors = {quantity: float(np.max(difference.size)) for quantity, difference in compared.items()}
    worst = max(errors, key=lambda quantity: errors[quantity])
    estimate = max(float(np.max(difference.first)) for difference in compared.values())
    return {
        **row,
        **row_of_accuracy(errors[worst], estimate),
        "worst quantity": worst,
        "estimate of the reference": float(np.max(compared[worst].second)),
    }


def measure_naive(problem: Problem, reference: Solution, cells: int, step: float) -> Row:
    """Return seconds and true error of the naive finite elements.

    Parameters
    ----------
    problem : with quantities that they compute, compared at the radii of the reference
    reference : solution by another theory to a finer tolerance
    cells : number of elements on the radius of the punch
    step : time step of explicit Euler in a/(E* k_max v0)

    Raises
    ------
    SolverError
        if the march diverges
    """

    def solve() -> Results:
        # each run has to assemble and condense anew, as the first one does
        naive.press.cache_clear()
        return naive.solve(problem, cells=cells, step=step * problem.units.time)

    values, timing = time_runs(solve)
    compared = {
        name: value[problem.compared_rows] if name != "time" else value
        for name, value in values.items()
    }
    with np.errstate(all="ignore"):
        naive_errors = differences(compared, reference.compared, problem.face)
    errors = {
        name: float(np.max(error)) for name, error in naive_errors.items() if problem.wants(name)
    }
    worst = max(errors, key=lambda name: errors[name])
    if not all(np.isfinite(list(errors.values()))) or errors[worst] > DIVERGED_ERROR:
        raise SolverError(
            "the explicit march of the naive finite elements is unstable: leave them out, or end "
            "wear.times earlier"
        )
    return {**timing.row, **row_of_accuracy(errors[worst], np.nan), "worst quantity": worst}


def stable_naive_step(problem: Problem, cells: int) -> float:
    """Return the greatest stable step of the naive finite elements in a/(E* k_max v0).

    It is two over the greatest rate at which wear makes pressures decay at a fixed indentation.
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
    """Return the columns of the table for a relative error and its estimate.

    The effectivity is the estimate over the error; it is NaN without an estimate, or if the error
    is zero.
    """
    effectivity = estimate / error if error > 0 else np.nan
    return {"estimate": estimate, "error": error, "effectivity": effectivity}
