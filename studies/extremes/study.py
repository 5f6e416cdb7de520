"""The study of extremes: panels over one parameter, and the map over two."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ..scene.scene import Scene
from ..study.levels import Record
from ..study.options import Options
from ..study.study import Study
from . import cells
from .draw import draw_panels
from .panels import NAIVE, Panel, read_panels
from .verdicts import MEANINGS, in_words

COLUMNS = [
    "part",
    "family",
    "method",
    "x",
    "y",
    "verdict",
    "quantity",
    "error",
    "estimate",
    "promised",
    "greatest error",
    "greatest estimate",
    "seconds",
    "message",
    "parameters",
]


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Judge every run of the panels and every cell of the map.

    Of the scene, Poisson's ratio is taken. The table is sorted by the worst: by the verdict, then
    by the error over the accuracy that was promised.
    """
    ratio, quick = scene.half_space.poisson_ratio, options.quick
    panels = list(read_panels(ratio))
    families = [panel.family(quick) for panel in panels]
    table = record.solve("extremes", [*families, *cells.families(ratio, quick)], COLUMNS)
    # everything may have been interrupted
    along, mapped = (table[table.part == part] for part in ("panel", "map"))
    figures = {"extremes": draw_panels(panels, along)} if len(along) else {}
    # one cell of each family is no map
    if len(mapped) and not quick:
        figures["map"] = cells.draw(mapped)
    refusals = list_refusals(table)
    return Study(
        "extremes",
        scene,
        sort_by_worst(table),
        conclusions=(*conclude(panels, along, mapped), *record.conclusions),
        figures=figures,
        tables={"refusals": refusals} if len(refusals) else {},
    )


def sort_by_worst(table: pd.DataFrame) -> pd.DataFrame:
    """Return the table with the worst verdict first, and the greatest error over the promise."""
    ranks = table.verdict.map({verdict: at for at, verdict in enumerate(MEANINGS)}).fillna(-1)
    over = table.error.astype(float) / table.promised.astype(float)
    order = np.lexsort([-over.fillna(0.0).to_numpy(), -ranks.to_numpy()])
    return table.iloc[order].reset_index(drop=True)


def list_refusals(table: pd.DataFrame) -> pd.DataFrame:
    """Return the texts of refusals, each once, with how many runs and which first it refused."""
    refused = table[table.verdict == "refused"]
    grouped = refused.groupby("message", sort=False, as_index=False)
    return grouped.agg(
        runs=("family", "size"),
        family=("family", "first"),
        method=("method", "first"),
        x=("x", "first"),
        y=("y", "first"),
    )


def conclude(panels: list[Panel], along: pd.DataFrame, mapped: pd.DataFrame) -> Iterator[str]:
    """Yield the headline of the panels and of the map, and what the naive choice errs by."""
    own = along[along.method != NAIVE]
    if len(own):
        yield f"{in_words(count_verdicts(own), 'runs along one parameter')}."
    if len(mapped):
        yield f"{in_words(count_verdicts(mapped), 'cells of the map')}."
    stated = own.dropna(subset=["greatest error", "greatest estimate"])
    if len(stated):
        over = (stated["greatest estimate"] / stated["greatest error"]).astype(float)
        yield (
            "The greatest error that a run states is "
            f"{over.median():.2g} times its greatest true error in the median."
        )
    errors = along[along.method == NAIVE].error.dropna().astype(float)
    if len(errors):
        finite = errors[np.isfinite(errors)]
        # what is beyond 1 is no result any more
        diverged = int((errors > 1).sum())
        yield (
            f"The naive choice errs by {100 * finite.min():.2g} % at the least; it errs by more "
            f"than the result itself in {diverged} of {len(errors)} runs."
        )
    for panel in panels:
        of_panel = along[(along.family == panel.name) & (along.method == NAIVE)]
        errors = of_panel.error.dropna().astype(float)
        if len(errors):
            text, greatest = " ".join(panel.naive.split()), errors.max()
            size = "without bound" if greatest > 1e3 else f"by up to {100 * greatest:.3g} %"
            yield f"{panel.name}: the naive choice errs {size} ({text})."


def count_verdicts(table: pd.DataFrame) -> dict[str, int]:
    """Return how many rows have each verdict."""
    return {verdict: int((table.verdict == verdict).sum()) for verdict in MEANINGS}
