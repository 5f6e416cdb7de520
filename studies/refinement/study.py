"""Refine the mesh in every way, and tell what each accuracy costs (`ringwear study refinement`).

The punch is flat, once of one ring, and once that of the scene. The truth is a far finer MDR. What
the ways are is told in `ways.py`, what is measured in `case.py`.
"""

import pandas as pd

from ..problem.scene import Scene
from ..study.levels import Record
from ..study.options import Options
from ..study.study import Study
from .case import COLUMNS, Case, Level
from .conclusions import conclude, costs, sequences
from .figures import draw_figures
from .own_meshes import OwnMeshes
from .ways import Ways


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Refine each case in each way.

    Raises
    ------
    SceneError
        if a mesh of the user's does not fit the flat punch, and so fits nothing
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
