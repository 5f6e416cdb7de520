"""What varies in a sweep: values of scene keys, each along a dimension of the store.

Values are numbers in the units of the base, whatever units they are written in.
"""

from collections import Counter
from collections.abc import Callable, Iterable
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..problem.fields import TomlTable
from ..problem.unit_names import without_quantities
from ..scene.explain import shown
from ..scene.scene import Scene

# values of one key, of whatever kind the scene declares
Values = list[Any]
DRAW = "draw"
# labels of the store that no axis may have for its name
RESERVED = (
    *("solver", "time", "radius", "ring", "mode", "state"),
    *("status", "reason", "disagreement", "code"),
)
# values of one axis; a list of them is kept in memory
MOST_VALUES = 10_000_000
SPACED: dict[str, Callable[..., Array]] = {"linspace": np.linspace, "geomspace": np.geomspace}


class Column(NamedTuple):
    """Values of a scene key, under the name of its coordinate, along a dimension of the store."""

    name: str
    dim: str
    values: Values


def read_columns(table: TomlTable, base: TomlTable) -> dict[str, Column]:
    """Return by scene key what varies: each of the axes along a dimension of its own.

    Parameters
    ----------
    table : the sweep, with [axes], [zip] and [random]
    base : its scene, whose units values are converted to

    Raises
    ------
    SceneError
        if a key is given twice, or its values are not understood, too many or not of its unit
    """
    crossed, zipped = table.get("axes", {}), table.get("zip", {})
    draws = dict(table.get("random", {}))
    count, seed = draws.pop("count", 0), draws.pop("seed", None)
    if draws and not (isinstance(count, int) and count > 0 and isinstance(seed, int)):
        raise SceneError(
            f"random.count = {count} and random.seed = {seed}: give how many, and a whole number "
            "that the draws begin from"
        )
    given = {"axes": crossed, "zip": zipped, "random": draws}
    for first, second in combinations(given, 2):
        for key in given[first].keys() & given[second].keys():
            raise SceneError(
                f"{key} is given twice, in [{first}] and in [{second}]: leave one of them out"
            )
    dims = dict.fromkeys(draws, DRAW)
    columns: dict[str, Column] = {}
    # a quantity that is kept has its name for itself
    taken = {*RESERVED, *map(str, table.get("keep") or ())}
    for key, values in (crossed | zipped | draws).items():
        if key == "punch.heights":
            raise SceneError(
                "punch.heights are functions, which no axis can hold: give the heights by "
                "punch.profile = { kind = 'table', ... }"
            )
        *_, name = parts = key.split(".")
        if name in {*taken, *(column.name for column in columns.values())}:
            name = "_".join(parts[-2:])
        if key in zipped:
            # the first of them names the dimension of all
            dims |= dict.fromkeys(zipped, dims.get(key, name))
        numbers = read_values(key, values, base, count if key in draws else 0, seed)
        columns[key] = Column(name, dims.get(key, name), numbers)
        if key in crossed:
            _refuse_repeats(key, numbers)
    if len({len(columns[key].values) for key in zipped}) > 1:
        raise SceneError("columns of [zip] go together: give them one length")
    return columns


def read_values(key: str, given: Any, base: TomlTable, draws: int, seed: int | None) -> Values:
    """Return the values of an axis: a list, evenly spaced, or so many random draws."""
    generator = np.random.default_rng([seed or 0, *key.encode()])
    try:
        if isinstance(given, list) and given:
            _refuse_too_many(key, draws or len(given))
            values = _in_units(key, given, base)
            drawn = generator.integers(len(values), size=draws)
            return [values[place] for place in drawn] if draws else values
        ((kind, numbers),) = given.items()
        space = SPACED[kind]
        (first, last), count = _in_units(key, numbers[:2], base), numbers[2:]
        _refuse_too_many(key, draws or count[0])
        if draws:
            part = generator.uniform(size=draws)
            if kind == "linspace":
                return (first + (last - first) * part).tolist()
            return (first * (last / first) ** part).tolist()
        spaced = space(first, last, count[0])
        # whole numbers stay whole, although powers are computed with roundoff
        near = np.abs(spaced - spaced.round()) <= 1e-12 * np.abs(spaced)
        whole = isinstance(first, int) and near.all()
        return (spaced.round().astype(int) if whole else spaced).tolist()
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        raise SceneError(
            f"{key} = {shown(given)}: give a list of values, or linspace or geomspace = [first, "
            "last, count] in braces, without count to draw from"
        ) from None


def has_units(columns: Iterable[tuple[str, object]]) -> bool:
    """Return whether any values of scene keys are written with a unit."""
    numbers = (
        (key, next(iter(of.values()), None) if isinstance(of, dict) else of) for key, of in columns
    )
    return any("units" in without_quantities(_nest(key, of), Scene) for key, of in numbers)


def _in_units(key: str, values: Values, base: TomlTable) -> Values:
    """Return values of a key as numbers in the units of the base."""
    stated = {"units": base["units"]} if "units" in base else {}
    table = without_quantities(stated | _nest(key, values), Scene)
    for part in key.split("."):
        table = table[part]
    return list(table)


def _nest(key: str, value: object) -> TomlTable:
    """Return the table of a scene that has one key."""
    *outer, last = key.split(".")
    table: TomlTable = {last: value}
    for part in reversed(outer):
        table = {part: table}
    return table


def _refuse_too_many(key: str, count: int) -> None:
    if count > MOST_VALUES:
        raise SceneError(
            f"{key} has {count} values: give at most {MOST_VALUES}, or cut the sweep into several"
        )


def _refuse_repeats(key: str, values: Values) -> None:
    """Refuse an axis that has a value twice: neither could be selected by it."""
    # lists and tables by what they look like
    alike = (value if isinstance(value, int | float) else repr(value) for value in values)
    value, count = Counter(alike).most_common(1)[0]
    if count > 1:
        raise SceneError(f"{key} has {value} twice: give each value of an axis once")
