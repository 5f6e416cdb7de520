"""Explicit updates of a worn profile: their longest stable step, and the limit of short steps.

A program with elements updates the profile at its contact nodes by ``f += k v p dt``. In contact,
``p = g F - G f`` under a given force F, with a matrix G of the mesh. Euler's explicit method is
stable if

    dt <= 2 Re(l) / |l|^2    for all eigenvalues l of k v G.

Beyond that, the modes of the largest eigenvalues, which change their sign from node to node, grow
by the factor ``|1 - l dt|`` with each update. Non-dimensional: time unit a / (E* k v) with the
greatest wear coefficient k.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import eigs

from ...meshes import Array, Indices
from ..crosscheck import Problem, Rings
from .contact_nodes import ContactNodes

MOST_DENSE = 600
"""Greatest number of nodes of which all eigenvalues are computed, and not only the largest one."""
ITERATION_TOLERANCE = 1e-4
"""Relative residual of the largest eigenvalue of more nodes; those next to it are close."""
LEAST_PART = 1e-3
"""Eigenvalues below this part of the largest one do not limit the step."""
ZERO_RATE = 1e-7
"""Rate of a mode over the greatest one below which it is roundoff: even wear does not decay, nor
does a node on the axis whose pressure follows from those of others."""


def wear_at_nodes(rings: Rings, radii: Array) -> Array:
    """Return the wear coefficients (n,) at nodes, over the greatest; harmonic means at ring edges.

    The steady pressure is proportional to 1 / k, so that the harmonic mean is that of the mean
    pressure of both sides. With the arithmetic mean, pressures beside an edge err by 15 %.
    """
    inside, outside = (
        rings.at(np.clip(radii + shift, rings.ring_edges[0], 1.0)) for shift in (-1e-7, 1e-7)
    )
    return 2 / (1 / inside + 1 / outside)


@dataclass(frozen=True, eq=False)
class ExplicitWear:
    """Explicit updates of the profile at n contact nodes of a mesh that stay in contact.

    Parameters
    ----------
    nodes : the nodes
    treatment : how pressures are computed from the forces on the nodes
    wear : (n,) wear coefficients of the nodes in contact, over the greatest
    force : the force; None if the indentation is given
    touching : numbers of the nodes in contact; the others carry no force
    """

    nodes: ContactNodes
    treatment: str
    wear: Array
    force: float | None
    touching: Indices

    @cached_property
    def _stiffness(self) -> Array:
        """(n, n) stiffness of the nodes in contact."""
        if len(self.touching) == len(self.nodes.radii):
            return self.nodes.stiffness
        compliance = self.nodes.compliance[np.ix_(self.touching, self.touching)]
        return np.asarray(np.linalg.inv(compliance), dtype=float)

    @cached_property
    def _stiffness_per_area(self) -> Array:
        to_pressures = self.nodes.pressures(self.treatment)[np.ix_(self.touching, self.touching)]
        return to_pressures @ self._stiffness

    @cached_property
    def _forces_of_indentation(self) -> Array:
        """(n,) force on each node under the indentation 1."""
        return self._stiffness.sum(axis=0)

    @cached_property
    def relief(self) -> Array:
        """(n, n) the matrix G of ``p = p0 - G f``."""
        matrix = self._stiffness_per_area
        if self.force is None:
            return matrix
        per_depth = matrix.sum(axis=1)
        forces = self._forces_of_indentation
        return matrix - np.outer(per_depth, forces) / forces.sum()

    @cached_property
    def start(self) -> Array:
        """(n,) pressures of the unworn flat punch, under the force or the indentation 1."""
        per_depth = self._stiffness_per_area.sum(axis=1)
        if self.force is None:
            return per_depth
        return per_depth * self.force / self._forces_of_indentation.sum()

    def depth(self, profiles: Array) -> Array:
        """Return the indentations (...) of worn profiles (..., n)."""
        forces = self._forces_of_indentation
        if self.force is None:
            return np.ones(profiles.shape[:-1])
        return (self.force + profiles @ forces) / forces.sum()

    def pressures(self, profiles: Array) -> Array:
        """Return the pressures (..., n) of worn profiles (..., n)."""
        return self.start - profiles @ self.relief.T

    @cached_property
    def limit(self) -> float:
        """The longest stable step."""
        operator = self.wear[:, None] * self.relief
        if len(operator) <= MOST_DENSE:
            values = np.linalg.eigvals(operator)
        else:
            start = (-1.0) ** np.arange(len(operator))
            values = eigs(operator, k=1, v0=start, tol=ITERATION_TOLERANCE)[0]
        values = values[np.abs(values) > LEAST_PART * np.abs(values).max()]
        return float((2 * values.real / np.abs(values) ** 2).min())

    def exact(self, times: Array) -> Array:
        """Return the worn profiles (T, n) of this mesh at times (T,) without any error of steps."""
        rates, vectors = np.linalg.eig(self.wear[:, None] * self.relief)
        parts = vectors * np.linalg.solve(vectors, (self.wear * self.start).astype(complex))
        decays = np.abs(rates) > ZERO_RATE * np.abs(rates).max()
        rest, elapsed = np.where(decays, rates, 1.0), times[:, None]
        grown = np.where(decays, -np.expm1(-rest * elapsed) / rest, elapsed)
        return (grown @ parts.T).real


def explicit(
    problem: Problem, nodes: ContactNodes, treatment: str, touching: Indices | None = None
) -> ExplicitWear:
    """Return the explicit updates of a problem at the nodes of a mesh.

    Parameters
    ----------
    problem : the problem
    nodes : the nodes
    treatment : how pressures are computed from the forces on the nodes
    touching : numbers of the nodes in contact; by default all
    """
    force = None if problem.indentation is not None else 1.0
    if touching is None:
        touching = np.arange(len(nodes.radii))
    wear = wear_at_nodes(problem.merged, nodes.radii[touching])
    return ExplicitWear(nodes, treatment, wear, force, touching)
