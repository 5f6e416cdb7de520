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
from itertools import product
from math import prod
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

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
# labels of the store that no axis may have for its name
RESERVED = (
    *("solver", "time", "radius", "ring", "mode", "state"),
    *("status", "reason", "disagreement"),
)
# keys of a section that say the same in several ways
ALTERNATIVES = (
    ("punch", ("wear_coefficients",), ("wear_coefficient", "wear_ratio")),
    ("punch", ("rings", "width_ratio"), ("ring_edges",)),
    ("half_space", ("plane_strain_modulus",), ("youngs_modulus",)),
    ("load", ("normal_force",), ("mean_pressure",), ("indentation",)),
)


class Column(NamedTuple):
    """Values of a scene key, under the name of its coordinate, along a dimension of the store."""

    name: str
    dim: str
    values: list[Any]


@dataclass(frozen=True, eq=False)
class Sweep:
    """Scenes over a labelled grid.

    Parameters
    ----------
    table : the sweep as nested dictionaries, its base a table: enough to make it again
    columns : by scene key what varies; columns along one dimension go together
    keep : names of the quantities to keep
    shared : by scene key what all scenes have in common: the methods, and times and radii of the
        quantities to keep

    Raises
    ------
    SceneError
        from `load` and `of`, naming the key, the value and the remedy
    """

    table: Table
    columns: dict[str, Column]
    keep: tuple[str, ...] = ()
    shared: dict[str, Column] = field(default_factory=dict)

    @classmethod
    def load(cls, source: str | Path) -> Self:
        """Read a sweep file, or a bundled one by its name."""
        path, folder = Path(source), Path(str(files("ringwear.studies"))) / "sweep" / "files"
        file = path if path.exists() else folder / f"{source}.toml"
        try:
            table = tomllib.loads(file.read_text("utf-8"))
        except (OSError, ValueError) as error:
            raise SceneError(
                f"{source} cannot be read ({error}): give a sweep file, TOML in UTF-8, or one that "
                "is bundled, such as running_in"
            ) from error
        return cls.of(table, path.parent)

    @classmethod
    def of(cls, table: Table, folder: Path | None = None) -> Self:
        """Make a sweep from nested dictionaries; a base that is a file is sought in a folder, too.

        Of each axis up to 200 values are tried, beside the first of the others. Values that are
        bad beyond that fail as scenes, with the reason.
        """
        kinds = {"base": str | dict, "keep": list, "axes": dict, "zip": dict, "random": dict}
        for key, value in table.items():
            if not isinstance(value, kinds.get(key, ())):
                raise SceneError(
                    f"{key} = {value!r} is not understood: give base, keep, which is a list of "
                    "quantities, and tables [axes], [zip] and [random] of scene keys"
                )
        base, columns = table.get("base"), _columns(table)
        if base is None or not columns:
            raise SceneError(
                "missing key base, or nothing varies: give base, a file, a bundled scene or a "
                "table, and [axes], [zip] or [random]"
            )
        if isinstance(base, str):
            beside = (folder or Path()) / base
            base = Scene.load(beside if beside.is_file() else base).table()
        sweep = cls(table | {"base": _without_alternatives(base, set(columns))}, columns)
        start = dict.fromkeys(sweep.sizes, 0)
        tried = [
            sweep.changes_at(start | {dim: place})
            for dim, size in sweep.sizes.items()
            for place in range(min(size, 200))
        ]
        problems = [sweep.scene(changes).problem for changes in tried]
        names = {column.name for column in columns.values()}
        keep = _checked_keep(table.get("keep"), problems, names)
        dims = {"solver"}.union(*(KEEPABLE[quantity].dims for quantity in keep))
        if "worn_volume" in keep and "wear.times" not in columns:
            dims.add("time")  # by the last of which it is worn
        labels = _labels(sweep.first)
        shared = {key: column for key, column in labels.items() if column.dim in dims}
        sweep = cls(sweep.table | {"keep": list(keep)}, columns, keep, shared)
        for changes in tried:
            sweep.scene(changes)
        return sweep

    @property
    def sizes(self) -> dict[str, int]:
        """Numbers of values along each dimension."""
        return {column.dim: len(column.values) for column in self.columns.values()}

    @property
    def count(self) -> int:
        """Number of scenes."""
        return prod(self.sizes.values())

    @cached_property
    def first(self) -> Scene:
        """The scene of the first values."""
        return self.scene(next(self.changes()))

    def changes(self) -> Iterator[Table]:
        """Yield what each scene changes of the base, in the order of the store."""
        for places in product(*map(range, self.sizes.values())):
            yield self.changes_at(dict(zip(self.sizes, places, strict=True)))

    def changes_at(self, places: dict[str, int]) -> Table:
        """Return what the scene at a place along each dimension changes of the base."""
        return {key: values[places[dim]] for key, (_, dim, values) in self.columns.items()}

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
        name = ", ".join(f"{key} = {value}" for key, value in changes.items())
        scene = Scene.from_table(table, name)
        labels = _labels(scene)
        for key, column in self.shared.items():
            if not column.values or labels[key] != column:
                raise SceneError(
                    f"{name}: not all scenes have the same {key}, over which something is kept: "
                    f"give the base {key} as numbers, or keep only what is not over them"
                )
        return scene

    def problem(self, changes: Table) -> Problem:
        """Return the problem of some changes, asking for what is to be kept and nothing else."""
        quantities = (part for name in self.keep for part in ANSWERS.get(name, (name,)))
        return self.scene(changes).problem.asking_for(frozenset(quantities))

    def part(self, region: dict[str, slice]) -> "Sweep":
        """Return a box of the grid, a slice of each dimension, as a sweep of its own."""
        columns = {
            key: Column(name, dim, values[region[dim]])
            for key, (name, dim, values) in self.columns.items()
        }
        return replace(self, table={"base": self.table["base"]}, columns=columns)


