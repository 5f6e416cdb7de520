"""The one answer of all studies: how accurate each way is, and what an accuracy costs by it.

The table has a row for each way, and a column for each quantity with its observed order, that of
theory in parentheses, and the error of the finest level. Further columns have the unknowns and the
seconds, or the step or the radius, from which on the worst quantity is within 1e-2, 1e-4 and 1e-6,
and the same for each quantity. They are interpolated between levels on logarithmic scales. A way
that failed has the reason. Up to eight sentences of up to thirty words follow.
"""

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from ...meshes import Array
from .errors import EIGENVALUE, STABLE
from .orders import DIFFERS, sequences
from .record import SOLVED
from .way import KEYS_OF_STUDIES, Part

GOALS = (1e-2, 1e-4, 1e-6)
"""Relative errors whose cost is told."""
COSTS = {"step": ("step",), "reach": ("reach",)}
"""What an accuracy costs, by the axis of the study; otherwise unknowns and seconds."""
CHEAPEST = {"seconds": "the cheapest", "step": "the longest step", "reach": "the least radius"}
"""How a sentence names the least cost."""
WORST = "worst quantity"
"""Name of the quantity of a level with the greatest error."""
MOST_WORDS, MOST_WORDS_OF_PART, MOST_SENTENCES = 30, 18, 8
"""Greatest numbers of words of a sentence and of a thing that it lists, and of sentences."""
MOST_LETTERS = 60
"""Greatest length of a reason in the table."""
EMPTY = pd.DataFrame()
"""The table of orders or costs of a study that has none."""


