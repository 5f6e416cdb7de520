"""Handle keys of a scene by their names: lists of names, changes, and alternative keys."""

import copy
from collections.abc import Iterable, Sequence
from typing import TypeVar

from ...meshes.errors import SceneError
from ..problem.fields import TomlTable

Entry = TypeVar("Entry")
# groups of keys of a section that are alternatives to each other
ALTERNATIVES = (
    ("punch", ("wear_coefficients",), ("wear_coefficient", "wear_ratio")),
    ("punch", ("rings", "width_ratio"), ("ring_edges",)),
    ("half_space", ("plane_strain_modulus",), ("youngs_modulus",)),
    ("load", ("normal_force",), ("mean_pressure",), ("indentation",)),
)


def listed(names: Sequence[Entry] | str) -> list[Entry | str]:
    """Return names as a list; a text may contain several, separated by commas or spaces.

    Raises
    ------
    SceneError
        if `names` is neither a text nor a sequence
    """
    if not isinstance(names, Iterable):
        raise SceneError(f"{names!r} is not a list of names: write ['mdr', 'fem'], for example")
    return [*(names.replace(",", " ").split() if isinstance(names, str) else names)]


def dotted(name: object) -> str:
    """Return the name of a scene key with dots instead of double underscores: ``punch.rings``."""
    return str(name).replace("__", ".")


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
    table = copy.deepcopy(base)
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


def set_key(table: TomlTable, path: Sequence[str], value: object) -> None:
    """Set a key of nested dictionaries by its path, and create missing tables.

    Raises
    ------
    SceneError
        if the path contains an index that a list of tables does not have
    """
    *sections, key = path
    for section in sections:
        if isinstance(table, list):
            # a table in a list of tables, given by its index
            if not section.isdigit() or int(section) >= len(table):
                raise SceneError(
                    f"{'.'.join(path)}: the scene has no such table; there are {len(table)}, "
                    "numbered from 0"
                )
            table = table[int(section)]
        else:
            table = table.setdefault(section, {})
    table[key] = value
