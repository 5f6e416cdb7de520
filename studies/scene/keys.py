"""Keys of a scene by their names: lists of names, changes, and keys that say the same."""

import copy
from collections.abc import Iterable, Sequence
from typing import TypeVar

from ...meshes.errors import SceneError
from ..problem.fields import TomlTable

Entry = TypeVar("Entry")
# keys of a section that say the same in several ways
ALTERNATIVES = (
    ("punch", ("wear_coefficients",), ("wear_coefficient", "wear_ratio")),
    ("punch", ("rings", "width_ratio"), ("ring_edges",)),
    ("half_space", ("plane_strain_modulus",), ("youngs_modulus",)),
    ("load", ("normal_force",), ("mean_pressure",), ("indentation",)),
)


def listed(names: Sequence[Entry] | str) -> list[Entry | str]:
    """Return names as a list; in a text they may be separated by commas."""
    if not isinstance(names, Iterable):
        raise SceneError(f"{names!r} is no list of names: write ['mdr', 'fem'], for example")
    return [*(names.replace(",", " ").split() if isinstance(names, str) else names)]


def dotted(name: object) -> str:
    """Return the name of a scene key with dots, as files have it: ``punch.rings``."""
    return str(name).replace("__", ".")


def without_alternatives(base: TomlTable, keys: set[str]) -> TomlTable:
    """Return the table of a scene without what some keys give in another way.

    Two materials stay two, whichever way they are given.
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
    """Set a key of nested dictionaries by its path; tables on the way are made."""
    *sections, key = path
    for section in sections:
        if isinstance(table, list):
            # one of a list of tables, by its number
            if not section.isdigit() or int(section) >= len(table):
                raise SceneError(
                    f"{'.'.join(path)}: the scene has no such table; there are {len(table)}, "
                    "numbered from 0 on"
                )
            table = table[int(section)]
        else:
            table = table.setdefault(section, {})
    table[key] = value
