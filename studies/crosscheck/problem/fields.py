"""Define the types of numbers and of profiles in the tables of a scene."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

# nested tables as read from TOML; values have any type until a scene validates them
TomlTable = dict[str, Any]
Height = Callable[[NDArray[np.floating]], NDArray[np.floating]]


def check_increasing(values: list[float]) -> list[float]:
    """Refuse values that do not increase."""
    if any(after <= before for before, after in pairwise(values)):
        raise ValueError(f"{values} must increase, without repeats")
    return values


def check_range(value: float) -> float:
    """Refuse values whose products with a few others could leave the range of double precision."""
    if not value > 0:
        raise ValueError(f"{value} must be positive")
    if not 1e-40 <= value <= 1e40:
        raise ValueError(f"{value} is beyond 1e-40 to 1e+40 in these units")
    return value


def check_not_negative(value: float) -> float:
    """Refuse values that are neither 0 nor in the range of `check_range`."""
    if not value >= 0:
        raise ValueError(f"{value} must be 0 or positive")
    return check_range(value) if value else value


Positive = Annotated[float, AfterValidator(check_range)]
NotNegative = Annotated[float, AfterValidator(check_not_negative)]
Increasing = Annotated[list[NotNegative], AfterValidator(check_increasing)]


@dataclass(frozen=True)
class Unit:
    """The unit of a scene key, declared with its type: ``Annotated[float, Unit("length")]``.

    For a list it is the unit of each number, and for a table over times or radii that of its
    `values`. `kind` is a key of `SI` in `unit_names.py`.
    """

    kind: Literal["length", "force", "pressure", "time", "speed", "wear_rate", "wear_coefficient"]


def optional(description: str, **limits: Any) -> Any:
    """Define a key that may be omitted and then is None."""
    return Field(default=None, description=description, **limits)


class Section(BaseModel):
    """A table of the scene file: frozen, strictly typed, no unknown keys."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid")
    # name of the table in a scene, with a trailing dot, for messages
    prefix: ClassVar[str] = ""

    def __setattr__(self, name: str, value: object) -> None:
        """Raise AttributeError, with the call that returns a changed scene."""
        if callable(as_plain := getattr(value, "tolist", None)):
            value = as_plain()
        raise AttributeError(
            f"a scene does not change: write scene.changed({{'{self.prefix}{name}': {value!r}}}) "
            "for another one"
        )

    def check_one_of(self, *names: str) -> None:
        """Raise ValueError unless exactly one of the keys is given."""
        if sum(getattr(self, name) is not None for name in names) != 1:
            raise ValueError(f"give one of {', '.join(names)}, and only one")


class OverTime(Section):
    """A number over time: linear between times, constant before the first and after the last."""

    times: Annotated[Increasing, Unit("time")] = Field(
        min_length=1, description="increasing times, 0 or later"
    )
    values: list[NotNegative] = Field(
        description="a value, 0 or more, for each of the times; not all 0"
    )

    @model_validator(mode="after")
    def _check_knots(self) -> Self:
        if len(self.times) != len(self.values):
            raise ValueError(
                f"{len(self.values)} values for {len(self.times)} times: give one for each"
            )
        if not any(self.values):
            raise ValueError(
                "values are 0.0 at all times and must be positive at some: give a value above 0"
            )
        check_range(self.greatest)
        return self

    @property
    def greatest(self) -> float:
        """The greatest of the values."""
        return max(self.values)

    def repeated(self, count: int, period: float) -> "OverTime":
        """Return these numbers in several cycles of a period, at the end of which they begin."""
        if len(self.times) == 1 or count == 1:
            return self
        # before the first of the times, a number is constant
        first = [] if self.times[0] == 0 else [0.0]
        times, values = [*first, *self.times], [*self.values[: len(first)], *self.values]
        # a cycle begins with the value at which the last one ended, to the last digit at its end
        later = [
            time
            for cycle in range(1, count)
            for time in (*(cycle * period + time for time in times[1:-1]), (cycle + 1) * period)
        ]
        return OverTime(times=times + later, values=values + values[1:] * (count - 1))


def over_time(value: "float | OverTime") -> OverTime:
    """Return a constant or a varying number as an `OverTime`."""
    return value if isinstance(value, OverTime) else OverTime(times=[0.0], values=[value])


