"""Solve unilateral contact for any compliance: ``p >= 0``, ``gap >= 0`` and ``p gap = 0``.

Non-dimensional. On a space of continuous piecewise linear pressures the unknowns are the nodal
values p. The gap is represented by its moments, ``g_i = int (u + f - d) phi_i dA = (A p + m)_i - d
b_i``, with the moments m of the profile f. An active-set method finds the contact: nodes with
negative pressure leave it and nodes with negative gap enter it, until there are none. Only signs
are tested, so no scaling is needed. If this iteration cycles, only one node changes at a time, the
one with the lowest index (Murty's rule). That cannot cycle because every principal minor of the
system is positive.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

# directly, because a march solves thousands of small systems, and the checks of `scipy.linalg` take
# as long as a solution; LAPACK's `dpotrs` takes more than twice the time of two calls of `dtrsv`
from scipy.linalg.blas import dsymv, dtrsv
from scipy.linalg.lapack import dgetrf, dgetrs, dpotrf

from ....meshes.errors import SolverError
from ....meshes.radial import Array

Mask = NDArray[np.bool_]


class Load(NamedTuple):
    """The load on the punch: a force or a fixed indentation. One of the two is None."""

    force: float | None = 1.0
    indentation: float | None = None


@dataclass(frozen=True)
class Interval:
    """A part of the contact, as an interval of radii.

    Parameters
    ----------
    inner, outer : float
        Radii of its edges.
    inner_free, outer_free : bool
        Whether each edge is free: the pressure vanishes there, and wear moves the edge. Other edges
        are corners of the face, or the axis.
    """

    inner: float
    outer: float
    inner_free: bool = False
    outer_free: bool = False


@dataclass(frozen=True, eq=False)
class ContactSolution:
    """The solution of a contact problem.

    Parameters
    ----------
    pressure : (n,) array
        Nodal pressures, none negative.
    gap : (n,) array
        Moments of the gap, zero in contact except for roundoff.
    indentation, force : float
        Indentation and force. The load prescribes one of them.
    contact : (n,) array of bool
        Whether each node is in contact.
    iterations : int
        Number of active sets tried.
    """

    pressure: Array
    gap: Array
    indentation: float
    force: float
    contact: Mask
    iterations: int


# greatest number of nodes by which a contact may differ from the factored one; with more, the
# matrix is factored again
MOST_CHANGES = 24
# Greatest gaps at contact nodes after a bordered solve, relative to |m| + |d| b. Above the first
# one the solution is refined, above the second one the matrix is factored again.
GAP_BY_ROUNDOFF, MOST_GAP = 1e-15, 1e-14


class Factor:
    """The Cholesky factor of the rows and columns of a matrix that belong to one contact.

    Raises
    ------
    SolverError
        if this block is not positive definite
    """

    def __init__(self, matrix: Array, contact: Mask) -> None:
        self.matrix, self.contact = matrix, contact.copy()
        self.nodes = np.flatnonzero(contact)
        first, last = self.nodes[0], self.nodes[-1] + 1
        if last - first == len(self.nodes):
            # the contact has one part: a slice needs no copy
            block = matrix[first:last, first:last]
        else:
            block = matrix[np.ix_(self.nodes, self.nodes)]
        # LAPACK stores columns: the transpose of a symmetric matrix needs no reordering
        self._cholesky, failed_at = dpotrf(block.T, clean=False)
        if failed_at:
            raise SolverError(
                f"the contact system is not positive definite: pivot {failed_at} is not positive; "
                "ask for fewer cells"
            )
        self._borders = dict[int, tuple[Array, Array]]()

    def solve(self, right: Array) -> Array:
        """Return the pressures (nodes,) of the contact nodes that have the moments `right`."""
        return dtrsv(self._cholesky, dtrsv(self._cholesky, right, trans=1))

    def border(self, node: int) -> tuple[Array, Array]:
        """Return the bordering column of a node (nodes,), and the factor's solution for it.

        If the node enters the contact, the column is its column of the matrix. If it leaves, the
        column is a unit vector, with which the bordered system makes its pressure zero.
        """
        if node not in self._borders:
            if self.contact[node]:
                column = (self.nodes == node).astype(float)
            else:
                column = self.matrix[self.nodes, node]
            self._borders[node] = column, self.solve(column)
        return self._borders[node]


class BorderedSystem:
    """The linear system of a contact, solved with the factor of a contact that is almost the same.

    Each node in which the two contacts differ adds a row and a column to the factored matrix. Block
    elimination with these columns and their Schur complement solves the system. If the contacts are
    equal, the factor alone solves it.
    """

    def __init__(self, factor: Factor, contact: Mask) -> None:
        self.factor, self.contact = factor, contact
        self.changed = np.flatnonzero(contact != factor.contact)
        self._enters = contact[self.changed]
        if len(self.changed):
            borders = [factor.border(node) for node in self.changed.tolist()]
            self._columns, self._column_solutions = (
                np.stack(parts, axis=1) for parts in zip(*borders, strict=True)
            )
            # rows and columns of entering nodes; the bordering block of leaving nodes is zero
            entering_pairs = np.outer(self._enters, self._enters)
            block = factor.matrix[np.ix_(self.changed, self.changed)] * entering_pairs
            self._schur = dgetrf(block - self._columns.T @ self._column_solutions)[:2]

    def solve(self, moments: Array) -> Array:
        """Return pressures (n,) with given moments (n,) in contact, zero elsewhere."""
        pressures, nodes = np.zeros(len(moments)), self.factor.nodes
        factor_solution = self.factor.solve(moments[nodes])
        if not len(self.changed):
            pressures[nodes] = factor_solution
            return pressures
        right = (
            np.where(self._enters, moments[self.changed], 0.0) - self._columns.T @ factor_solution
        )
        border_values, _ = dgetrs(*self._schur, right)
        pressures[nodes] = factor_solution - self._column_solutions @ border_values
        pressures[self.changed] = np.where(self._enters, border_values, 0.0)
        return pressures


class Contact:
    """The matrix of a contact problem; it stores the last factor and the last system.

    The steps of a march share them. Successive contacts differ by a few nodes, and bordering the
    factored system with these takes a fraction of the time of another factorisation.

    Parameters
    ----------
    matrix : (n, n) array
        Compliance matrix A of the nodal pressures.
    weights : (n,) array
        Integrals b of the basis functions over the face.
    """

    def __init__(self, matrix: Array, weights: Array) -> None:
        self.matrix, self.weights = matrix, weights
        self._system: BorderedSystem | None = None
        self._weights_solution: Array = np.empty(0)

    def _system_for(self, contact: Mask, refactorise: bool = False) -> BorderedSystem:
        """Return the system of a contact and store it; `refactorise` forces a new factorisation."""
        last = None if refactorise else self._system
        if last and np.array_equal(contact, last.contact):
            return last
        factor = last.factor if last else None
        if factor is None or np.count_nonzero(contact != factor.contact) > MOST_CHANGES:
            factor = Factor(self.matrix, contact)
        self._system = system = BorderedSystem(factor, contact)
        self._weights_solution = system.solve(self.weights)
        return system

    def _solve_for_contact(
        self, moments: Array, load: Load, contact: Mask, refactorise: bool = False
    ) -> tuple[Array, Array, float]:
        """Return pressure, gap and indentation for exactly the given contact.

        Pressures and gaps may have either sign.
        """
        if not contact.any():
            indentation = float(load.indentation or 0.0)
            return np.zeros(len(contact)), moments - indentation * self.weights, indentation
        system, weights = self._system_for(contact, refactorise), self.weights
        moments_solution, weights_solution = system.solve(moments), self._weights_solution
        if load.force is None:
            indentation = float(load.indentation or 0.0)
        else:
            indentation = float(
                (load.force + weights @ moments_solution) / (weights @ weights_solution)
            )
        pressure = indentation * weights_solution - moments_solution
        # a product that reads one triangle of the matrix takes two thirds of the time
        gap = dsymv(1.0, self.matrix.T, pressure) + moments - indentation * weights
        if not len(system.changed):
            return pressure, gap, indentation
        # NaN, from a singular Schur complement, is not within a tolerance
        scale = np.abs(moments) + abs(indentation) * weights
        if (np.abs(gap) <= GAP_BY_ROUNDOFF * scale)[contact].all():
            return pressure, gap, indentation
        # bordering has lost a digit or two, which one step of iterative refinement restores
        correction = system.solve(gap)
        if load.force is not None:
            indentation_change = float((weights @ correction) / (weights @ weights_solution))
            correction = correction - indentation_change * weights_solution
            indentation = indentation + indentation_change
        pressure -= correction
        gap = dsymv(1.0, self.matrix.T, pressure) + moments - indentation * weights
        if not (np.abs(gap) <= MOST_GAP * scale)[contact].all():
            return self._solve_for_contact(moments, load, contact, refactorise=True)
        return pressure, gap, indentation

    def press(self, moments: Array, load: Load, start: Mask | None = None) -> ContactSolution:
        """Solve the contact problem under a load.

        Parameters
        ----------
        moments : (n,) array
            Moments of the profile.
        load : Load
            Force or indentation.
        start : (n,) array of bool, optional
            First guess of the contact; all nodes if it is not given.

        Raises
        ------
        SolverError
            if no contact satisfies the inequalities, which only roundoff can cause
        """
        if load.force == 0:
            # without a force, the punch rests on its point nearest to the half-space
            indentation = float((moments / self.weights).min())
            gap, zero = moments - indentation * self.weights, np.zeros(len(moments))
            return ContactSolution(zero, gap, indentation, 0.0, zero > 0, 1)
        contact = np.ones(len(moments), dtype=bool) if start is None else start
        if load.force is not None:
            contact = self._not_empty(contact, moments)
        for count in range(1, 4000):
            pressure, gap, indentation = self._solve_for_contact(moments, load, contact)
            # bound on the roundoff in a gap that is zero
            roundoff = 1e-15 * (np.abs(moments) + abs(indentation) * self.weights)
            violations = np.where(contact, pressure < 0, gap < -roundoff)
            if not violations.any():
                force = load.force if load.force is not None else float(self.weights @ pressure)
                return ContactSolution(pressure, gap, indentation, force, contact, count)
            if count > 40:
                # changes of many nodes at a time may cycle: change the lowest index only
                violations[np.flatnonzero(violations)[0] + 1 :] = False
            contact = contact ^ violations
            if load.force is not None:
                contact = self._not_empty(contact, gap)
        raise SolverError("no contact satisfies the inequalities: ask for fewer cells")

    def respond(self, moments: Array, load: Load, contact: Mask) -> Array:
        """Return the change of pressure (n,) on a contact that causes a change of moments (n,).

        The force does not change, unless the load is an indentation.
        """
        change = self._system_for(contact).solve(moments)
        if load.force is None:
            return change
        uniform = self._weights_solution
        return change - (self.weights @ change) / (self.weights @ uniform) * uniform

    def _not_empty(self, contact: Mask, gap: Array) -> Mask:
        """Return the contact, or the node nearest to the half-space if the contact is empty.

        At least one node has to carry the force.
        """
        if contact.any():
            return contact
        return np.arange(len(gap)) == np.argmin(gap / self.weights)
