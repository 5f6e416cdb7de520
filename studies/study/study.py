"""The value that a study returns: a table, its orders, its figures and its conclusions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from ...meshes.errors import RingwearError, SceneError
from ..figures.style import html_of, in_style
from ..output.folder import output_folder
from ..output.one_file import make
from ..scene.scene import Scene
from ..tables import write_csv
from .formats import to_latex, to_markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Study:
    """What a study found.

    Parameters
    ----------
    name : of the study, as the command line calls it
    scene : that was studied
    table : one row for each level that was solved
    orders : one row for each sequence of levels: observed orders beside those of theory, and
        Richardson's limit; empty for studies without orders
    conclusions : what the tables and figures say, a sentence each
    figures : by the name of their file, without its ending
    tables : further tables, by the name of their file, without its ending
    purpose : what the study is for, for its page

    Examples
    --------
    >>> import ringwear
    >>> march = ringwear.study("march", "five_rings", quick=True)
    >>> march.orders["expected order"].dropna().tolist()  # Euler's methods are of the first order
    [1.0, 1.0]
    """

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
        shown = self.orders if len(self.orders) else self.table
        parts.append(shown.to_html(index=False, max_rows=40, float_format="{:.4g}".format))
        parts += map(html_of, self.figures.values())
        return "".join(parts)

    def to_markdown(self, table: str = "") -> str:
        """Return a table in Markdown, with rows and columns as on disk.

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
        """Write what ``ringwear study NAME --out folder`` does; return the names of the files.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or holds files of others with these names
        RingwearError
            if a figure cannot be drawn
        """
        with output_folder(Path(folder), f"study {self.name}", ["report.html"]) as out:
            if failures := self.write(out.hidden):
                raise RingwearError("; ".join(failures))
        return out.written

    def write(self, folder: Path) -> list[str]:
        """Write tables, figures and the page to a folder; return what could not be made."""
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
        """Return the table of a name, or that of the levels.

        Raises
        ------
        SceneError
            if there is no such table, naming those that there are
        """
        if table in ("", self.name):
            return self.table
        tables = self._tables()
        if table not in tables:
            raise SceneError(f"no table {table!r} in this study: give one of {', '.join(tables)}")
        return tables[table]

    def _tables(self) -> dict[str, pd.DataFrame]:
        """Return every table that is not empty, by the name of its file."""
        tables = {"orders": self.orders, **self.tables}
        if not any(table is self.table for table in self.tables.values()):
            tables = {self.name: self.table} | tables
        return {name: table for name, table in tables.items() if len(table.columns)}
