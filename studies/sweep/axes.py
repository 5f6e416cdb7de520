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

import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.resources import files
from itertools import product
from math import prod
from pathlib import Path
from types import UnionType
from typing import Self

from ...meshes.errors import SceneError
from ..problem.fields import Height, TomlTable, read_table, refuse_device
from ..problem.problem import Problem
from ..problem.quantities import ANSWER, GROUPS, QUANTITIES
from ..scene.explain import did_you_mean, nearest
from ..scene.keys import without_alternatives
from ..scene.scene import Scene
from ..scene.sources import bundled
from .columns import Column, has_units, read_columns

# scenes of one sweep
MOST_SCENES = 1_000_000_000
# answers of a run that can be kept, and the quantities that they are computed from
ANSWERS = {
    "worn_volume": ("profile", "ring_worn_volume"),
    "force_share": ("ring_force", "normal_force", "indentation", "steady_pressure"),
    "running_in_time": ("indentation",),
    "time_to_90": ("indentation", "time_to_90"),
    "time_to_99": ("indentation", "time_to_99"),
}
KEEPABLE = {
    name: quantity
    for name, quantity in QUANTITIES.items()
    if name not in ("contact", "contact_edge")
} | {name: ANSWER[name] for name in ANSWERS}


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
    heights : functions added to the face of each scene (`Scene.with_heights`), which no table holds
    profiles : by file the radii and heights of the profiles that scenes name; no file is read again

    Raises
    ------
    SceneError
        from `load` and `of`, naming the key, the value and the remedy
    """

    table: TomlTable
    columns: dict[str, Column]
    keep: tuple[str, ...] = ()
    shared: dict[str, Column] = field(default_factory=dict)
    heights: tuple[Height, ...] = ()
    profiles: TomlTable = field(default_factory=dict)

    @classmethod
    def load(cls, source: str | Path) -> Self:
        """Read a sweep file, or a bundled one by its name."""
        path, folder = Path(source), Path(str(files("ringwear.studies"))) / "sweep" / "files"
        file = path if path.exists() else folder / f"{source}.toml"
        try:
            refuse_device(file)
            table = tomllib.loads(file.read_text("utf-8"))
        except (OSError, ValueError) as error:
            raise SceneError(_unread(str(source), error)) from error
        return cls.of(table, path.parent)

    @classmethod
    def of(cls, table: TomlTable, folder: Path | None = None) -> Self:
        """Make a sweep from nested dictionaries; a base that is a file is sought in a folder, too.

        Of each axis up to 200 values are tried, beside the first of the others. Values that are
        bad beyond that fail as scenes, with the reason.
        """
        kinds: dict[str, type | UnionType] = {"base": str | dict, "keep": list}
        kinds |= dict.fromkeys(("axes", "zip", "random", "profiles"), dict)
        for key, value in table.items():
            if not isinstance(value, kinds.get(key, ())):
                raise SceneError(
                    f"{key} = {value!r} is not understood: give base, keep, which is a list of "
                    "quantities, and tables [axes], [zip] and [random] of scene keys"
                )
        base = table.get("base")
        varied = {key: of for name in ("axes", "zip") for key, of in table.get(name, {}).items()}
        varied |= table.get("random", {})
        if base is None or not varied:
            raise SceneError(
                "missing key base, or nothing varies: give base, a file, a bundled scene or a "
                "table, and [axes], [zip] or [random]"
            )
        if isinstance(base, str):
            in_folder = (folder or Path()) / base
            base = Scene.load(in_folder if in_folder.is_file() else base).table()
        if "units" not in base and has_units(varied.items()):
            base = base | {"units": "SI"}
        columns = read_columns(table, base)
        base, heights = _without_heights(without_alternatives(base, set(columns)))
        profiles = table.get("profiles") or _read_profiles(base, columns, folder or Path())
        table = table | {"base": base} | ({"profiles": profiles} if profiles else {})
        sweep = cls(table, columns, heights=heights, profiles=profiles)
        if sweep.count > MOST_SCENES:
            raise SceneError(
                f"{sweep.count} scenes are too many for one store: cut the sweep into several of "
                f"at most {MOST_SCENES}, by an axis, each with a directory of its own"
            )
        start = dict.fromkeys(sweep.sizes, 0)
        tried = [
            sweep.changes_at(start | {dim: place})
            for dim, size in sweep.sizes.items()
            for place in range(min(size, 200))
        ]
        scenes = [sweep.scene(changes) for changes in tried]
        problems = [scene.problem for scene in scenes]
        names = {column.name for column in columns.values()}
        keep = _checked_keep(table.get("keep"), problems, names)
        dims = {"solver"}.union(*(KEEPABLE[quantity].dims for quantity in keep))
        if "worn_volume" in keep and "wear.times" not in columns:
            dims.add("time")  # by the last of which it is worn
        labels = _labels(scenes[0])
        shared = {key: column for key, column in labels.items() if column.dim in dims}
        sweep = replace(sweep, table=table | {"keep": list(keep)}, keep=keep, shared=shared)
        for scene, changes in zip(scenes, tried, strict=True):
            sweep.check_labels(scene, changes)
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

    def changes(self) -> Iterator[TomlTable]:
        """Yield what each scene changes of the base, in the order of the store."""
        for places in product(*map(range, self.sizes.values())):
            yield self.changes_at(dict(zip(self.sizes, places, strict=True)))

    def changes_at(self, places: dict[str, int]) -> TomlTable:
        """Return what the scene at a place along each dimension changes of the base."""
        return {key: values[places[dim]] for key, (_, dim, values) in self.columns.items()}

    def scene(self, changes: TomlTable) -> Scene:
        """Return the scene of some changes.

        Raises
        ------
        SceneError
            if there is no such scene, or it does not fit the others
        """
        table = self.table["base"]
        for key, value in changes.items():
            table = _changed(table, key.split("."), value)
        if (file := _profile_file(table)) in self.profiles:
            profile = {"kind": "table"} | self.profiles[file]
            table = _changed(table, ["punch", "profile"], profile)
        scene = Scene.from_table(table, _name_of(changes)).with_heights(*self.heights)
        self.check_labels(scene, changes)
        return scene

    def check_labels(self, scene: Scene, changes: TomlTable) -> None:
        """Refuse a scene of some changes that has not what all scenes share."""
        labels = _labels(scene)
        for key, column in self.shared.items():
            if not column.values or labels[key] != column:
                raise SceneError(
                    f"{_name_of(changes)}: not all scenes have the same {key}, over which "
                    f"something is kept: give the base {key} as numbers, or keep only what is not "
                    "over them"
                )

    def problem(self, changes: TomlTable) -> Problem:
        """Return the problem of some changes, asking for what is to be kept and nothing else."""
        quantities = (part for name in self.keep for part in ANSWERS.get(name, (name,)))
        return self.scene(changes).problem.with_quantities(frozenset(quantities))

    def part(self, region: dict[str, slice]) -> "Sweep":
        """Return a box of the grid, a slice of each dimension, as a sweep of its own."""
        columns = {
            key: Column(name, dim, values[region[dim]])
            for key, (name, dim, values) in self.columns.items()
        }
        return replace(self, table={"base": self.table["base"]}, columns=columns)


def _name_of(changes: TomlTable) -> str:
    return ", ".join(f"{key} = {value}" for key, value in changes.items())


def _labels(scene: Scene) -> dict[str, Column]:
    """Return what of a scene labels its results."""
    return {
        "methods": Column("solver", "solver", scene.methods),
        "wear.times": Column("time", "time", scene.wear.times),
        "output.radii": Column("radius", "radius", scene.output.radii or []),
    }


def _changed(table: TomlTable, path: list[str], value: object) -> TomlTable:
    """Return nested dictionaries with another value at a path; those given stay as they are."""
    key, *rest = path
    if rest:
        inner = table.get(key)
        if isinstance(inner, list):
            value = _with_entry(inner, rest, value)
        else:
            value = _changed(inner if isinstance(inner, dict) else {}, rest, value)
    return table | {key: value}


def _unread(source: str, error: OSError | ValueError) -> str:
    """Return why a sweep file cannot be read, and what to give."""
    there = (files("ringwear.studies") / "sweep" / "files").iterdir()
    names = sorted(file.name.removesuffix(".toml") for file in there)
    reason = str(error.strerror).lower() if isinstance(error, OSError) else str(error)
    near = nearest(source, names)
    meant = f"did you mean {near}? Else " if near else ""
    if source in bundled():
        reason, meant = "it is a scene", f"a scene is computed by `ringwear run {source}`; "
    return (
        f"{source} cannot be read as a sweep: {reason}; {meant}give a sweep file, TOML in UTF-8, "
        f"or one of {', '.join(names)}"
    )


def _with_entry(tables: list[TomlTable], path: list[str], value: object) -> list[TomlTable]:
    """Return a list of tables with another value at a path that begins with a number."""
    number, *rest = path
    if not number.isdigit() or int(number) >= len(tables) or not rest:
        raise SceneError(
            f"there is no {'.'.join(path)} in a list of {len(tables)} tables: they are numbered "
            "from 0 on"
        )
    changed = [*tables]
    changed[int(number)] = _changed(changed[int(number)], rest, value)
    return changed


def _profile_file(table: TomlTable) -> str:
    """Return the file that the profile of a scene's table is to be read from; empty if none."""
    punch = table.get("punch")
    profile = punch.get("profile") if isinstance(punch, dict) else None
    if not isinstance(profile, dict) or {"radii", "heights"} & profile.keys():
        return ""
    return str(profile.get("file", ""))


