"""Orders of convergence from sequences of refined levels.

A level is one computation with one size: of the elements, of the step, or of ``a/R``. The observed
order is the slope of ``log error`` over ``log size``: between neighbouring levels, and by least
squares over all that lie above the floor where roundoff or another error takes over.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ...meshes.compliance import Compliance
from ...meshes.errors import RingwearError
from ...meshes.radial import Array
from ..figures.style import curve, legend_below, plain_numbers
from ..progress import LOG
from ..tables import Table, keeping_rows

# how far observed orders may be from theory's, by least squares and between the last levels
WITHIN = 0.15
VERDICT = f"within {WITHIN}"  # the column that says so
LEVEL_FIELDS = ("refined", "quantity", "level", "size", "unknowns", "value", "error", "remark")
ORDER_FIELDS = (
    "refined",
    "quantity",
    "levels",
    "expected order",
    "least squares",
    "last levels",
    VERDICT,
    "between levels",
    "finest error",
)


def least_squares(sizes: Array, errors: Array) -> float:
    """Observed order over all levels; NaN of fewer than two."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0]) if len(sizes) > 1 else np.nan


@dataclass
class Sequence:
    """One quantity on levels from coarse to fine.

    Parameters
    ----------
    name : what was refined
    quantity : what was computed
    expected : order that theory gives; NaN if it gives none
    exact : value without the error that is studied; 0 where values are errors themselves
    floor : relative errors below it are shown but not counted
    sizes, values, unknowns : (n,) of the levels
    coarsest : levels of a greater size are shown but not counted: what theory neglects is not small
        there
    """

    name: str
    quantity: str
    expected: float = np.nan
    exact: float = 0.0
    floor: float = 0.0
    sizes: Array = field(default_factory=lambda: np.empty(0))
    values: Array = field(default_factory=lambda: np.empty(0))
    coarsest: float = np.inf
    unknowns: Array = field(default_factory=lambda: np.empty(0))

    def add(self, size: float, value: float, unknowns: float = np.nan) -> None:
        """Add the next finer level."""
        self.sizes, self.values = np.append(self.sizes, size), np.append(self.values, value)
        self.unknowns = np.append(self.unknowns, unknowns)

    @property
    def errors(self) -> Array:
        """(n,) relative errors; absolute ones of what should be zero."""
        return np.abs(self.values - self.exact) / (abs(self.exact) or 1.0)

    @property
    def counted(self) -> NDArray[np.bool_]:
        return (self.errors > self.floor) & (self.sizes <= self.coarsest)

    @property
    def order(self) -> float:
        """Observed order by least squares over the levels that count."""
        return least_squares(self.sizes[self.counted], self.errors[self.counted])

    @property
    def last_order(self) -> float:
        """Observed order between the last two levels that count."""
        return least_squares(self.sizes[self.counted][-2:], self.errors[self.counted][-2:])

    @property
    def orders(self) -> Array:
        """(n-1,) observed orders between neighbouring levels; NaN at an error of zero."""
        return np.diff(np.log(np.where(self.errors > 0, self.errors, np.nan))) / np.diff(
            np.log(self.sizes)
        )

    @property
    def verdict(self) -> str:
        """Whether the observed orders are those of theory, and if not, what can be seen of the
        reason.
        """
        if np.isnan(self.expected):
            return ""
        if np.isnan(self.order):
            return "too few levels above the floor"
        if max(abs(self.order - self.expected), abs(self.last_order - self.expected)) <= WITHIN:
            return "yes"
        if np.ptp(np.sign(self.values - self.exact)[self.counted]):
            return "no: the error changes sign"
        distance = np.abs(self.orders - self.expected)[self.counted[1:] & self.counted[:-1]]
        return (
            "no: still approaching" if len(distance) > 1 and (np.diff(distance) < 0).all() else "no"
        )

    def summary(self) -> dict[str, Any]:
        """A row for a table of orders; in brackets between levels of which one does not count."""
        both = self.counted[1:] & self.counted[:-1]
        return {
            "refined": self.name,
            "quantity": self.quantity,
            "levels": f"{self.counted.sum()} of {len(self.sizes)}",
            "expected order": self.expected,
            "least squares": self.order,
            "last levels": self.last_order,
            VERDICT: self.verdict,
            "between levels": " ".join(
                f"{p:.2f}" if own else f"({p:.2f})"
                for p, own in zip(self.orders, both, strict=True)
            ),
            "finest error": f"{self.errors[-1]:.1e}",
        }


