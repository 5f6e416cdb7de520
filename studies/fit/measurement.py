"""Measurements, and the interface of models that predict them."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from ...meshes import Array


@dataclass(frozen=True, eq=False)
class Measurement:
    """A series of n measured values: one column of a table, or a profile at one time.

    Parameters
    ----------
    column : name of the column, without the number of a ring
    quantity : quantity that a model predicts for it: indentation, normal_force, profile or
        worn_volume
    times : (n,) in the units of the scene
    values : (n,) in the units of the scene
    noise : (n,) standard deviations
    noise_known : whether the noise was given; otherwise only the ratios of the deviations count
    radii : (n,) for a profile; None for other quantities
    ring : index of the ring whose volume is measured, from 0; None for all rings together
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
        """Whether all values share an unknown offset, like the heights of a profilometer."""
        return self.quantity == "profile"

    @property
    def label(self) -> str:
        """The quantity, and the ring if there is one, in words."""
        words = self.quantity.replace("_", " ")
        return words if self.ring is None else f"{words} of ring {self.ring + 1}"

    def repeats(self, other: "Measurement") -> bool:
        """Return whether another series has the same column, ring, times, radii and values.

        They are equal to roundoff, which a conversion of units may leave.
        """
        if (self.column, self.ring, len(self.values)) != (
            other.column,
            other.ring,
            len(other.values),
        ):
            return False
        pairs = [(self.times, other.times), (self.values, other.values)]
        if self.radii is not None and other.radii is not None:
            pairs.append((self.radii, other.radii))
        return all(np.allclose(own, others, rtol=1e-12, atol=0.0) for own, others in pairs)

    def with_scaled_noise(self, factor: float) -> "Measurement":
        """Return the measurement with its noise multiplied by a factor."""
        return replace(self, noise=self.noise * factor)


class Predictor(Protocol):
    """A model that predicts measurements for coordinates (m,) of the parameters."""

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """The measurements that are predicted."""

    @property
    def rtol(self) -> float:
        """The tolerance to which the model is solved."""

    def predict(self, x: Array) -> list[Array]:
        """Return the values (n,) of each measurement at coordinates (m,)."""

    def slopes(self, x: Array) -> list[Array]:
        """Return the derivatives (n, m) of each measurement by the coordinates."""

    def for_measurements(self, measurements: tuple[Measurement, ...]) -> "Predictor":
        """Return the model that predicts other measurements."""
