"""The parameters of a fit: keys of a scene, by their logarithms, and unknowns of the rig."""

import re
from collections.abc import Sequence

import numpy as np

from ...meshes import SceneError
from ..crosscheck import (
    THINNEST_LAYER,
    Scene,
    TomlTable,
    UnitNames,
    declaration,
    did_you_mean,
    dotted,
    keys_of,
    kind_of,
    place_of,
)
from ..estimate.parameter import Change, Parameter, SceneChange, looked_up, with_values

# a positive parameter is fitted between its value in the scene divided and multiplied by this; the
# coordinate of another parameter, between minus and plus this
REACH = 1e3
# keys that can be fitted; all other keys change the geometry or the numerics
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
# keys of each layer that can be fitted
LAYER_KEYS = ("thickness", "youngs_modulus")
NUISANCES = {
    # time at which sliding began, by the clock of the data
    "start_time": ("time", "start_time"),
    # reading of the displacement sensor without indentation
    "sensor_offset": ("displacement", "offset"),
    # displacement of the machine under a unit force
    "machine_compliance": ("compliance", "compliance"),
}
"""Unknowns of the rig, each with the kind of its unit and its field in `Reading`."""


def written(parameter: Parameter, value: float, names: UnitNames) -> str:
    """Return a value of a parameter as text, with its unit."""
    if parameter.unit == "compliance":
        unit = "" if names.base is None else f" {names.base[0]}/{names.base[1]}"
        return f"{value:.4g}{unit}"
    return names.write(value, parameter.unit)


def find_parameters(scene: Scene, names: Sequence[str]) -> tuple[Scene, tuple[Parameter, ...]]:
    """Return the scene with the keys of the parameters, and the parameters of these names.

    The key of a list means all of its values. If a wear coefficient of a list is fitted, and the
    scene has `punch.wear_ratio` instead, the scene is returned with a list; and the other way round
    if the ratio is fitted.

    Raises
    ------
    SceneError
        if there is no such parameter, listing the possible ones; or if one is given twice
    """
    of_list = any(name.startswith("punch.wear_coefficients") for name in names)
    if of_list and "punch.wear_ratio" in names:
        raise SceneError(
            "punch.wear_coefficients and punch.wear_ratio describe the same: fit "
            "punch.wear_coefficients, or punch.wear_coefficient and punch.wear_ratio"
        )
    if of_list:
        scene = _with_list(scene)
    if "punch.wear_ratio" in names:
        scene = _with_ratio(scene)
    table, parameters = scene.table(), list[Parameter]()
    # the scene may not mention it
    table["load"].setdefault("sliding_speed", scene.load_.sliding_speed)
    for name in names:
        if name in NUISANCES:
            unit, field = NUISANCES[name]
            parameters.append(Parameter(name, field, 0.0, REACH, logarithmic=False, unit=unit))
            continue
        parameters += [
            Parameter(key, _change_of(key, scene), float(looked_up(table, key)), unit=_kind(key))
            for key in _expanded(table, name)
        ]
    all_names = [each.name for each in parameters]
    repeated = {name for name in all_names if all_names.count(name) > 1}
    if repeated or not parameters:
        fault = f"{min(repeated)} is given twice" if repeated else "no parameter is given"
        raise SceneError(f"{fault}: give each parameter once, such as {_choices(table)}")
    return scene, tuple(parameters)


def _change_of(key: str, scene: Scene) -> Change | str:
    """Return the change of a key: an upper layer is never thinner than a scene can have it."""
    if key != "half_space.layers[0].thickness":
        return key
    least = THINNEST_LAYER * scene.punch.radius
    return SceneChange(lambda scene, value: with_values(scene, {key: max(value, least)}))


def _with_list(scene: Scene) -> Scene:
    """Return the scene with `punch.wear_coefficients` in place of a coefficient and a ratio.

    Raises
    ------
    SceneError
        if the punch has one material and no rings
    """
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


