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
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from ..meshes import RingwearError, SceneError
from .crosscheck import Problem, Scene, Solution, Source, method, shown
from .study.declared import Declared, conduct
from .study.errors import DEFAULT
from .study.own import Methods, Quantities, accept, read_methods, read_quantities
from .study.record import REFUSED, Record
from .study.reference import Reference, reference
from .study.study import Study
from .study.way import Case, Level, Way
from .study.ways.runs import NaiveSizes, naive_elements, tolerances
from .sweep.columns import read_values

METHODS = ("mdr", "bem", "fem", "naive")
DEFAULT_METHODS = ("mdr", "fem", "naive")
NAIVE = NaiveSizes(cells=20, steps=2000)
"""Sizes that a user of a naive solver might choose, whatever the scene is."""
FINER, QUICK_FINER, FINEST = 0.01, 0.1, 1e-9
"""Tolerance of the reference over that of the scene, also of quick studies, and the finest one."""
VALUES, QUICK_VALUES = 7, 2
"""Numbers of values of each key that is varied by itself."""
SMALL = 1e-4
"""Least width of a ring and earliest time that are tried by themselves, over those of the scene."""
LEAST_WEAR_RATIO = 1e-6
"""Least wear ratio that is tried, and the greatest one is its inverse; in the quick study it is
`SMALL`, because the modes of this one take a third of the time."""
RATIO, NEAREST = "half_space.poisson_ratio", 1e-7
"""Key of Poisson's ratio, which is drawn as 1 - 2 nu, and the place of 1/2 on this axis."""
AXES = {RATIO: r"$1 - 2 \nu$, with 0 at $10^{-7}$", "wear.times": "earliest time"}
"""Labels of axes by keys; others are labelled with the key."""


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
    """Tell where a scene stops being accurate if one of its keys varies over decades.

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
    quick : whether to try fewer values, and to compare with coarser references
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
    scene = accept("extremes", scene, any_punch=True, layered=True)
    names, functions = read_quantities(quantities, DEFAULT)
    named, own = read_methods(methods or DEFAULT_METHODS, METHODS, "extremes")
    record = record or Record()
    varied = {key: list(values)} if key else values_of_keys(scene, vary, quick)
    entries = [*(method(name) for name in named if name != "naive"), *own]
    wanted = names or (() if functions else DEFAULT)

    def ways(case: Case) -> list[Way]:
        listed = [watched(tolerances(entry, [case.problem.rtol])) for entry in entries]
        return [*listed, *([naive_elements([NAIVE])] if "naive" in named else [])]

    def exact(case: Case) -> Reference:
        finer = max((QUICK_FINER if quick else FINER) * case.problem.rtol, FINEST)
        try:
            return reference(case, wanted, functions, finer, quick, confirmed=False)
        except RingwearError as failure:
            record.remarks.append(f"{case.name}: no reference: {failure}")
            return Reference({}, lambda _: np.nan)

    cases = list[Case]()
    for key, listed in varied.items():
        for value in listed:
            try:
                cases.append(case_of(scene, key, value, len(cases)))
            except SceneError as failure:
                if "no key" in str(failure):
                    raise
                facts = {"case": case_name(key, value), "outcome": REFUSED, "message": str(failure)}
                for way in ways(Case.of(scene)):
                    record.add([facts | {"way": way.name, "method": way.method, "level": ""}])
    declared = Declared(
        *("extremes", "where does the scene stop being accurate?", scene, cases, ways, wanted),
        exact=exact,
        axis="key",
        functions=functions,
        worst=True,
        only_promised=True,
        labels=AXES,
    )
    return conduct(declared, record, quick)


def case_of(scene: Scene, key: str, value: Any, number: int) -> Case:
    """Return the scene with one value of a key, and the place of this value on its axis.

    Raises
    ------
    SceneError
        if the scene has no such key, or cannot have that value
    """
    first = value[0] if isinstance(value, list) and value else value
    place = float(number)
    if isinstance(first, int | float) and not isinstance(first, bool):
        place = max(1 - 2 * first, NEAREST) if key == RATIO else float(first)
    case = Case.of(scene.changed({key: value}), case_name(key, value), None, place)
    # the radii at which fields are compared follow from the scene, and may refuse it, too
    _ = case.problem.face
    return case


def case_name(key: str, value: Any) -> str:
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
        return keys_of_scene(scene, quick)
    if isinstance(vary, Mapping):
        return {str(key): list(values) for key, values in vary.items()}
    texts = [vary] if isinstance(vary, str) else list(vary)
    return {
        key: read_values(key, spaced, scene.table(), 0, None) for key, spaced in map(parse, texts)
    }


def parse(text: str) -> tuple[str, dict[str, list[Any]]]:
    """Return key and values of ``KEY=LOW:HIGH:N`` or ``KEY=geom:LOW:HIGH:N``, as in sweeps.

    Raises
    ------
    SceneError
        if the text has another form
    """
    found = re.fullmatch(r"([\w.]+)=(geom:)?([^:]+):([^:]+):([1-9]\d*)", text.strip())
    if not found:
        raise SceneError(
            f"--vary {shown(text)}: give KEY=LOW:HIGH:N, such as "
            "half_space.poisson_ratio=0.3:0.4999:7, or KEY=geom:LOW:HIGH:N with positive ends, "
            "such as punch.wear_ratio=geom:1e-8:1e8:9"
        )
    key, geometric, *ends, count = found.groups()
    return key, {"geomspace" if geometric else "linspace": [*map(_number, ends), int(count)]}


def _number(text: str) -> float | str:
    """Return a number, which stays whole if it is; or a text with a unit as it is."""
    for read in (int, float):
        with suppress(ValueError):
            return read(text)
    return text


def keys_of_scene(scene: Scene, quick: bool) -> dict[str, list[Any]]:
    """Return values of the keys that a scene has, towards its extremes."""
    table, punch, count = scene.table(), scene.punch, QUICK_VALUES if quick else VALUES
    # the quick study does not solve the scene as it is for each key
    others = slice(-1 if quick else None)
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
        least = SMALL if quick else LEAST_WEAR_RATIO
        varied["punch.wear_ratio"] = geometric(least, 1 / least)
        if "rings" in table["punch"]:
            varied["punch.width_ratio"] = geometric(SMALL, 1.0)[others]
    if later := [time for time in scene.wear.times if time > 0]:
        varied["wear.times"] = [
            [time, *(each for each in later if each > time)]
            for time in geometric(SMALL * later[0], later[0])[others]
        ]
    varied["accuracy.rtol"] = geometric(1e-1, 1e-6 if scene.problem.full_contact else 1e-3)
    return varied


def watched(way: Way) -> Way:
    """Return a way whose levels also fail at warnings about numbers, such as overflows."""

    def solve(problem: Problem, level: Level) -> Solution:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            return way.solve(problem, level)

    return replace(way, solve=solve)
