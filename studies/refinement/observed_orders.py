"""Names of the ways to refine, and observed orders of those that refine one kind of elements."""

import pandas as pd

from ..study.levels import Theory
from ..study.orders import Sequence
from .case import ERRORS

NAMES = {
    "uniform": "uniform triangles",
    "graded": "triangles graded before solving",
    "adaptive": "adaptive triangles",
    "layered": "the default (layers and degrees)",
    "degree": "rising degree",
    "file": "your meshes",
}
"""What the families are called in sentences and figures."""
BEST_ORDER = (
    "elements of degree k have the order k at best, and marked so they reach it (Stevenson, Found. "
    "Comput. Math. 7, 2007, doi 10.1007/s10208-005-0183-0)"
)
"""Theory of the energy error on adaptive meshes."""


def sequences(rows: pd.DataFrame) -> list[Sequence]:
    """Return errors over N^(-1/2), N the unknowns, for the ways that refine one kind of elements.

    In the plane N^(-1/2) stands for the size of the elements. Of adaptive meshes the finer half of
    the levels counts: the coarser half is still on its way to the singularities.
    """
    found = []
    for (case, family), all_levels in rows.groupby(["case", "family"], sort=False):
        levels = all_levels
        if family == "adaptive":
            levels = levels.iloc[len(levels) // 2 :]
        if family not in ("uniform", "adaptive", "file") or len(levels) < 2:
            continue
        for quantity in ("energy", *ERRORS):
            theory = Theory()
            if family == "adaptive" and quantity == "energy":
                theory = Theory(reason=BEST_ORDER)
            sizes = levels["unknowns"].to_numpy(float) ** -0.5
            errors = levels[quantity].to_numpy(float)
            found.append(Sequence(f"{case}, {family}", quantity, theory, sizes, errors))
    return found
