"""The one answer of all studies: how accurate each way is, and what an accuracy costs by it.

The table has a row for each way, and a column for each quantity with its observed order, that of
theory in parentheses, and the error of the finest level. Further columns have the unknowns and the
seconds, or the step or the radius, with which all these quantities are within 1e-2, 1e-4 and 1e-6.
They are interpolated between levels on logarithmic scales. Up to eight sentences follow.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from ...meshes import Array
from ..crosscheck import STABLE
from .errors import EIGENVALUE
from .orders import DIFFERS, KEYS_OF_STUDIES
from .record import SOLVED
from .way import Part

GOALS = (1e-2, 1e-4, 1e-6)
"""Relative errors whose cost is told."""
COSTS = {"step": ("step",), "reach": ("reach",)}
"""What an accuracy costs, by the axis of the study; otherwise unknowns and seconds."""
CHEAPEST = {
    "seconds": "costs least by",
    "step": "allows the longest steps to",
    "reach": "needs the least radius by",
}
"""How a sentence names the cheapest way."""
WORST = "worst quantity"
"""Name of the quantity of a level with the greatest error."""
MOST_NAMED = 4
"""Greatest number of things that a sentence names; it counts the others."""


def worst(table: pd.DataFrame, by: Sequence[str] = ("case", "way", "level")) -> pd.DataFrame:
    """Return one row for each level: that of its quantity with the greatest error.

    Its estimate and the error of its reference are the greatest of all quantities of the level.
    """
    solved = table.dropna(subset=["error"])
    groups = solved.assign(error=solved["error"].abs()).groupby(list(by), sort=False)
    rows = solved.loc[groups["error"].idxmax()]
    return rows.assign(
        error=rows["error"].abs(),
        estimate=groups["estimate"].max().to_numpy(),
        reference=groups["reference"].max().to_numpy(),
        quantity=WORST,
        when="all",
    )


def short(value: float, form: str = ".1e") -> str:
    """Return a number as 1.2e-7, or as 0.031; empty for NaN."""
    if not value or np.isnan(value):
        return "0" if value == 0 else ""
    if form == "g":
        value = float(f"{value:.2g}")
    return f"{value:{form}}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def reached(costs: Array, errors: Array, goal: float) -> float:
    """Return the cost from which on all levels are within a goal; NaN if the finest is not.

    Parameters
    ----------
    costs, errors : (n,) of the levels, from coarse to fine
    goal : relative error
    """
    beyond = np.flatnonzero(~(errors <= goal))
    first = beyond[-1] + 1 if len(beyond) else 0
    if first == len(errors):
        return np.nan
    if not first or not errors[first] or not (costs > 0).all():
        return float(costs[first])
    part = np.log(errors[first - 1] / goal) / np.log(errors[first - 1] / errors[first])
    return float(costs[first - 1] * (costs[first] / costs[first - 1]) ** part)


def costs_of(table: pd.DataFrame, axis: str = "size") -> pd.DataFrame:
    """Return what each way costs to be within each goal in each quantity, and in the worst one.

    It is NaN if the finest level is not within the goal.
    """
    rows, names = list[dict[str, object]](), COSTS.get(axis, ("unknowns", "seconds"))
    errors = table[table["quantity"] != EIGENVALUE].dropna(subset=["error"])
    each = pd.concat([errors, worst(errors)])
    for key, levels in each.groupby(list(KEYS_OF_STUDIES), sort=False):
        sizes = levels["error"].abs().to_numpy()
        ends = {"finest error": sizes[-1], "reference": levels["reference"].max()}
        for goal in GOALS:
            told = {name: reached(levels[name].to_numpy(float), sizes, goal) for name in names}
            key_of = dict(zip(KEYS_OF_STUDIES, key, strict=True))
            rows.append(key_of | {"goal": goal} | told | ends)
    return pd.DataFrame(rows).drop_duplicates()


def answer(measured: pd.DataFrame, fits: pd.DataFrame, costs: pd.DataFrame) -> pd.DataFrame:
    """Return the answer as texts: a row for each way, a column for each quantity and each goal."""
    rows, names = [], [*costs][5:-2]
    orders = {tuple(row[key] for key in KEYS_OF_STUDIES): row for row in fits.to_dict("records")}
    several, solved = measured["case"].nunique() > 1, measured.dropna(subset=["error"])
    parts = solved[["quantity", "when"]].drop_duplicates()
    columns = ["way", *(str(Part(*part)) for part in parts.itertuples(index=False))]
    for (case, way), levels in solved.groupby(["case", "way"], sort=False):
        row = {"way": f"{case}: {way}" if several else way}
        for (quantity, when), each in levels.groupby(["quantity", "when"], sort=False):
            fit = orders.get((case, way, quantity, when), {})
            order, theory = (short(fit.get(name, np.nan), ".2f") for name in ("order", "theory"))
            # of values of a key, the greatest error counts
            error = each["error"].abs().max() if "key" in each else abs(each["error"].iloc[-1])
            words = f"{order} ({theory})" if theory else order
            row[str(Part(quantity, when))] = ", ".join(filter(None, (words, short(error))))
        of_way = costs[(costs["case"] == case) & (costs["way"] == way)] if len(costs) else costs
        for cost in of_way[of_way["quantity"] == WORST].to_dict("records") if len(costs) else ():
            told = [short(cost[name], ".0f" if name == "unknowns" else "g") for name in names]
            head = f"{short(cost['goal'], '.0e')} in all: {', '.join(names)}"
            row[head] = ", ".join(filter(None, told))
        if "verdict" in levels and not len(costs):
            row["within tolerance"] = f"{(levels['verdict'] == 'within').sum()} of {len(levels)}"
        rows.append(row)
    table = pd.DataFrame(rows).fillna("")
    return table[[*columns, *(name for name in table if name not in columns)]]


def listed(parts: Sequence[str]) -> str:
    """Return the first few of some parts in words, and how many others there are."""
    others = len(parts) - MOST_NAMED
    return "; ".join([*parts[:MOST_NAMED], *([f"and {others} more"] if others > 0 else [])])


def conclude(
    table: pd.DataFrame,
    measured: pd.DataFrame,
    fits: pd.DataFrame,
    costs: pd.DataFrame,
    axis: str,
) -> Iterator[str]:
    """Yield what differs from theory, the cheapest way for each goal, and what is not reached."""
    several = measured["case"].nunique() > 1

    def name(row: dict[str, object]) -> str:
        return f"{row['case']}: {row['way']}" if several else str(row["way"])

    judged = fits[fits["theory"].notna() & fits["order"].notna()]
    if len(judged):
        differing = judged[judged["remark"].str.startswith(DIFFERS)]
        off = [
            f"{name(row)}, {Part(row['quantity'], row['when'])}: {row['order']:.2f}, not "
            f"{row['theory']:.3g}"
            for row in differing.to_dict("records")
        ]
        tail = f"; the others are {listed(off)}" if off else ""
        yield f"{len(judged) - len(off)} of {len(judged)} orders agree with theory{tail}."
    by, seen = axis if axis in COSTS else "seconds", set[str]()
    of_all = costs[costs["quantity"] == WORST] if len(costs) else costs
    for goal, rows in of_all.groupby("goal", sort=False) if len(costs) else ():
        told = list[str]()
        for _, ways in rows.dropna(subset=[by]).groupby("case", sort=False):
            best = ways.loc[ways[by].idxmax() if by == "step" else ways[by].idxmin()]
            told.append(f"{name(dict(best))} ({short(best[by], 'g')}{' s' * (by == 'seconds')})")
        words = f"{CHEAPEST[by]} {listed(told)}" if told else "is reached by no way"
        missed = {
            name(row): f"{name(row)} ({short(row['finest error'])})"
            for row in rows[rows[by].isna()].to_dict("records")
        }
        # who misses a greater error misses this one, too
        if new := [text for way, text in missed.items() if way not in seen]:
            words += f"; it is below the error of the finest level of {listed(new)}"
        if (least := rows["reference"].max()) > goal:
            words += f"; the reference itself errs by up to {short(least)}"
        seen |= missed.keys()
        yield f"An error of {short(goal, '.0e')} in all these quantities {words}."
    if (eigenvalues := table[table["quantity"] == EIGENVALUE]["error"]).size:
        stable = "stable" if eigenvalues.min() >= STABLE else "unstable: change the degree"
        yield f"The least eigenvalue of the multipliers is {eigenvalues.min():.2g}: {stable}."
    if "verdict" in table:
        promised = table[(table["verdict"] != "") & (table["outcome"] == SOLVED)]
        counts = promised["verdict"].value_counts()
        words = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
        bad = [
            f"{row['case']}: {row['way']} ({short(row['error'])})"
            for row in worst(promised[promised["verdict"] == "wrong"]).to_dict("records")
        ]
        stated = promised[promised["estimate"].notna()]
        unsafe = (stated["error"].abs() > stated[["estimate", "reference"]].max(axis=1)).sum()
        tail = f"; wrong are {listed(bad)}" if bad else ""
        yield (
            f"Of {len(promised)} errors with a tolerance, {words}; {unsafe} exceed the estimate of "
            f"the method{tail}."
        )
