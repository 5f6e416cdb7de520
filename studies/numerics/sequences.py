"""Sequences of discretisations: solved level by level, tabulated, their orders fitted and drawn.

A study lists families: a family is one way to refine (a mesh, a step, an outer boundary, the dial
of a method), from coarse to fine. Each level is solved to relative errors of some quantities. The
observed order is the slope of ``log error`` over ``log size``: between neighbouring levels, and by
least squares over all that lie above the floor where roundoff or another error takes over.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ...meshes.errors import RingwearError
from ...meshes.radial import Array
from ..figures.style import LOOKS, curve, legend_below, new_figure
from ..progress import LOG
from ..tables import Row, keeping_rows, without_formulas

WITHIN = 0.15
"""How far an observed order may be from theory's, by least squares and between the last levels."""


class Theory(NamedTuple):
    """What is expected of the errors of a quantity.

    Parameters
    ----------
    order : slope of log error over log size; NaN if there is no theory
    floor : relative errors below it are shown but not counted
    """

    order: float = np.nan
    floor: float = 0.0


class Family(NamedTuple):
    """One way to refine, from coarse to fine.

    Parameters
    ----------
    name : of the family
    sizes : settings of its levels, each with its size; NaN where settings have none
    solve : setting -> row of the table
    theory : of the quantities whose orders are fitted
    xlabel : what its size is called
    """

    name: str
    sizes: Mapping[Any, float]
    solve: Callable[[Any], Row]
    theory: Mapping[str, Theory] = {}
    xlabel: str = ""


@dataclass(frozen=True)
class Sequence:
    """One quantity on the levels of a family that were solved.

    Parameters
    ----------
    name : of the family
    quantity : what was computed
    theory : what is expected of it
    sizes, signed : (n,) of the levels; errors relative and signed
    """

    name: str
    quantity: str
    theory: Theory
    sizes: Array
    signed: Array

    @property
    def errors(self) -> Array:
        """(n,) relative errors without their signs."""
        return np.abs(self.signed)

    @property
    def counted(self) -> NDArray[np.bool_]:
        """(n,) whether a level counts for the order."""
        return self.errors > self.theory.floor

    @property
    def order(self) -> float:
        """Observed order by least squares over the levels that count; NaN of fewer than two."""
        return self._fit(slice(None))

    @property
    def last_order(self) -> float:
        """Observed order between the last two levels that count."""
        return self._fit(slice(-2, None))

    def _fit(self, part: slice) -> float:
        sizes, errors = (np.log(values[self.counted][part]) for values in (self.sizes, self.errors))
        return float(np.polyfit(sizes, errors, 1)[0]) if len(sizes) > 1 else np.nan

    @property
    def orders(self) -> Array:
        """(n-1,) observed orders between neighbouring levels; NaN at an error of zero."""
        errors = np.where(self.errors > 0, self.errors, np.nan)
        return np.diff(np.log(errors)) / np.diff(np.log(self.sizes))

    @property
    def verdict(self) -> str:
        """Whether observed orders are those of theory."""
        if np.isnan(self.theory.order):
            return ""
        if np.isnan(self.order):
            return "too few levels above the floor"
        off = np.array([self.order, self.last_order]) - self.theory.order
        return "yes" if (np.abs(off) <= WITHIN).all() else "no"

    @property
    def label(self) -> str:
        """What was computed, with the observed order, that of theory and the verdict."""
        label = f"{self.name}, {self.quantity}: {self.order:.2f}"
        if not self.verdict:
            return label
        return f"{label} (theory {self.theory.order:.3g}: {self.verdict})"

    def summary(self) -> Row:
        """Return a row of the table of orders."""
        return {
            "refined": self.name,
            "quantity": self.quantity,
            "levels": f"{self.counted.sum()} of {len(self.sizes)}",
            "expected order": self.theory.order,
            "least squares": self.order,
            "last levels": self.last_order,
            f"within {WITHIN}": self.verdict,
            "finest error": f"{self.errors[-1]:.1e}",
        }


Curves = dict[str, Sequence]
"""Of a panel, by their labels."""


def solve_all(
    families: Iterable[Family], path: Path, columns: list[str], conclusions: list[str]
) -> pd.DataFrame:
    """Solve every level of every family, each a row that is on disk as soon as it is solved.

    A level that fails is a row, too, and a conclusion. Ctrl-C keeps those before it.
    """
    rows = list[Row]()
    pd.DataFrame(columns=columns).to_csv(path, index=False)
    with threadpool_limits(1), keeping_rows(conclusions):
        for family in families:
            for setting, size in family.sizes.items():
                LOG.info("   level  %s, %s ...", family.name, setting)
                row = {"family": family.name, "setting": setting, "size": size}
                try:
                    row |= family.solve(setting)
                except RingwearError as error:
                    row["remark"] = f"failed: {error}"
                    conclusions.append(f"{family.name}, {setting} failed: {error}")
                rows.append(row)
                last = pd.DataFrame([row], columns=columns)
                without_formulas(last).to_csv(path, mode="a", header=False, index=False)
    return pd.DataFrame(rows, columns=columns)


