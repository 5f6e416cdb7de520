"""Elements graded to every ring edge, in ``s = 1 - r^2``.

In distances from an edge, a thin one keeps all its digits.
"""

from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np

from ...meshes.radial import Array, Indices


class Layers(NamedTuple):
    """Elements from the rim (s = 0) to the axis.

    Parameters
    ----------
    edge : (n,) the nearest ring edge of each element, in s
    low, high : (n,) its ends, as distances from that edge
    ring : (n,) its ring, counted from the rim
    between : (n,) how many elements are between it and the edge
    """

    edge: Array
    low: Array
    high: Array
    ring: Indices
    between: Indices

    @classmethod
    def graded(cls, edges: Array, smallest: Array, factor: float) -> Self:
        """Elements that shrink by a factor towards every ring edge, down to a size at each.

        The axis is no edge.
        """
        pieces: list[Layers] = []
        for ring, (left, right) in enumerate(pairwise(edges)):
            half = (right - left) / 2
            for edge, beside in ((left, ring), (right, ring + 1)):
                at_axis = beside == len(smallest)
                ends = np.append(0.0, _graded(half, half if at_axis else smallest[beside], factor))
                between = np.arange(len(ends) - 1) + (len(pieces[-1].low) if at_axis else 0)
                piece = cls(
                    np.full(len(between), edge),
                    ends[:-1],
                    ends[1:],
                    np.full(len(between), ring),
                    between,
                )
                pieces.append(piece if edge == left else piece.mirrored())
        return cls(*(np.concatenate(parts) for parts in zip(*pieces, strict=True)))

    def mirrored(self) -> Self:
        """The same on the other side of the edge."""
        return self._replace(low=-self.high[::-1], high=-self.low[::-1], between=self.between[::-1])

    @property
    def widths(self) -> Array:
        return self.high - self.low

    @property
    def breakpoints(self) -> Array:
        """(n+1,) element boundaries in s, to the digits of s."""
        return np.append(self.edge + self.low, 1.0)


def _graded(half: float, smallest: float, factor: float) -> Array:
    count = max(0, int(np.ceil(np.log(smallest / half) / np.log(factor))))
    return np.asarray(half * factor ** np.arange(count, -1.0, -1))
