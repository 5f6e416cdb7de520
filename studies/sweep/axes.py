"""A sweep file: a base scene, the quantities to keep, and axes of scene keys.

Each scene is one point of a labelled grid.

    base = "five_rings"                                    # a bundled scene, a file, or a table
    keep = ["steady_rms_slope", "relaxation_time"]         # default: all without radius and ring
    [axes]                                                 # crossed with each other
    "punch.rings" = [2, 4, 8]
    "punch.wear_ratio" = { geomspace = [1e-4, 1e4, 81] }   # or linspace
    [zip]                                                  # columns that go together: one dimension
    [random]                                               # draws: one dimension, `draw`
    count = 1000
    seed = 1
    "punch.width_ratio" = { geomspace = [0.1, 10.0] }      # log-uniform; or linspace, a list

A dimension has the name of the last part of its key, or of its last two where that is taken.
"""

import copy
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.resources import files
from math import prod
from pathlib import Path
from typing import Any, Self

import numpy as np

from ...meshes.errors import SceneError
from ..methods.quantities import ANSWER, HISTORIES, OF_PROFILES, QUANTITIES
from ..problem.problem import Problem
from ..problem.scene import Scene, declaration
from ..problem.sections import WearSection

Table = dict[str, Any]
DRAW = "draw"
# answers of a run that can be kept, and the quantities that they are computed from
ANSWERS = {
    "worn_volume": ("profile",),
    "force_share": ("indentation", "steady_pressure", "steady_displacement_max"),
    "running_in_time": ("indentation",),
    "time_to_90": ("indentation",),
    "time_to_99": ("indentation",),
}
KEEPABLE = {name: QUANTITIES[name] for name in QUANTITIES if name not in OF_PROFILES} | {
    name: ANSWER[name] for name in ANSWERS
}
# of scenes that several methods compute, by the quantities to keep
JUDGED = {
    "disagreement": "greatest difference over its uncertainty: above 1 methods disagree",
    "effectivity": "least error stated, over the error that a far more accurate method shows",
}
# labels of the store that no axis may have for its name
RESERVED = ("solver", "time", "radius", "ring", "mode", "state", "status", "reason", *JUDGED)


