"""Orders of convergence of any table of levels: of a study, or of another program's results.

`orders` accepts two kinds of tables:

- tables of a study (`measure.measure`), which have the columns `quantity` and `error`;
- tables with one row for each level and one column for each quantity.

A column holds values, whose order follows from their changes from level to level, or errors, whose
order is the slope of their logarithm. Errors are columns whose right value is 0, or that have the
word "error" in their names.
"""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...meshes import Array, SceneError
from ..crosscheck import did_you_mean, shown
from ..tables.frame import Frame
from ..tables.writing import write_csv
from .extrapolation import (
    INDEX_SAFETY_FACTOR,
    order_of_changes,
    order_of_errors,
    order_of_three,
    orders_between,
    weight_of_limit,
)
from .formats import to_latex, to_markdown
from .way import KEYS_OF_STUDIES

ORDER_TOLERANCE = 0.15
"""Greatest difference of two orders that counts as agreement.

It holds for an observed order and its theory, and for the orders of the last levels and of those
before, which shows whether the levels are in the asymptotic range.
"""
COLUMNS = ("quantity", "order", "low", "high", "limit", "index", "asymptotic")
"""Columns of the table, to which a right value and a tolerance add others."""
DIFFERS = "differs from theory"
"""Beginning of the remark on an order of a study that does."""


def orders(
    table: pd.DataFrame,
    by: str,
    right: Mapping[str, float] | float | None = None,
    tolerance: float | None = None,
) -> pd.DataFrame:
    """Fit the order of convergence of each column of a table of levels.

    Parameters
    ----------
    table : one row for each level, in any order; or the table of a study
    by : name of the column with the size of each level, such as the element size or the time step
    right : right value of each quantity, by name, or one for all of them; 0 for errors
    tolerance : greatest relative error of the finest level that is allowed

    Returns
    -------
    DataFrame
        One row for each quantity with the columns

        order, low, high
            the order, and the ends of its 95 % interval, which needs four levels. It is the slope
            of the logarithms of errors, if these are known, or else it follows from the changes of
            the values from level to level
        limit
            Richardson's limit of the last three levels; of a study, the true error of the limit
        index
            the grid convergence index: an estimate of the relative error of the finest level
        asymptotic
            1 if the last three levels have the same order as those before, to 0.15, or else 0; NaN
            for three levels

        With `right` or `tolerance`, also `computed` (on the finest level), `target` (the right
        value or else the limit), `ratio` of the two, `tolerance`, and `within`.

    Raises
    ------
    SceneError
        if the table has no such column, or if its sizes are not three different positive numbers

    Examples
    --------
    Values ``1 + h^2`` converge to 1 with the order 2:

    >>> import pandas as pd
    >>> sizes = [0.4, 0.2, 0.1]
    >>> table = pd.DataFrame({"h": sizes, "depth": [1 + h**2 for h in sizes]})
    >>> (row,) = orders(table, by="h").to_dict("records")
    >>> row["quantity"], round(row["order"], 6), round(row["limit"], 6)
    ('depth', 2.0, 1.0)
    """
    if not isinstance(table, pd.DataFrame):
        raise SceneError(f"orders: {type(table).__name__} is no table: give a pandas DataFrame")
    if by not in table:
        names = [str(name) for name in table]
        hint = did_you_mean(by, names, f"give one of {', '.join(names)}")
        raise SceneError(f"by = {shown(by)}: the table has no such column{hint}")
    if {"quantity", "error"} <= set(table):
        rows = list(_of_study(table, by))
    else:
        rows = [
            _of_numbers(table, by, name, _right_value(right, str(name)), tolerance)
            for name in table.select_dtypes("number")
            if name != by
        ]
    if not rows:
        raise SceneError(f"the table has no numbers besides {shown(by)}: add a column of values")
    return pd.DataFrame(rows)


def _right_value(right: Mapping[str, float] | float | None, name: str) -> float:
    """Return the right value of a column; NaN if it is not known."""
    if isinstance(right, Mapping):
        right = right.get(name)
    if right is None:
        return 0.0 if "error" in name.lower() else np.nan
    return float(right)


def _levels(table: pd.DataFrame, by: str, name: Hashable) -> tuple[Array, Array]:
    """Return the sizes (n,) and the values (n,) of a column, from coarse to fine.

    Raises
    ------
    SceneError
        if the sizes are not at least three different positive numbers
    """
    rows = table[[by, name]].dropna().sort_values(by, ascending=False, kind="stable")
    sizes, values = rows.to_numpy(float).T
    if len(sizes) < 3 or len(np.unique(sizes)) < len(sizes) or sizes.min() <= 0:
        raise SceneError(
            f"by = {shown(by)}: an order needs three levels or more, each with another positive "
            f"size; the table has {', '.join(f'{size:g}' for size in sizes) or 'none'}"
        )
    return sizes, values


