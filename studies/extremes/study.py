"""The study of extremes: panels over one parameter, and the map over two."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ..crosscheck import Scene
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

    Only Poisson's ratio of the scene is used. The table begins with the worst row: it is sorted by
    the verdict, then by the error relative to the promised accuracy.
    """
    ratio, quick = scene.half_space.poisson_ratio, options.quick
    panels = list(read_panels(ratio))
    families = [panel.family(quick) for panel in panels]
    table = record.solve("extremes", [*families, *cells.families(ratio, quick)], COLUMNS)
    # after an interruption, either part may be empty
    panel_rows, map_rows = (table[table.part == part] for part in ("panel", "map"))
    figures = {"extremes": draw_panels(panels, panel_rows)} if len(panel_rows) else {}
    # the quick study has one point of each family, which makes no map
    if len(map_rows) and not quick:
        figures["map"] = cells.draw(map_rows)
    refusals = list_refusals(table)
    return Study(
        "extremes",
        scene,
        sort_by_worst(table),
        conclusions=(*conclude(panels, panel_rows, map_rows), *record.conclusions),
        figures=figures,
        tables={"refusals": refusals} if len(refusals) else {},
    )


def sort_by_worst(table: pd.DataFrame) -> pd.DataFrame:
    """Return the table sorted by verdict, worst first, and by error over promised accuracy."""
    ranks = table.verdict.map({verdict: rank for rank, verdict in enumerate(MEANINGS)}).fillna(-1)
    relative_errors = table.error.astype(float) / table.promised.astype(float)
    order = np.lexsort([-relative_errors.fillna(0.0).to_numpy(), -ranks.to_numpy()])
    return table.iloc[order].reset_index(drop=True)


def list_refusals(table: pd.DataFrame) -> pd.DataFrame:
    """Return each text of a refusal once, with the number of its runs and the first of them."""
    refused = table[table.verdict == "refused"]
    grouped = refused.groupby("message", sort=False, as_index=False)
    return grouped.agg(
        runs=("family", "size"),
        family=("family", "first"),
        method=("method", "first"),
        x=("x", "first"),
        y=("y", "first"),
    )


def conclude(
    panels: list[Panel], panel_rows: pd.DataFrame, map_rows: pd.DataFrame
) -> Iterator[str]:
    """Yield the headlines of the panels and of the map, and the errors of the naive solver."""
    ringwear_rows = panel_rows[panel_rows.method != NAIVE]
    if len(ringwear_rows):
        yield f"{in_words(count_verdicts(ringwear_rows), 'runs along one parameter')}."
    if len(map_rows):
        yield f"{in_words(count_verdicts(map_rows), 'cells of the map')}."
    estimated = ringwear_rows.dropna(subset=["greatest error", "greatest estimate"])
    if len(estimated):
        ratios = (estimated["greatest estimate"] / estimated["greatest error"]).astype(float)
        yield (
            "The median ratio of the greatest error estimate of a run to its greatest true error "
            f"is {ratios.median():.2g}."
        )
    errors = panel_rows[panel_rows.method == NAIVE].error.dropna().astype(float)
    if len(errors):
        finite = errors[np.isfinite(errors)]
        # a relative error above 1 exceeds the result itself
        diverged = int((errors > 1).sum())
        yield (
            f"The naive finite elements have errors of {100 * finite.min():.2g} % at least; the "
            f"error exceeds the result itself in {diverged} of {len(errors)} runs."
        )
    for panel in panels:
        naive_rows = panel_rows[(panel_rows.family == panel.name) & (panel_rows.method == NAIVE)]
        errors = naive_rows.error.dropna().astype(float)
        if len(errors):
            reason, greatest = " ".join(panel.naive_failure.split()), errors.max()
            size = "without bound" if greatest > 1e3 else f"of up to {100 * greatest:.3g} %"
            yield f"{panel.name}: the naive finite elements have errors {size} ({reason})."


def count_verdicts(table: pd.DataFrame) -> dict[str, int]:
    """Return the number of rows with each verdict."""
    return {verdict: int((table.verdict == verdict).sum()) for verdict in MEANINGS}