def _read_profiles(base: TomlTable, columns: dict[str, Column], folder: Path) -> TomlTable:
    """Return radii and heights of all files that profiles of a sweep are given by, by file.

    Files are sought in the folder of the sweep file, then where the command was given.
    """
    tables = [base]
    for key, column in columns.items():
        if key in ("punch", "punch.profile", "punch.profile.file"):
            tables += [_changed(base, key.split("."), value) for value in column.values]
    profiles: TomlTable = {}
    for file in dict.fromkeys(filter(None, map(_profile_file, tables))):
        in_folder = folder / file
        try:
            radii, heights = read_table(in_folder if in_folder.is_file() else Path(file))
        except ValueError as error:
            raise SceneError(f"punch.profile: {error}") from error
        profiles[file] = {"radii": radii, "heights": heights}
    return profiles


def _without_heights(base: TomlTable) -> tuple[TomlTable, tuple[Height, ...]]:
    """Return the base without the functions of its face, and these."""
    punch = base.get("punch")
    if not isinstance(punch, dict) or "heights" not in punch:
        return base, ()
    left = {key: value for key, value in punch.items() if key != "heights"}
    return base | {"punch": left}, tuple(punch["heights"])


def _checked_keep(
    keep: list[str] | None, problems: list[Problem], axes: Iterable[str]
) -> tuple[str, ...]:
    """Return the quantities to keep: those named, or by default those without radius and ring.

    The default holds if `keep` is None. Relaxation times are left out of it, too, if there are no
    times. A quantity that is an axis is never kept.

    Raises
    ------
    SceneError
        if `keep` is empty or names something that is no quantity of these scenes
    """
    given = set[str]().union(*map(_given, problems)) - set(axes)
    if keep is None:
        left_out = {"radius", "ring"} if len(problems[0].times) else {"radius", "ring", "mode"}
        return tuple(
            name for name in KEEPABLE if name in given and left_out.isdisjoint(KEEPABLE[name].dims)
        )
    computed = {of for of in KEEPABLE if not given.isdisjoint(ANSWERS.get(of, (of,)))}
    if not keep or not set(map(str, keep)) <= computed:
        strange = next((str(name) for name in keep if str(name) not in computed), "")
        raise SceneError(
            f"keep = {keep!r} names what is no quantity of such punches"
            f"{did_you_mean(strange, computed) if strange else ':'} give a list of "
            f"{', '.join(sorted(computed))}; histories need wear.times, and steady quantities "
            "wear.steady = true"
        )
    return tuple(dict.fromkeys(keep))


def _given(problem: Problem) -> frozenset[str]:
    """Return the quantities that a problem has."""
    return problem.with_quantities(GROUPS["all"]).quantities or frozenset()
