"""Define the tables of a scene: each key is declared once, with its check and its description.

In messages about a key, the description follows the word "give".
"""

from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator

from ....meshes.errors import SceneError
from ....meshes.ground.ground import Ground
from .fields import (
    Increasing,
    OverTime,
    Positive,
    Section,
    Unit,
    optional,
    over_time,
)
from .quantities import expand


def check_quantities(names: list[str]) -> list[str]:
    """Refuse names that are neither quantities nor groups of quantities."""
    expand(names)
    return names


Size = Annotated[float, Field(ge=1e-12, le=0.5)]
# possible polynomial degrees of the displacement for each mesher; on triangles, the highest one is
# the default
DEGREES = {"quads": range(1, 17), "gmsh": range(1, 5), "bisection": range(1, 5)}
# lowest degree of quadrilaterals in layers whose sizes shrink fourfold towards an edge; lower
# degrees need layers that shrink more slowly
LAYERED = 4
# times of ``times = "running-in"``, in slowest relaxation times
RUNNING_IN = [0.0, 0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0]


# least radius of the mesh of the half-space, in punch radii
LEAST_TRUNCATION = 2.0
# least thickness of the first layer in punch radii; a run with a thinner one would take more than
# some minutes
THINNEST_LAYER = 5e-4
# greatest ratio of the moduli of adjacent layers; beyond it, the kernel loses half of its digits
MOST_CONTRAST = 1e4


class LayerSection(Section):
    """A table of `half_space.layers`: a layer, bonded to its neighbours."""

    # of the first layer, as an example
    prefix = "half_space.layers.0."

    thickness: Annotated[Positive, Unit("length")] = Field(description="a positive length")
    youngs_modulus: Annotated[Positive, Unit("pressure")] = Field(
        description="Young's modulus E of the layer, a positive pressure"
    )
    poisson_ratio: float = Field(
        default=0.3,
        gt=-1,
        le=0.5,
        allow_inf_nan=False,
        description="a number above -1 and at most 0.5",
    )


