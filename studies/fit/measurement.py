"""What is measured, and what a model of it yields."""

from dataclasses import dataclass, replace
from typing import Protocol

from ...meshes.radial import Array


@dataclass(frozen=True, eq=False)
class Measurement:
    """One column of a table; of profiles, one for each time.

    Parameters
    ----------
    column : its name, without the number of a ring
    quantity : what a model predicts for it: indentation, normal_force, profile or worn_volume
    times : (n,) in the units of the scene
    values : (n,) in the units of the scene
    noise : (n,) standard deviations
    noise_known : whether these were given; else only their ratios are meant
    radii : (n,) of a profile; None of anything else
    ring : number of the ring that a volume is of, from 0; None of all rings together
    """

    column: str
    quantity: str
    times: Array
    values: Array
    noise: Array
    noise_known: bool
    radii: Array | None = None
    ring: int | None = None

    @property
    def has_offset(self) -> bool:
        """Whether a constant is unknown, as heights of a profilometer have it."""
        return self.quantity == "profile"

    @property
    def label(self) -> str:
        """What figures call it."""
        words = self.quantity.replace("_", " ")
        return words if self.ring is None else f"{words} of ring {self.ring + 1}"

    def scaled(self, factor: float) -> "Measurement":
        """Return it with its noise times a factor."""
        return replace(self, noise=self.noise * factor)


class Predictor(Protocol):
    """A model of what is measured."""

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """What is predicted."""

    @property
    def rtol(self) -> float:
        """The accuracy of the model."""

    def predict(self, x: Array) -> list[Array]:
        """Return the values (n,) of each measurement at coordinates (m,) of the parameters."""

    def slopes(self, x: Array) -> list[Array]:
        """Return the derivatives (n, m) of each measurement by these coordinates."""

    def measuring(self, measurements: tuple[Measurement, ...]) -> "Predictor":
        """Return the model of other measurements."""