class ProfileSection(Section):
    """Heights of the unworn face over the radius: material that is missing."""

    @property
    def kinks(self) -> list[float]:
        """Radii at which the heights are not smooth."""
        return []

    def check_fit(self, punch_radius: float, inner_radius: float) -> None:
        """Raise ValueError if the profile does not fit the punch, which may be hollow."""


class Parabola(ProfileSection):
    """Heights f = r^2 / (2 R), with the radius of curvature R."""

    kind: Literal["parabola"]
    curvature_radius: Annotated[Positive, Unit("length")] = Field(
        description="the radius of curvature R, a positive length"
    )

    def height_over(self, punch_radius: float) -> Height:
        """Return the function of radii that gives the heights."""
        return lambda radii: radii**2 / (2 * self.curvature_radius)


class Cone(ProfileSection):
    """Heights f = slope * r."""

    kind: Literal["cone"]
    slope: Positive = Field(description="the slope of the cone, positive")

    def height_over(self, punch_radius: float) -> Height:
        """Return the function of radii that gives the heights."""
        return lambda radii: self.slope * np.abs(radii)


class Power(ProfileSection):
    """Heights f = c (r/a)^n, with the punch radius a."""

    kind: Literal["power"]
    coefficient: Annotated[Positive, Unit("length")] = Field(
        description="the height at the rim of f = c (r/a)^n, positive"
    )
    exponent: Positive = Field(description="the exponent n of f = c (r/a)^n, positive")

    def height_over(self, punch_radius: float) -> Height:
        """Return the function of radii that gives the heights."""
        return lambda radii: self.coefficient * np.abs(radii / punch_radius) ** self.exponent


class Ball(ProfileSection):
    """A ball with its exact circular section; a `parabola` is the usual approximation."""

    kind: Literal["ball"]
    ball_radius: Annotated[Positive, Unit("length")] = Field(
        description="the radius of the ball, a length that is not below punch.radius"
    )

    def check_fit(self, punch_radius: float, inner_radius: float) -> None:
        """Raise ValueError if the ball is smaller than the punch."""
        if self.ball_radius < punch_radius:
            raise ValueError(
                f"profile.ball_radius = {self.ball_radius:g} is below punch.radius = "
                f"{punch_radius:g}, but a ball is not wider than its radius; give a smaller "
                "punch.radius"
            )

    def height_over(self, punch_radius: float) -> Height:
        """Return the function of radii that gives the heights R - sqrt(R^2 - r^2)."""
        radius = self.ball_radius
        # without the cancellation of R - sqrt(R^2 - r^2)
        return lambda radii: (
            radii**2 / (radius + np.sqrt(np.maximum((radius - radii) * (radius + radii), 0.0)))
        )


class FlatCentre(ProfileSection):
    """A face that is flat inside a radius, at which the slope or the curvature jumps."""

    flat_radius: Annotated[Positive, Unit("length")] = Field(
        description="the radius b inside which the face is flat"
    )

    @property
    def kinks(self) -> list[float]:
        """The flat radius."""
        return [self.flat_radius]

    def check_fit(self, punch_radius: float, inner_radius: float) -> None:
        """Raise ValueError if the flat radius is not below the punch radius."""
        if self.flat_radius >= punch_radius:
            raise ValueError(
                f"profile.flat_radius = {self.flat_radius:g} leaves nothing beyond it: give less "
                f"than {punch_radius:g}"
            )


class RoundedRim(FlatCentre):
    """Heights f = (r - b)^2 / (2 R) beyond the flat radius b, and 0 inside it."""

    kind: Literal["rounded_rim"]
    flat_radius: Annotated[NotNegative, Unit("length")] = Field(
        description="the radius b inside which the face is flat"
    )
    curvature_radius: Annotated[Positive, Unit("length")] = Field(
        description="the radius of curvature R, a positive length"
    )

    def height_over(self, punch_radius: float) -> Height:
        """Return the function of radii that gives the heights."""
        return lambda radii: (
            np.maximum(radii - self.flat_radius, 0.0) ** 2 / (2 * self.curvature_radius)
        )


