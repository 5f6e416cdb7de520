"""Compare the observed orders of a study with theory."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from .orders import DIFFERS, KEYS_OF_STUDIES, ORDER_TOLERANCE, fit, sequences
from .way import Way

COLUMNS = (
    *(*KEYS_OF_STUDIES, "order", "low", "high", "theory", "asymptotic", "limit", "index"),
    *("finest error", "remark"),
)
"""Columns of the table of observed orders: keys, numbers, and one column of words."""


def observed_orders(table: pd.DataFrame, ways: Mapping[str, Sequence[Way]]) -> pd.DataFrame:
    """Return one row for each quantity of each way: its observed and its theoretical order.

    The order is the slope of log error over log size, by least squares over the levels whose error
    is above the floor: that of the theory, or the error of the reference. Of a sequential way, such
    as adaptive refinement, only the finer half counts: the coarser levels do not yet resolve the
    singularities. An order differs from theory if it does by least squares, or between the last two
    levels.

    Parameters
    ----------
    table : table of `measure`
    ways : the ways of each case by its name, with their theory
    """
    listed = {(case, way.name): way for case, each in ways.items() for way in each}
    rows = []
    for key, levels in sequences(table[table["size"] > 0]):
        way = listed.get((key["case"], key["way"]))
        if way is None or way.largest < levels["size"].min():
            continue
        levels = levels.iloc[len(levels) // 2 :] if way.sequential else levels
        levels = levels[levels["size"] <= way.largest]
        if len(levels) < 2:
            continue
        theory = way.theory(key["quantity"], key["when"])
        fitted = fit(levels, floor=theory.floor)
        off = np.abs(np.array([fitted["order"], fitted.pop("last order")]) - theory.order)
        remarks = [theory.reason]
        if np.isnan(fitted["order"]):
            cause = theory.floor_cause or "the error of the reference"
            remarks.insert(0, f"too few levels above {cause}.")
        elif (off > ORDER_TOLERANCE).any():
            remarks.insert(0, f"{DIFFERS}.")
        remark = " ".join(filter(None, remarks))
        rows.append(key | fitted | {"theory": theory.order, "remark": remark})
    return pd.DataFrame(rows, columns=list(COLUMNS))