def fit(families: Iterable[Family], rows: pd.DataFrame) -> list[Sequence]:
    """Return a sequence for each quantity of a family that has a theory, if rows tell of it."""
    sequences = []
    for family in families:
        solved = rows[rows.family == family.name]
        for quantity, theory in family.theory.items():
            levels = solved[["size", quantity]].dropna().to_numpy(float)
            if len(levels):
                sequences.append(Sequence(family.name, quantity, theory, *levels.T))
    return sequences


def study_orders(families: Iterable[Family], out: Path, name: str, ylabel: str) -> list[str]:
    """Solve families, fit their orders and draw their errors.

    The orders are written to `orders.csv`, the errors to a table and a figure with the study's
    name.

    Returns
    -------
    conclusions: how the orders agree with theory
    """
    families, conclusions = list(families), list[str]()
    quantities = dict.fromkeys(quantity for family in families for quantity in family.theory)
    columns = ["family", "setting", "size", "unknowns", *quantities, "remark"]
    sequences = fit(families, solve_all(families, out / f"{name}.csv", columns, conclusions))
    orders = pd.DataFrame(sequence.summary() for sequence in sequences)
    orders.to_csv(out / "orders.csv", index=False)
    verdicts = [sequence.verdict for sequence in sequences if sequence.verdict]
    conclusions[:0] = [
        f"{verdicts.count('yes')} of {len(verdicts)} orders that theory tells are within {WITHIN} "
        "of it, fitted and between the last levels.",
        *(f"{sequence.label}, finest error {sequence.errors[-1]:.1e}" for sequence in sequences),
    ]
    panels: dict[str, Curves] = {}
    xlabels = {family.name: family.xlabel for family in families}
    for sequence in sequences:
        panels.setdefault(xlabels[sequence.name], {})[sequence.label] = sequence
    draw_errors(out / f"{name}.png", panels, ylabel)
    return conclusions


def draw_errors(path: Path, panels: Mapping[str, Curves], ylabel: str) -> None:
    """Draw errors over sizes or unknowns, logarithmic: a panel for each label of these.

    Curves are in the colours of their methods, with orders in theory as triangles beside them.
    """
    longest = max(map(len, panels.values()), default=0)
    figure = new_figure(4.4 * max(len(panels), 1), 5 + 0.2 * longest)
    row = figure.subplots(1, max(len(panels), 1), sharey=True, squeeze=False)[0]
    for axes, (xlabel, curves) in zip(row, panels.items(), strict=False):
        for number, (label, sequence) in enumerate(curves.items()):
            colors = [look["color"] for look in LOOKS.values()]
            of_method = LOOKS.get(label.split()[0].lower(), {}).get("color")
            look = curve(number) | {"color": of_method or colors[number % len(colors)]}
            errors = np.where(sequence.errors > 0, sequence.errors, np.nan)
            axes.loglog(sequence.sizes, errors, label=label, **look)
            if np.isfinite(sequence.theory.order) and len(errors) > 1:
                _draw_triangle(axes, sequence, look["color"])
        axes.set(xlabel=xlabel, ylabel=ylabel)
        low, high = axes.get_xlim()
        ticks = LogLocator(subs=(1, 2, 5) if high < 30 * low else (1,))
        axes.xaxis.set(major_locator=ticks, minor_formatter=NullFormatter())
        axes.grid(True, which="major", color="0.88", linewidth=0.6)
        axes.label_outer()
        legend_below(axes)
    figure.savefig(path)


def _draw_triangle(axes: Any, sequence: Sequence, color: str) -> None:
    """Draw the slope of theory below the first step of a curve, and say which it is."""
    right, second, *_ = sequence.sizes
    left, high, order = np.sqrt(right * second), sequence.errors[0] / 2, sequence.theory.order
    low = high * (left / right) ** order
    axes.plot([left, right, right, left], [low, low, high, low], color=color, linewidth=0.6)
    place = {"textcoords": "offset points", "xytext": (2, 0), "va": "center"}
    axes.annotate(f"{order:.2g}", (right, np.sqrt(low * high)), fontsize=6, color=color, **place)
