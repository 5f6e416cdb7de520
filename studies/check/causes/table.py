"""Histories that are computed once, and read at any time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....meshes.radial import Array


@dataclass(frozen=True, eq=False)
class Table:
    """A history (T, K) over non-dimensional times, between which it is linear.

    Parameters
    ----------
    times : (T,)
    values : (T, K)
    growing : (K,) whether a column goes on straight beyond the last time; else it stays
    """

    times: Array
    values: Array
    growing: NDArray[np.bool_]

    def at(self, times: Array) -> Array:
        """Return values (S, K) at times."""
        place = np.clip(np.searchsorted(self.times, times) - 1, 0, len(self.times) - 2)
        start = self.times[place]
        share = (np.maximum(times, 0.0) - start) / (self.times[place + 1] - start)
        part = np.where(self.growing, share[:, None], np.minimum(share, 1.0)[:, None])
        before = self.values[place]
        return np.asarray(before + part * (self.values[place + 1] - before))

    @cached_property
    def _later(self) -> Array:
        """(T, T - 1, K) what a step of the indentation in each interval causes later."""
        lags = self.times[:, None] - (self.times[1:] + self.times[:-1]) / 2
        later = self.at(lags.ravel()).reshape(*lags.shape, -1)
        later[lags < 0] = 0.0
        return later

    def lowered(self, low: float) -> "Table":
        """Return the history under the same indentation where a force lowers all of the surface.

        The punch presses as if its indentation were greater by that, and this changes with the
        force. The force is the last column, and linear in the indentation's changes before
        (Boltzmann's superposition).

        Parameters
        ----------
        low : by how much the force 1 lowers the surface less, over the indentation
        """
        start, steps = self.values[:, -1], np.diff(np.eye(len(self.times)), axis=0)
        whole = np.eye(len(start)) - low * self._later[..., -1] @ steps
        whole[:, 0] -= low * start
        more = low * np.linalg.solve(whole, start)
        values = self.values * (1 + more[0]) + np.tensordot(np.diff(more), self._later, (0, 1))
        return Table(self.times, values, self.growing)