class TruncatedCone(FlatCentre):
    """Heights f = slope * (r - b) beyond the flat radius b, and 0 inside it."""

    kind: Literal["truncated_cone"]
    slope: Positive = Field(description="the slope of the cone beyond the flat, positive")

    def height_over(self, punch_radius: float) -> Height:
        """Return the function of radii that gives the heights."""
        return lambda radii: self.slope * np.maximum(radii - self.flat_radius, 0.0)


class TruncatedParaboloid(FlatCentre):
    """Heights f = (r^2 - b^2) / (2 R) beyond the flat radius b, and 0 inside it."""

    kind: Literal["truncated_paraboloid"]
    curvature_radius: Annotated[Positive, Unit("length")] = Field(
        description="the radius of curvature R, a positive length"
    )

    def height_over(self, punch_radius: float) -> Height:
        """Return the function of radii that gives the heights."""
        flat = self.flat_radius
        return lambda radii: (
            np.maximum(radii - flat, 0.0) * (radii + flat) / (2 * self.curvature_radius)
        )


class Concave(ProfileSection):
    """Heights f = h (1 - r^2/a^2) of a dish, which touches at the rim first."""

    kind: Literal["concave"]
    depth: Annotated[Positive, Unit("length")] = Field(
        description="the depth h at the centre of f = h (1 - r^2/a^2)"
    )

    def height_over(self, punch_radius: float) -> Height:
        """Return the function of radii that gives the heights."""
        return lambda radii: self.depth * (1 - (radii / punch_radius) ** 2)


class HeightTable(ProfileSection):
    """Heights interpolated by monotone cubics (Fritsch and Carlson): smooth, without overshoot."""

    kind: Literal["table"]
    radii: Annotated[Increasing, Unit("length")] = Field(
        min_length=2,
        description="increasing radii from 0 to punch.radius, with heights; or a file of both, or "
        "of x, y and heights: then center = true finds the axis, and level = true removes the "
        "tilt; for a step of the face, use a ring edge with a recess",
    )
    heights: Annotated[list[NotNegative], Unit("length")] = Field(
        description="a height, 0 or more, for each of the radii"
    )

    @model_validator(mode="after")
    def _check_points(self) -> Self:
        if len(self.radii) != len(self.heights):
            raise ValueError("a table needs as many heights as radii")
        return self

    @property
    def kinks(self) -> list[float]:
        """All radii of the table."""
        return self.radii

    def check_fit(self, punch_radius: float, inner_radius: float) -> None:
        """Raise ValueError if the radii do not reach from the axis, or the hole, to the rim."""
        reaches_rim = self.radii[-1] >= punch_radius * (1 - 1e-9)
        if self.radii[0] > inner_radius or not reaches_rim:
            raise ValueError(
                f"profile.radii run from {self.radii[0]} to {self.radii[-1]}: give heights from "
                f"{inner_radius:g} to the rim, {punch_radius}"
            )

    def height_over(self, punch_radius: float) -> Height:
        """Return the function of radii that interpolates the heights."""
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.radii, self.heights)


class WearTable(Section):
    """Wear coefficients over the radius, linear between points, constant beyond the ends."""

    radii: Annotated[list[NotNegative], Unit("length")] = Field(
        min_length=1,
        description="radii from 0 to punch.radius that do not decrease; two equal ones are a step",
    )
    values: list[Positive] = Field(
        description="a wear coefficient, positive, for each of the radii"
    )

    def check_fit(self, punch_radius: float) -> None:
        """Raise ValueError if radii and values do not match or do not fit the punch."""
        radii = self.radii
        if len(self.values) != len(radii) or sorted(radii) != radii or radii[-1] > punch_radius:
            raise ValueError(
                f"wear_coefficient.radii = {radii} with {len(self.values)} values: give a value "
                f"for each of radii from 0 to {punch_radius} that do not decrease"
            )


Profile = (
    Parabola
    | Ball
    | Cone
    | TruncatedCone
    | TruncatedParaboloid
    | Concave
    | Power
    | RoundedRim
    | HeightTable
)
PROFILES: dict[str, type[Section]] = {
    get_args(section.model_fields["kind"].annotation)[0]: section for section in get_args(Profile)
}

# types of values by the names that pydantic inserts into locations of errors; messages omit these
KINDS: dict[str, type[Section]] = {
    "number": Section,
    "graded": WearTable,
    "over time": OverTime,
    **PROFILES,
}
