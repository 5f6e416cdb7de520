"""Results of a study: tables, orders of convergence, figures and conclusions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from ..crosscheck import RingwearError, Scene, SceneError, output_folder
from ..crosscheck.problem.written import shown
from ..crosscheck.result.guesses import AnswersGuesses
from ..crosscheck.result.output.one_file import make
from ..figures.style import html_of, in_style
from ..tables import write_csv
from .formats import to_latex, to_markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Study(AnswersGuesses):
    """Results of a study.

    Parameters
    ----------
    name : name of the study, as on the command line
    scene : scene that was studied
    table : one row for each level that was solved
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
    >>> march.orders["expected order"].dropna().tolist()  # both Euler methods have order 1
    [1.0, 1.0]
    """

    noun = "study"
    instead = (
        dict.fromkeys(("df", "data", "results", "rows", "dataset", "levels"), "table")
        | dict.fromkeys(("figure", "plot", "show"), "figures")
        | dict.fromkeys(("to_csv", "write_all", "export", "to_file"), "save(folder)")
        | {"summary": "conclusions", "verdict": "conclusions"}
    )

    name: str
    scene: Scene
    table: pd.DataFrame
    orders: pd.DataFrame = field(default_factory=pd.DataFrame)
    conclusions: tuple[str, ...] = ()
    figures: "Mapping[str, Figure]" = field(default_factory=dict)
    tables: Mapping[str, pd.DataFrame] = field(default_factory=dict)
    purpose: str = ""

    def __repr__(self) -> str:
        """Return the name, the number of levels, and the conclusions."""
        title = f"Study {self.name} of {self.scene.title or 'an untitled scene'}: "
        return "\n".join([f"{title}{len(self.table)} levels", *self.conclusions])

    def _repr_html_(self) -> str:
        """Return the conclusions, the orders and the figures as HTML, for notebooks."""
        parts = [f"<pre>{escape(repr(self))}</pre>"]
        main_table = self.orders if len(self.orders) else self.table
        parts.append(main_table.to_html(index=False, max_rows=40, float_format="{:.4g}".format))
        parts += map(html_of, self.figures.values())
        return "".join(parts)

    def to_markdown(self, table: str = "") -> str:
        """Return a table in Markdown, with the same rows and columns as in the files of `save`.

        Parameters
        ----------
        table : ``"orders"``, or the name of one of `tables`; by default the table of levels
        """
        return to_markdown(self._named(table))

    def to_latex(self, table: str = "") -> str:
        """Return a table as a LaTeX `tabular`, which needs the package `booktabs`.

        Parameters
        ----------
        table : ``"orders"``, or the name of one of `tables`; by default the table of levels
        """
        return to_latex(self._named(table))

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
        for name, table in self._tables().items():
            write_csv(table, folder / f"{name}.csv")
            (folder / f"{name}.md").write_text(to_markdown(table), "utf-8")
            (folder / f"{name}.tex").write_text(to_latex(table), "utf-8")
        for name, figure in self.figures.items():
            with in_style():
                figure.savefig(folder / f"{name}.png")
        from ..report.study_page import write_study

        title = f"Study: {self.name}"
        write = partial(write_study, title, self.purpose, self.scene, self.conclusions)
        return failures + make(folder / "report.html", write)

    def _named(self, table: str) -> pd.DataFrame:
        """Return a table by its name; the table of levels for the name of the study or "".

        Raises
        ------
        SceneError
            if there is no such table; the message lists the names of the existing tables
        """
        if table in ("", self.name):
            return self.table
        tables = self._tables()
        if table not in tables:
            raise SceneError(
                f"this study has no table {shown(table)}: give one of {', '.join(tables)}"
            )
        return tables[table]

    def _tables(self) -> dict[str, pd.DataFrame]:
        """Return every table that has columns, by the name of its file."""
        tables = {"orders": self.orders, **self.tables}
        if not any(table is self.table for table in self.tables.values()):
            tables = {self.name: self.table} | tables
        return {name: table for name, table in tables.items() if len(table.columns)}
