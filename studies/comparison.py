"""Two results beside each other, in Python and for the command `compare`."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from ..meshes.errors import SceneError
from .calls import naming_arguments
from .outcome.outcome import Outcome
from .outcome.run import run
from .output.folder import output_folder
from .output.stored import StoredOutcome, load
from .report.comparison import answer_rows, field_comparison, refuse_other_units, scene_rows
from .sampling.field_differences import FieldComparison
from .scene.explain import nearest
from .scene.scene import Scene, Source
from .tables import write_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FILES = "scenes.csv", "answers.csv", "comparison.png", "difference.png"


@naming_arguments
def compare(a: Source | Outcome, b: Source | Outcome) -> "Comparison":
    """Compare two results: what differs between their scenes, in their answers and in their fields.

    Parameters
    ----------
    a, b : Result, Scene, str, Path or dict
        Results, or a folder that they were saved in; or a scene as `run` takes it, which is
        computed.

    Returns
    -------
    Comparison
        With `table`, `scenes`, `verdict`, `figures` and `save(folder)`.

    Raises
    ------
    SceneError
        if one cannot be read or computed, or if the scenes have different units

    Examples
    --------
    Twice the force presses twice as deep:

    >>> from ringwear import Scene
    >>> scene = Scene.load("flat_punch").changed(methods=["mdr"])
    >>> twice = scene.changed({"load.normal_force": 2 * scene.load.normal_force})
    >>> found = compare(scene, twice)
    >>> found.verdict
    'differ'
    >>> found.table.set_index("quantity").loc["indentation_start", "B against A"]
    '+100 %'
    """
    sources = [_source(each) for each in (a, b)]
    first, second = (each if isinstance(each, Scene) else each.scene for each in sources)
    refuse_other_units(first, second)
    return Comparison(*(run(each) if isinstance(each, Scene) else each for each in sources))


def _source(given: Source | Outcome) -> Scene | Outcome:
    """Return the results that are there, or the scene that is to be computed."""
    if isinstance(given, Outcome):
        return given
    is_folder = isinstance(given, str | Path) and str(given) and Path(given).is_dir()
    return load(str(given), StoredOutcome) if is_folder else Scene.of(given)


@dataclass(frozen=True, eq=False)
class Comparison:
    """Two results beside each other: `table`, `scenes`, `verdict`, `figures` and `save(folder)`.

    Parameters
    ----------
    a, b : what is compared
    """

    a: Outcome
    b: Outcome

    @cached_property
    def table(self) -> pd.DataFrame:
        """Each number of the punch: `quantity`, `A`, `B`, `B against A`, and what is `known`.

        What is known is the sum of the relative errors that both sides state.
        """
        return answer_rows(self.a, self.b)

    @cached_property
    def scenes(self) -> pd.DataFrame:
        """The keys of the scenes that differ: `key`, `A` and `B`."""
        return scene_rows(self.a, self.b)

    @cached_property
    def fields(self) -> FieldComparison | None:
        """B minus A along the radius; None if no field is given by both at a common time."""
        return field_comparison(self.a, self.b)

    @property
    def differing(self) -> pd.DataFrame:
        """Rows of the table in which A and B differ by more than both state."""
        return self.table[self.table["differs"]]

    @property
    def verdict(self) -> str:
        """Either `same` or `differ`: whether any number differs by more than both sides state."""
        return "differ" if len(self.differing) else "same"

    @property
    def verdict_in_words(self) -> str:
        """The verdict in a sentence, with the number that differs most."""
        rows = self.differing
        if not len(rows):
            return f"A and B are the same in {len(self.table)} numbers, to the errors both state."
        most = rows.loc[rows["change"].abs().idxmax()]
        return (
            f"A and B differ in {len(rows)} of {len(self.table)} numbers by more than both state, "
            f"most in {most['quantity']}: {most['B against A'] or 'infinitely'}."
        )

    @cached_property
    def figures(self) -> "Mapping[str, Figure]":
        """Figures by name: `comparison`, and `difference` where there are fields of both."""
        from .figures.comparison import COMPARED_LOOKS, draw_comparison, titles
        from .figures.difference import draw_difference
        from .figures.scale import Scale
        from .figures.style import in_style

        with in_style():
            drawn = {"comparison": draw_comparison(self.a, self.b)}
            if self.fields is not None:
                title = ": ".join(titles(self.a, self.b))
                drawn["difference"] = draw_difference(
                    Scale(self.a.scene, COMPARED_LOOKS), title, (self.fields,)
                )
        return drawn

    def plot(self, kind: str = "comparison") -> "Figure":
        """Return one of the figures.

        Raises
        ------
        SceneError
            if there is none of that name
        """
        if kind not in self.figures:
            near = nearest(str(kind), self.figures)
            meant = f"did you mean {near!r}? Else " if near else ""
            raise SceneError(f"no figure {kind!r}: {meant}give one of {', '.join(self.figures)}")
        return self.figures[kind]

    def write(self, folder: Path) -> None:
        """Write tables and figures into a folder that is there."""
        from .figures.style import in_style

        for file, table in zip(FILES, (self.scenes, self.shown), strict=False):
            write_csv(table, folder / file)
        for name, figure in self.figures.items():
            with in_style():
                figure.savefig(folder / f"{name}.png", pil_kwargs={"compress_level": 3})

    def save(self, folder: str | Path) -> list[str]:
        """Write what ``ringwear compare --out folder`` does; return the names of the files.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or holds files of others with these names
        """
        with output_folder(Path(folder), "compare", FILES) as out:
            self.write(out.hidden)
        return out.written

    @property
    def shown(self) -> pd.DataFrame:
        """The columns of the table that are texts, for people."""
        return self.table[["quantity", "A", "B", "B against A", "known"]]

    def __repr__(self) -> str:
        """Return what differs between the scenes, the table and the verdict."""
        parts = [table.to_string(index=False) for table in (self.scenes, self.shown) if len(table)]
        return "\n\n".join([*parts, self.verdict_in_words])

    def _repr_html_(self) -> str:
        """Return the tables and the verdict as HTML, for notebooks."""
        parts = [table.to_html(index=False) for table in (self.scenes, self.shown) if len(table)]
        return "".join([*parts, f"<p>{self.verdict_in_words}</p>"])
