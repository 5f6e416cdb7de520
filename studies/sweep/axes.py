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
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.resources import files
from itertools import permutations, product
from math import prod
from pathlib import Path
from typing import Any, Self

import numpy as np
from pandas import DataFrame

from ...meshes.errors import SceneError
from ..problem.problem import Problem
from ..problem.quantities import ANSWER, GROUPS, QUANTITIES, STEADY
from ..problem.scene import Scene, set_key

Table = dict[str, Any]
DRAW = "draw"
# answers of a run that can be kept, and the quantities that they are computed from
ANSWERS = {
    "worn_volume": ("profile", "ring_worn_volume"),
    "force_share": ("ring_force", "normal_force", "indentation", "steady_pressure"),
    "running_in_time": ("indentation",),
    "time_to_90": ("indentation",),
    "time_to_99": ("indentation",),
}
KEEPABLE = {
    name: quantity
    for name, quantity in QUANTITIES.items()
    if name not in ("contact", "contact_edge")
} | {name: ANSWER[name] for name in ANSWERS}
# of scenes that several methods compute, by the quantities to keep
JUDGED = {
    "disagreement": "greatest difference over its uncertainty: above 1 methods disagree",
    "effectivity": "least error stated, over the error that a far more accurate method shows",
}
# labels of the store that no axis may have for its name
RESERVED = ("solver", "time", "radius", "ring", "mode", "state", "status", "reason", *JUDGED)


