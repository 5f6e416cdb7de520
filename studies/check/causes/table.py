"""Histories that are computed once and interpolated at any time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....meshes import Array


@dataclass(frozen=True, eq=False)
class Table:
    """A history of K numbers at T times, linear between them.

    Parameters
    ----------
    times : (T,) non-dimensional, increasing, from 0
    values : (T, K)
    growing : (K,) whether a column continues linearly beyond the last time; otherwise it keeps its
        last value
    """

    times: Array
    values: Array
    growing: NDArray[np.bool_]

    def at(self, times: Array) -> Array:
        """Return the values (S, K) at times (S,)."""
        interval = np.clip(np.searchsorted(self.times, times) - 1, 0, len(self.times) - 2)
        start = self.times[interval]
        fraction = (np.maximum(times, 0.0) - start) / (self.times[interval + 1] - start)
        weight = np.where(self.growing, fraction[:, None], np.minimum(fraction, 1.0)[:, None])
        first = self.values[interval]
        return np.asarray(first + weight * (self.values[interval + 1] - first))

    @cached_property
    def _step_responses(self) -> Array:
        """(T, T - 1, K) values at each time after a unit step of the indentation in an interval.

        The step is placed in the middle of the interval.
        """
        lags = self.times[:, None] - (self.times[1:] + self.times[:-1]) / 2
        responses = self.at(lags.ravel()).reshape(*lags.shape, -1)
        responses[lags < 0] = 0.0
        return responses

    def with_lowered_surface(self, low: float) -> "Table":
        """Return the history at the same indentation if the force lowers all of the surface.

        The punch then presses as if its indentation were greater by that amount, which changes with
        the force. The force is the last column. It depends linearly on the earlier changes of the
        indentation (Boltzmann's superposition).

        Parameters
        ----------
        low : displacement by which the force 1 lowers the surface less, over the indentation
        """
        start, steps = self.values[:, -1], np.diff(np.eye(len(self.times)), axis=0)
        matrix = np.eye(len(start)) - low * self._step_responses[..., -1] @ steps
        matrix[:, 0] -= low * start
        extra = low * np.linalg.solve(matrix, start)
        values = self.values * (1 + extra[0])
        values = values + np.tensordot(np.diff(extra), self._step_responses, (0, 1))
        return Table(self.times, values, self.growing)
