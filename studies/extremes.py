"""Extremes: where a scene stops being accurate if one of its keys varies over decades.

At each value the scene is run by each method at its own tolerance, and by naive finite elements.
The table has the true error, the stated error and a verdict:

========== =====================================================================================
within      the error is at most the tolerance
degraded    the error is above the tolerance, but at most three times what the method states
unjudged    there is no reference at this value
refused     the scene or the method says why the run is not possible
wrong       the error is above the tolerance and above three times what the method states: a defect
crashed     any other exception: a defect
========== =====================================================================================

A naive solver states nothing; its runs are `within` or `wrong`. Errors are taken at the times at
which the accuracy is promised (`crosscheck/verdict/promise.py`).
"""

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from ..meshes import RingwearError, SceneError
from .crosscheck import Problem, Scene, Solution, Source, allowed_error, method, shown
from .study.accept import accept
from .study.draw import draw, titled, worst
from .study.errors import DEFAULT
from .study.measure import measure
from .study.own import Methods, Quantities, read_methods, read_quantities
from .study.record import SOLVED, Record
from .study.reference import Reference, reference
from .study.study import Study, remarks
from .study.way import Case, Level, Part, Way
from .study.ways.runs import NaiveSizes, as_run, naive_elements

VERDICTS = ("within", "degraded", "unjudged", "refused", "wrong", "crashed")
"""Verdicts from the best to the worst."""
METHODS = ("mdr", "bem", "fem", "naive")
DEFAULT_METHODS = ("mdr", "fem", "naive")
NAIVE = NaiveSizes(cells=20, steps=2000)
"""Sizes that a user of a naive solver might choose, whatever the scene is."""
FINER, FINEST = 0.01, 1e-9
"""Tolerance of the reference over that of the scene, and the finest one."""
STATED_FACTOR = 3.0
"""Greatest ratio of an error to its estimate that still counts as stated."""
VALUES, QUICK_VALUES = 7, 3
"""Numbers of values of each key that is varied by itself."""
SMALL = 1e-4
"""Least width of a ring and earliest time that are tried by themselves, over those of the scene."""


