"""A closed form or a balance that a method is held to, and how it is judged."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...meshes.radial import Array


@dataclass(frozen=True)
class Anchor:
    """A closed form or a balance that a method is held to.

    Relative difference and what is tolerated.
    """

    name: str
    method: str
    difference: float
    tolerance: float

    @property
    def holds(self) -> bool:
        return self.difference <= self.tolerance


def judge(
    name: str,
    method: str,
    value: Array | float,
    reference: Array | float,
    tolerance: Array | float,
    scale: Array | float | None = None,
) -> Iterator[Anchor]:
    """Yield an anchor where the difference is the greatest part of what is tolerated.

    It is relative to the reference, or to a scale. What is no number holds to nothing, and what may
    be infinitely wrong is no anchor.
    """
    difference = np.abs((value - reference) / (reference if scale is None else scale))
    # JSON cannot hold what is no number
    difference = np.nan_to_num(difference, nan=1e99)
    differences, tolerances = np.broadcast_arrays(np.atleast_1d(difference), tolerance)
    if (bound := np.isfinite(tolerances)).any():
        differences, tolerances = differences[bound], tolerances[bound]
        worst = np.argmax(differences / tolerances)
        yield Anchor(name, method, float(differences[worst]), float(tolerances[worst]))