def worst(table: pd.DataFrame) -> pd.DataFrame:
    """Return one row for each level: that of its quantity with the greatest error.

    Its estimate and the error of its reference are the greatest of all quantities of the level.
    """
    solved = table.dropna(subset=["error"])
    groups = solved.assign(error=solved["error"].abs()).groupby(
        ["case", "way", "level"], sort=False
    )
    rows = solved.loc[groups["error"].idxmax()]
    return rows.assign(
        error=rows["error"].abs(),
        estimate=groups["estimate"].max().to_numpy(),
        reference=groups["reference"].max().to_numpy(),
        of=list(map(str, map(Part, rows["quantity"], rows["when"]))),
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

    It is NaN if the finest level is not within the goal. Of one quantity, there is no worst one.
    """
    rows, names = list[dict[str, object]](), COSTS.get(axis, ("unknowns", "seconds"))
    each = table[table["quantity"] != EIGENVALUE].dropna(subset=["error"])
    parts = each[["quantity", "when"]].drop_duplicates()
    if len(parts) > 1 and WORST not in set(parts["quantity"]):
        each = pd.concat([worst(each), each])
    for key, levels in sequences(each):
        sizes = levels["error"].abs().to_numpy()
        ends = {"finest error": sizes[-1], "reference": levels["reference"].max()}
        ends |= {"of": levels["of"].iloc[-1]} if "of" in levels else {}
        for goal in GOALS:
            told = {name: reached(levels[name].to_numpy(float), sizes, goal) for name in names}
            rows.append(key | {"goal": goal} | told | ends)
    return pd.DataFrame(rows)


def answer(
    measured: pd.DataFrame, fits: pd.DataFrame = EMPTY, costs: pd.DataFrame = EMPTY
) -> pd.DataFrame:
    """Return the answer as texts: a row for each way, a column for each quantity and each cost."""
    rows, names = [], [name for name in ("unknowns", "seconds", "step", "reach") if name in costs]
    parts = dict.fromkeys(map(Part, measured["quantity"], measured["when"]))
    columns = {str(part): "" for part in parts if pd.notna(part.quantity)}
    orders = fits.reindex(columns=[*KEYS_OF_STUDIES, "order", "theory"])
    # without levels or orders, the columns have no types of their own
    types = measured.dtypes[[*KEYS_OF_STUDIES]].to_dict() | {"order": float, "theory": float}
    fitted = measured.merge(orders.astype(types), "left")
    for (case, way), levels in fitted.groupby(["case", "way"], sort=False):
        row = {"case": case, "way": way} | columns
        for part, each in levels.groupby(["quantity", "when"], sort=False):
            last = each.iloc[-1]
            order, theory = short(last["order"], ".2f"), short(last["theory"], ".2g")
            # of values of a key, the greatest error counts
            error = each["error"].abs().max() if "key" in each else abs(last["error"])
            words = f"{order} ({theory})" if theory else order
            row[str(Part(*part))] = ", ".join(filter(None, (words, short(error))))
        for cost in costs.to_dict("records"):
            if (cost["case"], cost["way"]) == (case, way):
                told = [short(cost[name], ".0f" if name == "unknowns" else "g") for name in names]
                head = f"{Part(cost['quantity'], cost['when'])}, {' and '.join(names)}"
                row[f"{head}: {short(cost['goal'], '.0e')}"] = ", ".join(filter(None, told))
        if "verdict" in levels and not len(costs):
            judged = levels[levels["quantity"] == WORST]
            row["within tolerance"] = f"{(judged['verdict'] == 'within').sum()} of {len(judged)}"
        for reason in levels["message"].dropna().head(1):
            row["not solved: because"] = textwrap.shorten(reason, MOST_LETTERS, placeholder=" ...")
        rows.append(row)
    table = pd.DataFrame(rows).fillna("")
    return table.drop(columns="case") if measured["case"].nunique() == 1 else table


def sentence(head: str, parts: Sequence[str] = ()) -> str:
    """Return a sentence of up to `MOST_WORDS` words that lists parts; it counts those left out."""
    words_of_parts = [part.rstrip(".").split(" ") for part in parts]
    texts = [
        " ".join([*words[:MOST_WORDS_OF_PART], *["..."] * (len(words) > MOST_WORDS_OF_PART)])
        for words in words_of_parts
    ]
    for count in range(len(texts), -1, -1):
        left = [f"{len(texts) - count} more"] if count < len(texts) else []
        line = f"{head}{'; '.join(texts[:count] + left)}."
        if len(line.split()) <= MOST_WORDS:
            break
    return line


def conclude(
    table: pd.DataFrame,
    measured: pd.DataFrame,
    fits: pd.DataFrame,
    costs: pd.DataFrame,
    axis: str,
) -> Iterator[str]:
    """Yield what differs from theory, the cheapest way for each goal, and what is not reached."""
    several = measured["case"].nunique() > 1

    def name(row: Mapping[Any, Any]) -> str:
        return f"{row['case']}: {row['way']}" if several else str(row["way"])

    judged = fits[fits["theory"].notna() & fits["order"].notna()]
    if len(judged):
        off = [
            f"{name(row)}, {Part(row['quantity'], row['when'])}: {row['order']:.2f}, not "
            f"{row['theory']:.3g}"
            for row in judged[judged["remark"].str.startswith(DIFFERS)].to_dict("records")
        ]
        tail = "; the others: " if off else ""
        yield sentence(
            f"{len(judged) - len(off)} of {len(judged)} orders agree with theory{tail}", off
        )
    if len(costs):
        yield from conclude_costs(costs, axis, name)
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
        head = f"{len(promised)} errors with a tolerance: {words}; {unsafe} exceed their estimate"
        yield sentence(head + "; wrong: " * bool(bad), bad)


def conclude_costs(
    costs: pd.DataFrame, axis: str, name: Callable[[Mapping[Any, Any]], str]
) -> Iterator[str]:
    """Yield the cheapest way for each goal, which ways do not reach the first, and why."""
    # the first quantity is the worst one, if there are several
    quantity, by = costs["quantity"].iloc[0], axis if axis in COSTS else "seconds"
    of_all = costs[costs["quantity"] == quantity]
    words, missed = quantity.replace("_", " "), pd.DataFrame()
    for goal, rows in of_all.groupby("goal", sort=False):
        told = [
            ways.loc[ways[by].idxmax() if by == "step" else ways[by].idxmin()]
            for _, ways in rows.dropna(subset=[by]).groupby("case", sort=False)
        ]
        best = [f"{name(way)} ({short(way[by], 'g')}{' s' * (by == 'seconds')})" for way in told]
        head = f"{short(float(goal), '.0e')} in the {words}"
        missed = missed if len(missed) else rows[rows[by].isna()]
        if not best:
            yield f"No way is within {head}."
            break
        yield sentence(f"{CHEAPEST[by].capitalize()} within {head}: ", best)
    if len(missed):
        parts = [
            f"{name(row)} ({short(row['finest error'])}{', ' + row['of'] if 'of' in row else ''})"
            for row in missed.to_dict("records")
        ]
        goal = short(missed["goal"].iloc[0], ".0e")
        yield sentence(f"Not within {goal} even on the finest level, which errs by: ", parts)
    if (least := of_all["reference"].max()) > GOALS[-1]:
        yield f"Errors below {short(least)} mean nothing, because the reference errs by up to that."