class Refinement(NamedTuple):
    """What is refined.

    Sequences of one name, size by the level (a count, a ratio, a degree), and how a level is
    computed.

    `discretise` a level to its compliance and number of unknowns; `quantities` of a compliance, at
    least the sequences'.
    """

    sequences: list[Sequence]
    levels: Mapping[Any, float]
    discretise: Callable[[Any], tuple[Compliance, int]]
    quantities: Callable[[Compliance], Mapping[str, float]]


def refined(
    refinements: Iterable[Refinement], path: Path, conclusions: list[str]
) -> list[Sequence]:
    """Compute and tabulate every level.

    One that fails is a row, too, and Ctrl-C keeps those before it.
    """
    table = Table(path, LEVEL_FIELDS)
    begun: list[Sequence] = []
    with threadpool_limits(1), keeping_rows(conclusions):
        for sequences, levels, discretise, quantities in refinements:
            begun += sequences
            for level, size in levels.items():
                row = {"refined": sequences[0].name, "level": level, "size": size}
                LOG.info("   level  %s, %.3g ...", row["refined"], level)
                try:
                    compliance, row["unknowns"] = discretise(level)
                    values = quantities(compliance)
                except RingwearError as error:
                    table.add(**row, remark=f"failed: {error}")
                    continue
                for one in sequences:
                    value = values[one.quantity]
                    one.add(size, value, row["unknowns"])
                    table.add(
                        **row,
                        quantity=one.quantity,
                        value=value,
                        error=(value - one.exact) / (one.exact or 1.0),
                    )
    return [one for one in begun if len(one.sizes)]


def verdicts(sequences: Iterable[Sequence]) -> str:
    """How many observed orders are those of theory, and which are not, in a sentence."""
    judged = [one for one in sequences if one.verdict]
    off = [f"{one.name}, {one.quantity} ({one.verdict})" for one in judged if one.verdict != "yes"]
    agree = f"{len(judged) - len(off)} of {len(judged)} orders are within {WITHIN} of theory"
    line = f"{agree}, fitted and between the last levels"
    return f"{line}; but {'; '.join(off)}." if off else f"{line}."


def draw_errors(axes: Any, curves: Mapping[str, tuple[Array, Array]], **labels: str) -> None:
    """Errors, logarithmic, over sizes, unknowns or degrees: a curve for each label."""
    for number, (label, (places, errors)) in enumerate(curves.items()):
        axes.semilogy(places, np.where(errors > 0, errors, np.nan), label=label, **curve(number))
    axes.set(**labels)
    axes.title.set_fontsize(9)
    axes.grid(True, which="major", color="0.88", linewidth=0.6)


def draw_orders(
    axes: Any, sequences: Iterable[Sequence], size_label: str, error_label: str, title: str = ""
) -> None:
    """Error over size, logarithmic, with the observed order of each sequence in the legend."""
    curves = {
        f"{one.name}: {one.order:.2f} (theory {one.expected:g})": (one.sizes, one.errors)
        for one in sequences
    }
    draw_errors(axes, curves, xlabel=size_label, ylabel=error_label, title=title)
    axes.set_xscale("log")
    if curves:  # there are none after an early interruption
        low, high = axes.get_xlim()
        axes.xaxis.set(
            major_locator=LogLocator(subs=(1, 2, 5) if high < 30 * low else (1,)),
            minor_formatter=NullFormatter(),
        )
        plain_numbers(axes.xaxis)
        legend_below(axes, title="observed order")
