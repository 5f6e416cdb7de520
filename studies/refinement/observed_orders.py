"""Name the ways to refine, and fit the orders of those whose elements have one degree."""

import pandas as pd

from ..study.levels import Theory
from ..study.orders import Sequence
from .case import ERRORS

FAMILY_NAMES = {
    "uniform": "uniform triangles",
    "graded": "triangles graded before solving",
    "adaptive": "adaptive triangles",
    "layered": "the default (layers and degrees)",
    "degree": "rising degree",
    "file": "your meshes",
}
"""Names of the families in sentences and figures."""
BEST_ORDER = (
    "elements of degree k have at best the order k, and refinement with this marking reaches it "
    "(Stevenson, Found. Comput. Math. 7, 2007, doi 10.1007/s10208-005-0183-0)"
)
"""Theory of the order of the energy error on adaptive meshes."""


def sequences(rows: pd.DataFrame) -> list[Sequence]:
    """Return errors over N^(-1/2), N the unknowns, for uniform, adaptive and the user's meshes.

    In the plane, N^(-1/2) is proportional to the size of uniform elements. For adaptive meshes only
    the finer half of the levels is used, because the coarser levels do not yet resolve the
    singularities.
    """
    fitted = []
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
            fitted.append(Sequence(f"{case}, {family}", quantity, theory, sizes, errors))
    return fitted
