"""Read a sweep: a base scene, the quantities to keep, and axes of scene keys.

Each scene is one point of a labelled grid. A sweep file reads:

    base = "five_rings"                                    # a bundled scene, a file, or a table
    keep = ["steady_rms_slope", "relaxation_time"]         # default: all without radius and ring
    [axes]                                                 # all combinations of their values
    "punch.rings" = [2, 4, 8]
    "punch.wear_ratio" = { geomspace = [1e-4, 1e4, 81] }   # or linspace
    [zip]                                                  # vary together along one dimension
    [random]                                               # draws along one dimension, `draw`
    count = 1000
    seed = 1
    "punch.width_ratio" = { geomspace = [0.1, 10.0] }      # log-uniform; or linspace, or a list

A dimension is named after the last part of its key, or after the last two parts if that name is in
use.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import prod
from operator import attrgetter
from pathlib import Path
from types import UnionType
from typing import Self

from ...meshes import SceneError
from ..crosscheck import (
    ANSWER,
    GROUPS,
    LOG,
    QUANTITIES,
    Height,
    Problem,
    Scene,
    TomlTable,
    method,
    nearest,
    profile_of_file,
    shown,
    tables_of,
    text_of,
    unsuitable_methods,
    with_key,
    without_alternatives,
)
from .columns import Column, has_units, read_columns

# greatest number of scenes of one sweep
MOST_SCENES = 1_000_000_000
# greatest number of values of each axis that are checked before a sweep begins
MOST_TRIED = 200
# numbers of the answer, and the quantities from which they are computed
ANSWERS = {
    "indentation_start": ("indentation",),
    "indentation_steady": ("indentation",),
    "running_in_time": ("indentation",),
    "time_to_90": ("indentation", "time_to_90"),
    "time_to_99": ("indentation", "time_to_99"),
    "pressure_min": ("pressure", "steady_pressure"),
    "pressure_max": ("pressure", "steady_pressure"),
    "force_share": ("ring_force", "normal_force", "indentation", "steady_pressure"),
    "worn_volume": ("profile", "ring_worn_volume"),
    "force_start": ("normal_force",),
    "force_end": ("normal_force",),
    "time_to_half_force": ("normal_force",),
    "contact_radius_start": ("contact_radius", "pressure"),
    "pressure_peak_start": ("pressure",),
    "time_to_full_contact": ("contact_radius", "indentation"),
}
# numbers of the answer that refer to the last time
AT_LAST_TIME = ("worn_volume", "force_end")
# all quantities and numbers of the answer that a sweep can keep
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
    table : the sweep as nested dictionaries, with the base scene as a table. It determines the
        sweep completely, except for `heights`
    columns : values that vary, by scene key; columns along one dimension vary together
    keep : names of the quantities to keep
    shared : values that all scenes share, by scene key: the methods, and the times and radii of the
        quantities to keep
    heights : functions added to the face of each scene (`Scene.with_heights`), which a table cannot
        contain
    profiles : radii and heights of the profiles that scenes read from files, by file; no file is
        read a second time

    Raises
    ------
    SceneError
        from `load` and `of`; its message gives the key, the value and the remedy
    """

    table: TomlTable
    columns: dict[str, Column]
    keep: tuple[str, ...] = ()
    shared: dict[str, Column] = field(default_factory=dict)
    heights: tuple[Height, ...] = ()
    profiles: TomlTable = field(default_factory=dict)

    @classmethod
    def load(
        cls,
        source: str | Path,
        methods: list[str] | None = None,
        keep: list[str] | None = None,
    ) -> Self:
        """Read a sweep from a file, or a bundled sweep by its name.

        Parameters
        ----------
        source : file or name
        methods, keep : methods and quantities to keep, in place of those of the sweep
        """
        table = tables_of(text_of(source, "sweep"), str(source))
        table |= {} if keep is None else {"keep": keep}
        return cls.of(table, Path(source).parent, methods)

    @classmethod
    def of(
        cls, table: TomlTable, folder: Path | None = None, methods: list[str] | None = None
    ) -> Self:
        """Make a sweep from nested dictionaries.

        Up to `MOST_TRIED` values of each axis are checked, with the first values of the other axes.
        A scene with an invalid value that is not checked here fails later, with the reason.

        Parameters
        ----------
        table : the sweep as nested dictionaries
        folder : folder in which the files of the base scene and of profiles are sought first
        methods : methods in place of those of the base scene
        """
        kinds: dict[str, type | UnionType] = {"base": str | dict, "keep": list}
        kinds |= dict.fromkeys(("axes", "zip", "random", "profiles"), dict)
        for key, value in table.items():
            if not isinstance(value, kinds.get(key, ())):
                raise SceneError(
                    f"{key} = {shown(value)} is invalid: give base, keep (a list of quantities), "
                    "and tables [axes], [zip] and [random] of scene keys"
                )
        base = table.get("base")
        columns_by_key = {
            key: values for name in ("axes", "zip") for key, values in table.get(name, {}).items()
        }
        columns_by_key |= table.get("random", {})
        if base is None or not columns_by_key:
            raise SceneError(
                "missing key base, or nothing varies: give base, a file, a bundled scene or a "
                "table, and [axes], [zip] or [random]"
            )
        if isinstance(base, str):
            in_folder = (folder or Path()) / base
            base = Scene.load(in_folder if in_folder.is_file() else base).table()
        if "units" not in base and has_units(columns_by_key.items()):
            base = base | {"units": "SI"}
        if methods is not None:
            base = base | {"methods": methods}
        columns = read_columns(table, base)
        base, heights = _without_heights(without_alternatives(base, set(columns)))
        profiles = table.get("profiles") or _read_profiles(base, columns, folder or Path())
        table = table | {"base": base} | ({"profiles": profiles} if profiles else {})
        sweep = cls(table, columns, heights=heights, profiles=profiles)
        if sweep.count > MOST_SCENES:
            raise SceneError(
                f"{sweep.count} scenes are too many for one store: split the sweep along an axis "
                f"into several sweeps of at most {MOST_SCENES} scenes, each with its own directory"
            )
        start = dict.fromkeys(sweep.sizes, 0)
        tried_changes = [
            sweep.changes_at(start | {dim: place})
            for dim, size in sweep.sizes.items()
            for place in range(min(size, MOST_TRIED))
        ]
        scenes = [sweep.scene(changes) for changes in tried_changes]
        names = {column.name for column in columns.values()}
        keep = _quantities_to_keep(table.get("keep"), [scene.problem for scene in scenes], names)
        dims = {"solver"}.union(*(KEEPABLE[quantity].dims for quantity in keep))
        if set(AT_LAST_TIME) & set(keep) and "wear.times" not in columns:
            dims.add("time")
        labels = _labels(scenes[0])
        shared = {key: column for key, column in labels.items() if column.dim in dims}
        sweep = replace(sweep, keep=keep, shared=shared)
        # all scenes have the same methods: by default those that can solve every scene
        unsuitable = dict[str, str]()
        for scene, changes in zip(scenes, tried_changes, strict=True):
            sweep.check_labels(scene, changes)
            unsuitable |= unsuitable_methods(scene)
        chosen = [name for name in scenes[0].methods if name not in unsuitable]
        if not scenes[0].names_methods:
            LOG.info("   sweep  methods are not given: using %s", ", ".join(chosen))
        if unsuitable and chosen:
            for name, reason in unsuitable.items():
                LOG.warning("   sweep  %s is left out: %s", name, reason)
            base = base | {"methods": chosen}
            shared["methods"] = Column("solver", "solver", chosen)
        reduced = sweep.to_keep if "keep" in table else attrgetter("problem")
        _refuse_all(map(reduced, scenes), chosen or scenes[0].methods)
        return replace(sweep, table=table | {"base": base, "keep": list(keep)})

    @property
    def sizes(self) -> dict[str, int]:
        """Number of values along each dimension."""
        return {column.dim: len(column.values) for column in self.columns.values()}

    @property
    def count(self) -> int:
        """Number of scenes."""
        return prod(self.sizes.values())

    @cached_property
    def first(self) -> Scene:
        """The scene with the first value of every column."""
        return self.scene(next(self.changes()))

    def changes(self) -> Iterator[TomlTable]:
        """Yield the changes of each scene with respect to the base, in the order of the store."""
        for places in product(*map(range, self.sizes.values())):
            yield self.changes_at(dict(zip(self.sizes, places, strict=True)))

    def changes_at(self, places: dict[str, int]) -> TomlTable:
        """Return the changes of the scene at a place along each dimension."""
        return {key: values[places[dim]] for key, (_, dim, values) in self.columns.items()}

    def scene(self, changes: TomlTable) -> Scene:
        """Return the base scene with some changes.

        Raises
        ------
        SceneError
            if the changed scene is invalid, or if its methods, times or radii differ from
            those that all scenes share
        """
        table = self.table["base"]
        for key, value in changes.items():
            table = with_key(table, key, value)
        if (file := str(_profile_of_file(table).get("file"))) in self.profiles:
            profile = {"kind": "table"} | self.profiles[file]
            table = with_key(table, "punch.profile", profile)
        scene = Scene.from_table(table, _name_of(changes)).with_heights(*self.heights)
        self.check_labels(scene, changes)
        return scene

    def check_labels(self, scene: Scene, changes: TomlTable) -> None:
        """Raise an error if a changed scene has other labels than all scenes share (`shared`)."""
        labels = _labels(scene)
        for key, column in self.shared.items():
            if labels[key] != column and key == "methods":
                raise SceneError(
                    f"{_name_of(changes)}: not all scenes have the same methods: give the base all "
                    "of them, and no axis of methods"
                )
            if not column.values or labels[key] != column:
                raise SceneError(
                    f"{_name_of(changes)}: not all scenes have the same {key}, but a kept quantity "
                    f"depends on them: give the base {key} as numbers, or keep only quantities "
                    "that do not depend on them"
                )

    def problem(self, changes: TomlTable) -> Problem:
        """Return the problem of a changed scene, with only the quantities to keep."""
        return self.to_keep(self.scene(changes))

    def to_keep(self, scene: Scene) -> Problem:
        """Return the problem of a scene, with only the quantities to keep."""
        quantities = (quantity for name in self.keep for quantity in ANSWERS.get(name, (name,)))
        return scene.problem.with_quantities(frozenset(quantities))

    def part(self, region: dict[str, slice]) -> "Sweep":
        """Return the sweep of the scenes in a region of the grid: a slice of each dimension."""
        columns = {
            key: Column(name, dim, values[region[dim]])
            for key, (name, dim, values) in self.columns.items()
        }
        return replace(self, table={"base": self.table["base"]}, columns=columns)


