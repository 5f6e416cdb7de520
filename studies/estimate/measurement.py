"""Measured numbers, and the errors that they are expected to have."""

from dataclasses import dataclass

import numpy as np

from ...meshes import Array


@dataclass(frozen=True, eq=False)
class Measurement:
    """A series of n measured values: one column of a table, or a profile at one time.

    Parameters
    ----------
    column : name of the column, without the number of a ring
    quantity : quantity that a model predicts for it, such as indentation or worn_volume
    times : (n,) in the units of the scene; (S,) if there are `means`
    values : (n,) in the units of the scene
    noise : (n,) standard deviations; infinite for values that are missing
    noise_known : whether the noise was given; otherwise only the ratios of the deviations count
    radii : (n,) for a profile; (R,) if there are `means`; None for numbers
    ring : index of the ring whose volume is measured, from 0; None for all rings together
    means : (P, R) weights of the P means over the radii that the values are, at each time in turn,
        so that n = S P; None for values at the radii themselves
    bias : standard deviation of the relative error that all values have in common
    """

    column: str
    quantity: str
    times: Array
    values: Array
    noise: Array
    noise_known: bool
    radii: Array | None = None
    ring: int | None = None
    means: Array | None = None
    bias: float = 0.0

    @property
    def has_offset(self) -> bool:
        """Whether all values share an unknown offset, like the heights of a profilometer."""
        return self.quantity == "profile" and self.means is None

    @property
    def common_error(self) -> tuple[Array, float]:
        """The error (n,) that all values have in common, over the noise, and its deviation.

        The deviation is infinite for an offset of which nothing is known, and 0 without such an
        error.
        """
        if self.has_offset:
            return 1 / self.noise, np.inf
        return self.values / self.noise, self.bias

    @property
    def label(self) -> str:
        """The quantity, and the ring if there is one, in words."""
        words = self.quantity.replace("_", " ")
        return words if self.ring is None else f"{words} of ring {self.ring + 1}"

    def repeats(self, other: "Measurement") -> bool:
        """Return whether another series has the same column, ring, times, radii and values.

        They are equal to roundoff, which a conversion of units may leave.
        """
        rows = [(each.column, each.ring, len(each.values)) for each in (self, other)]
        own, others = (
            np.concatenate([each.times, each.values, () if each.radii is None else each.radii])
            for each in (self, other)
        )
        return rows[0] == rows[1] and np.allclose(own, others, rtol=1e-12, atol=0.0)
