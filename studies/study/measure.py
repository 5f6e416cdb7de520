"""The loop of every study: solve every level of every way for every case, and tabulate errors.

The table is tidy: it has one row for each quantity of each level, with the columns of
`record.COLUMNS`. A level that fails has one row, with the reason.
"""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ...meshes import Array, RingwearError
from ..crosscheck import LOG, Results, Solution, allowed_error
from ..tables.writing import keeping_rows
from .errors import (
    ITSELF,
    error,
    estimate,
    in_units,
    parts_of,
    promised_times,
    values_of,
    values_of_functions,
)
from .extrapolation import richardson
from .own import Named
from .record import CRASHED, REFUSED, SOLVED, Record, Row
from .way import ALL, START, Case, Part, Way

if TYPE_CHECKING:
    from .reference import Reference

MOST_RUNS, ENOUGH_SECONDS = 5, 0.25
"""Greatest number of runs of a level; fewer are enough if they take longer than this in all."""


def measure(
    cases: Iterable[Case],
    ways: Iterable[Way] | Callable[[Case], Iterable[Way]],
    quantities: Sequence[str],
    record: Record,
    functions: Named | None = None,
    *,
    exact: "Callable[[Case], Reference]",
    runs: int = 1,
    only_promised: bool = False,
) -> pd.DataFrame:
    """Solve every level, and return the table of errors.

    After Ctrl-C the table has the levels that were solved before. A way ends at a level that fails.

    Parameters
    ----------
    cases : what to solve
    ways : how to solve it; a function if the ways depend on the case
    quantities : names as in results.nc, and those of finite elements
    record : rows so far, and the file that they are written to
    functions : functions of a result that the user defines, by the names of their quantities
    exact : function of a case that returns its reference
    runs : least number of times that a level is solved; its seconds are the median
    only_promised : whether errors are taken only at times at which the accuracy is promised

    Raises
    ------
    RingwearError
        if the reference of a case cannot be computed
    """
    functions = functions or {}
    names = (*quantities, *functions)
    with threadpool_limits(1), keeping_rows(record.remarks):
        listed = [(case, list(ways(case) if callable(ways) else ways)) for case in cases]
        total, first = sum(len(way.levels) for _, each in listed for way in each), 1
        for case, ways_of_case in listed:
            case_reference = exact(case)
            parts = parts_of(case, case_reference.values, names)
            for way in ways_of_case:
                judge = _Judge(case, way, parts, case_reference, functions, only_promised)
                _measure_way(judge, record, first, total, runs)
                first += len(way.levels)
    return record.table


def _measure_way(judge: "_Judge", record: Record, first: int, total: int, runs: int) -> None:
    """Solve the levels of a way that an earlier run has not solved, and add their rows.

    The number of its first level, and that of all levels, are logged.
    """
    case, way = judge.case, judge.way
    earlier = record.earlier(case.name, way.name)
    outcomes = [rows[0]["outcome"] for rows in earlier.values()]
    # an earlier run has solved all levels, or has failed
    done = len(earlier) == len(way.levels) or outcomes[-1:] not in ([], [SOLVED])
    previous, seconds_before = None, 0.0
    for number, level in enumerate(way.levels):
        rows = earlier.get(str(level), [])
        # extrapolation needs the two levels before the first new one, and some ways need them all
        needed = way.sequential or number >= len(earlier) - 2
        if rows and (done or not needed):
            record.add(rows)
            if rows[0]["outcome"] != SOLVED:
                return
            continue
        names = case.name, way.name, level
        LOG.info("   level %d of %d: %s, %s, %s ...", first + number, total, *names)
        facts, solution = _solve(case, way, level, previous, runs)
        if solution is None:
            record.add([facts])
            return
        if way.sequential:
            seconds_before = facts["seconds"] = seconds_before + facts["seconds"]
        judged = judge.rows(facts, solution)
        record.add(rows or judged)
        previous = solution


