"""The command `orders`: read a table of levels, and print or write its orders of convergence."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ...meshes import SceneError
from ..tables.frame import Frame
from ..tables.writing import write_csv
from .formats import to_latex, to_markdown
from .orders import RADIUS, orders

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    if "" in values and len(values) == 1:
        return values[""]
    if "" in values:
        raise SceneError("--right: give NAME=VALUE for each column, or one VALUE for all")
    return values or None


def write(table: pd.DataFrame, fitted: pd.DataFrame, by: str, folder: Path) -> None:
    """Write orders as CSV, Markdown and LaTeX, and draw the errors or changes of each column."""
    write_csv(fitted, folder / "orders.csv")
    (folder / "orders.md").write_text(to_markdown(fitted), "utf-8")
    (folder / "orders.tex").write_text(to_latex(fitted), "utf-8")
    if RADIUS not in table and "error" not in table:
        from ..figures.style import in_style

        with in_style():
            draw_columns(table, fitted, by).savefig(folder / "orders.png")


def draw_columns(table: pd.DataFrame, fitted: pd.DataFrame, by: str) -> "Figure":
    """Draw the distance of each column from its right value, or from Richardson's limit."""
    from .draw import draw

    rows = []
    for row in fitted.to_dict("records"):
        name = row["quantity"]
        is_error = "error" in name.lower()
        target = row.get("target", row["limit"])
        target = 0.0 if is_error else target
        levels = table[[by, name]].dropna().sort_values(by, ascending=False)
        for size, value in levels.to_numpy(float):
            distance = abs(value - target) / (abs(target) or 1.0)
            rows.append({"size": size, "error": distance, "quantity": name})
    constant = {"case": "", "way": "distance to the right value, or to Richardson's limit"}
    constant |= {"when": "all", "method": "table", "refined": by, "outcome": ""}
    return draw(pd.DataFrame(rows).assign(**constant, tolerance=np.nan, reference=0.0))


def orders_of_file(
    file: str, by: str, right: Sequence[str] = (), tolerance: float | None = None
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the table of a file, and its orders."""
    table = read_table(file, by)
    return table, orders(table, by, right_values(right), tolerance)
