"""What the levels of all ways say: the cost of an accuracy in numbers, and where to refine."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
import pandas as pd

from ..crosscheck.operators import STABLE
from ..study.levels import SECONDS
from .case import ERRORS, Case, Level
from .observed_orders import NAMES, sequences
from .own_meshes import WorstPlace, worst_place

GOALS = (1e-2, 1e-3, 1e-5)
"""Relative errors whose cost is told."""
TOLD = ("pressure", "history")
"""Quantities whose cost is told in sentences, that which costs most first."""


def costs(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the unknowns and seconds of the first level of each way that reaches each goal.

    They are NaN for a way that does not reach a goal; the least error of that way is told for all.
    """
    table = []
    for (case, family), levels in rows.groupby(["case", "family"], sort=False):
        for quantity in ERRORS:
            for goal in GOALS:
                reached = levels[levels[quantity] <= goal]
                first = reached.iloc[0] if len(reached) else None
                table.append(
                    {
                        "case": case,
                        "family": family,
                        "quantity": quantity,
                        "goal": goal,
                        "unknowns": np.nan if first is None else first["unknowns"],
                        SECONDS: np.nan if first is None else first[SECONDS],
                        "least error": levels[quantity].min(),
                    }
                )
    return pd.DataFrame(table)


def conclude(
    cases: Mapping[str, Case], rows: pd.DataFrame, levels: Iterable[Level]
) -> Iterator[str]:
    """Yield what to do with the user's meshes, the cost of accuracies, and the indicator's quality.

    Parameters
    ----------
    cases : by their names
    rows : of levels that were solved
    levels : the same, with their meshes
    """
    for level in levels:
        if level.family == "file":
            of_level = (rows["case"] == level.case) & (rows.setting == level.setting)
            row = rows[of_level & (rows.family == "file")].iloc[0]
            place = worst_place(cases[level.case], level)
            yield _tell_own_mesh(level, row, place, rows[rows["case"] == level.case])

    reached = costs(rows)
    for case in rows["case"].unique():
        for quantity in TOLD:
            of_quantity = reached[(reached["case"] == case) & (reached.quantity == quantity)]
            for goal, ways in of_quantity.groupby("goal", sort=False):
                yield _tell_costs(f"{case}: {ERRORS[quantity]} within {goal:g}", ways)
        yield from _tell_indicator(str(case), rows[rows["case"] == case])


def _tell_costs(what: str, ways: pd.DataFrame) -> str:
    """Return a sentence with the unknowns and seconds of each way for one accuracy."""
    told = []
    for row in ways.to_dict("records"):
        name = NAMES[row["family"]]
        if np.isnan(row["unknowns"]):
            least = f"{row['least error']:.1e}"
            told.append(f"no level of {name} reaches it (least error {least})")
        else:
            told.append(f"{name} {row['unknowns']:.0f} unknowns and {row[SECONDS]:.2f} s")
    return f"{what} costs: {'; '.join(told)}."


def _tell_indicator(case: str, rows: pd.DataFrame) -> Iterator[str]:
    """Yield a sentence on the effectivity, and one on the order of the energy error."""
    adaptive = rows[rows.family == "adaptive"]
    least, greatest = adaptive["least effectivity"].min(), adaptive["greatest effectivity"].max()
    if np.isfinite(least):
        yield (
            f"{case}: the error indicator is {least:.1f} to {greatest:.1f} times the true energy "
            f"error, over {len(adaptive)} adaptive levels and all states."
        )
    for sequence in sequences(adaptive):
        if sequence.quantity == "energy" and np.isfinite(sequence.order):
            degree = int(adaptive["degree"].iloc[0])
            yield (
                f"{case}: the energy error of adaptive triangles of degree {degree} falls with the "
                f"order {sequence.order:.2f} in N^(-1/2), N the unknowns, over the finer half of "
                f"the levels; the best order is {degree}."
            )


def _tell_own_mesh(level: Level, row: pd.Series, place: WorstPlace, rows: pd.DataFrame) -> str:
    """Return the errors on a mesh of the user's, and where to refine it."""
    kind = "triangles" if len(level.mesh.t) == 3 else "quadrilaterals"
    errors = ", ".join(f"{what} {row[column]:.1e}" for column, what in ERRORS.items())
    told = [
        f"{level.case}: {level.setting}, {row['elements']} {kind} of degree {level.degree} with "
        f"{row['unknowns']} unknowns, errs by: {errors}.",
        _tell_multipliers(float(row["least eigenvalue"])),
        f"{place.share:.0%} of the squared error of p(t = {place.time:.3g}) lies next to "
        f"r = {place.edge:.6g} a, {place.share_of_facet:.0%} on the facet from "
        f"{place.facet[0]:.6g} a to {place.facet[1]:.6g} a: refine there.",
    ]
    if level.indicators is not None:
        r, depth = level.mesh.p[:, level.mesh.t[:, level.indicators.argmax()]].mean(axis=1)
        told.append(
            f"The error indicator is greatest in the triangle at r = {r:.4g} a and depth "
            f"{depth:.4g} a."
        )
    adaptive = rows[(rows.family == "adaptive") & (rows.pressure <= GOALS[1])]
    if len(adaptive) and row["pressure"] > GOALS[1]:
        told.append(
            f"The adaptive mesh whose pressure is within {GOALS[1]:g} has facets down to "
            f"{adaptive.iloc[0]['smallest facet']:.0e} a; yours go down to "
            f"{row['smallest facet']:.0e} a."
        )
    return " ".join(told)


def _tell_multipliers(eigenvalue: float) -> str:
    if np.isnan(eigenvalue):
        return "It has too many multipliers to compute their least eigenvalue."
    verdict = "they are stable" if eigenvalue >= STABLE else "they are unstable: change the degree"
    return f"The least eigenvalue of its multipliers is {eigenvalue:.2g}: {verdict}."