def extremes(
    scene: Source = "five_rings",
    key: str = "",
    values: Sequence[Any] = (),
    *,
    vary: Mapping[str, Sequence[Any]] | str | None = None,
    methods: Methods = None,
    quantities: Quantities = None,
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Vary keys of a scene one after the other, and judge every run against its true error.

    Parameters
    ----------
    scene : a scene, a file, the name of a bundled scene, or nested dictionaries
    key, values : name of a key with dots, such as ``"half_space.poisson_ratio"``, and its values in
        the unit of the scene
    vary : values by the names of keys, in place of these; on the command line
        ``KEY=LOW:HIGH:N``, or ``KEY=geom:LOW:HIGH:N`` over decades. Without any, the study varies
        what the scene has: Poisson's ratio, the wear ratio, the narrowest ring, the earliest time,
        the tolerance and the thickness of the first layer
    methods : names of methods to judge, `naive` among them, and methods of your own
    quantities : names as in results.nc, and functions of a result
    quick : whether to try fewer values
    record : rows so far, and the file that they are written to

    Raises
    ------
    SceneError
        if the scene has no such key, or if an option does not fit the study

    Examples
    --------
    >>> from ringwear.studies.extremes import extremes
    >>> study = extremes("flat_punch", "half_space.poisson_ratio", [0.0, 0.5], methods=["mdr"])
    >>> study.table.groupby("value").verdict.first().tolist()
    ['within', 'within']
    """
    scene = accept("extremes", scene, any_punch=True, radial_wear=True, layered=True)
    names, functions = read_quantities(quantities, DEFAULT)
    named, own = read_methods(methods or DEFAULT_METHODS, METHODS, "extremes")
    record, rtol = record or Record(), scene.accuracy.rtol
    varied = {key: list(values)} if key else values_of_keys(scene, vary, quick)
    entries = [*(method(name) for name in named if name != "naive"), *own]
    ways = [watched(as_run(entry)) for entry in entries]
    if "naive" in named:
        ways.append(naive_elements([NAIVE]))
    wanted = names or (() if functions else DEFAULT)
    runs = [Varied.of(scene, key, value) for key, listed in varied.items() for value in listed]
    by_case = {run.name: run for run in runs}

    def exact(case: Case) -> Reference:
        finer = max(FINER * case.problem.rtol, FINEST)
        try:
            return reference(case, wanted, functions, finer, quick, confirmed=False)
        except RingwearError as failure:
            record.remarks.append(f"{case.name}: no reference: {failure}")
            return Reference({}, lambda _: np.nan)

    for run in runs:
        if run.case is None and not record.earlier(run.name, ways[0].name):
            facts = {"case": run.name, "level": "", "outcome": "refused", "message": run.refusal}
            record.add([facts | {"way": way.name, "method": way.method} for way in ways])
    cases = [run.case for run in runs if run.case]
    measured = measure(cases, ways, wanted, record, functions, exact, only_promised=True)
    table = judged(measured, by_case, rtol)
    levels = verdicts(table)
    return Study(
        "extremes",
        scene,
        table,
        conclusions=(*conclude(levels), *remarks(record, quick)),
        figures=dict(figures_of(scene, table, levels)),
        tables={"verdicts": levels} if len(levels) else {},
    )


@dataclass(frozen=True, eq=False)
class Varied:
    """The scene with one value of a key.

    Parameters
    ----------
    key, value : the key and its value
    position : place of the value on the axis of the figure
    case : what is solved; None if the scene refuses the value
    refusal : why it does
    """

    key: str
    value: Any
    position: float
    case: Case | None
    refusal: str = ""

    @property
    def name(self) -> str:
        """Name of the case in the table."""
        return _name(self.key, self.value)

    @classmethod
    def of(cls, scene: Scene, key: str, value: Any) -> "Varied":
        """Return the scene with one value of a key, or why it cannot have that value."""
        position = float(value) if isinstance(value, int | float) else np.nan
        try:
            case = Case.of(scene.changed({key: value}), _name(key, value), None, position)
            # the radii at which fields are compared follow from the scene, and may refuse it, too
            _ = case.problem.face
        except SceneError as failure:
            if "no key" in str(failure):
                raise
            return cls(key, value, position, None, str(failure))
        return cls(key, value, position, case)


def _name(key: str, value: Any) -> str:
    """Return a value of a key in words."""
    number = f"{value:.9g}" if isinstance(value, int | float) else str(value)
    return f"{key} = {number}"


def values_of_keys(
    scene: Scene, vary: Mapping[str, Sequence[Any]] | str | None, quick: bool
) -> dict[str, list[Any]]:
    """Return the values of each key that is varied.

    Raises
    ------
    SceneError
        if `vary` is not of one of its forms; the message shows them
    """
    if not vary:
        return keys_of_scene(scene, QUICK_VALUES if quick else VALUES)
    if isinstance(vary, Mapping):
        return {str(key): list(values) for key, values in vary.items()}
    texts = [vary] if isinstance(vary, str) else list(vary)
    return dict(map(parse, texts))


def parse(text: str) -> tuple[str, list[float]]:
    """Return key and values of ``KEY=LOW:HIGH:N`` or ``KEY=geom:LOW:HIGH:N``.

    Raises
    ------
    SceneError
        if the text has another form
    """
    found = re.fullmatch(r"([\w.]+)=(geom:)?([^:]+):([^:]+):(\d+)", text.strip())
    try:
        if not found:
            raise ValueError
        key, geometric = found[1], bool(found[2])
        low, high, count = float(found[3]), float(found[4]), int(found[5])
        if count < 1 or (geometric and min(low, high) <= 0):
            raise ValueError
    except ValueError:
        raise SceneError(
            f"--vary {shown(text)}: give KEY=LOW:HIGH:N, such as "
            "half_space.poisson_ratio=0.3:0.4999:7, or KEY=geom:LOW:HIGH:N with positive ends, "
            "such as punch.wear_ratio=geom:1e-8:1e8:9"
        ) from None
    spaced = np.geomspace if geometric else np.linspace
    # whole numbers stay whole, because some keys take no others
    return key, [
        int(value) if value.is_integer() and abs(value) < 1e6 else float(f"{value:.9g}")
        for value in map(float, spaced(low, high, count))
    ]


def keys_of_scene(scene: Scene, count: int) -> dict[str, list[Any]]:
    """Return values of the keys that a scene has, towards its extremes."""
    table, punch = scene.table(), scene.punch
    varied: dict[str, list[Any]] = {}

    def geometric(low: float, high: float) -> list[Any]:
        return [float(f"{value:.6g}") for value in np.geomspace(low, high, count)]

    if scene.problem.ground.layered:
        first = float(table["half_space"]["layers"][0]["thickness"])
        varied["half_space.layers.0.thickness"] = geometric(first / 30, first * 30)
    else:
        distances = np.geomspace(1.0, 1e-6, count - 1)
        ratios = [*(0.5 - 0.5 * distances), 0.5]
        varied["half_space.poisson_ratio"] = [float(f"{ratio:.9g}") for ratio in ratios]
    if len(scene.problem.merged.widths) > 1 and not punch.table:
        varied["punch.wear_ratio"] = geometric(1e-6, 1e6)
        if "rings" in table["punch"]:
            varied["punch.width_ratio"] = geometric(SMALL, 1.0)
    if later := [time for time in scene.wear.times if time > 0]:
        varied["wear.times"] = [
            [time, *(each for each in later if each > time)]
            for time in geometric(SMALL * later[0], later[0])
        ]
    varied["accuracy.rtol"] = geometric(1e-1, 1e-6 if scene.problem.full_contact else 1e-3)
    return varied


def watched(way: Way) -> Way:
    """Return a way whose levels also fail at warnings about numbers, such as overflows."""

    def solve(problem: Problem, level: Level, previous: Solution | None) -> Solution:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            return way.solve(problem, level, previous)

    return replace(way, solve=solve)


def judged(table: pd.DataFrame, runs: Mapping[str, Varied], rtol: float) -> pd.DataFrame:
    """Return the table with key, value and verdict of each row, and the tolerance of its case."""
    of_rows = [runs[name] for name in table["case"]]
    tolerance = np.array(
        [allowed_error(run.case.problem) if run.case else rtol for run in of_rows], dtype=float
    )
    error, estimate = table["error"].abs(), table["estimate"]
    verdict = np.select(
        [
            table["outcome"] != SOLVED,
            error.isna(),
            error <= tolerance,
            error <= STATED_FACTOR * estimate,
        ],
        [table["outcome"], "unjudged", "within", "degraded"],
        "wrong",
    )
    return table.assign(
        tolerance=tolerance,
        key=[run.key for run in of_rows],
        value=[run.value for run in of_rows],
        parameter=[run.position for run in of_rows],
        verdict=verdict,
    )


def verdicts(table: pd.DataFrame) -> pd.DataFrame:
    """Return one row for each run: its worst verdict, and the quantity that decides it."""
    if table.empty:
        return pd.DataFrame()
    rank = table["verdict"].map(VERDICTS.index)
    size = table["error"].abs().fillna(0.0)
    rows = table.assign(rank=rank, decisive=size).sort_values(["rank", "decisive"], kind="stable")
    order = {name: number for number, name in enumerate(dict.fromkeys(table["case"]))}
    last = rows.groupby(["case", "way"], sort=False).tail(1)
    last = last.sort_values("case", key=lambda names: names.map(order), kind="stable")
    columns = ["key", "value", "case", "parameter", "way", "method", "verdict", "quantity", "when"]
    return last[[*columns, "error", "estimate", "tolerance", "seconds", "message"]].reset_index(
        drop=True
    )


def figures_of(
    scene: Scene, table: pd.DataFrame, levels: pd.DataFrame
) -> Iterator[tuple[str, Any]]:
    """Yield the figures: the greatest error of each run, by key; and each quantity of one key."""
    solved = table[(table["outcome"] == SOLVED) & table["error"].notna()]
    if solved.empty:
        return
    drawn = worst(solved, ("case", "way")).drop(columns="verdict")
    drawn = drawn.merge(levels[["case", "way", "verdict"]], on=["case", "way"])
    lost = levels[levels["verdict"].isin(["refused", "crashed"])]
    drawn = pd.concat([drawn, lost.assign(refined="")]) if len(lost) else drawn
    keys = {key: number for number, key in enumerate(dict.fromkeys(table["key"]))}
    placed = drawn.assign(parameter=_places(drawn), number=drawn["key"].map(keys))
    placed = placed.sort_values(["number", "parameter"], kind="stable")
    axis = _label(placed)
    # each of several panels has the label of its own axis as its title
    placed = placed.assign(key=placed["key"].replace(AXES))
    title = titled(scene.title, "greatest error of all quantities over each key")
    yield "extremes", draw(placed, "parameter", ("key",), True, title=title, xlabel=axis)
    if len(keys) == 1:
        rows = solved.assign(parameter=_places(solved)).sort_values("parameter", kind="stable")
        yield (
            "extremes_by_quantity",
            draw(
                rows,
                "parameter",
                ("quantity", "when"),
                estimates=True,
                title=titled(scene.title, *map(str, keys)),
                xlabel=_label(rows),
            ),
        )


def _label(rows: pd.DataFrame) -> str:
    """Return the label of the axis of a parameter."""
    keys = rows["key"].unique()
    return (
        AXES.get(str(keys[0]), str(keys[0]))
        if len(keys) == 1
        else "value, in the unit of the scene"
    )


RATIO, NEAREST = "half_space.poisson_ratio", 1e-7
"""Key of Poisson's ratio, which is drawn as 1 - 2 nu, and the place of 1/2 on this axis."""
AXES = {RATIO: r"$1 - 2 \nu$, with 0 at $10^{-7}$", "wear.times": "earliest time"}
"""Labels of axes by keys; others are labelled with the key."""


def _places(rows: pd.DataFrame) -> list[float]:
    """Return the place of each row on its axis: the value, the first of a list, or the number."""
    numbers_of_values = {
        name: float(number) for number, name in enumerate(dict.fromkeys(map(str, rows["value"])))
    }
    places = list[float]()
    for key, value in zip(rows["key"], rows["value"], strict=True):
        first = value[0] if isinstance(value, list) and value else value
        if key == RATIO and isinstance(first, int | float):
            places.append(max(1 - 2 * float(first), NEAREST))
        elif isinstance(first, int | float) and not isinstance(first, bool):
            places.append(float(first))
        else:
            places.append(numbers_of_values[str(value)])
    return places


def conclude(levels: pd.DataFrame) -> Iterator[str]:
    """Yield the number of runs with each verdict, and where each way fails."""
    if levels.empty:
        return
    for way, rows in levels.groupby("way", sort=False):
        counts = rows["verdict"].value_counts()
        words = ", ".join(f"{counts[name]} {name}" for name in VERDICTS if name in counts)
        yield f"{way}: {len(rows)} runs: {words}."
    for (way, key), rows in levels.groupby(["way", "key"], sort=False):
        failed = rows[~rows["verdict"].isin(["within", "unjudged"])]
        for (verdict, why), same in _reasons(failed).groupby(["verdict", "why"], sort=False):
            values = ", ".join(_short(value) for value in same["value"])
            yield f"{way}, {key} = {values}: {verdict}: {why}."


def _short(value: Any) -> str:
    """Return a value of a key in words: of a list, only the first number."""
    return f"[{value[0]}, ...]" if isinstance(value, list) and len(value) > 1 else str(value)


def _reasons(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows with a column that says why they have their verdict.

    Runs with an error are one group, with the range of their errors.
    """
    why = []
    for row in rows.to_dict("records"):
        if isinstance(row["message"], str) and row["message"]:
            why.append(row["message"].rstrip("."))
            continue
        same = rows[(rows["verdict"] == row["verdict"]) & rows["error"].notna()]
        errors = same["error"].abs()
        ends = dict.fromkeys([errors.min(), errors.max()])
        size = " to ".join(f"{end:.2g}" for end in ends)
        parts = dict.fromkeys(
            str(Part(quantity, when))
            for quantity, when in zip(same["quantity"], same["when"], strict=True)
        )
        stated = same["estimate"].max()
        tail = f", stated up to {stated:.2g}" if np.isfinite(stated) else ""
        why.append(f"errors of {size}{tail} ({'; '.join(parts)})")
    return rows.assign(why=why)
