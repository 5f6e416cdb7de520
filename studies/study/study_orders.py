"""Conduct a study of orders: solve families, fit orders of convergence, and draw errors."""

from collections.abc import Iterable

import pandas as pd

from ..crosscheck import Scene
from .errors_over_size import draw_errors, panels_of
from .levels import Family, Record
from .orders import conclude, sequences_of
from .study import Study


def study_orders(
    families: Iterable[Family], record: Record, name: str, scene: Scene, ylabel: str
) -> Study:
    """Solve families, fit their orders, draw their errors, and compare the orders with theory.

    Parameters
    ----------
    families : ways to refine, each from coarse to fine
    record : solver of the levels, which writes their rows
    name : name of the study, its table and its figure
    scene : scene that is studied
    ylabel : label of the errors in the figure
    """
    families = list(families)
    quantities = dict.fromkeys(quantity for family in families for quantity in family.theory)
    columns = ["family", "setting", "size", "unknowns", *quantities]
    table = record.solve(name, families, columns)
    sequences = sequences_of(families, table)
    panels = panels_of(sequences, {family.name: family.xlabel for family in families})
    return Study(
        name,
        scene,
        table,
        orders=pd.DataFrame(sequence.summary() for sequence in sequences),
        conclusions=(*conclude(sequences), *record.conclusions),
        figures={name: draw_errors(panels, ylabel, scene.title)},
    )