@dataclass(frozen=True, eq=False)
class Sweep:
    """Scenes over a labelled grid.

    Parameters
    ----------
    table : the sweep as nested dictionaries, its base a table: enough to make it again
    axes : by dimension the changes of the base along it, as values of scene keys
    name : for messages
    keep : names of the quantities to keep
    labels : times and radii of the quantities to keep, by dimension: all scenes have the same

    Raises
    ------
    SceneError
        from `load` and `of`, naming the key, the value and the remedy
    """

    table: Table
    axes: dict[str, list[Table]]
    name: str
    keep: tuple[str, ...] = ()
    labels: dict[str, list[float]] = field(default_factory=dict)

    @classmethod
    def load(cls, source: str | Path) -> Self:
        """Read a sweep file, or a bundled one by its name."""
        path, folder = Path(source), Path(str(files("ringwear.studies"))) / "sweep" / "files"
        bundled = folder / f"{source}.toml"
        try:
            file = bundled if bundled.exists() and not path.exists() else path
            table = tomllib.loads(file.read_text("utf-8"))
        except (OSError, ValueError) as error:
            names = ", ".join(sorted(entry.stem for entry in folder.iterdir()))
            raise SceneError(
                f"{source} cannot be read ({error}): give a sweep file, TOML in UTF-8, or one of "
                f"{names}"
            ) from error
        return cls.of(table, str(source), path.parent)

    @classmethod
    def of(cls, table: Table, name: str = "sweep", folder: Path | None = None) -> Self:
        """Make a sweep from nested dictionaries; a base that is a file is sought in a folder, too.

        Of each axis up to 200 values are tried, beside the first of the others. Values that are
        bad beyond that fail as scenes, with the reason.
        """
        tables = ("axes", "zip", "random")
        for key, value in table.items():
            if key not in ("base", "keep", *tables) or (
                key in tables and not isinstance(value, dict)
            ):
                raise SceneError(
                    f"{name}: {key} = {value!r} is not understood: give base, keep, and tables "
                    "[axes], [zip] and [random] of scene keys"
                )
        axes = dict(_axes(table, name))
        if not axes:
            raise SceneError(f"{name}: nothing varies: give [axes], [zip] or [random]")
        base = table.get("base")
        if not isinstance(base, str | dict):
            raise SceneError(f"{name}: missing key base: give a file, a bundled scene or [base]")
        if isinstance(base, str):
            beside = (folder or Path()) / base
            base = Scene.load(beside if beside.is_file() else base).table()
        keys = {key for rows in axes.values() for key in rows[0]}
        table = table | {"base": _without_alternatives(base, keys, name)}
        bare = cls(table, axes, name)
        changes, first = next(bare.changes()), bare.first
        tried = [changes | row for rows in axes.values() for row in rows[:200]]
        problems = [first.problem, *(bare.scene(of).problem for of in tried)]
        keep = _checked_keep(table.get("keep"), problems, bare.coordinates, name)
        dims = {dim for quantity in keep for dim in KEEPABLE[quantity].dims}
        if "worn_volume" in keep and "wear.times" not in keys:
            dims.add("time")  # by the last of which it is worn
        labels = {dim: values for dim, values in _labels(first).items() if dim in dims}
        sweep = cls(table | {"keep": list(keep)}, axes, name, keep, labels)
        for of in tried if labels else ():
            sweep.scene(of)
        return sweep

    @property
    def dims(self) -> tuple[str, ...]:
        return tuple(self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(map(len, self.axes.values()))

    @property
    def count(self) -> int:
        """Number of scenes."""
        return prod(self.shape)

    @cached_property
    def first(self) -> Scene:
        """The scene of the first values."""
        return self.scene(next(self.changes()))

    def changes(self) -> Iterator[Table]:
        """Yield what each scene changes of the base, in the order of the store."""
        for rows in product(*self.axes.values()):
            yield {key: value for row in rows for key, value in row.items()}

    def scene(self, changes: Table) -> Scene:
        """Return the scene of some changes.

        Raises
        ------
        SceneError
            if there is no such scene, or it does not fit the others
        """
        table = copy.deepcopy(self.table["base"])
        for key, value in changes.items():
            set_key(table, key.split("."), value)
        name = f"{self.name}, {_in_words(changes)}"
        scene = Scene.from_table(table, name)
        for dim, values in self.labels.items():
            if not values or values != _labels(scene)[dim]:
                key = {"time": "wear.times", "radius": "output.radii"}[dim]
                raise SceneError(
                    f"{name}: something is kept over the {dim}, and not all scenes have the same "
                    f"{key}: give the base {key} as numbers, or keep only what is not over them"
                )
        return scene

    def problem(self, scene: Scene) -> Problem:
        """Return the problem of a scene, asking for what is to be kept and nothing else."""
        quantities = (part for name in self.keep for part in ANSWERS.get(name, (name,)))
        return scene.problem.asking_for(frozenset(quantities))

    def part(self, region: tuple[slice, ...]) -> "Sweep":
        """Return a box of the grid as a sweep of its own."""
        axes = {dim: self.axes[dim][places] for dim, places in zip(self.axes, region, strict=True)}
        return replace(self, table={"base": self.table["base"]}, axes=axes)

    @property
    def coordinates(self) -> dict[str, tuple[str, str, list[Any]]]:
        """Dimension, key and values of each coordinate."""
        dims = {key: dim for dim, rows in self.axes.items() for key in rows[0]}
        return {
            name: (dims[key], key, [row[key] for row in self.axes[dims[key]]])
            for key, name in _coordinate_names(dims).items()
        }


def _labels(scene: Scene) -> dict[str, list[float]]:
    return {"time": scene.wear.times, "radius": scene.output.radii or []}


def _in_words(changes: Table) -> str:
    return ", ".join(f"{key} = {value}" for key, value in changes.items())


def _axes(table: Table, name: str) -> Iterator[tuple[str, list[Table]]]:
    """Yield each dimension, and the changes of the base along it."""
    crossed, zipped = table.get("axes", {}), table.get("zip", {})
    draws = dict(table.get("random", {}))
    count, seed = draws.pop("count", 0), draws.pop("seed", None)
    if "random" in table and not (
        draws and isinstance(count, int) and count > 0 and isinstance(seed, int)
    ):
        raise SceneError(
            f"{name}: random.count = {count} and random.seed = {seed}: give how many, a whole "
            "number that the draws begin from, and scene keys to draw"
        )
    names = _coordinate_names([*crossed, *zipped, *draws])
    for given in filter(None, [*({key: crossed[key]} for key in crossed), zipped, draws]):
        number = count if given is draws else 0
        columns = [_values(key, given[key], name, number, seed) for key in given]
        if len(set(map(len, columns))) > 1:
            raise SceneError(f"{name}: columns of [zip] go together: give them one length")
        rows = [dict(zip(given, row, strict=True)) for row in zip(*columns, strict=True)]
        # numbers that are equal, such as 1 and 1.0, give one scene
        twice = DataFrame(rows).astype(str).duplicated()
        if twice.any() and not number:
            raise SceneError(
                f"{name}: {_in_words(rows[twice.argmax()])} is there twice: give it once"
            )
        yield DRAW if number else names[next(iter(given))], rows


def _coordinate_names(keys: Iterable[str]) -> dict[str, str]:
    """Return the name of each key's coordinate: its last part, or its last two."""
    names: dict[str, str] = {}
    for key in keys:
        *_, last = parts = key.split(".")
        names[key] = "_".join(parts[-2:]) if last in {*RESERVED, *names.values()} else last
    return names


def _values(key: str, values: Any, name: str, draws: int, seed: int | None) -> list[Any]:
    """Return the values of an axis: a list, evenly spaced, or drawn by a generator of its own."""
    # how to space values, and a scale on which they are drawn evenly, with its inverse
    kinds: Any = {
        "linspace": (np.linspace, float, np.array),
        "geomspace": (np.geomspace, np.log, np.exp),
    }
    generator = np.random.default_rng([seed or 0, *key.encode()])
    try:
        if isinstance(values, list) and values:
            places = generator.integers(len(values), size=draws) if draws else range(len(values))
            return [values[at] for at in places]
        ((kind, (first, last, *count)),) = values.items()
        space, scale, unscale = kinds[kind]
        with np.errstate(all="raise"):
            if draws:
                return unscale(generator.uniform(scale(first), scale(last), draws)).tolist()
            spaced = space(first, last, count[0])
        if not spaced.size:
            raise ValueError
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        raise SceneError(
            f"{name}: {key} = {values!r}: give a list of values, or linspace or geomspace = [first,"
            " last, count] in braces, without count to draw from"
        ) from None
    whole = isinstance(first, int) and (spaced == spaced.round()).all()
    return (spaced.astype(int) if whole else spaced).tolist()


def _without_alternatives(base: Table, keys: set[str], name: str) -> Table:
    """Return the base without what the axes give in another way.

    Two materials stay two, whichever way they are given.
    """
    # keys of a section that say the same in two ways
    alternatives = (
        ("punch", ("wear_coefficients",), ("wear_coefficient", "wear_ratio")),
        ("punch", ("rings", "width_ratio"), ("ring_edges",)),
        ("half_space", ("plane_strain_modulus",), ("youngs_modulus",)),
        ("load", ("normal_force",), ("mean_pressure",), ("indentation",)),
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
    for section, *ways in alternatives:
        for given, dropped in permutations(ways, 2):
            for key in dropped if keys.intersection(f"{section}.{way}" for way in given) else ():
                table.get(section, {}).pop(key, None)
    return table


def _checked_keep(
    keep: Any, problems: list[Problem], axes: Iterable[str], name: str
) -> tuple[str, ...]:
    """Return the quantities to keep: those named, or all that need no radius and no ring; none
    that is an axis.
    """
    given = frozenset[str]().union(*map(_given, problems)) - set(axes)
    if keep is None:
        alone = {"radius", "ring"}
        if not len(problems[0].times):
            alone.add("mode")
        return tuple(
            name for name in KEEPABLE if name in given and not alone & set(KEEPABLE[name].dims)
        )
    computed = {of for of in KEEPABLE if not given.isdisjoint(ANSWERS.get(of, (of,)))}
    if not (isinstance(keep, list) and keep and set(map(str, keep)) <= computed):
        raise SceneError(
            f"{name}: keep = {keep!r} names what is no quantity of such punches: "
            f"give a list of {', '.join(sorted(computed))}; histories need wear.times, and steady "
            "quantities wear.steady = true"
        )
    return tuple(dict.fromkeys(keep))


def _given(problem: Problem) -> frozenset[str]:
    """Return the quantities that a problem has."""
    given = problem.asking_for(GROUPS["all"]).quantities or frozenset()
    return given - (STEADY if problem.indentation is not None else frozenset())
