"""An anchor: a closed form or a conservation law that a reported number is checked against."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ....meshes.radial import Array


@dataclass(frozen=True)
class Anchor:
    """One closed form or conservation law, and how far a method is from it.

    Parameters
    ----------
    name : what is checked
    method : name of the method whose report is checked
    difference : relative difference, of the entry with the largest difference over tolerance
    tolerance : allowed relative difference of that entry
    """

    name: str
    method: str
    difference: float
    tolerance: float

    @property
    def holds(self) -> bool:
        """Whether the difference is within the tolerance."""
        return self.difference <= self.tolerance


class Row(NamedTuple):
    """A value and the reference that it must equal; arrays broadcast against each other.

    The difference is relative to `scale`, or to `reference` if there is no scale.
    """

    name: str
    value: Array | float
    reference: Array | float
    tolerance: Array | float
    scale: Array | float | None = None


Rows = Iterator[Row]


def judge(row: Row, method: str) -> Iterator[Anchor]:
    """Yield the anchor of a row: its entry with the largest difference over tolerance.

    A value that is not a number fails. Nothing is yielded if every tolerance is infinite, because
    such an anchor could not fail.
    """
    scale = row.reference if row.scale is None else row.scale
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        difference = np.abs((row.value - row.reference) / scale)
    # JSON has no number for NaN and infinity
    difference = np.nan_to_num(difference, nan=1e99, posinf=1e99)
    differences, tolerances = np.broadcast_arrays(np.atleast_1d(difference), row.tolerance)
    bounded = np.isfinite(tolerances)
    if not bounded.any():
        return
    differences, tolerances = differences[bounded], tolerances[bounded]
    worst = np.argmax(differences / np.maximum(tolerances, np.finfo(float).tiny))
    yield Anchor(row.name, method, float(differences[worst]), float(tolerances[worst]))
