"""Conclude from the levels of all ways: what an accuracy costs, and where to refine."""

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
import pandas as pd

from ..crosscheck.verdict.operators import STABLE
from ..study.levels import SECONDS
from .case import ERRORS, Case, Level
from .observed_orders import FAMILY_NAMES, sequences
from .own_meshes import WorstPlace, worst_place

GOALS = (1e-2, 1e-3, 1e-5)
"""Relative errors whose cost is reported."""
QUANTITIES_IN_SENTENCES = ("pressure", "history")
"""Quantities whose cost is reported in sentences, the most expensive quantity first."""


def costs(rows: pd.DataFrame) -> pd.DataFrame:
    """Return a table of the unknowns and seconds of the first level that reaches each goal.

    It has one row for each case, way, quantity and goal. Unknowns and seconds are NaN if the way
    does not reach the goal. Every row also gives the least error of the way.
    """
    table_rows = []
    for (case, family), levels in rows.groupby(["case", "family"], sort=False):
        for quantity in ERRORS:
            for goal in GOALS:
                levels_within_goal = levels[levels[quantity] <= goal]
                first_level = levels_within_goal.iloc[0] if len(levels_within_goal) else None
                table_rows.append(
                    {
                        "case": case,
                        "family": family,
                        "quantity": quantity,
                        "goal": goal,
                        "unknowns": np.nan if first_level is None else first_level["unknowns"],
                        SECONDS: np.nan if first_level is None else first_level[SECONDS],
                        "least error": levels[quantity].min(),
                    }
                )
    return pd.DataFrame(table_rows)


def conclude(
    cases: Mapping[str, Case], rows: pd.DataFrame, levels: Iterable[Level]
) -> Iterator[str]:
    """Yield sentences on the user's meshes, the cost of accuracies, and the error indicator.

    Parameters
    ----------
    cases : cases by their names
    rows : rows of the solved levels
    levels : the same levels, with their meshes
    """
    for level in levels:
        if level.family == "file":
            same_setting = (rows["case"] == level.case) & (rows.setting == level.setting)
            row = rows[same_setting & (rows.family == "file")].iloc[0]
            place = worst_place(cases[level.case], level)
            yield _describe_own_mesh(level, row, place, rows[rows["case"] == level.case])

    table = costs(rows)
    for case in rows["case"].unique():
        for quantity in QUANTITIES_IN_SENTENCES:
            quantity_costs = table[(table["case"] == case) & (table.quantity == quantity)]
            for goal, ways in quantity_costs.groupby("goal", sort=False):
                yield _describe_costs(f"{case}: {ERRORS[quantity]} within {goal:g}", ways)
        yield from _describe_indicator(str(case), rows[rows["case"] == case])


def _describe_costs(goal: str, ways: pd.DataFrame) -> str:
    """Return a sentence with the unknowns and seconds of each way that reaches a goal."""
    parts = []
    for row in ways.to_dict("records"):
        name = FAMILY_NAMES[row["family"]]
        if np.isnan(row["unknowns"]):
            least = f"{row['least error']:.1e}"
            parts.append(f"no level of {name} reaches it (least error {least})")
        else:
            parts.append(f"{name} {row['unknowns']:.0f} unknowns and {row[SECONDS]:.2f} s")
    return f"{goal} costs: {'; '.join(parts)}."


def _describe_indicator(case: str, rows: pd.DataFrame) -> Iterator[str]:
    """Yield a sentence on the effectivity of the indicator, and one on the energy errors."""
    adaptive = rows[rows.family == "adaptive"]
    least_ratio = adaptive["least effectivity"].min()
    greatest_ratio = adaptive["greatest effectivity"].max()
    if np.isfinite(least_ratio):
        yield (
            f"{case}: the error indicator is {least_ratio:.1f} to {greatest_ratio:.1f} times the "
            f"true energy error, over {len(adaptive)} adaptive levels and all states."
        )
    for sequence in sequences(adaptive):
        if sequence.quantity == "energy" and np.isfinite(sequence.order):
            degree = int(adaptive["degree"].iloc[0])
            yield (
                f"{case}: the energy error of adaptive triangles of degree {degree} decreases with "
                f"the order {sequence.order:.2f} in N^(-1/2), N the unknowns, over the finer half "
                f"of the levels; the best possible order is {degree}."
            )


def _describe_own_mesh(level: Level, row: pd.Series, place: WorstPlace, rows: pd.DataFrame) -> str:
    """Return sentences with the errors on a mesh of the user, and where to refine it."""
    kind = "triangles" if len(level.mesh.t) == 3 else "quadrilaterals"
    errors = ", ".join(f"{name} {row[column]:.1e}" for column, name in ERRORS.items())
    sentences = [
        f"{level.case}: {level.setting}, {row['elements']} {kind} of degree {level.degree} with "
        f"{row['unknowns']} unknowns, has the errors: {errors}.",
        _describe_multipliers(float(row["least eigenvalue"])),
        f"{place.share:.0%} of the squared error of p(t = {place.time:.3g}) lies next to "
        f"r = {place.edge:.6g} a, {place.share_of_facet:.0%} on the facet from "
        f"{place.facet[0]:.6g} a to {place.facet[1]:.6g} a: refine there.",
    ]
    if level.indicators is not None:
        r, depth = level.mesh.p[:, level.mesh.t[:, level.indicators.argmax()]].mean(axis=1)
        sentences.append(
            f"The error indicator is greatest in the triangle at r = {r:.4g} a and depth "
            f"{depth:.4g} a."
        )
    adaptive = rows[(rows.family == "adaptive") & (rows.pressure <= GOALS[1])]
    if len(adaptive) and row["pressure"] > GOALS[1]:
        sentences.append(
            f"The adaptive mesh whose pressure is within {GOALS[1]:g} has facets down to "
            f"{adaptive.iloc[0]['smallest facet']:.0e} a; the facets of your mesh go down to "
            f"{row['smallest facet']:.0e} a."
        )
    return " ".join(sentences)


def _describe_multipliers(eigenvalue: float) -> str:
    """Return a sentence on the stability of the multipliers of a mesh."""
    if np.isnan(eigenvalue):
        return "The mesh has too many multipliers to compute their least eigenvalue."
    verdict = "they are stable" if eigenvalue >= STABLE else "they are unstable: change the degree"
    return f"The least eigenvalue of the multipliers is {eigenvalue:.2g}: {verdict}."