def _name_of(changes: TomlTable) -> str:
    return ", ".join(f"{key} = {shown(value)}" for key, value in changes.items())


def _refuse_all(problems: Iterable[Problem], methods: Iterable[str]) -> None:
    """Raise an error if methods refuse all problems that are tried, as a run of each would.

    If they refuse only some, these scenes fail when they are computed.
    """
    solvers, reason = [method(name) for name in methods], ""
    for problem in problems:
        reasons = [solver.refusal(problem) for solver in solvers]
        if not any(reasons):
            return
        reason = reason or "; ".join(filter(None, reasons))
    raise SceneError(reason)


def _labels(scene: Scene) -> dict[str, Column]:
    """Return the methods, times and radii of a scene, which label its results."""
    return {
        "methods": Column("solver", "solver", scene.methods),
        "wear.times": Column("time", "time", scene.wear.times),
        "output.radii": Column("radius", "radius", scene.output.radii or []),
    }


def _profile_of_file(table: TomlTable) -> TomlTable:
    """Return the profile of a scene if it is read from a file; else an empty table."""
    punch = table.get("punch")
    profile = punch.get("profile") if isinstance(punch, dict) else None
    if not isinstance(profile, dict) or {"radii", "heights"} & profile.keys():
        return {}
    return profile if profile.get("file") else {}


