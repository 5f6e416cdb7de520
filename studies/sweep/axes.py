"""A sweep file.

A base scene, the quantities to keep, and axes of scene keys. Each scene is one point of a labelled
grid.

    base = "five_rings"                                     # a bundled scene, a file, or a table
    [base] keep = ["steady_rms_slope", "relaxation_time"]          # default: every quantity without
    radius and ring [axes]                                                  # crossed, each with
    every other "punch.rings" = [2, 4, 8] "punch.wear_ratio" = { geomspace = [1e-4, 1e4, 81] }    #
    or linspace [zip]                                                   # columns that go together:
    one dimension [random]                                                # draws: one dimension
    `draw` count = 1000 seed = 1 "punch.width_ratio" = { geomspace = [0.1, 10.0] }       #
    log-uniform; linspace uniform; a list is drawn from

A dimension is named as the last part of its key, or by its last two where that name is taken.
"""

import copy
import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import prod
from pathlib import Path
from typing import Any, Self

import numpy as np

from ...meshes.errors import SceneError
from ..problem.scene import Scene, bundled, declaration
from .kept import JUDGED, checked_keep

DRAW = "draw"
RESERVED = {
    "solver",
    "time",
    "radius",
    "ring",
    "mode",
    "state",
    "status",
    "reason",
    "checksum",
    *JUDGED,
}
SPACINGS: dict[str, Any] = {"linspace": np.linspace, "geomspace": np.geomspace}
# a scale to draw uniformly on, and the way back
DRAWN: dict[str, Any] = {"linspace": (float, float), "geomspace": (np.log, np.exp)}
# keys that say the same thing in other ways: what an axis gives takes the place of what the base
# gives
INSTEAD = (
    ({"punch.wear_coefficients"}, {"punch.wear_coefficient", "punch.wear_ratio"}),
    ({"punch.rings", "punch.width_ratio"}, {"punch.ring_edges"}),
    ({"half_space.plane_strain_modulus"}, {"half_space.youngs_modulus"}),
    ({"load.normal_force"}, {"load.mean_pressure"}),
)
# values of each axis that are tried before a sweep begins; others that are bad fail as scenes, with
# the reason
TRIED = 200

Table = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Axis:
    """One dimension: its name, and the values of one or several scene keys along it."""

    dim: str
    columns: Mapping[str, list[Any]]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))


