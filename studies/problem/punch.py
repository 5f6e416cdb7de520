"""The table `punch` of the scene: radii, rings, wear coefficients and the unworn face."""

from dataclasses import replace
from typing import Annotated, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag, model_validator

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from .fields import (
    Ball,
    Concave,
    Cone,
    Height,
    HeightTable,
    NotNegative,
    Parabola,
    Positive,
    Power,
    RoundedRim,
    Section,
    TruncatedCone,
    TruncatedParaboloid,
    Unit,
    WearTable,
    check_increasing,
    optional,
)
from .profile import InitialProfile, find_kinks

# holes smaller than this part of the punch radius, and faces narrower than this part of it, are
# refused: elements could not tell them
NARROWEST_HOLE, NARROWEST_FACE = 1e-9, 1e-9


class PunchSection(Section):
    """The table `punch` of the scene: radii, rings, wear coefficients and the unworn face."""

    prefix = "punch."

    radius: Annotated[Positive, Unit("length")] = Field(
        description="the punch radius, a positive length"
    )
    inner_radius: Annotated[NotNegative, Unit("length")] = Field(
        default=0.0,
        description="the radius of the hole of a hollow punch, below that of the first ring; 0 for "
        "a full one",
    )
    rings: int | None = optional(
        "the number of rings, 1 or more; of one material it may be left out", ge=1, le=100_000
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
        "a height, 0 or more, for each ring: material missing"
    )
    profile: (
        Parabola
        | Ball
        | Cone
        | TruncatedCone
        | TruncatedParaboloid
        | Concave
        | Power
        | RoundedRim
        | HeightTable
        | None
    ) = optional(
        "a table with what goes with its kind, one of parabola, ball, cone, truncated_cone, "
        "truncated_paraboloid, concave, power, rounded_rim and table",
        discriminator="kind",
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
        "that of the one material, or of odd rings, k1, a positive number; or that along the "
        "radius, { radii = [...], values = [...] }"
    )
    wear_ratio: Positive | None = optional("k2/k1 of two materials that alternate from the centre")

    @model_validator(mode="after")
    def _check_rings(self) -> Self:
        given = len(self.coefficients)
        if (self.table is None and given > 1) or (self.rings and self.ring_edges):
            self.check_one_of("rings", "ring_edges")
        least = min(self.ring_edges or [self.radius])
        if not self.inner_radius < least * (1 - NARROWEST_FACE):
            raise ValueError(
                f"inner_radius = {self.inner_radius:g} must be below {least:g}, where the first "
                "ring ends"
            )
        if 0 < self.inner_radius < NARROWEST_HOLE * self.radius:
            raise ValueError(
                f"inner_radius = {self.inner_radius:g} is too small to tell from no hole: leave it "
                f"out, or give at least {NARROWEST_HOLE:g} of punch.radius"
            )
        if self.ring_edges is not None:
            if "width_ratio" in self.model_fields_set:
                raise ValueError("width_ratio goes with rings; with ring_edges leave it out")
            if abs(self.ring_edges[-1] / self.radius - 1) > 1e-9:
                raise ValueError(
                    f"ring_edges = {self.ring_edges} must end at punch.radius = {self.radius}"
                )
        forms = self.wear_coefficients, self.wear_coefficient
        of_two = self.wear_ratio is not None
        if (of_two and not isinstance(forms[1], float)) or forms.count(None) != 1:
            raise ValueError(
                "give one of wear_coefficient = k of one material; wear_coefficient = k1 with "
                "wear_ratio = k2/k1; wear_coefficients, positive numbers, two that alternate from "
                "the centre or one for each ring; wear_coefficient = { radii = [...], values = "
                "[...] }"
            )
        count = self.rings or len(self.ring_edges or [0])
        if self.table:
            self.table.check_fit(self.radius)
        elif self.wear_coefficients is not None and given not in (2, count):
            raise ValueError(
                f"wear_coefficients has {given} values for {count} rings: give {count}, or two, "
                "which alternate from the centre"
            )
        if self.recess is not None and len(self.recess) != count:
            raise ValueError(
                f"recess has {len(self.recess)} values for {count} rings: give one for each ring"
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
        """Wear coefficients of the rings, or those of the table if wear is graded.

        There is one for all rings, or two that alternate from the centre, or one for each ring.
        """
        if self.wear_coefficients is not None:
            return self.wear_coefficients
        first = self.wear_coefficient or 0.0
        if isinstance(first, WearTable):
            return first.values
        return [first] if self.wear_ratio is None else [first, first * self.wear_ratio]

    @property
    def table(self) -> WearTable | None:
        """The wear coefficient along the radius."""
        return self.wear_coefficient if isinstance(self.wear_coefficient, WearTable) else None

    def unworn(self, ring_edges: Array, unit: float) -> InitialProfile:
        """Return the face before wear, between (N+1,) edges over the radius, in a unit of heights.

        Raises
        ------
        SceneError
            if a function of the user's gives heights that are negative or not finite
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
            return lambda radii: np.asarray(height(radii * self.radius), dtype=float) / unit

        profile = InitialProfile(ring_edges, recess, tuple(map(scaled, functions)), kinks)
        if self.heights:
            if self.kinks is None:
                given = InitialProfile(ring_edges, recess, tuple(map(scaled, self.heights)))
                more = find_kinks(given)
            else:
                more = tuple(kink / self.radius for kink in self.kinks)
            profile = replace(profile, kinks=tuple(np.union1d(kinks, more).tolist()))
        least = float(profile.sampled()[1].min())
        if self.heights and not least >= 0:
            raise SceneError(
                f"the height of the punch is {least * unit:.3g} somewhere: heights are material "
                "that is missing, 0 or more and finite; add a constant to them"
            )
        return replace(profile, recess=recess - least, standoff=least)

    def approach(self, given: float, ring_edges: Array) -> float:
        """Return by how much a given indentation is beyond the first touch, in the scene's units.

        Raises
        ------
        SceneError
            if nothing touches
        """
        least = self.unworn(ring_edges, 1.0).standoff
        if given <= least:
            raise SceneError(
                f"load.indentation = {given:.6g} is too small to touch: the punch stands "
                f"{least:.6g} from the half-space where it is nearest; give more"
            )
        return given - least
