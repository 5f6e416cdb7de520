"""Explicit updates of a worn profile: their longest stable step, and their errors.

A program with elements updates the profile at its contact nodes by ``f += k v p dt``. In contact,
``p = g F - G f`` under a given force F, with a matrix G of the mesh. Euler's explicit method is
stable if

    dt <= 2 Re(l) / |l|^2    for all eigenvalues l of k v G.

Beyond that, the modes of the largest eigenvalues, which change their sign from node to node, grow
by the factor ``|1 - l dt|`` with each update. Non-dimensional: time unit a / (E* k v) with the
greatest wear coefficient k.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
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
WORN_IN = 0.01
"""Part of the running-in of the indentation that is left when it counts as complete."""
INSIDE = 0.94
"""Radius inside which pressures are compared: at the rim they are infinite at the start."""


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
    nodal_wear : (k,) wear coefficients at all nodes, over the greatest
    force : the force; None if the indentation is given
    touching : numbers of the nodes in contact; the others carry no force
    """

    nodes: ContactNodes
    treatment: str
    nodal_wear: Array
    force: float | None
    touching: Indices

    @cached_property
    def wear(self) -> Array:
        """(n,) wear coefficients of the nodes in contact."""
        return self.nodal_wear[self.touching]

    @cached_property
    def radii(self) -> Array:
        """(n,) radii of the nodes in contact."""
        return self.nodes.radii[self.touching]

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

    @cached_property
    def _modes(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128], Array]:
        """Rates (n,), wear of the modes at the start (n, n), and the rates that are not zero."""
        rates, vectors = np.linalg.eig(self.wear[:, None] * self.relief)
        parts = vectors * np.linalg.solve(vectors, (self.wear * self.start).astype(complex))
        return rates, parts, np.abs(rates) > ZERO_RATE * np.abs(rates).max()

    def exact(self, times: Array) -> Array:
        """Return the worn profiles (T, n) of this mesh without any error of the steps."""
        return self._worn(lambda rates: -np.expm1(-rates * times[:, None]), times)

    def after(self, step: float, counts: Array) -> Array:
        """Return the worn profiles (T, n) after so many updates (T,) by a stable step."""
        return self._worn(lambda rates: 1 - (1 - rates * step) ** counts[:, None], step * counts)

    def _worn(
        self, decayed: Callable[[NDArray[np.complex128]], NDArray[np.complex128]], elapsed: Array
    ) -> Array:
        """Return the worn profiles (T, n) after times (T,).

        `decayed` is a function from the rates of the modes to the parts (T, n) of their wear rates
        that have decayed.
        """
        rates, parts, decays = self._modes
        rest = np.where(decays, rates, 1.0)
        grown = np.where(decays, decayed(rest) / rest, elapsed[:, None])
        return (grown @ parts.T).real

    def march(self, step: float, count: int) -> Iterator[tuple[Array, Array]]:
        """Yield pressures (n,) and the profile (n,) before each of so many updates by a step."""
        profile = np.zeros(len(self.wear))
        for _ in range(count):
            pressure = self.pressures(profile)
            yield pressure, profile
            profile = profile + step * self.wear * pressure

    @cached_property
    def running_in_time(self) -> float:
        """Time after which `WORN_IN` of the running-in is left."""
        rates, parts, decays = self._modes
        forces = self._forces_of_indentation
        # the rate of the mean wear, or of the force at a fixed indentation, is a sum of decays
        changes = np.where(decays, (forces @ parts).real / np.where(decays, rates.real, 1.0), 0.0)
        total = changes.sum()

        def remaining(log_time: float) -> float:
            decay = np.exp(-np.where(decays, rates.real, 0.0) * np.exp(log_time))
            return float(changes @ decay / total) - WORN_IN

        slowest = float(rates.real[decays].min())
        return float(np.exp(brentq(remaining, np.log(1e-9 / slowest), np.log(60 / slowest))))

    def errors(self, part: float, first: float) -> dict[str, float]:
        """Return the greatest relative errors by a step, of indentation, profile and pressure.

        Parameters
        ----------
        part : step over the longest stable one
        first : time from which errors count
        """
        step = part * self.limit
        last = max(int(np.ceil(self.running_in_time / step)), 2)
        counts = np.geomspace(max(first / step, 1.0), max(last, first / step + 1), 24)
        counts = np.unique(np.round(counts))
        worn, exact = self.after(step, counts), self.exact(counts * step)
        inner = self.radii < INSIDE
        weights = self.nodes.mass.sum(axis=1)[self.touching][inner]

        def size(fields: Array) -> Array:
            return np.sqrt((fields[:, inner] ** 2) @ weights / weights.sum())

        pressures, right = self.pressures(worn), self.pressures(exact)
        depths = self.depth(exact)
        return {
            "indentation": float(np.max(np.abs(self.depth(worn) / depths - 1))),
            "profile": float(np.max(size(worn - exact) / size(exact))),
            "pressure": float(np.max(size(pressures - right) / size(right))),
        }

    def step_for(self, error: float, first: float) -> dict[str, float]:
        """Return the step, over the longest stable one, with an error of each quantity.

        It is at most 1, and 0 if even a thousandth of that step has a larger error.
        """
        parts = np.geomspace(1e-3, 1.0, 25)
        found = [self.errors(part, first) for part in parts]
        steps = {}
        for name in found[0]:
            good = np.array([row[name] <= error for row in found])
            # the longest of the steps below which all are accurate enough
            count = len(good) if good.all() else int(np.argmin(good))
            steps[name] = float(parts[count - 1]) if count else 0.0
        return steps


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
    wear = wear_at_nodes(problem.merged, nodes.radii)
    if touching is None:
        touching = np.arange(len(nodes.radii))
    return ExplicitWear(nodes, treatment, wear, force, touching)
