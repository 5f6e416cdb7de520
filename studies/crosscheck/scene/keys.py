"""Handle keys of a scene by their names: lists of names, changes, and alternative keys."""

import re
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

from ....meshes.errors import SceneError
from ..problem.fields import TomlTable
from ..problem.written import TOO_DEEP, plain, shown

Entry = TypeVar("Entry")
# groups of keys of a section that are alternatives to each other
ALTERNATIVES = (
    ("punch", ("wear_coefficients",), ("wear_coefficient", "wear_ratio")),
    ("punch", ("rings", "width_ratio"), ("ring_edges",)),
    ("half_space", ("plane_strain_modulus",), ("youngs_modulus",)),
    ("load", ("normal_force",), ("mean_pressure",), ("indentation",)),
)

# keys that are lists of tables, each with an example
EXAMPLES = {
    "half_space.layers": "[{'thickness': 1.0, 'youngs_modulus': 1.0, 'poisson_ratio': 0.3}]"
}


def listed(names: Sequence[Entry] | str) -> list[Entry | str]:
    """Return names as a list; a text may contain several, separated by commas or spaces.

    Raises
    ------
    SceneError
        if `names` is neither a text nor a sequence
    """
    if not isinstance(names, Iterable):
        raise SceneError(
            f"{shown(names)} is not a list of names: write ['mdr', 'fem'], for example"
        )
    return [*(names.replace(",", " ").split() if isinstance(names, str) else names)]


def numbers(name: str, values: object) -> list[float]:
    """Return the values of an argument as numbers; a single number is a list of one.

    Raises
    ------
    SceneError
        if there is anything else; it names the argument
    """
    plain_values = plain(values)
    entries: list[Any] = [plain_values]
    if isinstance(plain_values, list | tuple):
        entries = list(plain_values)
    try:
        return [float(entry) for entry in entries]
    except (TypeError, ValueError):
        raise SceneError(f"{name} = {shown(values)}: give numbers, such as [0.1, 0.05]") from None


def dotted(name: object) -> str:
    """Return the name of a scene key with dots instead of double underscores: ``punch.rings``.

    An index may be in brackets: ``half_space.layers[0].thickness``.
    """
    return re.sub(r"\[(\d+)\]", r".\1", str(name).replace("__", "."))


def without_alternatives(base: TomlTable, keys: set[str]) -> TomlTable:
    """Return the table of a scene without the alternatives to some keys.

    Two wear coefficients are converted to `wear_coefficient` and `wear_ratio` if one of these keys
    is about to change, so that the scene still has two materials.

    Parameters
    ----------
    base : dict
        Table of the scene.
    keys : set of str
        Keys that are about to change, with dots.
    """
    # only sections lose keys
    table = {key: dict(each) if isinstance(each, dict) else each for key, each in base.items()}
    punch = table.get("punch", {})
    pair = punch.get("wear_coefficients", [])
    if len(pair) == 2 and keys & {"punch.wear_ratio", "punch.wear_coefficient"}:
        punch["wear_coefficient"], punch["wear_ratio"] = pair[0], pair[1] / pair[0]
    for section, *ways in ALTERNATIVES:
        varied = [way for way in ways if keys.intersection(f"{section}.{key}" for key in way)]
        dropped = [key for way in ways if varied and way not in varied for key in way]
        for key in dropped:
            table.get(section, {}).pop(key, None)
    return table


def with_key(table: TomlTable, key: str, value: object) -> TomlTable:
    """Return a copy of the table of a scene with another value of a key with dots.

    Missing tables are created. An index is that of a table in a list of tables, from 0.

    Raises
    ------
    SceneError
        if the key leads into a value that is not a table, or to a table that a list does not have
    """
    try:
        return _with_value(table, key.split("."), 0, value)
    except RecursionError:
        raise SceneError(f"{shown(key)}: {TOO_DEEP}") from None


def _with_value(table: TomlTable, path: list[str], depth: int, value: object) -> TomlTable:
    """Return a copy of a table at some depth of a path, with another value at the path's end."""
    name, *rest = path[depth:]
    if not rest:
        return table | {name: value}
    key, place = ".".join(path), ".".join(path[: depth + 1])
    inner = table.get(name, [] if place in EXAMPLES else {})
    if isinstance(inner, list):
        return table | {name: _with_entry(inner, path, depth + 1, value)}
    if not isinstance(inner, dict):
        raise SceneError(f"{key}: {place} = {shown(inner)} is not a table: give {place} as a whole")
    return table | {name: _with_value(inner, path, depth + 1, value)}


def _with_entry(entries: list[Any], path: list[str], depth: int, value: object) -> list[Any]:
    """Return a copy of a list of tables; the path has an index, and then a key, from a depth on."""
    key, place, (index, *rest) = ".".join(path), ".".join(path[:depth]), path[depth:]
    if place not in EXAMPLES:
        raise SceneError(
            f"{key}: {place} = {shown(entries)} is a list of values, which change only together: "
            f"give {place} as a whole"
        )
    if not entries:
        raise SceneError(
            f"{key}: the scene has no {place} that could be changed: give all of them, {place} = "
            f"{EXAMPLES[place]}"
        )
    if not index.isdigit() or int(index) >= len(entries) or not rest:
        numbers = f"0 to {len(entries) - 1}" if len(entries) > 1 else "0 for the only one"
        raise SceneError(
            f"{key}: give the number of a table of {place}, {numbers}, and one of its keys, such "
            f"as {place}.0.{next(iter(entries[0]))}"
        )
    number = int(index)
    entry = _with_value(entries[number], path, depth + 1, value)
    return [*entries[:number], entry, *entries[number + 1 :]]
