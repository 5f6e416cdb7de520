"""The result of a fit, which is shown in print and in notebooks, and saved to a folder."""

from dataclasses import dataclass
from functools import cached_property, partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from ...meshes import RingwearError
from ..crosscheck import AnswersGuesses, make, output_folder
from ..report.template import write_study
from ..tables.writing import write_csv
from .outcome import Outcome
from .words import conclusions_of_fit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABLES = ("estimates.csv", "residuals.csv", "tests.csv")
FILES = (*TABLES, "fit.png", "likelihood.png", "report.html")


@dataclass(frozen=True, eq=False, repr=False)
class Fit(AnswersGuesses, Outcome):
    """The result of a fit, which is shown in print and in notebooks, and saved to a folder."""

    @cached_property
    def conclusions(self) -> tuple[str, ...]:
        """The conclusions in sentences."""
        return conclusions_of_fit(self)

    @cached_property
    def figures(self) -> "dict[str, Figure]":
        """The figures, by the name of their file without its ending."""
        from ..figures.style import in_style
        from .figures import draw_all

        with in_style():
            return draw_all(self)

    def __repr__(self) -> str:
        """Return the conclusions."""
        title = f"Fit of {self.scene.title or 'an untitled scene'}"
        return "\n".join([title, *(f"  {line}" for line in self.conclusions)])

    def _repr_html_(self) -> str:
        """Return conclusions, estimates and figures as HTML, for notebooks."""
        from ..figures.style import html_of

        blocks = [f"<pre>{escape(repr(self))}</pre>"]
        blocks.append(self.estimates.to_html(float_format="{:.4g}".format))
        blocks += map(html_of, self.figures.values())
        return "".join(blocks)

    def save(self, folder: str | Path) -> list[str]:
        """Write the files of ``ringwear fit --out folder``, and return their names.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or contains other files with these names
        RingwearError
            if a figure or the page cannot be made
        """
        with output_folder(folder, "fit", FILES) as out:
            if failures := self.write(out.hidden):
                raise RingwearError("; ".join(failures))
        return out.written

    def write(self, folder: Path) -> list[str]:
        """Write tables, figures and the page to a folder; return messages on what failed."""
        from ..figures.style import in_style

        tables = {
            "estimates": self.estimates.rename_axis("parameter").reset_index(),
            "residuals": self.residuals,
            "tests": pd.DataFrame({"test": self.tests.keys(), "probability": self.tests.values()}),
        }
        for name, table in tables.items():
            if len(table):
                write_csv(table, folder / f"{name}.csv")
        for name, figure in self.figures.items():
            with in_style():
                figure.savefig(folder / f"{name}.png")
        title = f"Fit of {self.scene.title or 'an untitled scene'}"
        purpose = "Parameters that measurements determine, their intervals, and what is unknown."
        write = partial(write_study, title, purpose, self.scene, self.conclusions, tables.items())
        return make(folder / "report.html", write)