@dataclass(frozen=True, eq=False)
class Sweep:
    """Scenes over a labelled grid.

    Parameters
    ----------
    table : the sweep as nested dictionaries, its base a table: enough to make it again
    axes : the dimensions
    keep : names of the quantities to keep
    name : for messages

    Raises
    ------
    SceneError
        from `load` and `of`, naming the key, the value and the remedy
    """

    table: Table
    axes: tuple[Axis, ...]
    keep: tuple[str, ...]
    name: str = "sweep"

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a sweep file, or a bundled one by its name."""
        from .bundled import sweep_text

        text = sweep_text(path)
        try:
            table = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise SceneError(f"{path} is not TOML: {error}") from error
        return cls.of(table, str(path), Path(path).parent)

    @classmethod
    def of(cls, table: Table, name: str = "sweep", beside: Path | None = None) -> Self:
        """A sweep from nested dictionaries.

        A base that is a file is sought `beside` another, and where one stands.
        """
        if unknown := sorted(set(table) - {"base", "keep", "axes", "zip", "random"}):
            raise SceneError(
                f"{name}: unknown key {unknown[0]}: known here are base, keep, axes, zip and random"
            )
        table = {"base": _base(table.get("base"), name, beside)} | {
            key: table[key] for key in table if key != "base"
        }
        axes = tuple(_axes(table, name))
        if not axes:
            raise SceneError(f"{name}: nothing varies: give [axes], [zip] or [random]")
        table["base"] = _without_alternatives(
            table["base"], {key for axis in axes for key in axis.columns}, name
        )
        sweep = cls(table, axes, (), name)
        sweep._try_out()
        keep = checked_keep(table.get("keep"), sweep.scene((0,) * len(axes)).wear, name)
        return cls(table | {"keep": list(keep)}, axes, keep, name)

    @property
    def dims(self) -> tuple[str, ...]:
        return tuple(axis.dim for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(axis) for axis in self.axes)

    @property
    def count(self) -> int:
        """Number of scenes."""
        return prod(self.shape)

    def to_json(self) -> str:
        """The sweep as JSON, its base written out; TOML would not keep the order of the axes."""
        return json.dumps(self.table)

    @cached_property
    def _base_table(self) -> Table:
        return dict(self.table["base"])

    def changes(self, index: tuple[int, ...]) -> Table:
        """Keys and values of one scene, by its place on each axis."""
        chosen = zip(self.axes, index, strict=True)
        return {key: values[at] for axis, at in chosen for key, values in axis.columns.items()}

    def scene(self, index: tuple[int, ...]) -> Scene:
        """One scene, by its place on each axis."""
        table, changes = copy.deepcopy(self._base_table), self.changes(index)
        for key, value in changes.items():
            *path, last = key.split(".")
            part = table
            for step in path:
                part = part.setdefault(step, {})
            part[last] = value
        name = f"{self.name}, {described(changes)}"
        scene = Scene.from_table(table, name)
        if not scene.problem.full_contact:
            raise SceneError(
                f"{name}: sweeps are over flat punches under a force: leave out punch.recess and "
                "punch.profile, and give load.normal_force; or run such scenes one by one"
            )
        return scene

    def part(self, bounds: tuple[tuple[int, int], ...]) -> "Sweep":
        """A box of the grid, by first and last (beyond) place on each axis, as a sweep of
        its own.
        """
        axes = (
            Axis(axis.dim, {key: values[first:last] for key, values in axis.columns.items()})
            for axis, (first, last) in zip(self.axes, bounds, strict=True)
        )
        return Sweep({"base": self.table["base"]}, tuple(axes), self.keep, self.name)

    def coordinates(self) -> Iterator[tuple[str, str, list[Any], str]]:
        """Name, dimension, values and key of each coordinate; lists and tables are written
        as text.
        """
        taken = {*RESERVED, *self.dims}
        for axis in self.axes:
            for number, (key, values) in enumerate(axis.columns.items()):
                name = axis.dim if not number and axis.dim != DRAW else _named(key, taken)
                taken.add(name)
                plain = all(isinstance(value, int | float | str) for value in values)
                yield name, axis.dim, values if plain else [str(value) for value in values], key

    def _try_out(self) -> None:
        """Read the first scene, and every other value of each axis beside the first of the
        others.
        """
        for number, axis in enumerate(self.axes):
            for at in range(min(len(axis), TRIED)):
                _ = self.scene(
                    tuple(at if other == number else 0 for other in range(len(self.axes)))
                )


def described(changes: Mapping[str, Any]) -> str:
    """Keys and values in a line."""
    short = {
        key: f"{value:.6g}" if isinstance(value, float) else str(value)
        for key, value in changes.items()
    }
    return ", ".join(f"{key} = {value}" for key, value in short.items())


def _base(base: Any, name: str, beside: Path | None) -> Table:
    if isinstance(base, dict):
        return base
    if not isinstance(base, str):
        raise SceneError(
            f"{name}: missing key base; give a file, a table [base] or one of "
            f"{', '.join(bundled())}"
        )
    near = None if beside is None else beside / base
    return Scene.load(near if near is not None and near.is_file() else base).table()


def _axes(table: Table, name: str) -> Iterator[Axis]:
    taken = set(RESERVED)
    for section in ("axes", "zip", "random"):
        if not isinstance(table.get(section, {}), dict):
            raise SceneError(
                f"{name}: {section} = {table[section]!r} is no table of scene keys: give "
                f"[{section}]"
            )
    for key, values in table.get("axes", {}).items():
        yield _without_twins(Axis(_named(key, taken), {key: _spaced(key, values, name)}), name)
    if columns := {key: _spaced(key, values, name) for key, values in table.get("zip", {}).items()}:
        if len({len(values) for values in columns.values()}) > 1:
            lengths = ", ".join(f"{key} {len(values)}" for key, values in columns.items())
            raise SceneError(
                f"{name}: columns of [zip] go together, and must be of one length: {lengths}"
            )
        yield _without_twins(Axis(_named(next(iter(columns)), taken), columns), name)
    if "random" in table:
        yield _drawn(dict(table["random"]), name)


def _without_twins(axis: Axis, name: str) -> Axis:
    """The axis, if no scene on it is there twice."""
    # numbers that are equal, such as 1 and 1.0, give one scene; lists cannot be compared in a set
    rows = [
        tuple(str(value) if isinstance(value, list | dict) else value for value in row)
        for row in zip(*axis.columns.values(), strict=True)
    ]
    if len(set(rows)) < len(rows):
        twin = next(row for number, row in enumerate(rows) if row in rows[:number])
        columns, values = ", ".join(axis.columns), ", ".join(map(str, twin))
        raise SceneError(f"{name}: {columns} = {values} is there twice: give it once")
    return axis


def _named(key: str, taken: set[str]) -> str:
    """The last part of a key, or its last two; remembered as taken."""
    parts = key.split(".")
    found = next(
        one
        for one in (parts[-1], "_".join(parts[-2:]), "_".join(parts), f"{key}_")
        if one not in taken
    )
    taken.add(found)
    return found


def _spaced(key: str, values: Any, name: str) -> list[Any]:
    """The values of an axis: a list, or evenly spaced."""
    if isinstance(values, list) and values:
        return values
    if isinstance(values, dict) and len(values) == 1 and (kind := next(iter(values))) in SPACINGS:
        try:
            first, last, count = values[kind]
            with np.errstate(all="raise"):
                spaced = SPACINGS[kind](float(first), float(last), int(count)).tolist()
        except (TypeError, ValueError, FloatingPointError) as error:
            raise SceneError(
                f"{name}: {key} = {values}: {error}; give {kind} = [first, last, count]"
            ) from None
        if spaced:
            return _whole(key, spaced)
    raise SceneError(
        f"{name}: {key} = {values!r}: give a list of values, {{ linspace = [first, last, count] }} "
        f"or {{ geomspace = ... }}"
    )


def _whole(key: str, values: list[float]) -> list[Any]:
    """Whole numbers where the key wants them and the values are."""
    _, field = declaration(key.split("."))
    wants_whole = field is not None and field.annotation in (int, int | None)
    return (
        [round(value) for value in values]
        if wants_whole and all(value == round(value) for value in values)
        else values
    )


def _drawn(table: Table, name: str) -> Axis:
    """Values drawn at random, those of each key by a generator of its own."""
    count, seed = table.pop("count", None), table.pop("seed", None)
    if not (isinstance(count, int) and count > 0 and isinstance(seed, int) and seed >= 0):
        raise SceneError(
            f"{name}: random.count = {count} and random.seed = {seed}: give how many, and a whole "
            "number, 0 or "
            "more, that the draws begin from"
        )
    columns = {}
    for key, values in table.items():
        generator = np.random.default_rng([seed, *key.encode()])
        if isinstance(values, list) and values:
            columns[key] = [values[at] for at in generator.integers(len(values), size=count)]
            continue
        try:
            ((kind, (first, last)),) = values.items()
            scale, back = DRAWN[kind]
            columns[key] = [
                float(back(value)) for value in generator.uniform(scale(first), scale(last), count)
            ]
        except (AttributeError, KeyError, TypeError, ValueError):
            raise SceneError(
                f"{name}: {key} = {values!r}: to draw from, give a list, "
                f"{{ linspace = [least, greatest] }} "
                "(uniform) or { geomspace = [least, greatest] } (log-uniform)"
            ) from None
    if not columns:
        raise SceneError(f"{name}: [random] draws nothing: give scene keys beside count and seed")
    return Axis(DRAW, columns)


def _without_alternatives(base: Table, keys: set[str], name: str) -> Table:
    """The base without what the axes give in another way.

    Two materials stay two, whichever way they are given.
    """
    table = copy.deepcopy(base)
    punch = table.get("punch", {})
    pair = punch.get("wear_coefficients", [])
    if keys & {"punch.wear_ratio", "punch.wear_coefficient"} and pair:
        if len(pair) != 2:
            raise SceneError(
                f"{name}: punch.wear_ratio and punch.wear_coefficient vary two materials, and the "
                "base gives "
                f"{len(pair)} wear_coefficients: give it two"
            )
        punch["wear_coefficient"], punch["wear_ratio"] = pair[0], pair[1] / pair[0]
    for these, those in INSTEAD:
        for given, dropped in ((these, those), (those, these)):
            for key in dropped if keys & given else ():
                section, last = key.split(".")
                table.get(section, {}).pop(last, None)
    return table