@dataclass(frozen=True, eq=False)
class Axis:
    """One dimension: its name, and the values of one or several scene keys along it."""

    dim: str
    columns: Mapping[str, list[Any]]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    @property
    def shares_discretisation(self) -> bool:
        """Whether scenes along it can share a discretisation."""
        # beginnings of keys that scenes may differ in and yet share a discretisation
        sharing = (
            *("punch.wear", "punch.radius", "half_space.plane", "half_space.youngs"),
            *("load.", "wear.", "output.", "title"),
        )
        return all(key.startswith(sharing) for key in self.columns)


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
    def load(cls, source: str | Path) -> Self:
        """Read a sweep file, or a bundled one by its name."""
        path, folder = Path(source), files("ringwear.studies") / "sweep" / "files"
        bundled = {entry.name.removesuffix(".toml"): entry for entry in folder.iterdir()}
        try:
            file = path if path.exists() else bundled.get(str(source), path)
            table = tomllib.loads(file.read_text("utf-8"))
        except (OSError, ValueError) as error:
            raise SceneError(
                f"{source} cannot be read ({error}): give a sweep file, TOML in UTF-8, or one of "
                f"{', '.join(sorted(bundled))}"
            ) from error
        return cls.of(table, str(source), path.parent)

    @classmethod
    def of(cls, table: Table, name: str = "sweep", folder: Path | None = None) -> Self:
        """Make a sweep from nested dictionaries; a base that is a file is sought in a folder, too.

        Of each axis up to 200 values are tried, beside the first of the others. Values that are
        bad beyond that fail as scenes, with the reason.
        """
        for key, value in table.items():
            if key not in ("base", "keep", "axes", "zip", "random"):
                raise SceneError(
                    f"{name}: unknown key {key}: give base, keep, [axes], [zip] and [random]"
                )
            if key in ("axes", "zip", "random") and not isinstance(value, dict):
                raise SceneError(f"{name}: {key} = {value!r} is no table of scene keys")
        axes = tuple(_axes(table, name))
        if not axes:
            raise SceneError(f"{name}: nothing varies: give [axes], [zip] or [random]")
        keys = {key for axis in axes for key in axis.columns}
        base = _without_alternatives(_base_table(table.get("base"), name, folder), keys, name)
        sweep = cls(table | {"base": base}, axes, (), name)
        for number, axis in enumerate(axes):
            for at in range(min(len(axis), 200)):
                sweep.scene(tuple(at * (number == other) for other in range(len(axes))))
        keep = _checked_keep(table.get("keep"), sweep.first.wear, name)
        return replace(sweep, table=sweep.table | {"keep": list(keep)}, keep=keep)

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

    @cached_property
    def first(self) -> Scene:
        """The scene of the first values."""
        return self.scene((0,) * len(self.axes))

    def changes(self, index: tuple[int, ...]) -> Table:
        """Return keys and values of one scene, by its place on each axis."""
        places = zip(self.axes, index, strict=True)
        return {key: values[at] for axis, at in places for key, values in axis.columns.items()}

    def scene(self, index: tuple[int, ...]) -> Scene:
        """Return one scene, by its place on each axis."""
        table, changes = copy.deepcopy(self.table["base"]), self.changes(index)
        for key, value in changes.items():
            *path, last = key.split(".")
            section = table
            for step in path:
                section = section.setdefault(step, {})
            section[last] = value
        name = f"{self.name}, {', '.join(f'{key} = {changes[key]}' for key in changes)}"
        scene = Scene.from_table(table, name)
        if not scene.problem.full_contact:
            raise SceneError(
                f"{name}: sweeps are over flat punches under a force: leave out punch.recess and "
                "punch.profile, and give load.normal_force; or run such scenes one by one"
            )
        return scene

    def problem(self, scene: Scene) -> Problem:
        """Return the problem of a scene, asking for what is to be kept and nothing else."""
        needed = {quantity for name in self.keep for quantity in ANSWERS.get(name, (name,))}
        quantities = frozenset(
            name for name in needed if name == "relaxation_time" or _is_computed(scene.wear, name)
        )
        if quantities & HISTORIES:
            return replace(scene.problem, quantities=quantities)
        return replace(scene.problem, quantities=quantities, times=np.empty(0), march="modal")

    @property
    def last(self) -> "Sweep":
        """The scene of the last values, as a sweep of its own."""
        return self.part((slice(-1, None),) * len(self.axes))

    def part(self, region: tuple[slice, ...]) -> "Sweep":
        """Return a box of the grid as a sweep of its own."""
        axes = (
            Axis(axis.dim, {key: values[places] for key, values in axis.columns.items()})
            for axis, places in zip(self.axes, region, strict=True)
        )
        return replace(self, table={"base": self.table["base"]}, axes=tuple(axes))

    @property
    def coordinates(self) -> dict[str, tuple[str, str, list[Any]]]:
        """Dimension, key and values of each coordinate; lists and tables become text."""
        taken, coordinates = {*RESERVED, *self.dims}, {}
        for axis in self.axes:
            for number, (key, values) in enumerate(axis.columns.items()):
                name = axis.dim if not number and axis.dim != DRAW else _named(key, taken)
                plain = all(isinstance(value, int | float | str) for value in values)
                coordinates[name] = axis.dim, key, values if plain else list(map(str, values))
        return coordinates


def _base_table(base: Any, name: str, folder: Path | None) -> Table:
    if isinstance(base, dict):
        return base
    if not isinstance(base, str):
        raise SceneError(f"{name}: missing key base: give a file, a bundled scene or [base]")
    beside = None if folder is None else folder / base
    return Scene.load(beside if beside is not None and beside.is_file() else base).table()


def _axes(table: Table, name: str) -> Iterator[Axis]:
    taken = set(RESERVED)
    draws = dict(table.get("random", {}))
    count, seed = draws.pop("count", 0), draws.pop("seed", None)
    if bool(draws) != (isinstance(count, int) and count > 0 and isinstance(seed, int)):
        raise SceneError(
            f"{name}: random.count = {count} and random.seed = {seed}: give how many, a whole "
            "number that the draws begin from, and scene keys to draw"
        )
    for columns in [
        *({key: table["axes"][key]} for key in table.get("axes", {})),
        table.get("zip"),
    ]:
        if not columns:
            continue
        values = {key: _values(key, columns[key], name) for key in columns}
        if len({len(column) for column in values.values()}) > 1:
            raise SceneError(f"{name}: columns of [zip] go together: give them one length")
        # numbers that are equal, such as 1 and 1.0, give one scene; lists cannot be counted
        rows = Counter(
            tuple(str(value) if isinstance(value, list | dict) else value for value in row)
            for row in zip(*values.values(), strict=True)
        )
        if twins := [row for row in rows if rows[row] > 1]:
            text = ", ".join(map(str, twins[0]))
            raise SceneError(f"{name}: {', '.join(values)} = {text} is there twice: give it once")
        yield Axis(_named(next(iter(values)), taken), values)
    if draws:
        yield Axis(DRAW, {key: _values(key, draws[key], name, count, seed) for key in draws})


