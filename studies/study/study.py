"""Results of a study: the answer, a table of levels, orders of convergence, and the figure."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from ...meshes import RingwearError, SceneError
from ..crosscheck import AnswersGuesses, Scene, make, output_folder, shown
from ..figures.style import html_of, in_style
from ..tables.writing import INTERRUPTED, write_csv
from .answer import sentence
from .draw import draw, titled
from .formats import LATEX_WIDTH, blocks, to_latex, to_markdown
from .record import SOLVED, Record
from .way import Part

if TYPE_CHECKING:
    from matplotlib.figure import Figure

QUICK = (
    "With --quick, levels are coarse and few: orders and costs are those of coarse levels, and "
    "may differ from those of the whole study."
)
CELLS = "observed order (that of theory), and error on the finest level; then costs of each error"
"""Meaning of the cells of the answer."""
ON_PAGE = ("answer", "orders", "claims")
"""Names of the tables that the page shows."""


@dataclass(frozen=True)
class Study(AnswersGuesses):
    """Results of a study.

    Parameters
    ----------
    name : name of the study, as on the command line
    scene : scene that was studied
    table : tidy table: one row for each quantity of each level (`studies/study/README.md`)
    orders : one row for each sequence of levels: numbers of its observed order, that of theory and
        Richardson's limit, and a remark in words; empty for studies without orders
    conclusions : up to eight sentences that summarise the answer
    figures : figures by the name of their file, without its extension
    tables : further tables by the name of their file, without its extension; `costs` has the
        numbers of what an accuracy costs
    purpose : the question of the study
    measured : rows of the table that the answer and the figure show
    answer : how accurate each way is and what an accuracy costs by it, as texts; a row for each

    Examples
    --------
    >>> import ringwear
    >>> march = ringwear.study("march", "five_rings", quick=True)
    >>> sorted(set(march.orders["theory"].dropna()))  # both Euler methods have order 1
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
    measured: pd.DataFrame = field(default_factory=pd.DataFrame)
    answer: pd.DataFrame = field(default_factory=pd.DataFrame)

    def __repr__(self) -> str:
        """Return the name, the number of levels, and the conclusions."""
        title = f"Study {self.name} of {self.scene.title or 'an untitled scene'}: "
        keys = [name for name in ("case", "way", "level") if name in self.table]
        count = len(self.table[keys].drop_duplicates()) if keys else len(self.table)
        return "\n".join([f"{title}{count} levels", *self.conclusions])

    def _repr_html_(self) -> str:
        """Return the conclusions, the orders and the figures as HTML, for notebooks."""
        parts = [f"<pre>{escape(repr(self))}</pre>"]
        parts += [part.to_html(index=False) for part in blocks(self._for_papers(""))]
        parts += map(html_of, self.figures.values())
        return "".join(parts)

    def plot(self, x: str = "seconds", y: str = "error") -> "Figure":
        """Return a figure of one column of `table` over another, as in the figure of the study.

        Parameters
        ----------
        x, y : names of columns that have numbers

        Raises
        ------
        SceneError
            if no level has numbers in both columns
        """
        numbers = self.measured.select_dtypes("number")
        if not {x, y} <= {*numbers} or numbers[[x, y]].dropna().empty:
            raise SceneError(
                f"no level has {shown(x)} and {shown(y)}: give two of {', '.join(numbers)}"
            )
        return draw(self.measured, (x,), y, self.orders, titled(self.scene.title, self.purpose))

    def to_markdown(self, table: str = "") -> str:
        """Return a table in Markdown, as in the files of `save` and on the terminal.

        Parameters
        ----------
        table : ``"answer"``, ``"orders"``, or the name of one of `tables`; by default the answer.
            Wide tables are split
        """
        return "\n".join(map(to_markdown, blocks(self._for_papers(table))))

    def to_latex(self, table: str = "") -> str:
        """Return a table as `tabular` of up to five columns, which need the package `booktabs`.

        Parameters
        ----------
        table : as in `to_markdown`
        """
        return "\n".join(map(to_latex, blocks(self._for_papers(table), LATEX_WIDTH)))

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
        tables = self._tables()
        if not any(table is self.table for table in tables.values()):
            tables |= {self.name: self.table}
        for name, table in tables.items():
            write_csv(table, folder / f"{name}.csv")
        for name in [name for name in tables if name in (*ON_PAGE, "costs")]:
            (folder / f"{name}.md").write_text(self.to_markdown(name), "utf-8")
            (folder / f"{name}.tex").write_text(self.to_latex(name), "utf-8")
        for name, figure in self.figures.items():
            with in_style():
                figure.savefig(folder / f"{name}.png")
        from ..report.template import write_study

        title = f"Study: {self.name}"
        captions = {"answer": f"answer: {CELLS}"}
        parts = [
            (captions.get(name, name) * (not number), part)
            for name in [name for name in ON_PAGE if name in tables] or [self.name]
            for number, part in enumerate(blocks(self._for_papers(name)))
        ]
        write = partial(write_study, title, self.purpose, self.scene, self.conclusions, parts)
        return failures + make(folder / "report.html", write)

    def _for_papers(self, name: str) -> pd.DataFrame:
        """Return a table by its name; of orders and costs, each quantity is a case.

        Raises
        ------
        SceneError
            if there is no such table; the message lists the names of the existing tables
        """
        tables = {self.name: self.table} | self._tables()
        name = name or ("answer" if "answer" in tables else self.name)
        if name not in tables:
            raise SceneError(
                f"this study has no table {shown(name)}: give one of {', '.join(tables)}"
            )
        table = tables[name]
        if name not in ("orders", "costs"):
            return table
        several = table["case"].nunique() > 1
        keys = table[["case", "quantity", "when"]].to_numpy()
        cases = [titled(case * several, str(Part(*part))) for case, *part in keys]
        return table.drop(columns=["quantity", "when", "remark"], errors="ignore").assign(
            case=cases
        )

    def _tables(self) -> dict[str, pd.DataFrame]:
        """Return every table that has columns, without the tidy one, by the name of its file."""
        tables = {"answer": self.answer, "orders": self.orders, **self.tables}
        return {name: table for name, table in tables.items() if len(table)}


def remarks(record: Record, quick: bool = False) -> list[str]:
    """Return the sentences on levels that failed, on an interruption, and on a quick study."""
    table = record.table
    failed = table[table["outcome"].notna() & (table["outcome"] != SOLVED)]
    texts = [
        f"{row['case']}, {row['way']}, level {row['level']} {row['outcome']}: {row['message']}"
        for row in failed.to_dict("records")
    ]
    others = [remark for remark in record.remarks if remark != INTERRUPTED]
    return [
        *([sentence("", texts)] if texts else []),
        *([sentence("", others)] if others else []),
        *([QUICK] if quick else []),
        *([INTERRUPTED] if INTERRUPTED in record.remarks else []),
    ]