def _labels(scene: Scene) -> dict[str, Column]:
    """Return what of a scene labels its results."""
    return {
        "methods": Column("solver", "solver", scene.methods),
        "wear.times": Column("time", "time", scene.wear.times),
        "output.radii": Column("radius", "radius", scene.output.radii or []),
    }


def _columns(table: Table) -> dict[str, Column]:
    """Return what varies: each of the axes along a dimension of its own."""
    crossed, zipped = table.get("axes", {}), table.get("zip", {})
    draws = dict(table.get("random", {}))
    count, seed = draws.pop("count", 0), draws.pop("seed", None)
    if draws and not (isinstance(count, int) and count > 0 and isinstance(seed, int)):
        raise SceneError(
            f"random.count = {count} and random.seed = {seed}: give how many, and a whole number "
            "that the draws begin from"
        )
    dims = dict.fromkeys(draws, DRAW)
    columns: dict[str, Column] = {}
    for key, given in (crossed | zipped | draws).items():
        *_, name = parts = key.split(".")
        if name in {*RESERVED, *(column.name for column in columns.values())}:
            name = "_".join(parts[-2:])
        if key in zipped and key not in dims:
            # the first of them names the dimension of all
            dims |= dict.fromkeys(zipped, name)
        values = _values(key, given, count if key in draws else 0, seed)
        columns[key] = Column(name, dims.get(key, name), values)
    if len({len(columns[key].values) for key in zipped}) > 1:
        raise SceneError("columns of [zip] go together: give them one length")
    return columns


def _values(key: str, values: Any, draws: int, seed: int | None) -> list[Any]:
    """Return the values of an axis: a list, evenly spaced, or drawn by a generator of its own."""
    generator = np.random.default_rng([seed or 0, *key.encode()])
    try:
        if isinstance(values, list) and values:
            drawn = generator.integers(len(values), size=draws)
            return [values[place] for place in drawn] if draws else values
        ((kind, (first, last, *count)),) = values.items()
        space: Any = {"linspace": np.linspace, "geomspace": np.geomspace}[kind]
        if draws:
            part = generator.uniform(size=draws)
            if kind == "linspace":
                return (first + (last - first) * part).tolist()
            return (first * (last / first) ** part).tolist()
        spaced = space(first, last, count[0])
        whole = isinstance(first, int) and (spaced == spaced.round()).all()
        return (spaced.astype(int) if whole else spaced).tolist()
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        raise SceneError(
            f"{key} = {values!r}: give a list of values, or linspace or geomspace = [first, last, "
            "count] in braces, without count to draw from"
        ) from None


def _without_alternatives(base: Table, keys: set[str]) -> Table:
    """Return the base without what the axes give in another way.

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


def _checked_keep(keep: Any, problems: list[Problem], axes: Iterable[str]) -> tuple[str, ...]:
    """Return the quantities to keep: those named, or all that need no radius and no ring; none
    that is an axis.
    """
    given = set[str]().union(*map(_given, problems)) - set(axes)
    if keep is None:
        left_out = {"radius", "ring"} if len(problems[0].times) else {"radius", "ring", "mode"}
        return tuple(
            name for name in KEEPABLE if name in given and left_out.isdisjoint(KEEPABLE[name].dims)
        )
    computed = {of for of in KEEPABLE if not given.isdisjoint(ANSWERS.get(of, (of,)))}
    if not keep or not set(map(str, keep)) <= computed:
        raise SceneError(
            f"keep = {keep!r} names what is no quantity of such punches: give a list of "
            f"{', '.join(sorted(computed))}; histories need wear.times, and steady quantities "
            "wear.steady = true"
        )
    return tuple(dict.fromkeys(keep))


def _given(problem: Problem) -> frozenset[str]:
    """Return the quantities that a problem has."""
    given = problem.asking_for(GROUPS["all"]).quantities or frozenset()
    return given - (STEADY if problem.indentation is not None else frozenset())