def _with_ratio(scene: Scene) -> Scene:
    """Return the scene with `punch.wear_coefficient` and `wear_ratio` in place of two coefficients.

    Raises
    ------
    SceneError
        if the punch does not have two materials that alternate
    """
    punch = scene.punch
    if punch.wear_ratio is not None:
        return scene
    if punch.wear_coefficients is None or len(punch.wear_coefficients) != 2:
        instead = "wear_coefficient" if punch.wear_coefficients is None else "wear_coefficients"
        raise SceneError(
            "punch.wear_ratio cannot be fitted: the punch of the scene does not have two materials "
            f"that alternate from the centre; fit punch.{instead}"
        )
    first, second = punch.wear_coefficients
    return scene.changed({"punch.wear_coefficient": first, "punch.wear_ratio": second / first})


def _key_and_index(name: str) -> tuple[str, int | None]:
    """Return the key of a parameter, and the index of its value in a list; None without a list."""
    matched = re.fullmatch(r"(.+?)(?:\[(\d+)\])?", name)
    if matched is None:
        return name, None
    return matched[1], None if matched[2] is None else int(matched[2])


def _kind(name: str) -> str:
    return kind_of(dotted(_key_and_index(name)[0]), Scene)


def _expanded(table: TomlTable, name: str) -> list[str]:
    """Return the names of all values that a name means.

    Raises
    ------
    SceneError
        if the name cannot be fitted, or if its index is too large
    """
    if name in _keys_of_layers(table):
        return [name]
    path, index = _key_and_index(name)
    if path in KEYS and isinstance(looked_up(table, path), dict) and looked_up(table, path):
        path = f"{path}.values"
    value = looked_up(table, path)
    can_be_fitted = path.removesuffix(".values") in KEYS and value != {}
    if can_be_fitted and isinstance(value, list):
        numbers = range(len(value)) if index is None else [index]
        if numbers[-1] < len(value):
            return [f"{path}[{number}]" for number in numbers if value[number]]
        raise SceneError(
            f"{name}: {path} has {len(value)} values, counted from 0; give a value for each ring "
            "in the scene to fit each of them"
        )
    if can_be_fitted and index is None:
        return [path]
    raise SceneError(_why_not_fitted(name, table))


def _why_not_fitted(name: str, table: TomlTable) -> str:
    """Return why a name cannot be fitted, and which names can."""
    names = [*_keys_in(table), *NUISANCES]
    *sections, key = _key_and_index(name)[0].split(".")
    section, _ = declaration(sections, Scene)
    if key not in keys_of(section):
        word = place_of(name, Scene, Scene) or name
        hint = did_you_mean(word, names, f"give some of {_choices(table)}", "")
        return f"{name} is no key of a scene{hint}"
    path, index = _key_and_index(name)
    if path in KEYS and index is not None and looked_up(table, path) != {}:
        return f"{name}: {path} is one number in the scene: leave out the index"
    if path in KEYS:
        return (
            f"{name} cannot be fitted, because the scene does not have it: give it in the scene, "
            f"or fit some of {_choices(table)}"
        )
    return (
        f"{name} cannot be fitted, only wear coefficients, moduli, layers, loads and unknowns of "
        "the rig: "
        f"give its value in the scene, and fit some of {_choices(table)}"
    )


def _keys_in(table: TomlTable) -> list[str]:
    """Return the keys that can be fitted, in the form that the scene has or can have."""
    keys = [key for key in KEYS if looked_up(table, key) != {}]
    two_materials = len(looked_up(table, "punch.wear_coefficients")) == 2
    return keys + ["punch.wear_ratio"] * two_materials + _keys_of_layers(table)


def _keys_of_layers(table: TomlTable) -> list[str]:
    layers = range(len(looked_up(table, "half_space.layers")))
    return [f"half_space.layers[{number}].{key}" for number in layers for key in LAYER_KEYS]


def _choices(table: TomlTable) -> str:
    return ", ".join([*_keys_in(table), *NUISANCES])
