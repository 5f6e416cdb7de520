"""The tables of the scene file.

Every key declared once, with its check and the remedy that an error message gives.
"""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

# beyond them squares and products of a few of them leave the range of double precision
SMALLEST, LARGEST = 1e-40, 1e40


def _computable(value: float) -> float:
    if not SMALLEST <= value <= LARGEST:
        raise ValueError(
            f"{value} is beyond {SMALLEST:.0e} to {LARGEST:.0e}, the range that can be computed "
            "with: "
            "give it in other units"
        )
    return value


Positive = Annotated[float, Field(gt=0, allow_inf_nan=False), AfterValidator(_computable)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Size = Annotated[float, Field(ge=1e-12, le=0.5)]
# degrees of the displacement that each mesher's elements can have; on triangles alone the highest
# is the default
DEGREES = {"quads": range(4, 17), "gmsh": range(2, 5), "bisection": range(2, 5)}


class Section(BaseModel):
    """A table of the scene file: frozen, strictly typed, no unknown keys."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid")

    def _has_one_of(self, one: str, other: str) -> None:
        if (getattr(self, one) is None) == (getattr(self, other) is None):
            raise ValueError(f"give either {one} or {other}, and not both")


def increasing(key: str, values: list[float]) -> None:
    """Refuse values that do not increase."""
    if any(b <= a for a, b in pairwise(values)):
        raise ValueError(f"{key} = {values} must increase, without repeats")


# keys that each kind of profile needs
PROFILES = {
    "parabola": ("curvature_radius",),
    "cone": ("slope",),
    "power": ("coefficient", "exponent"),
    "rounded_rim": ("flat_radius", "curvature_radius"),
    "table": ("radii", "heights"),
}


class ProfileSection(Section):
    """Heights of the unworn face over the radius: material that is missing."""

    kind: Literal["parabola", "cone", "power", "rounded_rim", "table"] = Field(
        description=f"one of {', '.join(PROFILES)}"
    )
    curvature_radius: Positive | None = Field(
        default=None, description="the radius of curvature R, a positive length"
    )
    slope: Positive | None = Field(default=None, description="the slope of a cone, positive")
    coefficient: Positive | None = Field(
        default=None, description="the height at the rim of f = c (r/a)^n, positive"
    )
    exponent: Positive | None = Field(
        default=None, description="the exponent n of f = c (r/a)^n, positive"
    )
    flat_radius: NotNegative | None = Field(
        default=None, description="the radius b inside which the face is flat"
    )
    file: str | None = Field(
        default=None, description="a file of two columns, radius and height, separated by a comma"
    )
    radii: list[NotNegative] | None = Field(
        default=None, description="increasing radii from 0 to punch.radius"
    )
    heights: list[NotNegative] | None = Field(
        default=None, description="a height, 0 or more, for each of the radii"
    )

    @model_validator(mode="before")
    @classmethod
    def _file_is_read(cls, table: Any) -> Any:
        """The scene keeps the numbers: it is complete without the file."""
        if not (
            isinstance(table, dict)
            and table.get("kind") == "table"
            and isinstance(table.get("file"), str)
        ):
            return table
        if "radii" in table or "heights" in table:
            raise ValueError("give either file, or radii and heights, and not both")
        radii, heights = read_table(table["file"])
        return {"kind": "table", "radii": radii, "heights": heights}

    @model_validator(mode="after")
    def _goes_with_its_kind(self) -> Self:
        needed = PROFILES[self.kind]
        for name in type(self).model_fields:
            given = getattr(self, name) is not None
            if name in needed and not given:
                raise ValueError(
                    f"kind = '{self.kind}' needs {' and '.join(needed)}"
                    + (", or file" if name == "radii" else "")
                )
            if name not in ("kind", *needed) and given:
                raise ValueError(
                    f"{name} does not go with kind = '{self.kind}', which takes "
                    f"{' and '.join(needed)}"
                )
        if self.radii is not None and self.heights is not None:
            if len(self.radii) != len(self.heights) or len(self.radii) < 2:
                raise ValueError(
                    "a table needs as many heights as radii, two or more; nan is no height"
                )
            if any(b <= a for a, b in pairwise(self.radii)):
                raise ValueError(
                    "radii must increase, without repeats; a step of the face is a ring edge with "
                    "a recess"
                )
        return self


def read_table(name: str) -> tuple[list[float], list[float]]:
    """Two columns of numbers; a line that begins with no number is a heading."""
    try:
        lines = [line for line in Path(name).read_text("utf-8").splitlines() if line.strip()]
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(
            f"file = '{name}' cannot be read: give a text file of two columns, radius and height"
        ) from error
    rows = []
    for number, line in enumerate(lines):
        try:
            radius, height = (float(part) for part in line.replace(";", ",").split(","))
        except ValueError:
            if number == 0:
                continue
            raise ValueError(
                f"file = '{name}': '{line}' is not a radius and a height, separated by a comma"
            ) from None
        rows.append((radius, height))
    return [radius for radius, _ in rows], [height for _, height in rows]


class PunchSection(Section):
    radius: Positive = Field(description="the punch radius, a positive length")
    rings: int | None = Field(
        default=None, ge=1, le=100_000, description="the number of rings, 1 or more"
    )
    width_ratio: float = Field(
        default=1.0,
        ge=1e-9,
        le=1e9,
        description="the width of even rings over that of odd rings, h2/h1, from 1e-9 to 1e9",
    )
    ring_edges: list[Positive] | None = Field(
        default=None,
        description="the outer radius of each ring, increasing, the last equal to punch.radius",
    )
    wear_coefficients: list[Positive] | None = Field(
        default=None,
        description="positive numbers: two, alternating from the centre, or one for each ring",
    )
    recess: list[NotNegative] | None = Field(
        default=None, description="a height, 0 or more, for each ring: material missing"
    )
    profile: ProfileSection | None = Field(
        default=None, description="a table with kind and what goes with it"
    )
    heights: tuple[Callable[[Any], Any], ...] = Field(
        default=(),
        exclude=True,
        repr=False,
        description="functions, in Python only: see Scene.with_heights",
    )
    wear_coefficient: Positive | None = Field(
        default=None, description="that of odd rings, k1, a positive number"
    )
    wear_ratio: Positive | None = Field(
        default=None, description="k2/k1 of two materials that alternate from the centre"
    )

    @model_validator(mode="after")
    def _rings_are_given_once(self) -> Self:
        self._has_one_of("rings", "ring_edges")
        if self.ring_edges is not None:
            if "width_ratio" in self.model_fields_set:
                raise ValueError("width_ratio goes with rings; with ring_edges leave it out")
            increasing("ring_edges", self.ring_edges)
            if not self.ring_edges or abs(self.ring_edges[-1] / self.radius - 1) > 1e-9:
                raise ValueError(
                    f"ring_edges = {self.ring_edges} must end at punch.radius = {self.radius}"
                )
        count = self.rings or len(self.ring_edges or [])
        if self.wear_coefficients is None and self.wear_coefficient is None:
            raise ValueError(
                "missing key punch.wear_coefficients; give positive numbers, two that alternate "
                "from the "
                "centre or one for each ring; or wear_coefficient with wear_ratio"
            )
        if self.wear_coefficients is not None and (self.wear_coefficient or self.wear_ratio):
            raise ValueError(
                "give either wear_coefficients or wear_coefficient with wear_ratio, and not both"
            )
        if (self.wear_coefficient is None) != (self.wear_ratio is None):
            raise ValueError(
                "wear_ratio = k2/k1 goes with wear_coefficient = k1: give both, or the list "
                "wear_coefficients"
            )
        given = len(self.coefficients)
        if given not in (2, count):
            raise ValueError(
                f"wear_coefficients has {given} values for {count} rings: "
                f"give {count}, or two, which alternate from the centre"
            )
        if self.recess is not None and len(self.recess) != count:
            raise ValueError(
                f"recess has {len(self.recess)} values for {count} rings: give one for each ring"
            )
        return self

    @model_validator(mode="after")
    def _profile_covers_the_face(self) -> Self:
        profile = self.profile
        if profile is None:
            return self
        if profile.radii is not None and (
            profile.radii[0] > 0 or profile.radii[-1] < self.radius * (1 - 1e-9)
        ):
            raise ValueError(
                f"profile.radii run from {profile.radii[0]} to {profile.radii[-1]}: "
                f"give heights from 0 to the rim, {self.radius}"
            )
        if profile.flat_radius is not None and profile.flat_radius >= self.radius:
            raise ValueError(
                f"profile.flat_radius = {profile.flat_radius} leaves nothing to round: give less "
                f"than {self.radius}"
            )
        return self

    @property
    def coefficients(self) -> list[float]:
        """Wear coefficients: two, alternating from the centre, or one for each ring."""
        if self.wear_coefficients is not None:
            return self.wear_coefficients
        assert self.wear_coefficient is not None
        assert self.wear_ratio is not None
        return [self.wear_coefficient, self.wear_coefficient * self.wear_ratio]


class HalfSpaceSection(Section):
    plane_strain_modulus: Positive | None = Field(
        default=None, description="E* = E/(1 - nu^2), a positive pressure"
    )
    youngs_modulus: Positive | None = Field(
        default=None, description="Young's modulus E, a positive pressure"
    )
    poisson_ratio: float = Field(
        default=0.3,
        gt=-1,
        le=0.5,
        allow_inf_nan=False,
        description="a number above -1 and at most 0.5",
    )

    @model_validator(mode="after")
    def _one_modulus(self) -> Self:
        self._has_one_of("plane_strain_modulus", "youngs_modulus")
        return self


class LoadSection(Section):
    normal_force: Positive | None = Field(default=None, description="the normal force F, positive")
    mean_pressure: Positive | None = Field(default=None, description="F / (pi a^2), positive")
    indentation: Positive | None = Field(
        default=None,
        description="the indentation d of the unworn face plane, held fixed: the force decays as "
        "wear goes on",
    )
    sliding_speed: Positive = Field(default=1.0, description="the sliding speed, positive")

    @model_validator(mode="after")
    def _one_load(self) -> Self:
        given = [
            name
            for name in ("normal_force", "mean_pressure", "indentation")
            if getattr(self, name) is not None
        ]
        if len(given) != 1:
            raise ValueError("give one of normal_force, mean_pressure and indentation, and not two")
        return self


class WearSection(Section):
    times: list[NotNegative] = Field(
        default=[],
        description="increasing times, 0 or later, none for no history; or 'running-in'; or counts "
        "of the slowest "
        "relaxation time, { tau = [0.1, 1.0, 5.0] }",
    )
    steady: bool = Field(default=True, description="true or false")
    march: Literal["modal", "implicit", "explicit"] = Field(
        default="modal", description="modal, implicit or explicit"
    )
    step: Positive | None = Field(
        default=None, description="the time step of the implicit or explicit march"
    )

    @model_validator(mode="after")
    def _times_and_steps(self) -> Self:
        increasing("times", self.times)
        if self.march == "modal" and self.step is not None:
            raise ValueError(
                "step goes with march = 'implicit' or 'explicit': the modal march has none"
            )
        if self.march != "modal" and self.step is None and any(self.times):
            raise ValueError(
                f"march = '{self.march}' needs a step; march = 'modal' is exact in time and needs "
                "none"
            )
        if not self.times and not self.steady:
            raise ValueError("nothing to compute: give times, or steady = true")
        return self


class Sizes(Section):
    """Sizes of one kind of discretisation."""

    @property
    def given(self) -> bool:
        """Whether the user has given sizes or degrees, which then stay as they are."""
        return bool(
            self.model_fields_set & {"rim_size", "ring_size", "growth", "grading", "degree"}
        )


class FemAccuracy(Sizes):
    mesher: Literal["quads", "gmsh", "bisection"] | None = Field(
        default=None,
        description="quads (quadrilaterals), gmsh or bisection (triangles of degree 2 to 4)",
    )
    far_field: Literal["boussinesq", "fixed"] = Field(
        default="boussinesq", description="boussinesq or fixed"
    )
    poles: int | None = Field(
        default=None, ge=1, le=8, description="Boussinesq poles tied to the outer boundary, 1 to 8"
    )
    truncation: float | None = Field(
        default=None, ge=2, le=1e6, description="radius of the half-space in a, 2 to 1e6"
    )
    degree: int | None = Field(
        default=None, ge=2, le=16, description="2 to 4 on triangles, 4 to 16 on quadrilaterals"
    )
    rim_size: Size | None = Field(
        default=None, description="element size at the rim in a, 1e-12 to 0.5"
    )
    ring_size: Size | None = Field(
        default=None, description="element size at ring edges in a, 1e-12 to 0.5"
    )
    growth: float | None = Field(
        default=None, ge=0.05, le=2, description="growth of the size with distance, 0.05 to 2"
    )

    @model_validator(mode="after")
    def _degree_goes_with_the_mesher(self) -> Self:
        if (
            self.degree is not None
            and self.mesher is not None
            and (self.degree not in DEGREES[self.mesher])
        ):
            lowest, highest = DEGREES[self.mesher][0], DEGREES[self.mesher][-1]
            raise ValueError(
                f"degree = {self.degree} does not go with mesher = '{self.mesher}': give {lowest} "
                f"to {highest}"
            )
        return self

    @property
    def meshed_by(self) -> str:
        """The mesher: the one asked for, or the one that goes with the other keys."""
        return self.mesher or (
            "quads" if self.degree is None or self.degree in DEGREES["quads"] else "gmsh"
        )


class MdrAccuracy(Sizes):
    degree: int | None = Field(
        default=None, ge=1, le=20, description="highest degree of the pressure, 1 to 20"
    )
    rim_size: Size | None = Field(
        default=None, description="element size at the rim in a, 1e-12 to 0.5"
    )
    ring_size: Size | None = Field(
        default=None, description="element size at ring edges in a, 1e-12 to 0.5"
    )
    grading: float | None = Field(
        default=None, ge=0.05, le=0.8, description="ratio of neighbouring sizes, 0.05 to 0.8"
    )
    grid: int = Field(
        default=400,
        ge=4,
        le=20_000,
        description="springs of the uniform grid of mdr-grid, 4 to 20000",
    )
    step: Positive | None = Field(
        default=None, description="time step of mdr-grid, positive; default half the greatest"
    )


class AccuracySection(Section):
    rtol: float = Field(
        default=1e-4, ge=1e-9, le=0.1, description="the relative accuracy wanted, 1e-9 to 0.1"
    )
    fem: FemAccuracy = FemAccuracy()
    mdr: MdrAccuracy = MdrAccuracy()


class OutputSection(Section):
    radii: list[NotNegative] | None = Field(
        default=None, description="radii from 0 to punch.radius, increasing"
    )
    field_times: list[NotNegative] | None = Field(
        default=None,
        description="times at which the inside of the half-space is written, increasing",
    )
    gradient_average: Literal["line", "area"] = Field(default="line", description="line or area")