def _solve(
    case: Case, way: Way, level: Any, previous: Solution | None, runs: int
) -> tuple[dict[str, Any], Solution | None]:
    """Return the facts of a level, and its solution, which is None if the level fails."""
    facts: dict[str, Any] = {
        "case": case.name,
        "parameter": case.parameter,
        "way": way.name,
        "method": way.method,
        "refined": way.refined,
        "level": str(level),
    }
    start = time.process_time()
    try:
        before = [previous] if way.sequential else []
        solution, seconds = timed(partial(way.solve, case.problem, level, *before), runs)
    except Exception as failure:  # a study of extreme parameters looks for these
        facts |= {"outcome": CRASHED, "message": f"{type(failure).__name__}: {failure}"}
        if isinstance(failure, RingwearError):
            facts |= {"outcome": REFUSED, "message": str(failure)}
        return facts | {"seconds": time.process_time() - start}, None
    size = way.size(level) if way.size else max(solution.unknowns, 1) ** -0.5
    facts |= {"size": size, "unknowns": solution.unknowns, "outcome": SOLVED}
    if way.promises:
        facts["tolerance"] = level / case.problem.rtol * allowed_error(case.problem)
    if runs > 1:
        facts |= {"least seconds": min(seconds), "greatest seconds": max(seconds)}
    return facts | {"seconds": float(np.median(seconds))}, solution


def timed(solve: Callable[[], Solution], runs: int) -> tuple[Solution, list[float]]:
    """Return a solution, and the processor seconds of several runs: more of short ones."""
    seconds = list[float]()
    while len(seconds) < runs or (
        runs > 1 and len(seconds) < MOST_RUNS and sum(seconds) < ENOUGH_SECONDS
    ):
        start = time.process_time()
        solution = solve()
        seconds.append(time.process_time() - start)
    return solution, seconds


@dataclass
class _Judge:
    """Errors of the levels of one way; it remembers the last three levels for extrapolation."""

    case: Case
    way: Way
    parts: Sequence[Part]
    exact: "Reference"
    functions: Named
    only_promised: bool
    levels: list[tuple[float, Results]] = field(default_factory=list)

    def rows(self, facts: dict[str, Any], solution: Solution) -> list[Row]:
        """Return the rows of a level: one for each quantity that its solution has."""
        problem, method, exact = self.case.problem, self.way.method, self.exact
        wanted = {part.quantity for part in self.parts}
        values = values_of(self.case, solution, wanted)
        values |= values_of_functions(self.case, method, solution, self.functions)
        self.levels = [*self.levels[-2:], (facts["size"], values)]
        rows = list[Row]()
        for part in self.parts:
            if part.quantity not in values:
                continue
            among: NDArray[np.bool_] | bool = True
            if self.only_promised:
                among = promised_times(problem, part.quantity, method, solution)
            if not np.any(among):
                continue
            limit, index = self._richardson(part)
            judged = {
                "quantity": part.quantity,
                "when": part.when,
                "error": error(part, values, exact.values, problem, among),
                "estimate": estimate(part, solution, problem, among),
                "index": index,
                "limit": limit,
                "reference": exact.errors(part),
                "computed": in_units(part, values, problem),
            }
            rows.append(facts | judged)
        return rows or [facts]

    def _richardson(self, part: Part) -> tuple[float, float]:
        """Return the error of Richardson's limit and the grid convergence index; NaN if none."""
        missing = any(part.quantity not in values for _, values in self.levels)
        if len(self.levels) < 3 or missing or part.quantity in ITSELF:
            return np.nan, np.nan
        name, exact, problem = part.quantity, self.exact.values, self.case.problem
        sizes, levels = zip(*self.levels, strict=True)
        signed = np.array([error(part, values, exact, problem) for values in levels])
        # one number has a sign, which shows whether the last levels converge monotonically
        value = np.asarray(levels[-1][name])
        if value.ndim <= (part.when != ALL) and (part.when == START or value.size <= 1):
            return richardson(np.array(sizes), signed)
        arrays = [np.asarray(values[name]) for values in (*levels, exact)]
        # the part that all levels have, such as the first relaxation times
        shapes = zip(*(array.shape for array in arrays), strict=True)
        common = tuple(slice(0, min(lengths)) for lengths in shapes)
        first, second, third, right = (array[common] for array in arrays)

        def norm(deviation: Array) -> float:
            return abs(error(part, {name: right + deviation}, exact, problem))

        def error_of_limit(weight: float) -> float:
            return norm(third + weight * (third - second) - right)

        changes = np.array([norm(second - first), norm(third - second)])
        return richardson(np.array(sizes), signed, changes, error_of_limit)
