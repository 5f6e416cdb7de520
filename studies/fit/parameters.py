"""What is fitted: keys of a scene, in logarithms, and unknowns of the rig."""

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..problem.fields import TomlTable
from ..problem.unit_names import UnitNames, kind_of
from ..scene.scene import Scene

# a positive parameter is sought between its value in the scene over and times this factor
REACH = 1e3
# keys that a fit can take; others change the geometry or the numerics
KEYS = (
    "punch.wear_coefficient",
    "punch.wear_coefficients",
    "punch.wear_ratio",
    "half_space.youngs_modulus",
    "half_space.plane_strain_modulus",
    "load.normal_force",
    "load.mean_pressure",
    "load.indentation",
    "load.sliding_speed",
)
NUISANCES = {
    "start_time": ("time", "when sliding began, by the clock of the data"),
    "sensor_offset": ("displacement", "what the displacement sensor shows at no indentation"),
    "machine_compliance": ("compliance", "by how much the machine gives under a unit force"),
}
"""Unknowns of the rig: the kind of their unit, and what they are."""
WEAR = "punch.wear_"


@dataclass(frozen=True)
class Parameter:
    """One unknown of a fit.

    It is sought as ``value exp(x)`` if it is logarithmic, and as ``value + scale x`` if not.

    Parameters
    ----------
    name : a key of the scene, with the number of a value in brackets if it is one of a list; or a
        name of `NUISANCES`
    value : in the scene, 0 of a nuisance; in the units of the scene
    scale : of steps of what is not logarithmic
    unit : kind of its unit
    """

    name: str
    value: float
    scale: float
    unit: str

    @property
    def logarithmic(self) -> bool:
        """Whether it is positive, and sought by its logarithm."""
        return self.name not in NUISANCES

    @property
    def reach(self) -> float:
        """How far it is sought from the value in the scene, in x."""
        return float(np.log(REACH)) if self.logarithmic else REACH

    @property
    def wear(self) -> bool:
        """Whether it is a wear coefficient, or a ratio of two."""
        return self.name.startswith(WEAR)

    def at(self, x: float) -> float:
        """Return the value, in the units of the scene, at a coordinate."""
        if self.logarithmic:
            return float(self.value * np.exp(x))
        return self.value + self.scale * x

    def written(self, value: float, names: UnitNames) -> str:
        """Return a value with its unit, for people."""
        if self.unit == "compliance":
            unit = "" if names.base is None else f" {names.base[0]}/{names.base[1]}"
            return f"{value:.4g}{unit}"
        return names.write(value, self.unit)


def find_parameters(scene: Scene, names: Sequence[str]) -> tuple[Scene, tuple[Parameter, ...]]:
    """Return the parameters of these names, and the scene with the keys that they need.

    The key of a list stands for all of its values. A scene that has `punch.wear_ratio` is given a
    list of wear coefficients if one of these is asked for.

    Raises
    ------
    SceneError
        if there is no such parameter, naming those that there are
    """
    if any(name.startswith("punch.wear_coefficients") for name in names):
        scene = _with_list(scene)
    table, found = scene.table(), list[Parameter]()
    for name in names:
        if name in NUISANCES:
            found.append(Parameter(name, 0.0, 1.0, NUISANCES[name][0]))
            continue
        found += [
            Parameter(key, _value(table, key), 1.0, _kind(key)) for key in _expanded(table, name)
        ]
    twice = {each.name for each in found if sum(of.name == each.name for of in found) > 1}
    if twice or not found:
        what = f"{min(twice)} is asked for twice" if twice else "nothing is asked for"
        raise SceneError(f"{what}: give each parameter once, such as {_choices(table)}")
    return scene, tuple(found)


def scene_at(scene: Scene, parameters: Sequence[Parameter], x: Array) -> Scene:
    """Return the scene with its keys at coordinates (m,)."""
    changes = TomlTable()
    table = scene.table()
    for parameter, coordinate in zip(parameters, x, strict=True):
        if parameter.name in NUISANCES:
            continue
        path, index = _parts(parameter.name)
        value = parameter.at(float(coordinate))
        if index is None:
            changes[path] = value
        else:
            values = changes.setdefault(path, list(_lookup(table, path)))
            values[index] = value
    return scene.changed(changes) if changes else scene


def _with_list(scene: Scene) -> Scene:
    punch = scene.punch
    if punch.wear_coefficients is not None or punch.table:
        return scene
    if punch.rings is None and punch.ring_edges is None:
        raise SceneError(
            "punch.wear_coefficients: the punch of the scene has one material; fit "
            "punch.wear_coefficient, or give rings"
        )
    table = scene.table()
    for key in ("wear_coefficient", "wear_ratio"):
        table["punch"].pop(key, None)
    table["punch"]["wear_coefficients"] = list(np.resize(punch.coefficients, 2).tolist())
    return Scene.from_table(table).with_heights(*punch.heights, kinks=punch.kinks)


def _parts(name: str) -> tuple[str, int | None]:
    """Return the key of a parameter, and the number of its value in a list."""
    matched = re.fullmatch(r"([\w.]+)(?:\[(\d+)\])?", name)
    if matched is None:
        return name, None
    return matched[1], None if matched[2] is None else int(matched[2])


def _lookup(table: TomlTable, path: str) -> Any:
    for part in path.split("."):
        table = table[part] if isinstance(table, dict) and part in table else {}
    return table


def _value(table: TomlTable, name: str) -> float:
    path, index = _parts(name)
    found = _lookup(table, path)
    return float(found if index is None else found[index])


def _kind(name: str) -> str:
    return kind_of(_parts(name)[0], Scene)


def _expanded(table: TomlTable, name: str) -> list[str]:
    """Return the names of the values that a name stands for."""
    path, index = _parts(name)
    if path in KEYS and isinstance(_lookup(table, path), dict) and _lookup(table, path):
        path = f"{path}.values"
    value = _lookup(table, path)
    known = path.removesuffix(".values") in KEYS and value != {}
    if known and isinstance(value, list):
        numbers = range(len(value)) if index is None else [index]
        if numbers[-1] < len(value):
            return [f"{path}[{number}]" for number in numbers if value[number]]
        raise SceneError(
            f"{name}: {path} has {len(value)} values, counted from 0; give one for each ring in "
            "the scene to fit each of them"
        )
    if known and index is None:
        return [path]
    choices = [key for key in KEYS if _lookup(table, key) != {}] + list(NUISANCES)
    near = difflib.get_close_matches(name, choices, 1)
    meant = f"did you mean {near[0]}? Else " if near else ""
    raise SceneError(f"{name} cannot be fitted: {meant}give some of {_choices(table)}")


def _choices(table: TomlTable) -> str:
    there = [key for key in KEYS if _lookup(table, key) != {}]
    return ", ".join([*there, *NUISANCES])
