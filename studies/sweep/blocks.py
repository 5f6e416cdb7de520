"""Blocks of scenes.

What is computed at once, written at once and, after an interruption, computed again.

A block holds all scenes of one geometry, material and accuracy, as far as that is not too many:
they share a discretisation. So every axis is cut whole or into single values, by what its keys are.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import ceil, prod

from .axes import Axis, Sweep
from .layout import Layout

# keys that scenes may differ in and yet share a discretisation: wear, load, time and units
SHARING = (
    "punch.wear",
    "punch.radius",
    "half_space.plane",
    "half_space.youngs",
    "load.",
    "wear.",
    "output.",
    "title",
)
# least and most scenes of a block: of closed forms, which take a fraction of a millisecond each;
# and of any others
OF_CLOSED_FORMS, OF_OTHERS = (256, 1024), (8, 64)
# most numbers of a block
NUMBERS = 2**23


@dataclass(frozen=True)
class Block:
    """A box of the grid: first and last (beyond) place on each axis."""

    number: int
    bounds: tuple[tuple[int, int], ...]

    @property
    def region(self) -> tuple[slice, ...]:
        return tuple(slice(*bound) for bound in self.bounds)

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(last - first for first, last in self.bounds)

    @property
    def count(self) -> int:
        """Number of scenes."""
        return prod(self.shape)


def shares(axis: Axis) -> bool:
    """Whether scenes along an axis can share a discretisation."""
    return all(key.startswith(SHARING) for key in axis.columns)


def block_shape(sweep: Sweep, layout: Layout) -> tuple[int, ...]:
    """Scenes of a block along each axis."""
    least, most = OF_CLOSED_FORMS if layout.solvers == ("direct",) else OF_OTHERS
    numbers = sum(prod(variable.shape) for variable in layout.variables.values())
    most = max(1, min(most, NUMBERS // max(numbers, 1)))
    shape = [1] * len(sweep.axes)
    # the last axes first, as their scenes stand side by side in the store
    for wanted, sharing in ((most, True), (min(least, most), False)):
        for number in reversed(range(len(shape))):
            if shares(sweep.axes[number]) == sharing and prod(shape) < wanted:
                shape[number] = _evenly(len(sweep.axes[number]), wanted // prod(shape))
    return tuple(shape)


def _evenly(count: int, most: int) -> int:
    """Length of the parts that a number is cut into, of about one length and at most so long."""
    return ceil(count / ceil(count / max(most, 1)))


def blocks(sweep: Sweep, shape: tuple[int, ...]) -> Iterator[Block]:
    """All blocks, in the order of the grid."""
    parts = (
        [(first, min(first + step, len(axis))) for first in range(0, len(axis), step)]
        for axis, step in zip(sweep.axes, shape, strict=True)
    )
    for number, bounds in enumerate(product(*parts)):
        yield Block(number, bounds)
