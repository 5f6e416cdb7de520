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
from scipy.linalg import cho_factor, cho_solve, lu_factor, lu_solve

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


# nodes that may enter or leave a contact before its matrix is factored anew
MOST_CHANGES = 24
# gap in contact, over the size of its two parts, beyond which a bordered system is solved anew
ROUNDOFF_OF_BORDERED = 1e-14


class Factor:
    """The Cholesky factor of a matrix on the nodes of one contact."""

    def __init__(self, matrix: Array, contact: Mask) -> None:
        self.matrix, self.contact = matrix, contact.copy()
        self.nodes = np.flatnonzero(contact)
        first, last = self.nodes[0], self.nodes[-1] + 1
        if last - first == len(self.nodes):
            # contact in one piece: a slice needs no copy
            block = matrix[first:last, first:last]
        else:
            block = matrix[np.ix_(self.nodes, self.nodes)]
        try:
            self._cholesky = cho_factor(block, check_finite=False)
        except np.linalg.LinAlgError as error:
            raise SolverError(
                f"the contact system is not positive definite: {error}; ask for fewer cells"
            ) from error
        self._borders = dict[int, tuple[Array, Array]]()

    def solve(self, right: Array) -> Array:
        """Return the pressures of its nodes that make moments of these (nodes,)."""
        return np.asarray(cho_solve(self._cholesky, right, check_finite=False))

    def border(self, node: int) -> tuple[Array, Array]:
        """Return the column that a node borders the system by, and what solves for it (nodes,).

        For a node that enters, that is its column of the matrix. For one that leaves, it is a unit
        vector: the bordered system makes its pressure zero.
        """
        if node not in self._borders:
            if self.contact[node]:
                column = (self.nodes == node).astype(float)
            else:
                column = self.matrix[self.nodes, node]
            self._borders[node] = column, self.solve(column)
        return self._borders[node]


class BorderedSystem:
    """A contact system by the factor of another contact, of which a few nodes differ.

    With the columns B that border the factored matrix, and the Schur complement S, it is solved by
    block elimination; without such nodes by the factor alone.
    """

    def __init__(self, factor: Factor, contact: Mask) -> None:
        self.factor = factor
        self.changed = np.flatnonzero(contact != factor.contact)
        self._enters = contact[self.changed]
        if len(self.changed):
            borders = [factor.border(node) for node in self.changed.tolist()]
            self._columns, self._solved = (
                np.stack(parts, axis=1) for parts in zip(*borders, strict=True)
            )
            # the matrix among nodes that enter; those that leave have no equation of their own
            both = np.outer(self._enters, self._enters)
            own = factor.matrix[np.ix_(self.changed, self.changed)] * both
            self._schur = lu_factor(own - self._columns.T @ self._solved, check_finite=False)

    def solve(self, moments: Array) -> Array:
        """Return pressures (n,) that make moments (n,) in contact, zero elsewhere."""
        pressures, nodes = np.zeros(len(moments)), self.factor.nodes
        inside = self.factor.solve(moments[nodes])
        if not len(self.changed):
            pressures[nodes] = inside
            return pressures
        right = np.where(self._enters, moments[self.changed], 0.0) - self._columns.T @ inside
        bordering = lu_solve(self._schur, right, check_finite=False)
        pressures[nodes] = inside - self._solved @ bordering
        pressures[self.changed] = np.where(self._enters, bordering, 0.0)
        return pressures


class Contact:
    """The matrix of a contact problem, with its last factor and system kept.

    Steps of a march share them. Neighbouring contacts differ by a few nodes, which border the
    factored system: that takes a fraction of the time of another factor.
    """

    def __init__(self, matrix: Array, weights: Array) -> None:
        self.matrix, self.weights = matrix, weights
        self._contact: Mask | None = None
        self._system: BorderedSystem | None = None
        self._by_weights = np.empty(0)

    def _system_of(self, contact: Mask, anew: bool = False) -> BorderedSystem:
        """Return the system of a contact, and keep it; of a factor of its own if wanted anew."""
        last, tried = self._system, self._contact
        if last is not None and tried is not None and not anew and np.array_equal(contact, tried):
            return last
        factor = None if last is None or anew else last.factor
        if factor is None or np.count_nonzero(contact != factor.contact) > MOST_CHANGES:
            factor = Factor(self.matrix, contact)
        system = BorderedSystem(factor, contact)
        self._system, self._contact = system, contact.copy()
        self._by_weights = system.solve(self.weights)
        return system

    def _solved(
        self, moments: Array, load: Load, contact: Mask, anew: bool = False
    ) -> tuple[Array, Array, float]:
        """Return pressure, gap and indentation if exactly the given nodes were in contact.

        Pressures and gaps may have any sign.
        """
        if not contact.any():
            indentation = float(load.indentation or 0.0)
            return np.zeros(len(contact)), moments - indentation * self.weights, indentation
        system, weights = self._system_of(contact, anew), self.weights
        by_moments, by_weights = system.solve(moments), self._by_weights
        if load.force is None:
            indentation = float(load.indentation or 0.0)
        else:
            indentation = float((load.force + weights @ by_moments) / (weights @ by_weights))
        pressure = indentation * by_weights - by_moments
        gap = self.matrix @ pressure + moments - indentation * weights
        if len(system.changed):
            # borders lose a digit or two, which one step of iterative refinement brings back
            wrong = system.solve(gap)
            if load.force is not None:
                deeper = float((weights @ wrong) / (weights @ by_weights))
                wrong, indentation = wrong - deeper * by_weights, indentation + deeper
            pressure -= wrong
            gap = self.matrix @ pressure + moments - indentation * weights
            roundoff = np.abs(moments) + abs(indentation) * weights
            if (np.abs(gap) > ROUNDOFF_OF_BORDERED * roundoff)[contact].any():
                return self._solved(moments, load, contact, anew=True)
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
        """Return a contact in which at least one node carries the force.

        An empty contact is replaced by the node that is nearest to the half-space.
        """
        if contact.any():
            return contact
        return np.arange(len(gap)) == np.argmin(gap / self.weights)
