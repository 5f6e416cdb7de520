"""Refine a mesh in every way, and report what each accuracy costs (`ringwear study refinement`).

The study solves two cases: a flat punch of one ring, and the flat punch of the scene. The reference
is a far finer MDR. `ways.py` defines the ways to refine, and `case.py` the errors.
"""

from collections.abc import Iterable, Mapping

import pandas as pd
from matplotlib.figure import Figure

from ..crosscheck import Scene
from ..study.levels import SECONDS, Record
from ..study.options import Options
from ..study.study import Study
from .case import COLUMNS, Case, Level
from .conclusions import conclude, costs
from .figures import THOUSANDS, draw_errors, draw_indicator
from .mesh_figures import draw_meshes, draw_own_meshes, draw_pressure_errors
from .observed_orders import sequences
from .own_meshes import OwnMeshes
from .ways import Ways


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Refine each case in each way.

    Raises
    ------
    SceneError
        if a mesh of the user does not fit the flat punch, so that it fits no case
    """
    cases = {case.name: case for case in Case.all_of(scene)}
    OwnMeshes(cases["flat punch"], options).refuse()
    levels = list[Level]()
    families = [
        family for case in cases.values() for family in Ways(case, options, levels).families()
    ]
    table = record.solve("refinement", families, COLUMNS)
    rows = table.dropna(subset="d0")
    return Study(
        "refinement",
        scene,
        table,
        orders=pd.DataFrame(sequence.summary() for sequence in sequences(rows)),
        conclusions=(*conclude(cases, rows, levels), *record.conclusions),
        figures=draw_figures(cases, rows, levels),
        tables={"costs": costs(rows)} if len(rows) else {},
    )


def draw_figures(
    cases: Mapping[str, Case], rows: pd.DataFrame, levels: Iterable[Level]
) -> dict[str, Figure]:
    """Return all figures by their names; figures without data are left out."""
    if rows.empty:
        return {}
    levels, titles = list(levels), {name: case.title for name, case in cases.items()}
    figures = {
        "error_against_unknowns": draw_errors(rows, "unknowns", THOUSANDS, titles),
        "error_against_seconds": draw_errors(rows, SECONDS, "seconds", titles),
        "indicator": draw_indicator(rows, titles),
    }
    for name, case in cases.items():
        case_levels = [level for level in levels if level.case == name]
        suffix = name.replace(" ", "_")
        if case_levels:
            figures[f"meshes_{suffix}"] = draw_meshes(case, case_levels)
            figures[f"pressure_error_{suffix}"] = draw_pressure_errors(case, case_levels)
        if own_levels := [level for level in case_levels if level.family == "file"]:
            figures[f"own_meshes_{suffix}"] = draw_own_meshes(case, own_levels)
    return figures
