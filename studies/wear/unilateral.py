"""Unilateral contact on any compliance.

``p >= 0``, ``gap >= 0``, and their product zero. Non-dimensional.

On a space of continuous piecewise linear pressures the unknowns are their values at nodes, and the
gap is known by its moments, ``g_i = int (u + f - d) phi_i dA = (A p + m)_i - d b_i`` with the
moments m of the profile. The contact is found by an active set: nodes of negative pressure leave
it, nodes of negative gap enter, until none does. Signs alone decide, so nothing has to be scaled.
Should that ever cycle, one node at a time (the one of least number, Murty's rule) cannot: every
principal minor of the system is positive.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from ...meshes.errors import SolverError
from ...meshes.radial import Array

Mask = NDArray[np.bool_]


class Load(NamedTuple):
    """How the punch is held: by a force, or by its indentation. One of the two is None."""

    force: float | None = 1.0
    indentation: float | None = None


@dataclass(frozen=True)
class Interval:
    """A part of the radius in contact; an edge on the axis is none, and counts as fixed."""

    inner: float
    outer: float
    inner_free: bool = False
    outer_free: bool = False


@dataclass(frozen=True, eq=False)
class Press:
    """A punch pressed on.

    Parameters
    ----------
    pressure : (n,) at the nodes, none negative
    gap : (n,) moments of the gap, zero in contact to roundoff
    indentation, force : one of them as given
    contact : (n,) which nodes carry
    iterations : active sets that were tried on the finest level
    """

    pressure: Array
    gap: Array
    indentation: float
    force: float
    contact: Mask
    iterations: int


class Contact:
    """The matrix of a contact problem, with the factor of its last active set kept.

    Steps of a march share it.
    """

    def __init__(self, matrix: Array, weights: Array) -> None:
        self.matrix, self.weights = matrix, weights
        self._contact: Mask | None = None

    def _factored(self, contact: Mask) -> None:
        if self._contact is not None and np.array_equal(contact, self._contact):
            return
        self._inside = np.flatnonzero(contact)
        block = self.matrix[np.ix_(self._inside, self._inside)]
        try:
            self._factor = cho_factor(block, check_finite=False)
        except np.linalg.LinAlgError as error:
            raise SolverError(
                f"the contact system is not positive definite: {error}; ask for fewer cells"
            ) from error
        self._by_weights = cho_solve(self._factor, self.weights[self._inside], check_finite=False)
        self._contact = contact.copy()

    def _solved(self, moments: Array, load: Load, contact: Mask) -> tuple[Array, Array, float]:
        """Pressure, gap and indentation if exactly these nodes were in contact, whatever
        the signs.
        """
        self._factored(contact)
        inside = self._inside
        by_moments = cho_solve(self._factor, moments[inside], check_finite=False)
        if load.force is None:
            indentation = float(load.indentation or 0.0)
        else:
            weights = self.weights[inside]
            indentation = float((load.force + weights @ by_moments) / (weights @ self._by_weights))
        pressure = np.zeros(len(contact))
        pressure[inside] = indentation * self._by_weights - by_moments
        gap = self.matrix[:, inside] @ pressure[inside] + moments - indentation * self.weights
        return pressure, gap, indentation

    def press(self, moments: Array, load: Load, start: Mask | None = None) -> Press:
        """Find the contact.

        Parameters
        ----------
        moments : (n,) of the profile
        load : force or indentation
        start : (n,) nodes to try first; all of them if not given

        Raises
        ------
        SolverError
            if no contact is found, which roundoff alone can cause
        """
        if load.force == 0:
            # it rests on the point nearest to the half-space
            indentation = float((moments / self.weights).min())
            gap, none = moments - indentation * self.weights, np.zeros(len(moments))
            return Press(none, gap, indentation, 0.0, none > 0, 1)
        contact = np.ones(len(moments), dtype=bool) if start is None else start
        if load.force is not None:
            contact = self._not_empty(contact, moments)
        for count in range(1, 4000):
            pressure, gap, indentation = self._solved(moments, load, contact)
            # what roundoff makes of a gap that is zero
            noise = 1e-15 * (np.abs(moments) + abs(indentation) * self.weights)
            wrong = np.where(contact, pressure < 0, gap < -noise)
            if not wrong.any():
                force = load.force if load.force is not None else float(self.weights @ pressure)
                return Press(pressure, gap, indentation, force, contact, count)
            if count > 40:
                # many at a time go in circles
                wrong[np.flatnonzero(wrong)[0] + 1 :] = False
            contact = contact ^ wrong
            if load.force is not None:
                contact = self._not_empty(contact, gap)
        raise SolverError("no contact satisfies the inequalities: ask for fewer cells")

    def _not_empty(self, contact: Mask, gap: Array) -> Mask:
        """Under a force something carries it: at the least the node nearest to the half-space."""
        if contact.any():
            return contact
        return np.arange(len(gap)) == np.argmin(gap / self.weights)
