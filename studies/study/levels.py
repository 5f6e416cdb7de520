"""Solve the levels of a study, one after the other, and write one row of a table for each.

A study lists families. A family is one way to refine from coarse to fine: a mesh, a time step, the
radius of the outer boundary, or the tolerance of a method. Each level of a family is one row of the
study's table. Its wall time and peak memory are measured, and progress is logged.
"""

import resource
import sys
import time
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from ..crosscheck import LOG, RingwearError
from ..tables import Row, keeping_rows, without_formulas

SECONDS, MEMORY = "seconds", "peak MiB"
"""Columns of every table of levels: wall time in seconds, and peak memory in MiB."""


class Theory(NamedTuple):
    """Theoretical order of convergence of a quantity.

    Parameters
    ----------
    order : slope of log error over log size; NaN if there is no theory
    floor : relative error; levels with smaller errors are shown but not used to fit the order
    reason : a sentence that explains the order, with its source
    floor_cause : source of the errors below the floor, such as roundoff
    """

    order: float = np.nan
    floor: float = 0.0
    reason: str = ""
    floor_cause: str = ""


class Family(NamedTuple):
    """One way to refine, from coarse to fine.

    Parameters
    ----------
    name : name of the family
    sizes : size of each level, by the setting of the level; NaN if a setting has no size
    solve : function that solves the level of a setting and returns its row of the table
    theory : theory of each quantity whose order is fitted, by the name of the quantity
    xlabel : label of the size in figures
    work : function that returns the expected seconds of the level of a setting. The remaining time
        is estimated from these seconds and from the measured seconds of the levels solved so far.
    """

    name: str
    sizes: Mapping[Any, float]
    solve: Callable[[Any], Row]
    theory: Mapping[str, Theory] = MappingProxyType({})
    xlabel: str = ""
    work: Callable[[Any], float] = lambda _: 1.0


@dataclass
class Progress:
    """Number of solved levels, and estimate of the remaining time.

    Parameters
    ----------
    expected : expected seconds of each level; only their ratios matter
    done : number of levels that are solved
    elapsed : seconds that these levels took
    """

    expected: list[float]
    done: int = 0
    elapsed: float = 0.0

    def announce(self, family: str, setting: Hashable) -> None:
        """Log which level begins and, from the second level on, the estimated remaining time."""
        LOG.info(
            "   level %d of %d%s: %s, %s ...",
            self.done + 1,
            len(self.expected),
            f", about {self.seconds_left:.0f} s left" if self.done else "",
            family,
            setting,
        )

    @property
    def seconds_left(self) -> float:
        """Estimated seconds of the remaining levels: expected seconds times measured / expected."""
        expected = sum(self.expected[: self.done])
        return self.elapsed / expected * sum(self.expected[self.done :]) if expected else 0.0

    def finish(self, seconds: float) -> None:
        """Count one more solved level, which took the given seconds."""
        self.done += 1
        self.elapsed += seconds


@dataclass(frozen=True)
class Record:
    """Solver of levels that writes each row to a table on disk, or keeps rows only in memory.

    Parameters
    ----------
    folder : folder of the tables; if None, rows are kept only in memory
    conclusions : sentences about levels that failed and about an interruption, appended as they
        occur
    """

    folder: Path | None = None
    conclusions: list[str] = field(default_factory=list)

    def solve(self, name: str, families: Iterable[Family], columns: list[str]) -> pd.DataFrame:
        """Solve every level of every family; return the table with one row for each level.

        A row is written to the file `name.csv` as soon as its level is solved. A level that fails
        also has a row, with a remark, and adds a conclusion. After Ctrl-C the rows of the levels
        that were solved before are kept.
        """
        families, rows = list(families), list[Row]()
        columns = [*columns, *(name for name in (SECONDS, MEMORY, "remark") if name not in columns)]
        path = self.folder / f"{name}.csv" if self.folder else None
        if path:
            pd.DataFrame(columns=columns).to_csv(path, index=False)
        progress = Progress(
            [family.work(setting) for family in families for setting in family.sizes]
        )
        with threadpool_limits(1), keeping_rows(self.conclusions):
            for family in families:
                for setting, size in family.sizes.items():
                    progress.announce(family.name, setting)
                    row, seconds = self._solve_level(family, setting)
                    progress.finish(seconds)
                    rows.append({"family": family.name, "setting": setting, "size": size} | row)
                    if path:
                        new_row = pd.DataFrame([rows[-1]], columns=columns)
                        without_formulas(new_row).to_csv(path, mode="a", header=False, index=False)
        return pd.DataFrame(rows, columns=columns)

    def _solve_level(self, family: Family, setting: Hashable) -> tuple[dict[str, Any], float]:
        """Solve a level; return its row with wall time and peak memory, and its seconds."""
        _reset_peak()
        start = time.perf_counter()
        try:
            row = dict(family.solve(setting))
        except RingwearError as error:
            row = {"remark": f"failed: {error}"}
            self.conclusions.append(f"{family.name}, {setting} failed: {error}")
        seconds = time.perf_counter() - start
        return {SECONDS: round(seconds, 4), MEMORY: round(_peak_mebibytes(), 1)} | row, seconds


def _reset_peak() -> None:
    """Start to measure the peak memory of this process anew, which is possible only on Linux."""
    try:
        Path("/proc/self/clear_refs").write_text("5", "ascii")
    except OSError:
        # on other systems the reported peak is the maximum over all levels so far
        return


def _peak_mebibytes() -> float:
    """Return the peak memory of this process in MiB, on Linux since the last `_reset_peak`."""
    try:
        status = Path("/proc/self/status").read_text("ascii")
    except OSError:
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return peak / (2**20 if sys.platform == "darwin" else 2**10)
    (line,) = (line for line in status.splitlines() if line.startswith("VmHWM"))
    return float(line.split()[1]) / 2**10
