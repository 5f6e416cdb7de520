"""Results of a study: a table of levels, orders of convergence, figures and conclusions."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ...meshes import RingwearError, SceneError
from ..crosscheck import AnswersGuesses, Scene, make, output_folder, shown
from ..figures.style import html_of, in_style
from ..tables.writing import write_csv
from .formats import to_latex, to_markdown
from .record import SOLVED, Record
from .theory import paper_table
from .way import Part

if TYPE_CHECKING:
    from matplotlib.figure import Figure

QUICK = (
    "With --quick, levels are coarse and few: orders and costs are those of coarse levels, and "
    "may differ from those of the whole study."
)
MOST_COLUMNS = 6
"""Greatest number of quantities in the table of levels for a paper."""


@dataclass(frozen=True)
class Study(AnswersGuesses):
    """Results of a study.

    Parameters
    ----------
    name : name of the study, as on the command line
    scene : scene that was studied
    table : tidy table: one row for each quantity of each level (`studies/study/README.md`)
    orders : one row for each sequence of levels: observed and theoretical order, and Richardson's
        limit; empty for studies without orders
    conclusions : sentences that summarise the tables and figures
    figures : figures by the name of their file, without its extension
    tables : further tables by the name of their file, without its extension
    purpose : subject of the study, shown on its page

    Examples
    --------
    >>> import ringwear
    >>> march = ringwear.study("march", "five_rings", quick=True)
    >>> sorted(set(march.orders["expected"].dropna()))  # both Euler methods have order 1
    [1.0]
    """

    name: str
    scene: Scene
    table: pd.DataFrame
    orders: pd.DataFrame = field(default_factory=pd.DataFrame)
    conclusions: tuple[str, ...] = ()
    figures: "Mapping[str, Figure]" = field(default_factory=dict)
    tables: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    purpose: str = ""

    @property
    def levels(self) -> pd.DataFrame:
        """One row for each level, and a column with the errors of each quantity, as for a paper."""
        if "outcome" not in self.table or not (self.table["outcome"] == SOLVED).any():
            return pd.DataFrame()
        solved = self.table[(self.table["outcome"] == SOLVED) & self.table["quantity"].notna()]
        pairs = zip(solved["quantity"], solved["when"], strict=True)
        named = solved.assign(part=[str(Part(*pair)) for pair in pairs])
        keys = ["case", "way", "level", "unknowns", "seconds"]
        if named["case"].nunique() == 1:
            keys = keys[1:]
        wide = named.pivot_table("error", keys, "part", sort=False).reset_index()
        shown_parts = list(dict.fromkeys(named["part"]))[:MOST_COLUMNS]
        return wide[[*keys, *shown_parts]].rename_axis(columns=None)

    def __repr__(self) -> str:
        """Return the name, the number of levels, and the conclusions."""
        title = f"Study {self.name} of {self.scene.title or 'an untitled scene'}: "
        keys = [name for name in ("case", "way", "level") if name in self.table]
        count = len(self.table[keys].drop_duplicates()) if keys else len(self.table)
        return "\n".join([f"{title}{count} levels", *self.conclusions])

    def _repr_html_(self) -> str:
        """Return the conclusions, the orders and the figures as HTML, for notebooks."""
        parts = [f"<pre>{escape(repr(self))}</pre>"]
        main_table = paper_table(self.orders) if len(self.orders) else self.levels
        parts.append(main_table.to_html(index=False, max_rows=40, float_format="{:.4g}".format))
        parts += map(html_of, self.figures.values())
        return "".join(parts)

    def to_markdown(self, table: str = "") -> str:
        """Return a table in Markdown, as in the files of `save`.

        Parameters
        ----------
        table : ``"levels"``, ``"orders"``, or the name of one of `tables`; by default that of the
            levels, with one column for each quantity
        """
        return to_markdown(self._for_papers(table))

    def to_latex(self, table: str = "") -> str:
        """Return a table as a LaTeX `tabular`, which needs the package `booktabs`.

        Parameters
        ----------
        table : ``"levels"``, ``"orders"``, or the name of one of `tables`; by default that of the
            levels, with one column for each quantity
        """
        return to_latex(self._for_papers(table))

    def save(self, folder: str | Path) -> list[str]:
        """Write the same files as ``ringwear study NAME --out folder``; return their names.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or if it contains files with these names that
            ringwear has not written
        RingwearError
            if a figure cannot be drawn
        """
        with output_folder(folder, f"study {self.name}", ["report.html"]) as out:
            if failures := self.write(out.hidden):
                raise RingwearError("; ".join(failures))
        return out.written

    def write(self, folder: Path) -> list[str]:
        """Write tables, figures and the page to a folder; return a message for each failure."""
        failures = list[str]()
        tables = {name: table for name, table in self._tables().items() if name != "levels"}
        if not any(table is self.table for table in tables.values()):
            tables |= {self.name: self.table}
        for name, table in tables.items():
            write_csv(table, folder / f"{name}.csv")
        for name in self._tables():
            (folder / f"{name}.md").write_text(self.to_markdown(name), "utf-8")
            (folder / f"{name}.tex").write_text(self.to_latex(name), "utf-8")
        for name, figure in self.figures.items():
            with in_style():
                figure.savefig(folder / f"{name}.png")
        from ..report.study_page import write_study

        title = f"Study: {self.name}"
        write = partial(write_study, title, self.purpose, self.scene, self.conclusions)
        return failures + make(folder / "report.html", write)

    def _for_papers(self, name: str) -> pd.DataFrame:
        """Return a table by its name, with the few columns that a paper shows.

        Raises
        ------
        SceneError
            if there is no such table; the message lists the names of the existing tables
        """
        tables = self._tables()
        name = "levels" if name in ("", self.name) and "levels" in tables else name or self.name
        if name == self.name and name not in tables:
            return self.table
        if name not in tables:
            raise SceneError(
                f"this study has no table {shown(name)}: give one of {', '.join(tables)}"
            )
        return paper_table(self.orders) if name == "orders" else tables[name]

    def _tables(self) -> dict[str, pd.DataFrame]:
        """Return every table that has columns, without the tidy one, by the name of its file."""
        tables = {"levels": self.levels, "orders": self.orders, **self.tables}
        return {name: table for name, table in tables.items() if len(table)}


def remarks(record: Record, quick: bool = False) -> list[str]:
    """Return the sentences on levels that failed, on an interruption, and on a quick study."""
    table = record.table
    failed = table[table["outcome"].notna() & (table["outcome"] != SOLVED)]
    texts = [
        f"{row['case']}, {row['way']}, level {row['level']} {row['outcome']}: {row['message']}"
        for row in failed.to_dict("records")
    ]
    return [*texts, *([QUICK] if quick else []), *record.remarks]


def choose_parts(
    table: pd.DataFrame, drawn: Sequence[tuple[str, str]], chosen: Sequence[str]
) -> pd.DataFrame:
    """Return the rows that a figure shows: those of the chosen quantities, or else of some.

    Parameters
    ----------
    table : table of `measure`
    drawn : quantities, with their values of `when`, that are drawn by default
    chosen : names of the quantities that the user asks for; empty for the default
    """
    if chosen:
        return table[table["quantity"].isin(chosen)]
    return rows_of(table, drawn)


def rows_of(table: pd.DataFrame, parts: Collection[tuple[str, str]]) -> pd.DataFrame:
    """Return the rows of a table of some quantities, with their values of `when`."""
    pairs = zip(table["quantity"], table["when"], strict=True)
    return table[np.array([pair in parts for pair in pairs], dtype=bool)]