def _read_profiles(base: TomlTable, columns: dict[str, Column], folder: Path) -> TomlTable:
    """Read the files of all profiles of a sweep; return their radii and heights by file.

    A file is sought first in the folder of the sweep file, then in the working directory.
    """
    tables, profiles = [base], TomlTable()
    for key, column in columns.items():
        if key in ("punch", "punch.profile", "punch.profile.file"):
            tables += [with_key(base, key, value) for value in column.values]
    for given in filter(None, map(_profile_of_file, tables)):
        file, in_folder = str(given["file"]), folder / str(given["file"])
        if file not in profiles:
            read = profile_of_file(given, in_folder if in_folder.is_file() else Path(file), base)
            profiles[file] = {key: read[key] for key in ("radii", "heights")}
    return profiles


def _without_heights(base: TomlTable) -> tuple[TomlTable, tuple[Height, ...]]:
    """Return the base without the functions of its face, and these functions."""
    punch = base.get("punch")
    if not isinstance(punch, dict) or "heights" not in punch:
        return base, ()
    other_keys = {key: value for key, value in punch.items() if key != "heights"}
    return base | {"punch": other_keys}, tuple(punch["heights"])


def _quantities_to_keep(
    keep: list[str] | None, problems: list[Problem], axes: Iterable[str]
) -> tuple[str, ...]:
    """Return the names of the quantities to keep.

    If `keep` is None, these are all quantities that do not depend on radius or ring; without times,
    relaxation times are left out, too. A quantity that is also an axis is never kept.

    Parameters
    ----------
    keep : names given by the user; None for the default
    problems : problems of the scenes that are checked
    axes : names of the columns of the sweep

    Raises
    ------
    SceneError
        if `keep` is empty, or if it names something that is not a quantity of these scenes
    """
    available = set[str]().union(*map(_quantities_of, problems)) - set(axes)
    if keep is None:
        left_out = {"radius", "ring"} if len(problems[0].times) else {"radius", "ring", "mode"}
        computed = available - frozenset.intersection(*(problem.known for problem in problems))
        return tuple(
            name
            for name in KEEPABLE
            if name in computed and left_out.isdisjoint(KEEPABLE[name].dims)
        )
    computable = {name for name in KEEPABLE if not available.isdisjoint(ANSWERS.get(name, (name,)))}
    unknown = [name for name in keep if str(name) not in computable]
    if unknown or not keep:
        wrong = "keep is empty"
        if unknown:
            wrong = f"keep has {', '.join(map(shown, unknown))}"
            wrong += ", no quantities of these scenes"
        nearest_names = (nearest(str(name), computable) for name in unknown)
        meant = ", ".join(f"'{name}'" for name in dict.fromkeys(nearest_names) if name)
        raise SceneError(
            f"{wrong}: {f'did you mean {meant}? Otherwise ' if meant else ''}give a list of "
            f"{', '.join(sorted(computable))}; histories need wear.times, and steady quantities "
            "wear.steady = true"
        )
    return tuple(dict.fromkeys(keep))


def _quantities_of(problem: Problem) -> frozenset[str]:
    """Return the names of all quantities of a problem."""
    return problem.with_quantities(GROUPS["all"]).quantities or frozenset()