class HalfSpaceSection(Section):
    """The table `half_space` of the scene: elastic constants of the ground and the punch."""

    prefix = "half_space."

    plane_strain_modulus: Annotated[Positive, Unit("pressure")] | None = optional(
        "E* = E/(1 - nu^2), a positive pressure"
    )
    youngs_modulus: Annotated[Positive, Unit("pressure")] | None = optional(
        "Young's modulus E, a positive pressure"
    )
    poisson_ratio: float = Field(
        default=0.3,
        gt=-1,
        le=0.5,
        allow_inf_nan=False,
        description="a number above -1 and at most 0.5",
    )
    layers: list[LayerSection] = Field(
        default=[],
        description="layers from the surface down, each a table [[half_space.layers]] with "
        "thickness, youngs_modulus and poisson_ratio",
    )
    rigid: bool = Field(
        default=False,
        description="true or false: whether the base below the layers is rigid; it replaces the "
        "modulus",
    )

    punch_youngs_modulus: Annotated[Positive, Unit("pressure")] | None = optional(
        "Young's modulus of an elastic punch, a positive pressure; the punch is then modelled as a "
        "second half-space; leave it out for a rigid punch"
    )
    punch_poisson_ratio: float | None = optional(
        "Poisson's ratio of an elastic punch, a number above -1 and at most 0.5; 0.3 if not given",
        gt=-1,
        le=0.5,
        allow_inf_nan=False,
    )

    @model_validator(mode="after")
    def _check_modulus(self) -> Self:
        if self.rigid:
            self._check_rigid_base()
        else:
            self.check_one_of("plane_strain_modulus", "youngs_modulus")
        if self.layers:
            self._check_layers()
        if self.punch_poisson_ratio is not None and self.punch_youngs_modulus is None:
            raise ValueError("punch_poisson_ratio needs punch_youngs_modulus: give both or neither")
        return self

    def _check_rigid_base(self) -> None:
        if not self.layers:
            raise ValueError(
                "rigid = true describes the base below [[half_space.layers]]: give layers, or "
                "leave it out"
            )
        base_keys = {"plane_strain_modulus", "youngs_modulus", "poisson_ratio"}
        if superfluous := sorted(self.model_fields_set & base_keys):
            raise ValueError(
                f"rigid = true excludes {', '.join(superfluous)}: leave out these; each layer has "
                "its own modulus"
            )

    def _check_layers(self) -> None:
        moduli = self.youngs_moduli[: len(self.layers) + (not self.rigid)]
        for number, (upper, lower) in enumerate(pairwise(moduli)):
            if not 1 / MOST_CONTRAST <= upper / lower <= MOST_CONTRAST:
                raise ValueError(
                    f"layers.{number}.youngs_modulus = {upper:g} and the modulus below it, "
                    f"{lower:g}, differ by a factor of more than {MOST_CONTRAST:g}, which loses "
                    "half of all digits: give rigid = true below a soft layer, or closer moduli"
                )

    @property
    def youngs_moduli(self) -> list[float]:
        """Young's moduli of the layers and, last, of the base below them."""
        below = self.youngs_modulus
        if below is None:
            below = (self.plane_strain_modulus or np.inf) * (1 - self.poisson_ratio**2)
        return [*(layer.youngs_modulus for layer in self.layers), below]

    def ground(self, radius: float) -> Ground:
        """Return the ground in units of the punch radius and of the modulus at the surface.

        Raises
        ------
        SceneError
            if the first layer is too thin
        """
        if not self.layers:
            return Ground.half_space(self.poisson_ratio)
        thicknesses = [layer.thickness / radius for layer in self.layers]
        if thicknesses[0] < THINNEST_LAYER:
            raise SceneError(
                f"half_space.layers.0.thickness = {self.layers[0].thickness:g} is below "
                f"{THINNEST_LAYER:g} of punch.radius: leave out so thin a layer, or give a thicker "
                "one"
            )
        ratios = [*(layer.poisson_ratio for layer in self.layers), self.poisson_ratio]
        ground = Ground.from_youngs_moduli(thicknesses, self.youngs_moduli, ratios)
        return replace(ground, share=self.modulus / self.own_modulus)

    @property
    def greatest_poisson_ratio(self) -> float:
        """The greatest Poisson's ratio of the layers and of the base below them."""
        ratios = [layer.poisson_ratio for layer in self.layers]
        return max(ratios if self.rigid else [*ratios, self.poisson_ratio])

    @property
    def own_modulus(self) -> float:
        """The plane strain modulus E/(1 - nu^2) of the half-space alone, or of the first layer."""
        if self.layers:
            return self.layers[0].youngs_modulus / (1 - self.layers[0].poisson_ratio ** 2)
        from_youngs_modulus = (self.youngs_modulus or 0.0) / (1 - self.poisson_ratio**2)
        return self.plane_strain_modulus or from_youngs_modulus

    @property
    def modulus(self) -> float:
        """The plane strain modulus of the contact, including that of an elastic punch."""
        if self.punch_youngs_modulus is None:
            return self.own_modulus
        ratio = 0.3 if self.punch_poisson_ratio is None else self.punch_poisson_ratio
        return 1 / (1 / self.own_modulus + (1 - ratio**2) / self.punch_youngs_modulus)


# a number, or a table of times and values
Varying = Annotated[
    Annotated[Positive, Tag("number")] | Annotated[OverTime, Tag("over time")],
    Discriminator(lambda given: "over time" if isinstance(given, dict | OverTime) else "number"),
]


def check_direction(speed: object) -> object:
    """Refuse a sliding speed that is negative: a number, or one of the values of a table."""
    values = [speed]
    if isinstance(speed, dict) and isinstance(speed.get("values"), list):
        values = speed["values"]
    for value in values:
        if isinstance(value, int | float) and value < 0:
            raise ValueError(
                f"{value:g} is negative, but wear does not depend on the direction of sliding: "
                "give its absolute value"
                + (", and a time of speed 0 where the direction changes" if len(values) > 1 else "")
            )
    return speed


