"""Compare two results, in Python and for the command `compare`."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ..meshes import SceneError
from .crosscheck import (
    ANSWER,
    IN_STEADY_STATE,
    OVER_TIME,
    QUANTITIES,
    AnswersGuesses,
    FieldComparison,
    Result,
    Scene,
    Source,
    compare_fields,
    error_name,
    load,
    naming_arguments,
    output_folder,
    run,
)
from .tables.writing import write_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# relative difference up to which numbers count as equal
ROUNDOFF = 1e-12
FILES = "scenes.csv", "answers.csv", "comparison.png", "difference.png"


@naming_arguments
def compare(a: Source | Result, b: Source | Result) -> "Comparison":
    """Compare two results: their scenes, the numbers of their answers, and their fields.

    Parameters
    ----------
    a, b : Result, Scene, str, Path or dict
        A result, a folder with saved results, or a scene in any form that `run` accepts, which is
        then computed.

    Returns
    -------
    Comparison
        With `table`, `scenes`, `same`, `figures` and `save(folder)`.

    Raises
    ------
    SceneError
        if one of them cannot be read or computed, or if the scenes have different units

    Examples
    --------
    Twice the force presses twice as deep:

    >>> from ringwear import Scene
    >>> scene = Scene.load("flat_punch").changed(methods=["mdr"])
    >>> twice = scene.changed({"load.normal_force": 2 * scene.load.normal_force})
    >>> found = compare(scene, twice)
    >>> found.same
    False
    >>> found.table.set_index("quantity").loc["indentation_start", "B against A"]
    '+100 %'
    """
    sources = [_source(source) for source in (a, b)]
    first, second = (source if isinstance(source, Scene) else source.scene for source in sources)
    if first.unit_names.base != second.unit_names.base:
        raise SceneError(
            f"units = {first.units!r} and {second.units!r} differ: compare scenes in the same units"
        )
    return Comparison(*(run(source) if isinstance(source, Scene) else source for source in sources))


def _source(source: Source | Result) -> Scene | Result:
    """Return existing results, or the scene that is to be computed."""
    if isinstance(source, Result):
        return source
    is_folder = isinstance(source, str | Path) and str(source) and Path(source).is_dir()
    return load(str(source)) if is_folder else Scene.of(source)


@dataclass(frozen=True, eq=False)
class Comparison(AnswersGuesses):
    """A comparison of two results: `table`, `scenes`, `same`, `figures` and `save(folder)`.

    Parameters
    ----------
    a, b : the two results
    """

    a: Result
    b: Result

    @cached_property
    def table(self) -> pd.DataFrame:
        """A row for each number of the answer: `quantity`, `A`, `B`, `B against A`, `known`, ...

        `known` is the sum of the relative error estimates of both results, `change` the relative
        difference as a number, and `differs` whether it is larger than `known`.
        """
        names, rows = self.a.scene.unit_names, []
        for name, quantity in (ANSWER | QUANTITIES).items():
            if quantity.dims:
                continue
            first, second = (float(side.first(name)) for side in (self.a, self.b))
            if np.isnan([first, second]).all():
                continue
            change = second / first - 1 if first else np.nan
            estimates = [side.first(error_name(name)) for side in (self.a, self.b)]
            uncertainty = max(float(np.nansum(estimates)), ROUNDOFF)
            written = names.write_together([first, second], quantity.unit)
            # a number that is missing does not differ
            differs = abs(second - first) > uncertainty * abs(first)
            rows.append(
                {
                    "quantity": name,
                    "A": written[0],
                    "B": written[1],
                    "B against A": f"{100 * change:+.3g} %" if np.isfinite(change) else "",
                    "known": f"{uncertainty:.1e}",
                    "change": change,
                    "differs": differs,
                }
            )
        return pd.DataFrame(rows)

    @cached_property
    def scenes(self) -> pd.DataFrame:
        """A row for each scene key whose values differ: `key`, `A` and `B`."""
        tables = [
            pd.json_normalize(side.scene.table()).iloc[0].astype(str) for side in (self.a, self.b)
        ]
        table = pd.concat(tables, axis=1, keys=["A", "B"]).fillna("not given")
        return table[table.A != table.B].rename_axis("key").reset_index()

    @cached_property
    def fields(self) -> FieldComparison | None:
        """B minus A along the radius, by the first method with fields of each.

        None if A and B have no field at a common time.
        """
        reports = []
        for side in (self.a, self.b):
            methods = [
                name for field in (*OVER_TIME, *IN_STEADY_STATE) for name in side.by_method(field)
            ]
            if not methods:
                return None
            reports.append(side.reported(methods[0]))
        comparison = compare_fields(self.a.scene.problem, ("A", "B"), *reports)
        return comparison if comparison.fields else None

    @property
    def differing(self) -> pd.DataFrame:
        """Rows of the table in which A and B differ by more than their error estimates."""
        return self.table[self.table["differs"]]

    @property
    def same(self) -> bool:
        """Whether no number differs by more than the error estimates of both."""
        return not len(self.differing)

    @property
    def conclusion(self) -> str:
        """How many numbers differ, and which one most, in a sentence."""
        rows = self.differing
        if not len(rows):
            return f"A and B are equal in {len(self.table)} numbers, within their error estimates."
        row = rows.loc[rows["change"].abs().idxmax()]
        return (
            f"A and B differ in {len(rows)} of {len(self.table)} numbers by more than their error "
            f"estimates, most in {row['quantity']}: {row['B against A'] or 'infinitely'}."
        )

    @cached_property
    def figures(self) -> "Mapping[str, Figure]":
        """Figures by name: `comparison`, and `difference` if both results have the same fields."""
        from .figures.comparison import COMPARED_LOOKS, draw_comparison, title
        from .figures.difference import draw_difference
        from .figures.scale import Scale
        from .figures.style import in_style

        with in_style():
            figures = {"comparison": draw_comparison(self.a, self.b)}
            if self.fields is not None:
                figures["difference"] = draw_difference(
                    Scale(self.a.scene, COMPARED_LOOKS), title(self.a, self.b), (self.fields,)
                )
        return figures

    def write(self, folder: Path) -> None:
        """Write tables and figures into an existing folder."""
        from .figures.style import in_style

        for file, table in zip(FILES, (self.scenes, self.shown), strict=False):
            write_csv(table, folder / file)
        for name, figure in self.figures.items():
            with in_style():
                figure.savefig(folder / f"{name}.png", pil_kwargs={"compress_level": 3})

    def save(self, folder: str | Path) -> list[str]:
        """Write the files of ``ringwear compare --out folder``; return their names.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or contains other files with these names
        """
        with output_folder(folder, "compare", FILES) as out:
            self.write(out.hidden)
        return out.written

    @property
    def shown(self) -> pd.DataFrame:
        """The columns of the table that are printed."""
        return self.table[["quantity", "A", "B", "B against A", "known"]]

    def __repr__(self) -> str:
        """Return the differing scene keys, the table and the conclusion as text."""
        parts = [table.to_string(index=False) for table in (self.scenes, self.shown) if len(table)]
        return "\n\n".join([*parts, self.conclusion])

    def _repr_html_(self) -> str:
        """Return the tables and the conclusion as HTML, for notebooks."""
        parts = [table.to_html(index=False) for table in (self.scenes, self.shown) if len(table)]
        return "".join([*parts, f"<p>{self.conclusion}</p>"])
