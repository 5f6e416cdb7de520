"""A study is a declaration; what follows from it is the same for all studies.

A declaration says what is asked, what is solved (cases), how (ways, with their theory), what is
measured (quantities), and over which axis errors are drawn. `conduct` measures it and returns the
one answer, the one figure and the sentences of every study.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from ..crosscheck import Scene
from .answer import MOST_SENTENCES, WORST, answer, conclude, costs_of, worst
from .draw import figures_of, titled
from .measure import measure
from .orders import DIFFERS, ORDER_TOLERANCE, fit, sequences
from .own import Named
from .record import SOLVED, Record
from .reference import Reference
from .study import Study, remarks
from .way import KEYS_OF_STUDIES, START, Case, Part, Way

SHOWN = (
    *(("indentation", "start"), ("indentation", "later"), ("normal_force", "later")),
    *(("pressure", "later"), ("steady_rms_slope", "all"), ("contact_radius", "later")),
    ("least_eigenvalue", "all"),
)
"""Quantities of the answer, with their values of `when`, if the user names none."""
FIGURE_AXES = {
    "size": ("size", "seconds"),
    "unknowns": ("unknowns", "seconds"),
    "key": ("parameter",),
}
"""Columns of the abscissas of the figure, where they are not the axis alone."""
COLUMNS_OF_ORDERS = (
    *(*KEYS_OF_STUDIES, "order", "low", "high", "theory", "asymptotic", "limit", "index"),
    *("finest error", "remark"),
)
"""Columns of the table of observed orders: keys, numbers, and one column of words."""
STATED_FACTOR = 3.0
"""Greatest ratio of an error to its estimate that still counts as stated."""


@dataclass(frozen=True, eq=False)
class Declared:
    """A study, declared.

    Parameters
    ----------
    name : name of the study, as on the command line
    question : what it asks, in one sentence
    scene : scene of the user
    cases : what is solved
    ways : function of a case that returns how it is solved, with the theory of each way
    quantities : names as in results.nc, and those of finite elements
    exact : function of a case that returns its reference, such as `reference`
    axis : abscissa of the figure, and what an accuracy costs: `size`, `unknowns`, `seconds`,
        `step` (time), `reach` (radius of a mesh) or `key` (a key of the scene that is varied)
    shown : names of the quantities in the answer and the figure; empty for `SHOWN`
    functions : functions of a result that the user defines
    worst : whether the figure has the worst quantity of each case, and the answer has it, too
    labels : labels of the axis, if it is not that of the ways, and of keys
    runs, only_promised : as in `measure`
    remarks : further sentences
    """

    name: str
    question: str
    scene: Scene
    cases: Sequence[Case]
    ways: Callable[[Case], Sequence[Way]]
    quantities: Sequence[str]
    exact: Callable[[Case], Reference]
    axis: str = "size"
    shown: Sequence[str] = ()
    functions: Named = field(default_factory=dict)
    worst: bool = False
    labels: Mapping[str, str] = field(default_factory=dict)
    runs: int = 1
    only_promised: bool = False
    remarks: Sequence[str] = ()


def conduct(declared: Declared, record: Record | None = None, quick: bool = False) -> Study:
    """Measure what is declared, and return the answer, the figure and the conclusions.

    Raises
    ------
    RingwearError
        if the reference of a case cannot be computed
    """
    record, axis, names = record or Record(), declared.axis, declared.quantities
    functions = declared.functions

    ways = {case.name: list(declared.ways(case)) for case in declared.cases}
    table = measure(
        declared.cases,
        lambda case: ways[case.name],
        names,
        record,
        functions,
        exact=declared.exact,
        runs=declared.runs,
        only_promised=declared.only_promised,
    )
    if axis == "step":
        # steps begin at an exact start
        table = table[table["when"] != START]
        table = table.assign(step=table["size"] * declared.scene.problem.units.time)
    elif axis == "reach":
        table = table.assign(reach=1 / table["size"])
    elif axis == "key":
        # ways that promise nothing are judged by the tolerance of the others
        promised = table.groupby("case")["tolerance"].transform("max")
        named = [str(name).rpartition(" = ") for name in table["case"]]
        table = table.assign(
            tolerance=table["tolerance"].fillna(promised),
            key=[key for key, _, _ in named],
            value=[value for _, _, value in named],
        )
    table = table.assign(verdict=verdicts(table)) if table["tolerance"].notna().any() else table
    failed, measured = table[table["quantity"].isna()], shown(table, declared.shown, functions)
    # worst quantities are first
    measured = pd.concat([worst(table), measured]) if declared.worst else measured
    measured = pd.concat([measured, failed]) if len(failed) else measured
    if axis == "key":
        measured = measured.assign(case=measured["key"], level=measured["value"])
    fits = observed_orders(measured if declared.worst else table, ways)
    costs = costs_of(measured, axis) if axis != "key" else pd.DataFrame()
    figures = figures_of(
        declared.name,
        measured[measured["quantity"].isin([WORST, np.nan])] if declared.worst else measured,
        FIGURE_AXES.get(axis, (axis,)),
        titled(declared.scene.title, declared.question),
        orders=fits,
        labels=declared.labels,
    )
    last = [*declared.remarks, *remarks(record, quick)]
    first = list(conclude(table, measured, fits, costs, axis))[: MOST_SENTENCES - len(last)]
    sentences = (*first, *last)
    tables = {"costs": costs} if len(costs) else {}
    return Study(
        *(declared.name, declared.scene, table, fits, sentences, figures, tables),
        *(declared.question, measured, answer(measured, fits, costs)),
    )


def shown(table: pd.DataFrame, names: Collection[str], functions: Collection[str]) -> pd.DataFrame:
    """Return the rows of the answer: of functions, and of named quantities or else of `SHOWN`."""
    chosen = [
        part.quantity in (*names, *functions) or (not names and part in SHOWN)
        for part in map(Part, table["quantity"], table["when"])
    ]
    rows = table[np.array(chosen, dtype=bool)] if any(chosen) else table.dropna(subset="quantity")
    own = rows["quantity"].isin([*functions])
    return pd.concat([rows[own], rows[~own]])


def verdicts(table: pd.DataFrame) -> np.ndarray:
    """Return the verdict on each row: whether its error keeps its tolerance, or is stated."""
    error = table["error"].abs()
    return np.select(
        [
            table["outcome"] != SOLVED,
            table["tolerance"].isna(),
            error.isna(),
            error <= table["tolerance"],
            error <= STATED_FACTOR * table["estimate"],
        ],
        [table["outcome"], "", "unjudged", "within", "degraded"],
        "wrong",
    )


def observed_orders(table: pd.DataFrame, ways: Mapping[str, Sequence[Way]]) -> pd.DataFrame:
    """Return one row for each quantity of each way: its observed and its theoretical order.

    The order is the slope of log error over log size, by least squares over the levels whose error
    is above the floor: that of the theory, or the error of the reference. Of a sequential way, such
    as adaptive refinement, only the finer half counts: the coarser levels do not yet resolve the
    singularities. An order differs from theory if it does by least squares, or between the last two
    levels.

    Parameters
    ----------
    table : table of `measure`
    ways : the ways of each case by its name, with their theory
    """
    listed = {(case, way.name): way for case, each in ways.items() for way in each}
    rows = []
    for key, levels in sequences(table[table["size"] > 0]):
        way = listed.get((key["case"], key["way"]))
        if way is None or way.largest < levels["size"].min():
            continue
        levels = levels.iloc[len(levels) // 2 :] if way.sequential else levels
        levels = levels[levels["size"] <= way.largest]
        if len(levels) < 2:
            continue
        theory = way.theory_of(Part(key["quantity"], key["when"]))
        fitted = fit(levels, floor=theory.floor)
        off = np.abs(np.array([fitted["order"], fitted.pop("last order")]) - theory.order)
        remarks = [theory.reason]
        if np.isnan(fitted["order"]):
            cause = theory.floor_cause or "the error of the reference"
            remarks.insert(0, f"too few levels above {cause}.")
        elif (off > ORDER_TOLERANCE).any():
            remarks.insert(0, f"{DIFFERS}.")
        remark = " ".join(filter(None, remarks))
        rows.append(key | fitted | {"theory": theory.order, "remark": remark})
    return pd.DataFrame(rows, columns=list(COLUMNS_OF_ORDERS))