class LoadSection(Section):
    """The table `load` of the scene: force, mean pressure or indentation, and sliding speed."""

    prefix = "load."

    normal_force: Annotated[Varying, Unit("force")] | None = optional(
        "the normal force F, positive, or { times = [...], values = [...] }"
    )
    mean_pressure: Annotated[Varying, Unit("pressure")] | None = optional(
        "the normal force over the area of the face, positive, or { times = [...], values = [...] }"
    )
    indentation: Annotated[Positive, Unit("length")] | None = optional(
        "the fixed indentation d of the unworn face plane; the force then decays during wear"
    )
    sliding_speed: Annotated[Varying, BeforeValidator(check_direction), Unit("speed")] = Field(
        default=1.0,
        description="the sliding speed, positive, or { times = [...], values = [...] }; without "
        "it, times are sliding distances",
    )
    repeat: int = Field(
        default=1,
        ge=1,
        le=100_000,
        description="how often the force or the speed over time is repeated, 1 or more",
    )

    @model_validator(mode="after")
    def _check_load(self) -> Self:
        self.check_one_of("normal_force", "mean_pressure", "indentation")
        cycles = self._cycles
        if self.repeat > 1 and not cycles:
            raise ValueError(
                "repeat needs a cycle: give normal_force or sliding_speed as { times = [...], "
                "values = [...] }, or leave out repeat"
            )
        if self.repeat > 1 and len({cycle.times[-1] for cycle in cycles}) > 1:
            raise ValueError("repeat: give force and sliding speed up to the same time")
        if self.repeat > 1 and any(cycle.values[0] != cycle.values[-1] for cycle in cycles):
            raise ValueError(
                "repeat: a cycle must end with the value with which it begins; give the way back, "
                "as { times = [0, 1, 1.9, 2], values = [5, 5, 0, 5] }"
            )
        return self

    @property
    def _cycles(self) -> list[OverTime]:
        """The force and the sliding speed, of those that vary."""
        given = self.normal_force, self.mean_pressure, self.sliding_speed
        return [each for each in given if isinstance(each, OverTime) and len(each.times) > 1]

    @property
    def period(self) -> float:
        """The duration of a cycle; 0 for a constant load."""
        return max((cycle.times[-1] for cycle in self._cycles), default=0.0)

    @property
    def cycle_ends(self) -> list[float]:
        """The start, and the end of each cycle."""
        return [number * self.period for number in range(self.repeat + 1)]

    @property
    def times_are_distances(self) -> bool:
        """Whether times are sliding distances, because no sliding speed is given."""
        return "sliding_speed" not in self.model_fields_set

    @property
    def load_over_time(self) -> OverTime:
        """The force or mean pressure over time; 1, which has no effect, for an indentation."""
        load = over_time(self.normal_force or self.mean_pressure or 1.0)
        return load.repeated(self.repeat, self.period)

    @property
    def speed_over_time(self) -> OverTime:
        """The sliding speed over time."""
        return over_time(self.sliding_speed).repeated(self.repeat, self.period)

    def greatest_force(self, radius: float, inner_radius: float) -> float:
        """Return the greatest force; 0 if the indentation is given.

        The radii of the rim and of the hole convert a mean pressure into a force.
        """
        face = np.pi * (radius - inner_radius) * (radius + inner_radius)
        area = face if self.normal_force is None else 1.0
        return 0.0 if self.indentation is not None else self.load_over_time.greatest * area


class WearSection(Section):
    """The table `wear` of the scene: times of the history, the march, and the steady state."""

    prefix = "wear."

    times: Annotated[Increasing, Unit("time")] = Field(
        default=[],
        description="increasing times, 0 or later, or an empty list for no history; or "
        "'running-in'; or multiples of the slowest relaxation time, { tau = [0.1, 1.0, 5.0] }; or "
        "'each cycle' of a load that is repeated",
    )
    each_cycle: bool = Field(default=False, exclude=True, description="it within times")
    tau: list[float] | None = optional("it within times: times = { tau = [...] }", exclude=True)
    steady: bool = True
    march: Literal["modal", "implicit", "explicit"] = "modal"
    step: Annotated[Positive, Unit("time")] | None = optional(
        "the time step of the implicit or explicit march"
    )

    @model_validator(mode="before")
    @classmethod
    def _read_counts(cls, table: object) -> object:
        """Store multiples of the slowest relaxation time in `tau`, and preliminarily in `times`.

        The scene replaces the latter when it has computed the relaxation time; and it gives the
        times of cycles.
        """
        if not isinstance(table, dict):
            return table
        if "tau" in table:
            raise ValueError("tau is a key of times: give times = { tau = [...] }")
        if "each_cycle" in table:
            raise ValueError("each_cycle is no key: give times = 'each cycle'")
        times = table.get("times")
        if times == "each cycle":
            return table | {"times": [0.0], "each_cycle": True}
        if times == "running-in":
            times = {"tau": RUNNING_IN}
        if isinstance(times, dict) and set(times) == {"tau"}:
            if not times["tau"]:
                raise ValueError("times.tau is empty: give counts, or times = [] for no history")
            return table | {"times": times["tau"], "tau": times["tau"]}
        return table

    @model_validator(mode="after")
    def _check_times(self) -> Self:
        if self.march == "modal" and self.step is not None:
            raise ValueError(
                "step needs march = 'implicit' or 'explicit': the modal march has no step"
            )
        if self.march != "modal" and self.step is None and any(self.times):
            raise ValueError(
                f"march = '{self.march}' needs a step: give one, or march = 'modal', which is "
                "exact in time without steps"
            )
        if not self.times and not self.steady:
            raise ValueError("nothing to compute: give times, or steady = true")
        return self


