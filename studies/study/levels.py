"""The levels of a study: solved one after the other, recorded at once, timed and announced.

A study lists families. A family is one way to refine (a mesh, a step, an outer boundary, the dial
of a method), from coarse to fine. Each level of it becomes a row of the table of the study.
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

from ...meshes.errors import RingwearError
from ..progress import LOG
from ..tables import Row, keeping_rows, without_formulas

SECONDS, MEMORY = "seconds", "peak MiB"
"""Columns that every table of levels has: seconds of wall time, and memory at its peak."""


class Theory(NamedTuple):
    """What is expected of the errors of a quantity.

    Parameters
    ----------
    order : slope of log error over log size; NaN if there is no theory
    floor : relative errors below it are shown but not counted
    reason : a sentence that says why the order is what it is, with its source
    floor_cause : what errors below the floor consist of, such as roundoff
    """

    order: float = np.nan
    floor: float = 0.0
    reason: str = ""
    floor_cause: str = ""


class Family(NamedTuple):
    """One way to refine, from coarse to fine.

    Parameters
    ----------
    name : of the family
    sizes : settings of its levels, each with its size; NaN where settings have none
    solve : setting -> row of the table
    theory : of the quantities whose orders are fitted
    xlabel : what its size is called
    work : setting -> seconds that a level is expected to take; from these, and from the seconds
        that levels took so far, follows the time left
    """

    name: str
    sizes: Mapping[Any, float]
    solve: Callable[[Any], Row]
    theory: Mapping[str, Theory] = MappingProxyType({})
    xlabel: str = ""
    work: Callable[[Any], float] = lambda _: 1.0


@dataclass
class Progress:
    """Which level of how many is solved, and how much time is left.

    Parameters
    ----------
    expected : seconds that each level was expected to take, on any machine
    """

    expected: list[float]
    done: int = 0
    elapsed: float = 0.0

    def announce(self, family: str, setting: Hashable) -> None:
        """Report which level begins, and the time left from the second level on."""
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
        """What levels are expected to take still, by what those before took."""
        expected = sum(self.expected[: self.done])
        return self.elapsed / expected * sum(self.expected[self.done :]) if expected else 0.0

    def finish(self, seconds: float) -> None:
        """Count a level that took some seconds."""
        self.done += 1
        self.elapsed += seconds


@dataclass(frozen=True)
class Record:
    """Where rows of levels go while a study works: a table on disk, or nowhere.

    Parameters
    ----------
    folder : of the tables; None keeps rows in memory alone
    conclusions : of levels that failed and of an interruption, as they come
    """

    folder: Path | None = None
    conclusions: list[str] = field(default_factory=list)

    def solve(self, name: str, families: Iterable[Family], columns: list[str]) -> pd.DataFrame:
        """Solve every level of every family; return the table, a row for each.

        A row is in the file `name.csv` as soon as its level is solved. A level that fails is a row,
        too, with a remark, and a conclusion. Ctrl-C keeps the rows before it.
        """
        families, rows = list(families), list[Row]()
        columns = [*columns, *(name for name in (SECONDS, MEMORY, "remark") if name not in columns)]
        path = self.folder / f"{name}.csv" if self.folder else None
        if path:
            pd.DataFrame(columns=columns).to_csv(path, index=False)
        progress = Progress([of.work(setting) for of in families for setting in of.sizes])
        with threadpool_limits(1), keeping_rows(self.conclusions):
            for family in families:
                for setting, size in family.sizes.items():
                    progress.announce(family.name, setting)
                    row, seconds = self._solve_level(family, setting)
                    progress.finish(seconds)
                    rows.append({"family": family.name, "setting": setting, "size": size} | row)
                    if path:
                        last = pd.DataFrame([rows[-1]], columns=columns)
                        without_formulas(last).to_csv(path, mode="a", header=False, index=False)
        return pd.DataFrame(rows, columns=columns)

    def _solve_level(self, family: Family, setting: Hashable) -> tuple[dict[str, Any], float]:
        """Return the row of a level with its cost, and the seconds that it took."""
        _forget_peak()
        start = time.perf_counter()
        try:
            row = dict(family.solve(setting))
        except RingwearError as error:
            row = {"remark": f"failed: {error}"}
            self.conclusions.append(f"{family.name}, {setting} failed: {error}")
        seconds = time.perf_counter() - start
        return {SECONDS: round(seconds, 4), MEMORY: round(_peak_mebibytes(), 1)} | row, seconds


def _forget_peak() -> None:
    """Start to count the greatest memory of this process anew, which Linux alone can do."""
    try:
        Path("/proc/self/clear_refs").write_text("5", "ascii")
    except OSError:
        # elsewhere the peak is that of all levels so far
        return


def _peak_mebibytes() -> float:
    """Return the greatest memory of this process, since it was forgotten if that can be done."""
    try:
        status = Path("/proc/self/status").read_text("ascii")
    except OSError:
        greatest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return greatest / (2**20 if sys.platform == "darwin" else 2**10)
    (line,) = (line for line in status.splitlines() if line.startswith("VmHWM"))
    return float(line.split()[1]) / 2**10