def _of_numbers(
    table: pd.DataFrame, by: str, name: Hashable, right: float, tolerance: float | None
) -> dict[str, Any]:
    """Return the row of a column with one number on each level."""
    sizes, values = _levels(table, by, name)
    errors, changes = np.abs(values - right), values[:-1] - values[1:]
    last = order_of_three(sizes[-3:], changes[-2:])
    if np.isfinite(right):
        fitted, between = order_of_errors(sizes, errors), orders_between(sizes, errors)
    else:
        monotonic = (np.sign(changes) == np.sign(changes[-1])).all()
        fitted = order_of_changes(sizes, np.abs(changes) if monotonic else changes * np.nan)
        # the order of the three levels before the last needs a fourth one
        pairs = [(sizes[-4:-1], changes[-3:-1])] if len(sizes) > 3 else []
        between = np.array([*(order_of_three(*pair) for pair in pairs), last])
    distance = weight_of_limit(sizes, last) * changes[-1]
    limit = values[-1] - distance
    relative = abs(distance / values[-1]) if right != 0 and values[-1] else np.nan
    index = INDEX_SAFETY_FACTOR * relative
    numbers = (*fitted, limit, index, _asymptotic(between))
    row = dict(zip(COLUMNS, (str(name), *numbers), strict=True))
    if np.isnan(right) and tolerance is None:
        return row
    target = limit if np.isnan(right) else right
    deviation = abs(values[-1] - target) / (abs(target) or 1.0)
    sheet = {
        "computed": values[-1],
        "target": target,
        "ratio": values[-1] / target if target else np.nan,
        "tolerance": np.nan if tolerance is None else tolerance,
    }
    within = "" if tolerance is None else "yes" if deviation <= tolerance else "no"
    return row | sheet | {"within": within}


def _asymptotic(orders: Array) -> float:
    """Return 1 if two orders agree, and 0 if they do not; NaN if there are not two of them."""
    return float(abs(orders[-1] - orders[-2]) <= ORDER_TOLERANCE) if len(orders) > 1 else np.nan


def _of_study(table: pd.DataFrame, by: str) -> list[dict[str, Any]]:
    """Return the rows of the sequences of a study, whose errors are known."""
    return [
        key | fit(levels, by)
        for key, levels in sequences(table)
        if np.isfinite(levels[by].to_numpy(float)).sum() > 1
    ]


def sequences(table: pd.DataFrame) -> Iterator[tuple[dict[str, Any], pd.DataFrame]]:
    """Yield the sequences of levels of a study, each with its case, way, quantity and `when`."""
    keys = [name for name in KEYS_OF_STUDIES if name in table]
    for key, levels in table.dropna(subset=["error"]).groupby(keys, sort=False):
        yield dict(zip(keys, key, strict=True)), levels


def fit(levels: pd.DataFrame, by: str = "size", floor: float = 0.0) -> dict[str, Any]:
    """Return the order of the errors of a sequence, and Richardson's limit and index.

    Parameters
    ----------
    levels : rows of the levels, from coarse to fine
    by : column of the sizes
    floor : levels with smaller errors are left out, as are those below the error of the reference
    """
    sizes, errors = levels[by].to_numpy(float), levels["error"].abs().to_numpy(float)
    reference = levels["reference"].max() if "reference" in levels else 0.0
    counted = errors > np.fmax(floor, reference)
    fitted = order_of_errors(sizes[counted], errors[counted])
    between = orders_between(sizes[counted], errors[counted])
    last = levels.iloc[-1]
    return {
        **dict(zip(COLUMNS[1:4], fitted, strict=True)),
        # of a study, this is the true error of the limit
        "limit": abs(last.get("limit", np.nan)),
        "index": last.get("index", np.nan),
        "asymptotic": _asymptotic(between),
        "last order": between[-1] if len(between) else np.nan,
        "finest error": errors[-1],
    }


def read_table(file: str, by: str = "") -> pd.DataFrame:
    """Return the table of levels in a file, with the names in its headings without units.

    Columns whose cells are no numbers are texts, but for that of the sizes of levels, `by`.

    Raises
    ------
    SceneError
        if the file cannot be read, has no rows, or has cells that are no numbers
    """
    frame = Frame.of_file(Path(file))
    frame.refuse_faults(dict.fromkeys(frame.find(by), by))
    return frame.table()


def right_values(texts: Sequence[str]) -> Mapping[str, float] | float | None:
    """Return right values from texts of the form ``NAME=VALUE``, or one ``VALUE`` for all columns.

    Raises
    ------
    SceneError
        if a text has another form
    """
    values = dict[str, float]()
    for text in texts:
        name, _, number = text.rpartition("=")
        try:
            values[name] = float(number)
        except ValueError:
            raise SceneError(
                f"--right {text}: give NAME=VALUE, or one VALUE for all columns, such as 0 for "
                "errors"
            ) from None
    if "" not in values:
        return values or None
    if len(values) > 1:
        raise SceneError("--right: give NAME=VALUE for each column, or one VALUE for all")
    return values[""]


def write(fitted: pd.DataFrame, folder: Path) -> None:
    """Write orders as CSV, Markdown and LaTeX."""
    write_csv(fitted, folder / "orders.csv")
    (folder / "orders.md").write_text(to_markdown(fitted), "utf-8")
    (folder / "orders.tex").write_text(to_latex(fitted), "utf-8")