class Sizes(Section):
    """Sizes of the elements of a method."""

    rim_size: Size | None = optional("element size at the rim in a, 1e-12 to 0.5")
    ring_size: Size | None = optional("element size at ring edges in a, 1e-12 to 0.5")

    @property
    def given_by_user(self) -> bool:
        """Whether the user has given sizes or degrees, which are then not changed."""
        sizes = {"rim_size", "ring_size", "growth", "grading", "degree"}
        return bool(self.model_fields_set & sizes)


class FemAccuracy(Sizes):
    """The table `accuracy.fem` of the scene: mesh and far field of the finite elements."""

    prefix = "accuracy.fem."

    mesher: Literal["quads", "gmsh", "bisection"] | None = optional(
        "quads (quadrilaterals), gmsh or bisection (triangles of degree 1 to 4)"
    )
    far_field: Literal["boussinesq", "fixed"] = "boussinesq"
    poles: int | None = optional("Boussinesq poles tied to the outer boundary, 1 to 8", ge=1, le=8)
    truncation: float | None = optional(
        "radius of the half-space in a, 2 to 1e6", ge=LEAST_TRUNCATION, le=1e6
    )
    degree: int | None = optional("1 to 4 on triangles, 1 to 16 on quadrilaterals", ge=1, le=16)
    growth: float | None = optional("growth of the size with distance, 0.05 to 2", ge=0.05, le=2)

    @model_validator(mode="after")
    def _check_degree(self) -> Self:
        if self.degree is not None and self.degree not in DEGREES[self.chosen_mesher]:
            degrees = DEGREES[self.chosen_mesher]
            raise ValueError(
                f"degree = {self.degree} is not possible with mesher = '{self.chosen_mesher}': "
                f"give {degrees[0]} to {degrees[-1]}"
            )
        return self

    @property
    def chosen_mesher(self) -> str:
        """The mesher of the scene, or else the one that suits the polynomial degree."""
        quads = self.degree is None or self.degree >= LAYERED
        return self.mesher or ("quads" if quads else "gmsh")


class MdrAccuracy(Sizes):
    """The table `accuracy.mdr` of the scene: elements, and the uniform grid of `mdr-grid`."""

    prefix = "accuracy.mdr."

    degree: int | None = optional("highest degree of the pressure, 1 to 20", ge=1, le=20)
    grading: float | None = optional("ratio of neighbouring sizes, 0.05 to 0.8", ge=0.05, le=0.8)
    grid: int = Field(
        default=400,
        ge=4,
        le=20_000,
        description="springs of the uniform grid of mdr-grid, 4 to 20000",
    )
    step: Annotated[Positive, Unit("time")] | None = optional(
        "time step of mdr-grid, positive; by default half of the greatest stable step"
    )


class AccuracySection(Section):
    """The table `accuracy` of the scene: the relative accuracy, and sizes by method."""

    prefix = "accuracy."

    rtol: float = Field(
        default=1e-4, ge=1e-9, le=0.1, description="the relative accuracy wanted, 1e-9 to 0.1"
    )
    fem: FemAccuracy = FemAccuracy()
    mdr: MdrAccuracy = MdrAccuracy()


class OutputSection(Section):
    """The table `output` of the scene: the quantities, radii and times that are written."""

    prefix = "output."

    radii: Annotated[Increasing, Unit("length")] | None = optional(
        "radii from 0 to punch.radius, increasing", min_length=1
    )
    field_times: Annotated[Increasing, Unit("time")] | None = optional(
        "times at which the inside of the half-space is written, increasing", min_length=1
    )
    depth: Annotated[Positive, Unit("length")] | None = optional(
        "the distance from the axis up to which the inside of the half-space is written to "
        "half_space.vtu; all of the mesh if not given"
    )
    gradient_average: Literal["line", "area"] = "line"
    every_step: bool = False
    quantities: Annotated[list[str], AfterValidator(check_quantities)] = Field(
        default=["all"],
        min_length=1,
        description="a list of quantities, or of the groups history, fields, steady and all",
    )
