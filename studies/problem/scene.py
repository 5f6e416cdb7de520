"""The scene: a TOML file in, a frozen and validated value out.

Every key is declared here once, with its check and the remedy that an error message gives.
"""

from __future__ import annotations

import difflib
import tomllib
from functools import cached_property
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from ringwear.meshes.errors import SceneError
from ringwear.studies.problem.problem import NaturalScene

Method = Literal["mdr", "bem", "direct", "fem"]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class Section(BaseModel):
    """A table of the scene file: frozen, strictly typed, no unknown keys."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid")


class Punch(Section):
    radius: Positive = Field(description="the punch radius, a positive length")
    rings: int | None = Field(default=None, ge=1, le=100_000, description="the number of rings, 1 or more")
    width_ratio: Positive = Field(default=1.0, description="the width of even rings over that of odd rings, h2/h1")
    ring_edges: list[Positive] | None = Field(
        default=None, description="the outer radius of each ring, increasing, the last equal to punch.radius"
    )
    wear_coefficients: list[Positive] = Field(
        description="positive numbers: two, alternating from the centre, or one for each ring"
    )

    @model_validator(mode="after")
    def _rings_are_told_once(self) -> Self:
        if (self.rings is None) == (self.ring_edges is None):
            raise ValueError("give either rings (with width_ratio) or ring_edges, and not both")
        if self.ring_edges is not None:
            if "width_ratio" in self.model_fields_set:
                raise ValueError("width_ratio goes with rings; with ring_edges leave it out")
            if any(b <= a for a, b in pairwise(self.ring_edges)):
                raise ValueError(f"ring_edges = {self.ring_edges} must increase from ring to ring, without repeats")
            if not self.ring_edges or abs(self.ring_edges[-1] / self.radius - 1) > 1e-9:
                raise ValueError(f"ring_edges = {self.ring_edges} must end at punch.radius = {self.radius}")
        count = self.rings or len(self.ring_edges or [])
        given = len(self.wear_coefficients)
        if given not in (2, count):
            raise ValueError(
                f"wear_coefficients has {given} values for {count} rings: "
                f"give {count}, or two, which alternate from the centre"
            )
        return self


class HalfSpace(Section):
    plane_strain_modulus: Positive | None = Field(default=None, description="E* = E/(1 - nu^2), a positive pressure")
    youngs_modulus: Positive | None = Field(default=None, description="Young's modulus E, a positive pressure")
    poisson_ratio: float = Field(
        default=0.3, gt=-1, le=0.5, allow_inf_nan=False,
        description="a number above -1 and at most 0.5",
    )  # fmt: skip

    @model_validator(mode="after")
    def _one_modulus(self) -> Self:
        if (self.plane_strain_modulus is None) == (self.youngs_modulus is None):
            raise ValueError("give either plane_strain_modulus or youngs_modulus, and not both")
        return self


class Load(Section):
    normal_force: Positive | None = Field(default=None, description="the normal force F, positive")
    mean_pressure: Positive | None = Field(default=None, description="F / (pi a^2), positive")
    sliding_speed: Positive = Field(default=1.0, description="the sliding speed, positive")

    @model_validator(mode="after")
    def _one_load(self) -> Self:
        if (self.normal_force is None) == (self.mean_pressure is None):
            raise ValueError("give either normal_force or mean_pressure, and not both")
        return self


class Wear(Section):
    times: list[NotNegative] = Field(default=[], description="increasing times, 0 or later; none for no history")
    steady: bool = Field(default=True, description="true or false")
    march: Literal["modal", "implicit", "explicit"] = Field(default="modal", description="modal, implicit or explicit")
    step: Positive | None = Field(default=None, description="the time step of the implicit or explicit march")

    @model_validator(mode="after")
    def _times_and_steps(self) -> Self:
        if any(b <= a for a, b in pairwise(self.times)):
            raise ValueError("times must increase, without repeats")
        if self.march == "modal" and self.step is not None:
            raise ValueError("step goes with march = 'implicit' or 'explicit': the modal march has none")
        if self.march != "modal" and self.step is None and any(self.times):
            raise ValueError(f"march = '{self.march}' needs a step; march = 'modal' is exact in time and needs none")
        if not self.times and not self.steady:
            raise ValueError("nothing to compute: give times, or steady = true")
        return self


class FemAccuracy(Section):
    mesher: Literal["quads", "gmsh", "bisection"] | None = Field(
        default=None,
        description="quads (quadrilaterals; once called stars), gmsh or bisection (triangles of degree 2 to 4)",
    )
    far_field: Literal["boussinesq", "fixed"] = Field(default="boussinesq", description="boussinesq or fixed")
    poles: int | None = Field(default=None, ge=1, le=8, description="Boussinesq poles tied to the outer boundary, 1 to 8")
    truncation: float | None = Field(default=None, ge=2, le=1e6, description="radius of the half-space in a, 2 to 1e6")
    degree: int | None = Field(
        default=None,
        ge=2,
        le=12,
        description="degree of the displacement: 2 to 4 on triangles, 4 to 12 on quadrilaterals",
    )
    rim_size: float | None = Field(default=None, ge=1e-12, le=0.5, description="element size at the rim in a, 1e-12 to 0.5")
    ring_size: float | None = Field(
        default=None, ge=1e-12, le=0.5, description="element size at ring edges in a, 1e-12 to 0.5"
    )
    growth: float | None = Field(default=None, ge=0.05, le=2, description="growth of the size with distance, 0.05 to 2")

    @model_validator(mode="after")
    def _degree_goes_with_the_mesher(self) -> Self:
        if self.degree is not None and self.mesher is not None and (self.degree not in DEGREES[self.mesher]):
            lowest, highest = DEGREES[self.mesher][0], DEGREES[self.mesher][-1]
            raise ValueError(f"degree = {self.degree} does not go with mesher = '{self.mesher}': give {lowest} to {highest}")
        return self

    @property
    def meshed_by(self) -> str:
        """The mesher: the one asked for, or the one that goes with the other keys."""
        return self.mesher or ("quads" if self.degree is None or self.degree in DEGREES["quads"] else "gmsh")


# degrees of the displacement that each mesher's elements can have; on triangles alone the highest is the default
DEGREES = {"quads": range(4, 13), "gmsh": range(2, 5), "bisection": range(2, 5)}


class MdrAccuracy(Section):
    degree: int | None = Field(default=None, ge=1, le=16, description="highest degree of the pressure, 1 to 16")
    rim_size: float | None = Field(default=None, ge=1e-12, le=0.5, description="element size at the rim in a")
    ring_size: float | None = Field(default=None, ge=1e-12, le=0.5, description="element size at ring edges in a")
    grading: float | None = Field(default=None, ge=0.05, le=0.8, description="ratio of neighbouring sizes, 0.05 to 0.8")
    grid: int = Field(default=400, ge=4, le=20_000, description="points of the uniform grid of the explicit march")


class Accuracy(Section):
    rtol: float = Field(default=1e-4, ge=1e-9, le=0.1, description="the relative accuracy wanted, 1e-9 to 0.1")
    fem: FemAccuracy = FemAccuracy()
    mdr: MdrAccuracy = MdrAccuracy()

    def gives_sizes(self, method: str) -> bool:
        """Whether the user has given sizes or degrees for a method, which then stay as they are."""
        chosen = self.fem if method == "fem" else self.mdr
        return bool(chosen.model_fields_set & {"rim_size", "ring_size", "growth", "grading", "degree"})


class Output(Section):
    radii: list[NotNegative] | None = Field(default=None, description="radii from 0 to punch.radius, increasing")
    field_times: list[NotNegative] | None = Field(
        default=None, description="times at which the inside of the half-space is written, increasing"
    )
    gradient_average: Literal["line", "area"] = Field(default="line", description="line or area")


class Scene(Section):
    """A complete, validated scene; see the README for the keys.

    Raises
    ------
    SceneError
        from `load` and `from_toml`, naming the key, the value and the remedy
    """

    title: str = Field(default="", description="a line of text")
    units: str = Field(default="", description="a line of text: the consistent units of the numbers, for labels only")
    methods: list[Method] = Field(
        default=["mdr", "direct", "fem"], min_length=1, description="a list of 'mdr', 'bem', 'direct', 'fem'"
    )
    punch: Punch
    half_space: HalfSpace
    load_: Load = Field(alias="load", description="a table")
    wear: Wear = Wear()
    accuracy: Accuracy = Accuracy()
    output: Output = Output()

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(set(self.methods)) < len(self.methods):
            raise ValueError(f"methods = {self.methods} names a method twice")
        radii = self.output.radii
        if radii is not None:
            if any(b <= a for a, b in pairwise(radii)) or not radii:
                raise ValueError("output.radii must increase, without repeats")
            if radii[-1] > self.punch.radius:
                raise ValueError(f"output.radii ends at {radii[-1]}, outside the punch of radius {self.punch.radius}")
        return self

    @classmethod
    def load(cls, source: str | Path) -> Scene:
        """Read a scene from a file, or a bundled one by its name."""
        path = Path(source)
        if not path.exists() and str(source) in bundled():
            return cls.from_toml((files("ringwear.studies") / "scenes" / f"{source}.toml").read_text("utf-8"), str(source))
        if path.is_dir():
            raise SceneError(f"{source} is a directory: give a scene file, or one of {', '.join(bundled())}")
        try:
            text = path.read_text("utf-8")
        except FileNotFoundError:
            raise SceneError(f"{source}: no such file, and no bundled scene ({', '.join(bundled())})") from None
        except UnicodeDecodeError:
            raise SceneError(f"{source} is not a text file: a scene is TOML in UTF-8") from None
        except OSError as error:
            raise SceneError(f"{source} cannot be read: {error.strerror}") from error
        return cls.from_toml(text, str(source))

    @classmethod
    def from_toml(cls, text: str, name: str = "scene") -> Scene:
        """Read a scene from TOML text; `name` is for messages."""
        try:
            table = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise SceneError(f"{name} is not TOML: {error}") from error
        return cls.from_table(table, name)

    @classmethod
    def from_table(cls, table: dict[str, Any], name: str = "scene") -> Scene:
        """Read a scene from nested dictionaries."""
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise SceneError(f"{name}: {_explain(error)}") from None

    def table(self) -> dict[str, Any]:
        """The scene as nested dictionaries, as `from_table` takes them."""
        return self.model_dump(by_alias=True, exclude_none=True, exclude_unset=True)

    def to_toml(self) -> str:
        """The scene as TOML."""
        return tomli_w.dumps(self.table())

    def changed(self, **changes: Any) -> Scene:
        """The same scene with some keys changed, named with double underscores: ``accuracy__rtol=1e-6``."""
        table = self.table()
        for name, value in changes.items():
            *path, key = name.split("__")
            part = table
            for step in path:
                part = part.setdefault(step, {})
            part[key] = value
        return Scene.from_table(table)

    @cached_property
    def natural(self) -> NaturalScene:
        """What the methods are given: geometry, wear and times in natural units."""
        return NaturalScene(self)


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
    section, field = _declaration(location)
    if first["type"] == "extra_forbidden":
        known = [info.alias or name for name, info in section.model_fields.items()]
        close = difflib.get_close_matches(location[-1], known, 1, 0.0)
        return f"unknown key {key}: did you mean {close[0]}? known here are {', '.join(known)}"
    remedy = f"; give {field.description}" if field is not None and field.description else ""
    if first["type"] == "missing":
        return f"missing key {key}{remedy}"
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "value_error":
        return f"{key}: {message}" if key else message
    return f"{key} = {first['input']!r}: {message[0].lower()}{message[1:]}{remedy}"


def _declaration(location: list[str]) -> tuple[type[Section], Any]:
    """The section that a location lies in, and its field if it is known."""
    section: type[Section] = Scene
    field = None
    for part in location:
        names = {info.alias or name: info for name, info in section.model_fields.items()}
        if part not in names:
            break
        field = names[part]
        if isinstance(field.annotation, type) and issubclass(field.annotation, Section):
            section = field.annotation
    return section, field
