"""Two results beside each other: what differs between their scenes, and in their answers."""

import numpy as np
import pandas as pd

from ...meshes.errors import SceneError
from ..outcome.outcome import Outcome
from ..problem.quantities import ANSWER, QUANTITIES, error_name
from ..problem.unit_names import UnitNames
from ..sampling.field_differences import (
    IN_STEADY_STATE,
    OVER_TIME,
    FieldComparison,
    compare_fields,
)
from ..scene.scene import Scene

# relative difference of numbers that are the same
ROUNDOFF = 1e-12


def refuse_other_units(a: Scene, b: Scene) -> None:
    """Raise a SceneError if the units of two scenes differ."""
    if UnitNames.of(a.units) != UnitNames.of(b.units):
        raise SceneError(
            f"units = {a.units!r} and {b.units!r} differ: compare scenes in the same units"
        )


def scene_rows(a: Outcome, b: Outcome) -> pd.DataFrame:
    """Return the keys of the scenes that differ."""
    tables = [pd.json_normalize(side.scene.table()).iloc[0].astype(str) for side in (a, b)]
    table = pd.concat(tables, axis=1, keys=["A", "B"]).fillna("not given")
    return table[table.A != table.B].rename_axis("key").reset_index()


def answer_rows(a: Outcome, b: Outcome) -> pd.DataFrame:
    """Return each number of the punch on both sides, and the relative difference.

    Columns `known`, the sum of the relative errors that both state, `change`, the relative
    difference as a number, and whether it `differs` by more than that, are beside the texts.
    """
    names, rows = UnitNames.of(a.scene.units), []
    for name, quantity in (ANSWER | QUANTITIES).items():
        if quantity.dims:
            continue
        first, second = float(a.first(name)), float(b.first(name))
        if np.isnan([first, second]).all():
            continue
        change = second / first - 1 if first else np.nan
        stated = [float(np.nan_to_num(side.first(error_name(name)))) for side in (a, b)]
        known = max(sum(stated), ROUNDOFF)
        one_missing = bool(np.isnan([first, second]).any())
        rows.append(
            {
                "quantity": name,
                "A": names.write(first, quantity.unit),
                "B": names.write(second, quantity.unit),
                "B against A": f"{100 * change:+.3g} %" if np.isfinite(change) else "",
                "known": f"{known:.1e}",
                "change": change,
                "differs": first != second and not one_missing and not abs(change) <= known,
            }
        )
    return pd.DataFrame(rows)


def field_comparison(a: Outcome, b: Outcome) -> FieldComparison | None:
    """Return B minus A in the fields along the radius, each by its first method that has them.

    Return None if no field is given by both at a common time.
    """
    reports = []
    for side in (a, b):
        giving = (name for field in OVER_TIME for name in side.by_method(field))
        steady = (name for field in IN_STEADY_STATE for name in side.by_method(field))
        method = next(giving, None) or next(steady, None)
        if method is None:
            return None
        reports.append(side.reported(method))
    comparison = compare_fields(a.scene.problem, ("A", "B"), *reports)
    return comparison if comparison.fields else None
