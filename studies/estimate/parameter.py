"""What may be unknown: a parameter changes the scene, or the way in which a table was read from it.

A mistake in the input of another program is such a parameter, too: its value is not 1 (or 0).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ...meshes import Array
from ..crosscheck import Scene, TomlTable, dotted


class Reading(NamedTuple):
    """How a table was read from a solution: everything that is not part of the scene.

    The table has the value ``factor * (value + offset + compliance * force)`` at its time t and
    radius r, with the value of the solution at ``time_scale * t - start_time`` and ``radius_scale *
    r``. Offset and compliances belong to indentations and displacements only.

    Parameters
    ----------
    start_time : at which sliding began, by the clock of the table
    time_scale, radius_scale : factors from times and radii of the table to those of the scene
    offset : reading of the displacement sensor without indentation
    compliance : displacement of the machine per force, which the sensor also measures
    ground_compliance : displacement per force, equal everywhere, that the half-space has besides
        that of the scene; negative if it is clamped at a distance
    step : length of the program's time steps of first order, implicit if positive, else explicit
    plane_strain : whether the program models a strip in plane strain in place of a round punch
    factors : by quantity, such as -1000 for another sign and unit
    mesh : part of the errors of a linear mesh that the table has (`Model.mesh_errors`)
    """

    start_time: float = 0.0
    time_scale: float = 1.0
    radius_scale: float = 1.0
    offset: float = 0.0
    compliance: float = 0.0
    ground_compliance: float = 0.0
    step: float = 0.0
    plane_strain: bool = False
    factors: Mapping[str, float] = {}
    mesh: float = 0.0

    def times(self, times: Array) -> Array:
        """Return the times of the scene since sliding began, from those of a table."""
        return np.maximum(times * self.time_scale - self.start_time, 0.0)

    def multiplied(self, factor: float, *quantities: str) -> "Reading":
        """Return the reading with the columns of some quantities multiplied."""
        changed = {name: factor * self.factors.get(name, 1.0) for name in quantities}
        return self._replace(factors={**self.factors, **changed})


# how a table is read that says what the solution says
AS_GIVEN = Reading()
Situation: TypeAlias = tuple[Scene, Reading]
Change: TypeAlias = Callable[[Scene, Reading, float], Situation]


@dataclass(frozen=True, eq=False)
class SceneChange:
    """A change of the scene, and not of the reading."""

    change: Callable[[Scene, float], Scene]

    def __call__(self, scene: Scene, reading: Reading, value: float) -> Situation:
        """Return the changed scene, and the reading as it is."""
        return self.change(scene, value), reading


@dataclass(frozen=True, eq=False)
class Parameter:
    """An unknown number, described by a coordinate x.

    Its value is ``value exp(x)`` if it is logarithmic, and ``value + scale x`` if not.

    Parameters
    ----------
    name : such as a key of the scene
    change : returns the scene and the reading with a value of the parameter put in; or the name of
        a field of the reading, or a key of the scene, with the index of a value in brackets if it
        is one of a list
    value : at x = 0: where a search begins
    reach : greatest absolute value of x
    logarithmic : whether it is positive, or negative, and described by its logarithm
    scale : unit of x if it is not logarithmic
    values : the only possible values of a discrete parameter; empty for a continuous one
    starts : further values at which a search may begin
    spacing : change of x over which predictions bend a little, at which nodes of a lattice are put
    unit : kind of its unit
    """

    name: str
    change: Change | str
    value: float = 1.0
    reach: float = float(np.log(1e3))
    logarithmic: bool = True
    scale: float = 1.0
    values: tuple[float, ...] = ()
    starts: tuple[float, ...] = ()
    spacing: float = 0.4
    unit: str = ""

    @property
    def of_scene(self) -> bool:
        """Whether it changes the scene, and not the reading."""
        return isinstance(self.change, str | SceneChange) and self.change not in Reading._fields

    def at(self, x: float) -> float:
        """Return the value at a coordinate."""
        if self.logarithmic:
            return float(self.value * np.exp(x))
        return self.value + self.scale * x

    def coordinate(self, value: float) -> float:
        """Return the coordinate of a value: the inverse of `at`."""
        if self.logarithmic:
            return float(np.log(value / self.value))
        return (value - self.value) / self.scale


def situation(
    scene: Scene,
    parameters: Sequence[Parameter],
    x: Sequence[float] | Array,
    reading: Reading = AS_GIVEN,
) -> Situation:
    """Return the scene and the reading at coordinates (m,) of the parameters.

    All keys and fields are set first, at once; the other changes are made in their order.
    """
    changes = [
        (each.change, each.at(float(coordinate)))
        for each, coordinate in zip(parameters, x, strict=True)
    ]
    named: dict[str, Any] = {key: value for key, value in changes if isinstance(key, str)}
    fields = {key: named.pop(key) for key in Reading._fields if key in named}
    if named:
        scene = with_values(scene, named)
    reading = reading._replace(**fields)
    for change, value in changes:
        if not isinstance(change, str):
            scene, reading = change(scene, reading, value)
    return scene, reading


def with_values(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """Return the scene with the values of keys, some of which may be those of values in lists."""
    changes, table = dict[str, Any](), scene.table()
    for name, value in values.items():
        if name.endswith("]"):
            key, _, index = name[:-1].rpartition("[")
            listed = changes.setdefault(key, list(looked_up(table, key)))
            listed[int(index)] = value
        else:
            changes[name] = value
    return scene.changed(changes)


def looked_up(table: TomlTable, key: str) -> Any:
    """Return the value of a key in nested dictionaries and lists; empty if there is none."""
    value: Any = table
    for part in dotted(key).split("."):
        if isinstance(value, list):
            value = value[int(part)] if part.isdigit() and int(part) < len(value) else {}
        else:
            value = value[part] if isinstance(value, dict) and part in value else {}
    return value
