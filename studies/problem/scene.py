"""The scene.

A TOML file in, a frozen and validated value out, and the non-dimensional problem that it poses.
"""

import difflib
import tomllib
from collections.abc import Callable
from functools import cached_property
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Self, get_args

import tomli_w
from pydantic import AfterValidator, Field, PrivateAttr, ValidationError, model_validator

from ...meshes.errors import SceneError
from ..registry import METHODS
from .problem import Problem
from .sections import (
    AccuracySection,
    HalfSpaceSection,
    LoadSection,
    OutputSection,
    PunchSection,
    Section,
    WearSection,
    increasing,
)

# counts of the slowest relaxation time that ``times = "running-in"`` stands for
RUNNING_IN = [0.0, 0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0]

ONLY_FLAT = (
    "wear.times by running-in is known for flat punches under a force: give times as numbers"
)
# the keys that no scene can be without
EXAMPLE = (
    "punch = { radius = 1.0, rings = 5, wear_coefficients = [1.0, 10.0] }, half_space = { "
    "plane_strain_modulus = 1.0 }, "
    "load = { normal_force = 2.0 }, and wear = { times = [0.0, 0.1, 1.0] } for a history"
)


def _known(method: str) -> str:
    if method not in METHODS:
        raise ValueError(f"no method '{method}'; give some of {', '.join(METHODS)}")
    return method


class Scene(Section):
    """A complete, validated scene.

    A frozen value, made by `load`, `from_toml` or `from_table`, varied by `changed`.

    The tables `punch`, `half_space` and `load` are needed; the README has all keys. Numbers are in
    any consistent units.

    Raises
    ------
    SceneError
        from `load` and `from_toml`, naming the key, the value and the remedy
    """

    title: str = Field(default="", description="a line of text")
    units: str = Field(
        default="",
        description="a line of text: the consistent units of the numbers, for labels only",
    )
    methods: list[Annotated[str, AfterValidator(_known)]] = Field(
        default=["mdr", "direct", "fem"],
        min_length=1,
        description=f"a list of {', '.join(METHODS)}",
    )
    punch: PunchSection
    half_space: HalfSpaceSection
    load_: LoadSection = Field(alias="load", description="a table")
    wear: WearSection = WearSection()
    accuracy: AccuracySection = AccuracySection()
    output: OutputSection = OutputSection()
    # times asked for as counts of the slowest relaxation time, if they are
    _counts: list[float] | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(set(self.methods)) < len(self.methods):
            raise ValueError(f"methods = {self.methods} names a method twice")
        radii = self.output.radii
        if radii is not None:
            if not radii:
                raise ValueError("output.radii is empty: leave it out, or give radii")
            increasing("output.radii", radii)
            if radii[-1] > self.punch.radius:
                raise ValueError(
                    f"output.radii ends at {radii[-1]}, outside the punch of radius "
                    f"{self.punch.radius}"
                )
        return self

    @classmethod
    def load(cls, source: str | Path) -> "Scene":
        """Read a scene from a file, or a bundled one by its name."""
        path = Path(source)
        if not path.exists() and str(source) in bundled():
            return cls.from_toml(
                (files("ringwear.studies") / "scenes" / f"{source}.toml").read_text("utf-8"),
                str(source),
            )
        if path.is_dir():
            raise SceneError(
                f"{source} is a directory: give a scene file, or one of {', '.join(bundled())}"
            )
        try:
            text = path.read_text("utf-8")
        except FileNotFoundError:
            raise SceneError(
                f"{source}: no such file, and no bundled scene ({', '.join(bundled())})"
            ) from None
        except UnicodeDecodeError:
            raise SceneError(f"{source} is not a text file: a scene is TOML in UTF-8") from None
        except OSError as error:
            raise SceneError(f"{source} cannot be read: {error.strerror}") from error
        return cls.from_toml(text, str(source), path.parent)

    @classmethod
    def from_toml(cls, text: str, name: str = "scene", folder: Path | None = None) -> "Scene":
        """Read a scene from TOML text.

        `name` is for messages, files that it names are sought in `folder`.
        """
        try:
            table = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise SceneError(f"{name} is not TOML: {error}") from error
        punch = table.get("punch")
        profile = punch.get("profile") if isinstance(punch, dict) else None
        if (
            folder is not None
            and isinstance(profile, dict)
            and isinstance(profile.get("file"), str)
        ):
            profile["file"] = str(folder / profile["file"])
        return cls.from_table(table, name)

    @classmethod
    def from_table(cls, table: dict[str, Any], name: str = "scene") -> "Scene":
        """Read a scene from nested dictionaries."""
        table, counts = _without_counts(table)
        try:
            scene = cls.model_validate(table)
        except ValidationError as error:
            raise SceneError(f"{name}: {_explain(error)}") from None
        return scene if counts is None else scene._timed(counts, name)

    def _timed(self, counts: list[float], name: str) -> "Scene":
        """The scene at counts of its slowest relaxation time, to three digits."""
        from .time_scale import MOST_RINGS, slowest_relaxation_time

        problem = self._posed()
        if not problem.full_contact:
            raise SceneError(f"{name}: {ONLY_FLAT}")
        scale = slowest_relaxation_time(problem.rings) * problem.units.time
        if scale != scale:
            raise SceneError(
                f"{name}: wear.times by running-in is known for up to {MOST_RINGS} rings: give "
                "times as numbers"
            )
        times = [float(f"{count * scale:.3g}") for count in counts]
        if any(b <= a for a, b in pairwise(times)):
            times = [count * scale for count in counts]
        timed = self.model_copy(update={"wear": self.wear.model_copy(update={"times": times})})
        timed._counts = counts
        return timed

    def table(self) -> dict[str, Any]:
        """The scene as nested dictionaries, as `from_table` takes them."""
        table = self.model_dump(by_alias=True, exclude_none=True, exclude_unset=True)
        return (
            table
            if self._counts is None
            else table | {"wear": table["wear"] | {"times": {"tau": self._counts}}}
        )

    def to_toml(self) -> str:
        """The scene as TOML."""
        return tomli_w.dumps(self.table())

    def changed(self, **changes: Any) -> "Scene":
        """The same scene with some keys changed, named with double underscores.

        ``accuracy__rtol=1e-6``.
        """
        table = self.table()
        for name, value in changes.items():
            *path, key = name.split("__")
            part = table
            for step in path:
                part = part.setdefault(step, {})
            part[key] = value
        return Scene.from_table(table).with_heights(*self.punch.heights)

    def with_heights(self, *heights: Callable[[Any], Any]) -> "Scene":
        """The same scene with functions added to the unworn face.

        Heights by arrays of radii, in the scene's units.

        A file cannot hold them: `to_toml` leaves them out.

        Raises
        ------
        SceneError
            if times were asked for as counts of the relaxation time, which is that of a flat punch
        """
        if not heights:
            return self
        if self._counts is not None:
            raise SceneError(ONLY_FLAT)
        changed = self.model_copy(
            update={"punch": self.punch.model_copy(update={"heights": heights})}
        )
        # a copy keeps what was cached
        changed.__dict__.pop("problem", None)
        return changed

    @cached_property
    def problem(self) -> Problem:
        """What the methods are given: geometry, wear and times, non-dimensional."""
        return self._posed()

    def _posed(self) -> Problem:
        return Problem.posed(
            self.punch, self.half_space, self.load_, self.wear, self.accuracy, self.output
        )


