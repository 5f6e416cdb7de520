"""Define the table `punch` of the scene: radii, rings, wear coefficients and the unworn face."""

from dataclasses import replace
from typing import Annotated, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from ....meshes.errors import SceneError
from ....meshes.radial import Array, alternating_edges
from .fields import (
    PROFILES,
    Height,
    NotNegative,
    Positive,
    Profile,
    Section,
    Unit,
    WearTable,
    check_increasing,
    optional,
)
from .profile import InitialProfile, find_kinks
from .written import shown

# smallest radius of a hole over the punch radius, and smallest width of the first ring over its
# outer radius; elements cannot resolve smaller ones, so these are refused
NARROWEST_HOLE, NARROWEST_FACE = 1e-9, 1e-9


def heights_of(height: Height, radii: Array) -> Array:
    """Return the heights of a function at radii; a single number is the height everywhere.

    Raises
    ------
    SceneError
        if a function of the user returns anything but one number for each radius
    """
    heights = height(radii)
    try:
        return np.broadcast_to(np.asarray(heights, dtype=float), radii.shape)
    except (TypeError, ValueError):
        raise SceneError(
            f"a function of with_heights returns {shown(heights)} for {radii.size} radii: return "
            "one height for each radius of the array"
        ) from None


class PunchSection(Section):
    """The table `punch` of the scene: radii, rings, wear coefficients and the unworn face."""

    prefix = "punch."

    radius: Annotated[Positive, Unit("length")] = Field(
        description="the punch radius, a positive length; a ball, a cone or a parabola needs none"
    )
    inner_radius: Annotated[NotNegative, Unit("length")] = Field(
        default=0.0,
        description="the radius of the hole of a hollow punch, less than the outer radius of the "
        "first ring; 0 for a punch without a hole",
    )
    rings: int | None = optional(
        "the number of rings, 1 or more; not needed for one material", ge=1, le=100_000
    )
    width_ratio: float = Field(
        default=1.0,
        ge=1e-9,
        le=1e9,
        description="the width of even rings over that of odd rings, h2/h1, from 1e-9 to 1e9",
    )
    ring_edges: (
        Annotated[list[Positive], AfterValidator(check_increasing), Unit("length")] | None
    ) = optional(
        "the outer radius of each ring, increasing, the last equal to punch.radius", min_length=1
    )
    wear_coefficients: Annotated[list[Positive], Unit("wear_coefficient")] | None = optional(
        "positive numbers: two, alternating from the centre, or one for each ring"
    )
    recess: Annotated[list[NotNegative], Unit("length")] | None = optional(
        "a height of missing material, 0 or more, for each ring"
    )
    profile: Profile | None = optional(
        f"a table with a kind and its keys; kinds are {', '.join(PROFILES)}", discriminator="kind"
    )
    heights: list[Height] = Field(
        default=[],
        exclude=True,
        repr=False,
        description="functions, in Python only: see Scene.with_heights",
    )
    kinks: list[float] | None = Field(
        default=None,
        exclude=True,
        repr=False,
        description="radii of their kinks, in Python only: see Scene.with_heights",
    )
    wear_coefficient: (
        Annotated[
            Annotated[Positive, Tag("number")] | Annotated[WearTable, Tag("graded")],
            Discriminator(lambda given: "number" if isinstance(given, float | int) else "graded"),
            Unit("wear_coefficient"),
        ]
        | None
    ) = optional(
        "the wear coefficient of the only material, or k1 of odd rings, a positive number; or "
        "values along the radius, { radii = [...], values = [...] }"
    )
    wear_ratio: Positive | None = optional("k2/k1 of two materials that alternate from the centre")

    @model_validator(mode="after")
    def _check_rings(self) -> Self:
        coefficient_count = len(self.coefficients)
        if (self.table is None and coefficient_count > 1) or (self.rings and self.ring_edges):
            self.check_one_of("rings", "ring_edges")
        first_edge = min(self.ring_edges or [self.radius])
        if not self.inner_radius < first_edge * (1 - NARROWEST_FACE):
            raise ValueError(
                f"inner_radius = {self.inner_radius:g} must be below {first_edge:g}, the outer "
                "radius of the first ring"
            )
        if 0 < self.inner_radius < NARROWEST_HOLE * self.radius:
            raise ValueError(
                f"inner_radius = {self.inner_radius:g} is too small to have an effect: leave it "
                f"out, or give at least {NARROWEST_HOLE:g} of punch.radius"
            )
        if self.ring_edges is not None:
            if "width_ratio" in self.model_fields_set:
                raise ValueError("width_ratio has no effect with ring_edges: leave it out")
            if abs(self.ring_edges[-1] / self.radius - 1) > 1e-9:
                raise ValueError(
                    f"ring_edges = {self.ring_edges} must end at punch.radius = {self.radius}"
                )
        forms = self.wear_coefficients, self.wear_coefficient
        has_ratio = self.wear_ratio is not None
        if (has_ratio and not isinstance(forms[1], float)) or forms.count(None) != 1:
            raise ValueError(
                "give one of: wear_coefficient = k for one material; wear_coefficient = k1 with "
                "wear_ratio = k2/k1; wear_coefficients, positive numbers, two that alternate from "
                "the centre or one for each ring; wear_coefficient = { radii = [...], values = "
                "[...] }"
            )
        ring_count = self.rings or len(self.ring_edges or [0])
        if self.table:
            self.table.check_fit(self.radius)
        elif self.wear_coefficients is not None and coefficient_count not in (2, ring_count):
            raise ValueError(
                f"wear_coefficients has {coefficient_count} values for {ring_count} rings: give "
                f"{ring_count}, or two, which alternate from the centre"
            )
        if self.recess is not None and len(self.recess) != ring_count:
            raise ValueError(
                f"recess has {len(self.recess)} values for {ring_count} rings: give one for each "
                "ring"
            )
        if self.profile is not None:
            self.profile.check_fit(self.radius, self.inner_radius)
        if not all(0 <= kink <= self.radius for kink in self.kinks or []):
            raise ValueError(
                f"kinks = {self.kinks} of heights: give radii from 0 to punch.radius, {self.radius}"
            )
        return self

    @property
    def coefficients(self) -> list[float]:
        """Wear coefficients of the rings, or the values of the table if wear is graded.

        There is one for all rings, two that alternate from the centre, or one for each ring.
        """
        if self.wear_coefficients is not None:
            return self.wear_coefficients
        first = self.wear_coefficient or 0.0
        if isinstance(first, WearTable):
            return first.values
        return [first] if self.wear_ratio is None else [first, first * self.wear_ratio]

    @property
    def as_wide_as_scar(self) -> bool:
        """Whether the scene gives no radius: the face is wider than the contact ever gets."""
        return "radius" not in self.model_fields_set

    @property
    def table(self) -> WearTable | None:
        """The table of wear coefficients along the radius; None if they are constant on rings."""
        return self.wear_coefficient if isinstance(self.wear_coefficient, WearTable) else None

    @property
    def relative_edges(self) -> Array:
        """(N+1,) ring edges over the punch radius, from the axis or the hole to 1."""
        hole = self.inner_radius / self.radius
        if self.ring_edges is None:
            edges = hole + (1 - hole) * alternating_edges(self.rings or 1, self.width_ratio)
        else:
            edges = np.array([self.inner_radius, *self.ring_edges]) / self.radius
        edges[-1] = 1.0
        return edges

    def unworn(self, ring_edges: Array, unit: float) -> InitialProfile:
        """Return the face before wear, non-dimensional.

        Parameters
        ----------
        ring_edges : (N+1,) array
            Ring edges over the punch radius.
        unit : float
            Unit of heights, in that of the scene.

        Raises
        ------
        SceneError
            if a function of the user returns heights that are negative or not finite
        """
        recess = np.zeros(len(ring_edges) - 1) + np.array(self.recess or 0.0) / unit
        if not (self.profile or self.heights or recess.any()):
            return InitialProfile(ring_edges, recess)
        functions: list[Height] = list(self.heights)
        kinks: tuple[float, ...] = ()
        if self.profile is not None:
            functions.append(self.profile.height_over(self.radius))
            kinks = tuple(kink / self.radius for kink in self.profile.kinks)

        def scaled(height: Height) -> Height:
            return lambda radii: heights_of(height, radii * self.radius) / unit

        profile = InitialProfile(ring_edges, recess, tuple(map(scaled, functions)), kinks)
        if self.heights:
            if self.kinks is None:
                heights_profile = InitialProfile(
                    ring_edges, recess, tuple(map(scaled, self.heights))
                )
                height_kinks = find_kinks(heights_profile)
            else:
                height_kinks = tuple(kink / self.radius for kink in self.kinks)
            profile = replace(profile, kinks=tuple(np.union1d(kinks, height_kinks).tolist()))
        least = float(profile.sampled()[1].min())
        if self.heights and not least >= 0:
            raise SceneError(
                f"the least height of the punch is {least * unit:.3g}: heights are material that "
                "is missing, 0 or more and finite; add a constant to them"
            )
        return replace(profile, recess=recess - least, standoff=least)

    def approach(self, indentation: float, ring_edges: Array) -> float:
        """Return an indentation minus that of the first touch, in the scene's units.

        Raises
        ------
        SceneError
            if the punch does not touch the half-space
        """
        least = self.unworn(ring_edges, 1.0).standoff
        if indentation <= least:
            raise SceneError(
                f"load.indentation = {indentation:.6g} is too small for contact: the nearest point "
                f"of the punch is {least:.6g} from the half-space; give more"
            )
        return indentation - least
