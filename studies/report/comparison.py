"""Compare two results: the keys of their scenes, the numbers of the answer, and the fields."""

import numpy as np
import pandas as pd

from ...meshes import SceneError
from ..crosscheck import (
    ANSWER,
    IN_STEADY_STATE,
    OVER_TIME,
    QUANTITIES,
    FieldComparison,
    Result,
    Scene,
    compare_fields,
    error_name,
)

# relative difference up to which numbers count as equal
ROUNDOFF = 1e-12


def refuse_other_units(a: Scene, b: Scene) -> None:
    """Raise a SceneError if the units of two scenes differ."""
    if a.unit_names.base != b.unit_names.base:
        raise SceneError(
            f"units = {a.units!r} and {b.units!r} differ: compare scenes in the same units"
        )


def scene_rows(a: Result, b: Result) -> pd.DataFrame:
    """Return the scene keys whose values differ, with both values."""
    tables = [pd.json_normalize(side.scene.table()).iloc[0].astype(str) for side in (a, b)]
    table = pd.concat(tables, axis=1, keys=["A", "B"]).fillna("not given")
    return table[table.A != table.B].rename_axis("key").reset_index()


def answer_rows(a: Result, b: Result) -> pd.DataFrame:
    """Return a row for each number of the answer: both values and their relative difference.

    Further columns are `known`, the sum of both relative error estimates, `change`, the relative
    difference as a number, and `differs`, whether `change` is larger than `known`.
    """
    names, rows = a.scene.unit_names, []
    for name, quantity in (ANSWER | QUANTITIES).items():
        if quantity.dims:
            continue
        first, second = float(a.first(name)), float(b.first(name))
        if np.isnan([first, second]).all():
            continue
        change = second / first - 1 if first else np.nan
        estimates = [float(np.nan_to_num(side.first(error_name(name)))) for side in (a, b)]
        uncertainty = max(sum(estimates), ROUNDOFF)
        one_missing = bool(np.isnan([first, second]).any())
        written = names.write_together([first, second], quantity.unit)
        rows.append(
            {
                "quantity": name,
                "A": written[0],
                "B": written[1],
                "B against A": f"{100 * change:+.3g} %" if np.isfinite(change) else "",
                "known": f"{uncertainty:.1e}",
                "change": change,
                "differs": first != second and not one_missing and not abs(change) <= uncertainty,
            }
        )
    return pd.DataFrame(rows)


def field_comparison(a: Result, b: Result) -> FieldComparison | None:
    """Return B minus A in the fields along the radius, by the first method with fields of each.

    Return None if A and B have no field at a common time.
    """
    reports = []
    for side in (a, b):
        methods = (name for field in OVER_TIME for name in side.by_method(field))
        steady_methods = (name for field in IN_STEADY_STATE for name in side.by_method(field))
        method = next(methods, None) or next(steady_methods, None)
        if method is None:
            return None
        reports.append(side.reported(method))
    comparison = compare_fields(a.scene.problem, ("A", "B"), *reports)
    return comparison if comparison.fields else None
