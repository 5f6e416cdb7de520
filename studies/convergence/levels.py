"""Orders of convergence from sequences of refined levels, and the tables and figures that show them.

A level is one computation with one size: of the elements, of the step, or of ``a/R``. The observed order is the slope
of ``log error`` over ``log size``: between neighbouring levels, and by least squares over all that lie above the floor
where roundoff or another error takes over. Without an exact value Richardson's extrapolation takes its place, and the
grid convergence index (GCI) bounds what is left: ``SAFETY |v1 - v2| / (r^p - 1)`` with the order observed on three levels.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray
from ringwear.meshes.radial import Array
from ringwear.studies.registry import INTERRUPTED
from scipy.optimize import brentq

SAFETY = 1.25  # of the GCI with three or more levels (Roache)
HIGHEST_ORDER = 20.0
ASYMPTOTIC = 0.25  # relative: how far the order on three levels may be from what it should be
WITHIN = 0.15  # how far observed orders may be from theory's, by least squares and between the last levels
VERDICT = f"within {WITHIN}"  # the column that says so
MARKERS = "os^Dvx+*"
LINES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))
GREYS = ("0.0", "0.45", "0.2", "0.6", "0.35")


def between(sizes: Array, errors: Array) -> Array:
    """(n-1,) observed orders between neighbouring levels; NaN where an error is zero."""
    with np.errstate(divide="ignore", invalid="ignore"):
        result = np.diff(np.log(np.abs(errors))) / np.diff(np.log(sizes))
    return np.where(np.isfinite(result), result, np.nan)


def least_squares(sizes: Array, errors: Array) -> float:
    """Observed order over all levels; NaN with fewer than two errors that are not zero."""
    kept = np.abs(errors) > 0
    if kept.sum() < 2:
        return float("nan")
    return float(np.polyfit(np.log(sizes[kept]), np.log(np.abs(errors[kept])), 1)[0])


def order_of_three(sizes: Array, values: Array) -> float:
    """Order observed on three levels without an exact value; NaN if they do not converge monotonically.

    Parameters
    ----------
    sizes, values : (3,) from coarse to fine, in any ratio of refinement
    """
    coarse, fine = values[0] - values[1], values[1] - values[2]
    if not coarse * fine > 0:
        return float("nan")
    first, second = sizes[0] / sizes[1], sizes[1] / sizes[2]

    def mismatch(order: float) -> float:
        return float(np.log(np.expm1(order * np.log(first)) / -np.expm1(-order * np.log(second))) - np.log(coarse / fine))

    if mismatch(1e-3) * mismatch(HIGHEST_ORDER) > 0:
        return float("nan")
    return float(brentq(mismatch, 1e-3, HIGHEST_ORDER))


@dataclass(frozen=True)
class Extrapolated:
    """What the three finest levels say of the limit.

    Parameters
    ----------
    value : Richardson's extrapolation; the finest value where there is no order
    order : observed on the three; NaN if there is none
    gci : relative uncertainty of the finest value; NaN if there is no order
    asymptotic : whether the order is the expected one, or that of the three levels before, within `ASYMPTOTIC`
    """

    value: float
    order: float
    gci: float
    asymptotic: bool


def extrapolated(sizes: Array, values: Array, expected: float | None = None) -> Extrapolated:
    """Richardson value and GCI of levels from coarse to fine."""
    if len(values) < 3:
        return Extrapolated(float(values[-1]), np.nan, np.nan, False)
    order = order_of_three(sizes[-3:], values[-3:])
    if not np.isfinite(order):
        return Extrapolated(float(values[-1]), np.nan, np.nan, False)
    step = (values[-1] - values[-2]) / np.expm1(order * np.log(sizes[-2] / sizes[-1]))
    should_be = expected
    if should_be is None:
        should_be = order_of_three(sizes[-4:-1], values[-4:-1]) if len(values) > 3 else np.nan
    close = bool(abs(order / should_be - 1) <= ASYMPTOTIC)
    return Extrapolated(float(values[-1] + step), order, float(SAFETY * abs(step / values[-1])), close)


@dataclass
class Sequence:
    """One quantity on levels from coarse to fine.

    Parameters
    ----------
    name : what was refined
    quantity : what was computed
    expected : order that theory gives; None if it gives none
    exact : value without the error that is studied; None to take Richardson's
    floor : relative errors below it are shown but not counted; one for all levels or for each
    coarsest : levels of a greater size are shown but not counted: what theory neglects is not small there
    """

    name: str
    quantity: str
    expected: float | None = None
    exact: float | None = None
    floor: float | Array = 0.0
    sizes: Array = field(default_factory=lambda: np.empty(0))
    values: Array = field(default_factory=lambda: np.empty(0))
    coarsest: float = np.inf

    def add(self, size: float, value: float) -> None:
        """Add the next finer level."""
        self.sizes, self.values = np.append(self.sizes, size), np.append(self.values, value)

    @property
    def limit(self) -> Extrapolated:
        return extrapolated(self.sizes, self.values, self.expected)

    @property
    def errors(self) -> Array:
        """(n,) relative errors; absolute ones of what should be zero."""
        exact = self.limit.value if self.exact is None else self.exact
        return np.abs(self.values - exact) / (abs(exact) or 1.0)

    @property
    def counted(self) -> NDArray[np.bool_]:
        return (self.errors > self.floor) & (self.sizes <= self.coarsest)

    @property
    def order(self) -> float:
        """Observed order by least squares over the levels that count."""
        kept = self.counted
        return least_squares(self.sizes[kept], self.errors[kept])

    @property
    def last_order(self) -> float:
        """Observed order between the last two levels that count."""
        kept = np.flatnonzero(self.counted)[-2:]
        return least_squares(self.sizes[kept], self.errors[kept])

    @property
    def verdict(self) -> str:
        """Whether the observed orders are those of theory, and if not, what can be seen of the reason."""
        if self.expected is None:
            return ""
        if not np.isfinite(self.order):
            return "too few levels above the floor"
        if max(abs(self.order - self.expected), abs(self.last_order - self.expected)) <= WITHIN:
            return "yes"
        kept = self.counted
        signed = np.sign(self.values - (self.limit.value if self.exact is None else self.exact))[kept]
        if np.ptp(signed):
            return "no: the error changes sign"
        distance = np.abs(between(self.sizes[kept], self.errors[kept]) - self.expected)
        return "no: still approaching" if len(distance) > 1 and (np.diff(distance) < 0).all() else "no"

    def _between(self) -> str:
        """Orders between neighbouring levels; in brackets where one of the two does not count."""
        pairs = self.counted[1:] & self.counted[:-1]
        orders = [f"{order:.2f}" if np.isfinite(order) else "–" for order in between(self.sizes, self.errors)]
        return " ".join(order if both else f"({order})" for order, both in zip(orders, pairs, strict=True))

    def summary(self) -> dict[str, Any]:
        """A row for the table of orders."""
        limit = self.limit
        verdict = "asymptotic" if limit.asymptotic else "not asymptotic"
        return {
            "refined": self.name,
            "quantity": self.quantity,
            "levels": f"{int(self.counted.sum())} of {len(self.sizes)}",
            "expected order": "" if self.expected is None else self.expected,
            "least squares": self.order,
            "last levels": self.last_order,
            VERDICT: self.verdict,
            "between levels": self._between(),
            "finest error": f"{self.errors[-1]:.1e}",
            "Richardson value": f"{limit.value:.12g}" if self.exact != 0 else "",
            "GCI": f"{limit.gci:.1e}" if np.isfinite(limit.gci) and self.exact != 0 else "",
            "three finest": verdict if len(self.sizes) > 2 else "fewer than three",
        }


def verdicts(sequences: Iterable[Sequence]) -> str:
    """How many observed orders are those of theory, and which are not, in a sentence."""
    judged = [(sequence, sequence.verdict) for sequence in sequences if sequence.expected is not None]
    off = [f"{one.name}, {one.quantity} ({verdict})" for one, verdict in judged if verdict != "yes"]
    line = (
        f"{len(judged) - len(off)} of {len(judged)} orders are within {WITHIN} of theory, fitted and between the last levels"
    )
    return "; but ".join([line, "; ".join(off)]) + "." if off else f"{line}."


class Table:
    """Rows that are on disk as CSV as soon as they are known, and as Markdown at the end."""

    def __init__(self, path: Path, fields: Iterable[str]) -> None:
        self.path, self.fields = path, tuple(fields)
        self.rows: list[dict[str, Any]] = []
        self._append(self.fields)

    def add(self, **row: Any) -> None:
        """Add a row; columns that it does not name stay empty."""
        self.rows.append(row)
        self._append(row.get(name, "") for name in self.fields)

    def _append(self, values: Iterable[Any]) -> None:
        with self.path.open("a" if self.rows else "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerow(list(values))

    def markdown(self) -> str:
        """The rows as a Markdown table; numbers to four digits."""
        lines = [self.fields, ["---"] * len(self.fields)]
        lines += [[_cell(row.get(name, "")) for name in self.fields] for row in self.rows]
        return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if np.isfinite(value) else ""
    return str(value).replace("|", "\\|")


def write_markdown(path: Path, title: str, conclusions: Iterable[str], tables: dict[str, Table]) -> None:
    """A page: the conclusions first, then each table under its heading."""
    text = [f"# {title}\n", *(f"{line}\n" for line in conclusions)]
    text += [f"## {heading}\n\n{table.markdown()}" for heading, table in tables.items()]
    path.write_text("\n".join(text), "utf-8")


@contextmanager
def keeping_rows(conclusions: list[str]) -> Iterator[None]:
    """Ctrl-C ends the computing, not the study: what is finished is still tabulated, drawn and named incomplete."""
    try:
        yield
    except KeyboardInterrupt:
        conclusions.append(INTERRUPTED)


def new_figure(width: float, height: float) -> Figure:
    """A figure that needs no display."""
    figure = Figure(figsize=(width, height), layout="constrained", dpi=150)
    FigureCanvasAgg(figure)
    return figure


def style(number: int) -> dict[str, Any]:
    """Marker, line and grey of the n-th curve: told apart without colour."""
    return {
        "marker": MARKERS[number % len(MARKERS)],
        "linestyle": LINES[number % len(LINES)],
        "color": GREYS[number % len(GREYS)],
        "markersize": 4.5,
        "markerfacecolor": "none",
        "linewidth": 1.1,
    }


def draw_orders(axes: Any, sequences: Iterable[Sequence], size_label: str, error_label: str) -> None:
    """Error over size, logarithmic, with the observed order of each sequence in the legend."""
    for number, sequence in enumerate(sequences):
        order = f"{sequence.order:.2f}" if np.isfinite(sequence.order) else "—"
        expected = "" if sequence.expected is None else f" (theory {sequence.expected:g})"
        label = f"{sequence.name}: {order}{expected}"
        shown = np.where(sequence.errors > 0, sequence.errors, np.nan)
        axes.loglog(sequence.sizes, shown, label=label, **style(number))
    axes.set_xlabel(size_label)
    axes.set_ylabel(error_label)
    axes.grid(True, which="major", color="0.88", linewidth=0.6)
    if axes.lines:  # there are none after an early interruption
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if axes.get_xlim()[1] < 30 * axes.get_xlim()[0] else (1,)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(NullFormatter())
        legend_below(axes, title="observed order")


def legend_below(axes: Any, **settings: Any) -> None:
    """A legend under the axes, where it covers nothing."""
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.14)}
    axes.legend(frameon=False, fontsize=7.5, title_fontsize=7.5, **place, **settings)
