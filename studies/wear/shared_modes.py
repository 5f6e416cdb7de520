"""Relaxation modes of many punches that differ in wear alone, on the span of a few of their
histories. Non-dimensional.

Histories on one set of ring edges resemble each other, whatever the wear coefficients: those of a
few punches span those of all between (proper orthogonal decomposition), and on that span the pencil
of `modes.py` is several times smaller (Galerkin). Compliance and mass are sums over the rings that
wear alike, so that a punch costs no product of large matrices. What the span leaves out shows: the
worn profile is where the half-space is not, and the sum of what wore; on the whole space both are
the same.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from scipy.linalg import eigh, svd
from scipy.sparse import csr_matrix

from ...meshes.compliance import Compliance
from ...meshes.radial import Array, Indices
from .modes import SHOWN, BandedCholesky, Modes, modes_of


@dataclass(frozen=True, eq=False)
class SharedModes:
    """A span of wear rates on one compliance.

    Parameters
    ----------
    compliance : of the half-space
    materials : (N,) number of the material of each ring: rings of one wear alike in every punch
    basis : (n, r) continuous wear rates, the first of which is one everywhere
    """

    compliance: Compliance
    materials: Indices
    basis: Array

    @classmethod
    def spanned(
        cls, compliance: Compliance, materials: Indices, rates: Array, least: float
    ) -> Self:
        """The span of (n, m) wear rates, without directions that have less than a share of them."""
        space = compliance.space
        continuous = space.joined()
        mass = continuous.T @ space.mass() @ continuous
        factor, uniform = BandedCholesky(mass), steady_rate(compliance)
        steady = factor.forward(mass @ uniform)
        steady /= np.linalg.norm(steady)
        scaled = factor.forward(mass @ rates)
        lengths = np.linalg.norm(scaled, axis=0)
        # late wear rates have decayed to nothing
        scaled = scaled[:, lengths > 0] / lengths[lengths > 0]
        scaled -= np.outer(steady, steady @ scaled)
        directions, sizes, _ = svd(scaled, full_matrices=False, check_finite=False)
        rest = factor.backward(np.ascontiguousarray(directions[:, sizes > least * sizes[0]]))
        return cls(compliance, materials, np.column_stack([uniform, rest]))

    def on(self, other: Compliance) -> "SharedModes":
        """The same span on another compliance, projected on its space."""
        if other.space is self.compliance.space:
            return SharedModes(other, self.materials, self.basis)
        space, mine = other.space, self.compliance.space
        radii, weights, local = space.quadrature
        continuous = space.joined()
        values = mine.matrix(radii.ravel()) @ (mine.joined() @ self.basis)
        moments = (space.on_elements(local) @ continuous).T @ (
            (2 * np.pi * radii * weights).reshape(-1, 1) * values
        )
        basis = BandedCholesky(continuous.T @ space.mass() @ continuous).solve(np.asarray(moments))
        return SharedModes(
            other, self.materials, np.column_stack([steady_rate(other), basis[:, 1:]])
        )

    @cached_property
    def _first(self) -> Indices:
        """(C,) a ring of each material."""
        return np.unique(self.materials, return_index=True)[1]

    @cached_property
    def _masses(self) -> list[csr_matrix]:
        """Of each material, (n, n) for wear rates."""
        space = self.compliance.space
        continuous = space.joined()
        rings = (np.where(self.materials == number, 1.0, 0.0) for number in range(len(self._first)))
        return [continuous.T @ space.mass(of) @ continuous for of in rings]

    def mass(self, wear_coefficients: Array) -> csr_matrix:
        """(n, n) mass of weight `k` of the pressures of wear rates."""
        parts = [
            mass / coefficient
            for mass, coefficient in zip(self._masses, wear_coefficients[self._first], strict=True)
        ]
        return sum(parts[1:], parts[0])

    @cached_property
    def _projected_masses(self) -> Array:
        """(C, r, r)"""
        return np.array([self.basis.T @ (mass @ self.basis) for mass in self._masses])

    @cached_property
    def _rates(self) -> Array:
        """(C, size, r) basis on the rings of each material."""
        wear = (np.where(self.materials == number, 1.0, 0.0) for number in range(len(self._first)))
        space, rates = self.compliance.space, self.compliance.space.joined() @ self.basis
        return np.array([space.at_vertices(of)[:, None] * rates for of in wear])

    @cached_property
    def _moments(self) -> Array:
        """(C, size, r) compliance times the basis on the rings of each material."""
        return np.array([self.compliance.matrix @ rates for rates in self._rates])

    def moments(self, wear_coefficients: Array) -> Array:
        """(size, r) compliance times the pressures of the basis."""
        return np.tensordot(1 / wear_coefficients[self._first], self._moments, 1)

    @cached_property
    def _projected_energies(self) -> Array:
        """(C, C, r, r) energy of the pressures of two materials."""
        return np.array([[rates.T @ moments for moments in self._moments] for rates in self._rates])

    def modes(self, wear_coefficients: Array, moments: Array) -> Modes:
        """The modes of a punch on the span, shapes as coefficients on the basis.

        (n,) `moments` as for `every_mode`.
        """
        softness = 1 / wear_coefficients[self._first]
        energy = np.tensordot(softness, np.tensordot(softness, self._projected_energies, 1), 1)
        mass = np.tensordot(softness, self._projected_masses, 1)
        # on wear rates that carry no force: each less as much of the steady state as carries its
        # own
        force = mass[0, 1:] / mass[0, 0]
        crossed = np.outer(force, energy[0, 1:])
        forceless = energy[1:, 1:] - crossed - crossed.T + energy[0, 0] * np.outer(force, force)
        mass = mass[1:, 1:] - mass[0, 0] * np.outer(force, force)
        relaxation, within = eigh(forceless, mass, driver="gvd", check_finite=False)
        shapes = np.concatenate([-(force @ within)[None], within])[:, ::-1]
        return modes_of(relaxation[::-1], shapes, moments @ self.basis, min(SHOWN, len(relaxation)))


def steady_rate(compliance: Compliance) -> Array:
    """(n,) the wear rate that is one everywhere."""
    hats = np.where(compliance.space.order == 1, 1.0, 0.0)
    return np.minimum(compliance.space.joined().T @ hats, 1.0)
