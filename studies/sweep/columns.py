"""Read the columns of a sweep: values of scene keys, each along a dimension of the store.

Values with units are converted to numbers in the units of the base scene.
"""

from collections import Counter
from collections.abc import Callable, Iterable
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ...meshes import Array, SceneError
from ..crosscheck import Scene, TomlTable, shown, without_quantities

# values of one key, of the type that the scene declares for it
Values = list[Any]
DRAW = "draw"
# names in the store that no axis may have
RESERVED = (
    *("solver", "time", "radius", "ring", "mode", "state"),
    *("status", "reason", "disagreement", "code"),
)
# greatest number of values of one axis, because the list of values is held in memory
MOST_VALUES = 10_000_000
SPACED: dict[str, Callable[..., Array]] = {"linspace": np.linspace, "geomspace": np.geomspace}


class Column(NamedTuple):
    """Values of a scene key along a dimension of the store, with the name of their coordinate."""

    name: str
    dim: str
    values: Values


def read_columns(table: TomlTable, base: TomlTable) -> dict[str, Column]:
    """Return the columns of a sweep by scene key.

    Each axis has its own dimension. All columns of [zip] share one dimension, and so do all columns
    of [random].

    Parameters
    ----------
    table : the sweep as nested dictionaries, with [axes], [zip] and [random]
    base : base scene as nested dictionaries; values are converted to its units

    Raises
    ------
    SceneError
        if a key is given twice, or if its values are invalid, too many or have a wrong unit
    """
    axes, zip_columns = table.get("axes", {}), table.get("zip", {})
    random_columns = dict(table.get("random", {}))
    count, seed = random_columns.pop("count", 0), random_columns.pop("seed", None)
    counted = isinstance(count, int) and count > 0
    if random_columns and not (counted and isinstance(seed, int) and seed >= 0):
        raise SceneError(
            f"random.count = {shown(count)} and random.seed = {shown(seed)}: give the number of "
            "draws, and a whole number, 0 or more, as the seed of the random generator"
        )
    sections = {"axes": axes, "zip": zip_columns, "random": random_columns}
    for first, second in combinations(sections, 2):
        for key in sections[first].keys() & sections[second].keys():
            raise SceneError(
                f"{key} is given twice, in [{first}] and in [{second}]: leave one of them out"
            )
    dims_by_key = dict.fromkeys(random_columns, DRAW)
    columns: dict[str, Column] = {}
    # no axis may have the name of a quantity that is kept
    used_names = {*RESERVED, *map(str, table.get("keep") or ())}
    for key, values in (axes | zip_columns | random_columns).items():
        if key == "punch.heights":
            raise SceneError(
                "punch.heights are functions, which cannot be values of an axis: give the heights "
                "by punch.profile = { kind = 'table', ... }"
            )
        *_, name = parts = key.split(".")
        if name in {*used_names, *(column.name for column in columns.values())}:
            name = "_".join(parts[-2:])
        if key in zip_columns:
            # the first column of [zip] names the dimension of all its columns
            dims_by_key |= dict.fromkeys(zip_columns, dims_by_key.get(key, name))
        numbers = read_values(key, values, base, count if key in random_columns else 0, seed)
        columns[key] = Column(name, dims_by_key.get(key, name), numbers)
        if key in axes:
            _refuse_repeats(key, numbers)
    if len({len(columns[key].values) for key in zip_columns}) > 1:
        raise SceneError("columns of [zip] vary together: give all of them one length")
    return columns


def read_values(key: str, source: Any, base: TomlTable, draws: int, seed: int | None) -> Values:
    """Return the values of a column: a list, evenly spaced values, or random draws.

    Parameters
    ----------
    key : scene key of the column
    source : list of values, or a dictionary ``{"linspace": [...]}`` or ``{"geomspace": [...]}``
    base : base scene as nested dictionaries; values are converted to its units
    draws : number of random draws; 0 if the column is not random
    seed : seed of the random generator; None without [random]

    Raises
    ------
    SceneError
        if the values are invalid, too many or have a wrong unit
    """
    generator = np.random.default_rng([seed or 0, *key.encode()])
    try:
        if isinstance(source, list) and source:
            _refuse_too_many(key, draws or len(source))
            values = _in_units(key, source, base)
            drawn_indices = generator.integers(len(values), size=draws)
            return [values[index] for index in drawn_indices] if draws else values
        ((kind, numbers),) = source.items()
        space = SPACED[kind]
        (first, last), count = _in_units(key, numbers[:2], base), [*map(_whole, numbers[2:])]
        _refuse_too_many(key, draws or count[0])
        if draws:
            fractions = generator.uniform(size=draws)
            if kind == "linspace":
                return (first + (last - first) * fractions).tolist()
            return (first * (last / first) ** fractions).tolist()
        spaced = space(first, last, count[0])
        # geomspace of whole numbers yields whole numbers only up to roundoff: round them
        nearly_whole = np.abs(spaced - spaced.round()) <= 1e-12 * np.abs(spaced)
        all_whole = isinstance(first, int) and nearly_whole.all()
        return (spaced.round().astype(int) if all_whole else spaced).tolist()
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        raise SceneError(
            f"{key} = {shown(source)}: give a list of values, or linspace or geomspace = [first, "
            "last, count] in braces, for geomspace with ends other than 0; leave out count for "
            "random draws"
        ) from None


def _whole(count: float) -> int:
    """Return a whole number that may be given as a float, such as 3.0; raise ValueError else."""
    if int(count) != count:
        raise ValueError(count)
    return int(count)


def has_units(columns: Iterable[tuple[str, object]]) -> bool:
    """Return whether any values of the columns (scene key, values) are written with a unit."""
    numbers = (
        (key, next(iter(values.values()), None) if isinstance(values, dict) else values)
        for key, values in columns
    )
    return any("units" in without_quantities(_nest(key, values), Scene) for key, values in numbers)


def _in_units(key: str, values: Values, base: TomlTable) -> Values:
    """Return values of a key as numbers in the units of the base."""
    units = {"units": base["units"]} if "units" in base else {}
    table = without_quantities(units | _nest(key, values), Scene)
    for key_part in key.split("."):
        table = table[key_part]
    return list(table)


def _nest(key: str, value: object) -> TomlTable:
    """Return nested dictionaries with a value at one scene key."""
    *outer, last = key.split(".")
    table: TomlTable = {last: value}
    for key_part in reversed(outer):
        table = {key_part: table}
    return table


def _refuse_too_many(key: str, count: int) -> None:
    if count > MOST_VALUES:
        raise SceneError(
            f"{key} has {shown(count)} values: give at most {MOST_VALUES}, or split the sweep into "
            "several"
        )


def _refuse_repeats(key: str, values: Values) -> None:
    """Raise an error if an axis has a value twice, because scenes are selected by the value."""
    # lists and tables are compared by their text
    comparable = (value if isinstance(value, int | float) else repr(value) for value in values)
    value, count = Counter(comparable).most_common(1)[0]
    if count > 1:
        raise SceneError(f"{key} has {value} twice: give each value of an axis once")
