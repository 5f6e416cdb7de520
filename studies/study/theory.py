"""Compare the observed orders of a study with theory, and say what they show."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from .orders import ORDER_TOLERANCE, fit, sequences
from .way import Part, Way

COLUMNS = (
    *("case", "way", "quantity", "when", "order", "low", "high", "limit", "index", "asymptotic"),
    *("last order", "levels", "fitted", "finest error", "expected", "agrees", "floor"),
    *("cause of the floor", "theory", "refined", "unknowns"),
)
"""Columns of the table of observed orders."""
MOST_PARTS = 4
"""Greatest number of quantities in the sentence about a way."""
UNFITTED = "too few levels above the floor"
"""Text in place of a verdict on an order that cannot be fitted."""


def observed_orders(
    table: pd.DataFrame, ways: Sequence[Way] | Mapping[str, Sequence[Way]]
) -> pd.DataFrame:
    """Return one row for each quantity of each way: its observed and its theoretical order.

    The order is the slope of log error over log size, by least squares over the levels whose error
    is above the floor: that of the theory, or the error of the reference. Of a sequential way, such
    as adaptive refinement, only the finer half counts: the coarser levels do not yet resolve the
    singularities.

    Parameters
    ----------
    table : table of `measure`
    ways : the ways, with their theory; those of each case by its name, if they differ. Rows of
        other ways have no order
    """
    ways_by_case = ways if isinstance(ways, Mapping) else dict.fromkeys(table["case"], ways)
    listed = {(case, way.name): way for case, of_case in ways_by_case.items() for way in of_case}
    rows = []
    for key, levels in sequences(table[table["size"] > 0]):
        way = listed.get((key["case"], key["way"]))
        if way is not None and way.sequential:
            levels = levels.iloc[len(levels) // 2 :]
        if way is None or len(levels) < 2:
            continue
        theory = way.theory(key["quantity"], key["when"])
        floor, cause = theory.floor, theory.floor_cause
        if levels["reference"].max() > floor:
            floor, cause = float(levels["reference"].max()), "the error of the reference"
        fitted = fit(levels, floor=floor)
        rows.append(
            key
            | fitted
            | {
                "expected": theory.order,
                "agrees": agrees(theory.order, fitted["order"], fitted["last order"]),
                "floor": floor,
                "cause of the floor": cause,
                "theory": theory.reason,
                "refined": way.refined,
                "unknowns": levels["unknowns"].iloc[-1],
            }
        )
    return pd.DataFrame(rows, columns=list(COLUMNS))


def agrees(expected: float, order: float, last_order: float) -> str:
    """Return whether observed orders agree with theory: `yes`, `no`, why not, or "" without one.

    The order by least squares and the order between the last two levels both have to agree.
    """
    if np.isnan(expected):
        return ""
    if np.isnan(order):
        return UNFITTED
    deviations = np.abs(np.array([order, last_order]) - expected)
    return "yes" if (deviations <= ORDER_TOLERANCE).all() else "no"


def in_words(row: dict[str, Any]) -> str:
    """Return an observed order in words, with the theoretical one."""
    name = str(Part(row["quantity"], row["when"]))
    if np.isnan(row["order"]):
        return f"{name}: no order, because there are {UNFITTED}"
    words = f"{name} {row['order']:.2f}"
    if row["agrees"] == "yes":
        return f"{words} (theory {row['expected']:.3g})"
    if row["agrees"] == "no":
        return f"{words}, but {row['expected']:.3g} in theory"
    return words


def conclude_orders(fits: pd.DataFrame) -> Iterator[str]:
    """Yield how many orders agree with theory, one line for each way, and how good the index is."""
    if fits.empty:
        return
    judged = fits[fits["agrees"].isin(["yes", "no"])]
    if judged.empty:
        reasons = " ".join(text for text in fits["theory"].unique() if text)
        yield f"No order can be compared with theory. {reasons}".strip()
    else:
        yield (
            f"{(judged['agrees'] == 'yes').sum()} of {len(judged)} orders with a theory are within "
            f"{ORDER_TOLERANCE} of it, by least squares and between the last levels."
        )
    several = fits["case"].nunique() > 1
    for (case, way), rows in fits.groupby(["case", "way"], sort=False):
        # orders that can be compared with theory come first, those that disagree before others
        ranks = rows["agrees"].map({"no": 0, "yes": 1}).fillna(2)
        first = rows.assign(rank=ranks).sort_values("rank", kind="stable").head(MOST_PARTS)
        orders = "; ".join(in_words(row) for row in first.to_dict("records"))
        best = rows.loc[rows["finest error"].idxmin()]
        yield (
            f"{f'{case}, ' if several else ''}{way}: orders of {orders}. The least error with "
            f"{best['unknowns']:.0f} unknowns is {best['finest error']:.1e} "
            f"({Part(best['quantity'], best['when'])})."
        )
    indexed = fits[np.isfinite(fits["index"])]
    if len(indexed):
        bounded = (indexed["finest error"] <= indexed["index"]).sum()
        yield (
            f"The grid convergence index exceeds the true error of the finest level in {bounded} "
            f"of {len(indexed)} sequences; {len(fits) - len(indexed)} have no index, because they "
            "have fewer than three levels or do not converge monotonically."
        )


def paper_table(fits: pd.DataFrame) -> pd.DataFrame:
    """Return the orders as a table of four columns for a paper."""
    if fits.empty:
        return fits
    several = fits["case"].nunique() > 1
    rows = []
    for row in fits.to_dict("records"):
        interval = f" ({row['low']:.2f} to {row['high']:.2f})" if np.isfinite(row["low"]) else ""
        rows.append(
            {
                "refined": f"{row['case']}: {row['way']}" if several else row["way"],
                "quantity": str(Part(row["quantity"], row["when"])),
                "order (95 %)": f"{row['order']:.2f}{interval}",
                "theory": row["expected"],
            }
        )
    return pd.DataFrame(rows)
