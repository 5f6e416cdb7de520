"""The scene.

A TOML file in, a frozen and validated value out, and the non-dimensional problem that it poses.
"""

import difflib
import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from importlib.resources import files
from itertools import pairwise
from math import isnan
from pathlib import Path
from typing import Annotated, Self, TypeVar, get_args

import tomli_w
from pydantic import AfterValidator, Field, ValidationError, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from ...meshes.errors import SceneError
from ..registry import METHODS
from .fields import KINDS, Height, Section, TomlTable, refuse_device
from .not_modelled import kind_instead, not_modelled
from .problem import Problem
from .punch import PunchSection
from .sections import (
    AccuracySection,
    HalfSpaceSection,
    LoadSection,
    OutputSection,
    WearSection,
)
from .unit_names import without_quantities

# least likeness of an unknown key to the one that it is taken for
ALIKE = 0.6


def check_method(method: str) -> str:
    """Refuse a method that nobody has registered."""
    if method not in METHODS:
        near = difflib.get_close_matches(method.lower(), METHODS, 1, ALIKE)
        meant = f": did you mean '{near[0]}'?" if near else ""
        raise ValueError(f"no method '{method}'{meant}")
    return method


class Scene(Section):
    """A complete, validated scene.

    A frozen value, made by `load`, `from_toml` or `from_table`, or of its tables, varied by
    `changed`.

    The tables `punch`, `half_space` and `load` are needed; `studies/reference.md` has all keys.
    Numbers are in any consistent units, and any may be a quantity with its own, ``"20 mm"``.

    Raises
    ------
    SceneError
        naming the key, the value and the remedy

    Examples
    --------
    >>> scene = Scene(
    ...     punch={"radius": "5 mm", "rings": 2, "wear_coefficients": [1e-14, "1e-4 mm^3/(N m)"]},
    ...     half_space={"youngs_modulus": "2 GPa"},
    ...     load={"normal_force": "100 N", "sliding_speed": 0.1},
    ... )
    >>> scene.units, scene.punch.radius, scene.half_space.youngs_modulus
    ('SI', 0.005, 2000000000.0)
    """

    title: str = ""
    units: str = Field(
        default="",
        description="'SI', or consistent units of length, force, pressure and time, such as "
        "'mm, N, MPa, s'",
    )
    methods: list[Annotated[str, AfterValidator(check_method)]] = Field(
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

    def __init__(self, /, *misplaced: object, **table: object) -> None:
        if misplaced:
            raise SceneError(
                f"Scene({misplaced[0]!r}): give sections by their names, Scene(punch={{...}}, "
                "...), or Scene.load of a file or of a bundled name"
            )
        table = without_quantities(table, type(self))
        try:
            super().__init__(**table)
        except ValidationError as error:
            raise SceneError(explain(error)) from None
        if self.wear.tau is not None:
            # counts of the slowest relaxation time, which the scene says, become times
            super().__init__(**table | {"wear": self._at_counts(self.wear.tau)})

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(set(self.methods)) < len(self.methods):
            raise ValueError(f"methods = {self.methods} names a method twice")
        radii, punch = self.output.radii, self.punch
        if punch.inner_radius and self.half_space.layers:
            raise ValueError(
                "punch.inner_radius does not go with half_space.layers, on which the start of a "
                "hollow punch is not solved: leave out either"
            )
        if radii is not None and radii[-1] > punch.radius:
            raise ValueError(
                f"output.radii ends at {radii[-1]}, outside the punch of radius {punch.radius}"
            )
        if radii is not None and radii[0] < punch.inner_radius:
            raise ValueError(
                f"output.radii begins at {radii[0]}, within the hole of radius {punch.inner_radius}"
            )
        return self

    @classmethod
    def load(cls, source: str | Path) -> "Scene":
        """Read a scene from a file, or a bundled one by its name."""
        return cls.from_toml(text_of(source), str(source), Path(source).parent)

    @classmethod
    def of(
        cls,
        source: "Source",
        methods: Sequence[str] | str | None = None,
        rtol: float | None = None,
        quantities: Sequence[str] | str | None = None,
    ) -> "Scene":
        """Return a scene that is given itself, by a file or a bundled name, or as dictionaries.

        Methods, accuracy and quantities, where given, take the place of its own.
        """
        scene = source
        if not isinstance(scene, Scene):
            scene = cls.from_table(dict(scene)) if isinstance(scene, Mapping) else cls.load(scene)
        names = {"methods": methods, "output__quantities": quantities}
        changes: dict[str, object] = {
            key: listed(of) for key, of in names.items() if of is not None
        }
        if rtol is not None:
            changes["accuracy__rtol"] = float(rtol)
        return scene.changed(**changes) if changes else scene

    @classmethod
    def from_toml(cls, text: str, name: str = "scene", folder: Path | None = None) -> "Scene":
        """Read a scene from TOML text.

        `name` is for messages, files that it names are sought in `folder`.
        """
        try:
            table = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise SceneError(f"{name} is not TOML: {error}") from error
        # without a folder or a file of a profile there is nothing to seek
        with suppress(KeyError, TypeError):
            profile = table["punch"]["profile"]
            profile["file"] = str(folder / profile["file"])
        return cls.from_table(table, name)

    @classmethod
    def from_table(cls, table: TomlTable, name: str = "scene") -> "Scene":
        """Read a scene from nested dictionaries."""
        try:
            return cls(**table)
        except SceneError as error:
            raise SceneError(f"{name}: {error}") from None

    def _at_counts(self, counts: list[float]) -> WearSection:
        """Return the times at counts of the slowest relaxation time, to three digits."""
        from ..wear.time_scale import running_in

        exact = (running_in(self.problem, counts) * self.problem.units.time).tolist()
        if self.problem.loading.varies or isnan(exact[-1]):
            raise SceneError(
                "wear.times by running-in is known for one force, one sliding speed and up to 64 "
                "rings: give times as numbers"
            )
        times = [float(f"{time:.3g}") for time in exact]
        if any(after <= before for before, after in pairwise(times)):
            times = exact
        return self.wear.model_copy(update={"times": times})

    def table(self) -> TomlTable:
        """Return the scene as nested dictionaries, as `from_table` takes them."""
        table = self.model_dump(by_alias=True, exclude_none=True, exclude_unset=True)
        if self.wear.tau is not None:
            table["wear"]["times"] = {"tau": self.wear.tau}
        return table

    def to_toml(self) -> str:
        """Return the scene as TOML."""
        return tomli_w.dumps(self.table())

    def changed(self, keys: Mapping[str, object] | None = None, /, **changes: object) -> "Scene":
        """Return the scene with some keys changed.

        Parameters
        ----------
        keys : values by names with dots, as sweeps have them: ``{"accuracy.rtol": 1e-6}``
        changes : values by names with double underscores: ``accuracy__rtol=1e-6``

        Raises
        ------
        SceneError
            if the scene cannot be so, naming the key and the remedy
        """
        table = self.table()
        for key, value in (keys or {}).items():
            set_key(table, key.split("."), value)
        for name, value in changes.items():
            set_key(table, name.split("__"), value)
        return Scene.from_table(table).with_heights(*self.punch.heights, kinks=self.punch.kinks)

    def with_heights(self, *heights: Height, kinks: Sequence[float] | None = None) -> "Scene":
        """Return the scene with functions added to the unworn face.

        A file cannot hold them: `to_toml` leaves them out.

        Parameters
        ----------
        *heights : callables
            Heights by arrays of radii, both in the scene's units.
        kinks : sequence of float, optional
            Radii at which the slope or the bend of a function jumps, in the scene's units: cells
            end there. If none are given, they are sought; an empty list says that there are none.

        Raises
        ------
        SceneError
            if a kink lies outside the punch
        """
        if not heights:
            return self
        table = self.table()
        table["punch"]["heights"] = list(heights)
        if kinks is not None:
            table["punch"]["kinks"] = [float(kink) for kink in kinks]
        return Scene(**table)

    @cached_property
    def problem(self) -> Problem:
        """What the methods are given: geometry, wear and times, non-dimensional."""
        return Problem.from_tables(
            self.punch, self.half_space, self.load_, self.wear, self.accuracy, self.output
        )


Entry = TypeVar("Entry")
Source = Scene | str | Path | Mapping[str, object]


def listed(names: Sequence[Entry] | str) -> list[Entry | str]:
    """Return names as a list; in a text they may be separated by commas."""
    return [*(names.replace(",", " ").split() if isinstance(names, str) else names)]


def text_of(source: str | Path) -> str:
    """Return the TOML of a scene file, or of a bundled scene by its name."""
    path = Path(source)
    if not path.exists() and str(source) in bundled():
        path = Path(str(files("ringwear.studies"))) / "scenes" / f"{source}.toml"
    try:
        refuse_device(path)
        return path.read_text("utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError(f"{source} is not a text file: a scene is TOML in UTF-8") from None
    except ValueError as error:
        raise SceneError(f"{error} that holds a scene") from None
    except OSError as error:
        alike = difflib.get_close_matches(str(source), bundled(), 1)
        meant = f"did you mean {alike[0]}? Else " if alike else ""
        raise SceneError(
            f"{source}: {str(error.strerror).lower()}; {meant}give a scene file, or one of "
            f"{', '.join(bundled())}"
        ) from None


def set_key(table: TomlTable, path: Sequence[str], value: object) -> None:
    """Set a key of nested dictionaries by its path; tables on the way are made."""
    *sections, key = path
    for section in sections:
        if isinstance(table, list):
            # one of a list of tables, by its number
            if not section.isdigit() or int(section) >= len(table):
                raise SceneError(
                    f"{'.'.join(path)}: the scene has no such table; there are {len(table)}, "
                    "numbered from 0 on"
                )
            table = table[int(section)]
        else:
            table = table.setdefault(section, {})
    table[key] = value


def bundled() -> list[str]:
    """Return the names of the scenes that come with ringwear."""
    names = (entry.name for entry in (files("ringwear.studies") / "scenes").iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def explain(error: ValidationError) -> str:
    """Return one line for the first problem: the key, the value, what is wrong, and the remedy."""
    errors = error.errors(include_url=False)
    # a misspelt key also leaves its right name missing: tell the misspelling first
    first = min(errors, key=lambda item: item["type"] != "extra_forbidden")
    section, field = declaration([str(part) for part in first["loc"]])
    key = key_of(first)
    remedy = f"; give {field.description}" if field is not None and field.description else ""
    if first["type"] == "extra_forbidden":
        if (instead := not_modelled(str(first["loc"][-1]))) is not None:
            return f"unknown key {key}: {instead}"
        names = [info.alias or name for name, info in section.model_fields.items()]
        guess = _guess(str(first["loc"][-1]), names)
        return f"unknown key {key}: {guess}the keys here are {', '.join(names)}"
    if first["type"] == "missing":
        missing = [key_of(item) for item in errors if item["type"] == "missing"]
        keys = f" {key}{remedy}" if len(missing) == 1 else f"s {', '.join(missing)}"
        return (
            f"missing key{keys}; needed are, for example, punch = {{ radius = 1.0, rings = 5, "
            "wear_coefficients = [1.0, 10.0] }, half_space = { plane_strain_modulus = 1.0 }, load "
            "= { normal_force = 2.0 }, and wear = { times = [0.0, 0.1, 1.0] } for a history"
        )
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "value_error":
        # what is wrong with a table says its remedy itself
        remedy = "" if isinstance(first["input"], Mapping) else remedy
        return f"{key}: {message}{remedy}" if key else message
    if first["type"].startswith("union_tag"):
        return f"{key}.kind: {kind_instead(first['input']) or message}{remedy}"
    return f"{key} = {first['input']!r}: {message[0].lower()}{message[1:]}{remedy}"


def _guess(unknown: str, names: list[str]) -> str:
    """Return what an unknown key may stand for, of the keys at its place or of another table."""
    tables = {
        info.alias or name: names_of
        for name, info in Scene.model_fields.items()
        if (names_of := getattr(info.annotation, "model_fields", None))
    }
    for table, others in tables.items():
        if unknown in others and unknown not in names:
            return f"did you mean {table}.{unknown}? Else "
    if near := difflib.get_close_matches(unknown, names, 1, ALIKE):
        return f"did you mean {near[0]}? Else "
    for table, others in tables.items():
        if near := difflib.get_close_matches(unknown, others, 1, ALIKE):
            return f"did you mean {table}.{near[0]}? Else "
    return ""


def key_of(error: ErrorDetails) -> str:
    """Return the key that an error is about, as it is written: without the kind of a profile."""
    return ".".join(str(part) for part in error["loc"] if part not in KINDS)


def declaration(location: Sequence[str]) -> tuple[type[Section], FieldInfo | None]:
    """Return the section that a location lies in, and the field of its innermost known key."""
    section: type[Section] = Scene
    field = None
    for part in location:
        if part in KINDS:
            section = KINDS[part]
            continue
        names = {info.alias or name: info for name, info in section.model_fields.items()}
        if part.isdigit():  # one of a list of tables
            continue
        if part not in names:  # such as the number of a value in a list
            break
        field = names[part]
        # a table that may be left out has `None` beside its own type
        for kind in (field.annotation, *get_args(field.annotation)):
            if isinstance(kind, type) and issubclass(kind, Section):
                section = kind
    return section, field