def _without_counts(table: dict[str, Any]) -> tuple[dict[str, Any], list[float] | None]:
    """A table whose times are numbers, and the counts of relaxation times that they were asked for
    as.
    """
    wear = table.get("wear")
    times = wear.get("times") if isinstance(wear, dict) else None
    if not isinstance(wear, dict) or not isinstance(times, str | dict):
        return table, None
    if times == "running-in":
        counts: Any = RUNNING_IN
    elif isinstance(times, dict) and set(times) == {"tau"}:
        counts = times["tau"]
    else:
        # the check of the key says what it may be
        return table, None
    # what they are counts of is known when the rest is: until then they are checked as they are
    return table | {"wear": wear | {"times": counts}}, counts


def bundled() -> list[str]:
    """Names of the scenes that come with ringwear."""
    names = (entry.name for entry in (files("ringwear.studies") / "scenes").iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def _explain(error: ValidationError) -> str:
    """One line for the first problem: the key, the value, what is wrong, and the remedy."""
    # a misspelt key also leaves its right name missing: tell the misspelling first
    first = min(error.errors(include_url=False), key=lambda item: item["type"] != "extra_forbidden")
    location = [str(part) for part in first["loc"]]
    key = ".".join(location)
    section, field = declaration(location)
    if first["type"] == "extra_forbidden":
        known = [info.alias or name for name, info in section.model_fields.items()]
        close = difflib.get_close_matches(location[-1], known, 1, 0.0)
        return f"unknown key {key}: did you mean {close[0]}? known here are {', '.join(known)}"
    remedy = f"; give {field.description}" if field is not None and field.description else ""
    if first["type"] == "missing":
        missing = [
            ".".join(map(str, one["loc"]))
            for one in error.errors(include_url=False)
            if one["type"] == "missing"
        ]
        keys = (
            f"missing key {key}{remedy}"
            if len(missing) == 1
            else f"missing keys {', '.join(missing)}"
        )
        return f"{keys}; needed are, for example, {EXAMPLE}"
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "value_error":
        return f"{key}: {message}" if key else message
    return f"{key} = {first['input']!r}: {message[0].lower()}{message[1:]}{remedy}"


def declaration(location: list[str]) -> tuple[type[Section], Any]:
    """The section that a location lies in, and its field if it is known."""
    section: type[Section] = Scene
    field = None
    for part in location:
        names = {info.alias or name: info for name, info in section.model_fields.items()}
        if part not in names:
            break
        field = names[part]
        # a table that may be left out has `None` beside its own type
        for kind in (field.annotation, *get_args(field.annotation)):
            if isinstance(kind, type) and issubclass(kind, Section):
                section = kind
    return section, field