def _named(key: str, taken: set[str]) -> str:
    """Return the last part of a key, or its last two; remember it as taken."""
    parts = key.split(".")
    choices = parts[-1], "_".join(parts[-2:]), "_".join(parts), f"{key}_"
    name = next(choice for choice in choices if choice not in taken)
    taken.add(name)
    return name


def _values(key: str, values: Any, name: str, draws: int = 0, seed: int = 0) -> list[Any]:
    """Return the values of an axis: a list, evenly spaced, or drawn by a generator of its own."""
    generator = np.random.default_rng([seed, *key.encode()])
    try:
        if isinstance(values, list) and values:
            places = generator.integers(len(values), size=draws) if draws else range(len(values))
            return [values[at] for at in places]
        ((kind, (first, last, *count)),) = values.items()
        if draws:
            scales: Any = {"linspace": (float, np.array), "geomspace": (np.log, np.exp)}
            scale, back = scales[kind]
            return back(generator.uniform(scale(first), scale(last), draws)).tolist()
        spacings: Any = {"linspace": np.linspace, "geomspace": np.geomspace}
        with np.errstate(all="raise"):
            spaced = spacings[kind](float(first), float(last), int(count[0]))
        if not spaced.size:
            raise ValueError
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        raise SceneError(
            f"{name}: {key} = {values!r}: give a list of values, or linspace or geomspace = [first,"
            " last, count] in braces, without count to draw from"
        ) from None
    _, field = declaration(key.split("."))
    wants_whole = field is not None and field.annotation in (int, int | None)
    whole = wants_whole and (spaced == spaced.round()).all()
    return (spaced.astype(int) if whole else spaced).tolist()


def _without_alternatives(base: Table, keys: set[str], name: str) -> Table:
    """Return the base without what the axes give in another way.

    Two materials stay two, whichever way they are given.
    """
    # keys that say the same in other ways: what an axis gives takes the place of what the base
    # gives
    alternatives = (
        ({"punch.wear_coefficients"}, {"punch.wear_coefficient", "punch.wear_ratio"}),
        ({"punch.rings", "punch.width_ratio"}, {"punch.ring_edges"}),
        ({"half_space.plane_strain_modulus"}, {"half_space.youngs_modulus"}),
        ({"load.normal_force"}, {"load.mean_pressure"}),
    )
    table = copy.deepcopy(base)
    punch = table.get("punch", {})
    pair = punch.get("wear_coefficients", [])
    if pair and keys & {"punch.wear_ratio", "punch.wear_coefficient"}:
        if len(pair) != 2:
            raise SceneError(
                f"{name}: punch.wear_ratio and punch.wear_coefficient vary two materials, and the "
                f"base gives {len(pair)} wear_coefficients: give it two"
            )
        punch["wear_coefficient"], punch["wear_ratio"] = pair[0], pair[1] / pair[0]
    for these, those in alternatives:
        for given, dropped in ((these, those), (those, these)):
            for key in dropped if keys & given else ():
                section, last = key.split(".")
                table.get(section, {}).pop(last, None)
    return table


def _checked_keep(keep: Any, wear: WearSection, name: str) -> tuple[str, ...]:
    """Return the quantities to keep: those named, or all that need no radius and no ring."""
    computed = {
        quantity: any(_is_computed(wear, part) for part in ANSWERS.get(quantity, (quantity,)))
        for quantity in KEEPABLE
    }
    if keep is None:
        plain = [key for key in QUANTITIES if not {"radius", "ring"} & set(QUANTITIES[key].dims)]
        return tuple(quantity for quantity in plain if computed.get(quantity))
    if not (isinstance(keep, list) and keep and set(map(str, keep)) <= set(KEEPABLE)):
        raise SceneError(
            f"{name}: keep = {keep!r} names what is no quantity of a flat punch: give a list of "
            f"{', '.join(KEEPABLE)}"
        )
    for quantity in keep:
        if not computed[quantity] and quantity != "relaxation_time":
            missing = "wear.steady = true" if quantity.startswith("steady_") else "wear.times"
            raise SceneError(
                f"{name}: keep names '{quantity}', which the base does not ask for: give it "
                f"{missing}"
            )
    return tuple(dict.fromkeys(keep))


def _is_computed(wear: WearSection, name: str) -> bool:
    """Return whether a scene with such times and steady state has a quantity."""
    return wear.steady if name.startswith("steady_") else bool(wear.times)
