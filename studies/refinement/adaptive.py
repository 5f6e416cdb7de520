"""Meshes that refine themselves: an error indicator of the finite elements, and nested refinement where it is large.

The indicator of a triangle is the energy of the part of its stress that has the highest degree: what the next lower
degree could not hold. It is local, costs one evaluation of stresses, and is taken in both the flat start (singular at
the rim) and the steady state (singular at ring edges), so that one mesh serves the whole history. Refinement is that
of `meshes.bisection`: nested, so that ring edges stay vertices, with new points on the arc put back on it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.far_field import enough_poles
from ringwear.fem.half_space import HalfSpace, pressure_space
from ringwear.fem.stresses import displacements, stresses
from ringwear.fem.weak_form import element_of_degree, moduli, projection, rule
from ringwear.meshes.bisection import MOST_ROUNDS, _dyadic_image, _moved, _on_the_arc, _polar_quarter_disc, _spans_an_edge
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.errors import MeshError
from ringwear.meshes.half_space import contact_facets, half_space, truncation
from ringwear.meshes.radial import Array, Indices
from ringwear.studies.wear.contact import SteadyState, flat_start, steady_state
from skfem import Mesh, MeshTri

# marked in a round: the triangles with the largest indicators that together hold this share
SHARE = 0.5
NEGLIGIBLE = 1e-9  # truncation error
MOST_MESHES = 40


@dataclass(frozen=True, eq=False)
class Nested:
    """A mesh of the quarter disc that can be refined triangle by triangle.

    Parameters
    ----------
    dyadic : triangles whose contact vertices have dyadic radii
    edges : (N+1,) ring edges
    image : (N+1,) the dyadic radius of each
    outer : radius of the quarter disc
    """

    dyadic: MeshTri
    edges: Array
    image: Array
    outer: float

    @property
    def corners(self) -> Array:
        """(m, 3, 2) corners of the triangles where they really are."""
        return _moved(self.dyadic.p.T, self.image, self.edges)[self.dyadic.t.T]

    @property
    def mesh(self) -> MeshTri:
        """The triangles, in the same order, as a checked mesh."""
        moved = np.ascontiguousarray(_moved(self.dyadic.p.T, self.image, self.edges).T)
        return half_space(replace(self.dyadic, doflocs=moved), self.edges)

    def refined(self, triangles: Indices) -> Nested:
        finer = self.dyadic.refined(triangles)
        points = _on_the_arc(finer.p.T, finer.boundary_nodes(), self.outer)
        return replace(self, dyadic=replace(finer, doflocs=np.ascontiguousarray(points.T)))


def uniform(edges: Array, outer: float, size: float) -> Nested:
    """Triangles of at most `size` everywhere, and smaller ones only where a ring edge would not be a vertex.

    Raises
    ------
    MeshError
        if the ring edges are too close together to be told apart on a dyadic grid
    """
    image, spacing = _dyadic_image(edges)
    points, triangles = _polar_quarter_disc(outer)
    nested = Nested(
        MeshTri(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T)), np.asarray(edges), image, outer
    )
    for _ in range(MOST_ROUNDS):
        corners = nested.corners
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        marked = longest > 1.5 * size
        marked |= _spans_an_edge(nested.dyadic.p.T[nested.dyadic.t.T], image, spacing)
        if not marked.any():
            return nested
        nested = nested.refined(np.flatnonzero(marked))
    raise MeshError("local refinement did not separate the ring edges: make the rings wider")


@dataclass(frozen=True, eq=False)
class Round:
    """One round of the adaptation: a mesh, what it gives, and where it is wrong.

    Parameters
    ----------
    solid, half_space, compliance : the finite elements on the mesh
    indicators : (m,) share of the energy that is in doubt, by triangle
    defects : (n,) mean square of what the pressure space does not hold of the steady displacement, by contact facet
        and relative to its mean square
    """

    solid: AxisymmetricElasticity
    half_space: HalfSpace
    compliance: Compliance
    indicators: Array
    defects: Array

    @property
    def mesh(self) -> Mesh:
        return self.solid.mesh

    @property
    def estimate(self) -> float:
        """Relative error of displacements: the share of energy in doubt, or what the pressure space does not hold."""
        return max(float(self.indicators.sum()), self._lost)

    @property
    def _lost(self) -> float:
        return float(np.sqrt(self.defects.sum()))

    @property
    def marked(self) -> Indices:
        """Triangles to refine."""
        chosen = _largest(self.indicators)
        if self._lost > self.indicators.sum():
            facets = _largest(self.defects)
            chosen = np.union1d(chosen, self.mesh.f2t[0, contact_facets(self.mesh)[facets]])
        return chosen


def solved(mesh: Mesh, edges: Array, wear: Array, poisson_ratio: float, degree: int) -> Round:
    """The finite elements on a mesh, with the indicator of each element."""
    solid = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    half_space = HalfSpace(solid, pressure_space(solid, edges), enough_poles(truncation(mesh), NEGLIGIBLE))
    compliance = half_space.compliance()
    steady = steady_state(compliance, wear)
    states = np.array([flat_start(compliance).pressure, steady.pressure])
    energies = np.einsum("si,ij,sj->s", states, compliance.matrix, states)
    found = indicators(solid, displacements(half_space, states), energies)
    return Round(solid, half_space, compliance, found, _defects(half_space, steady))


def _defects(half_space: HalfSpace, steady: SteadyState) -> Array:
    """(n,) see `Round`: of the contact displacement that the elements found, against what the pressure space holds of it."""
    count = half_space.solid.degree + 1
    local = (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2
    _, found, _ = half_space.contact_displacement(steady.pressure, local)
    lost = found - (half_space.space.on_elements(2 * local - 1) @ steady.displacement).reshape(found.shape)
    return np.asarray((lost**2).mean(axis=1) * np.diff(half_space.space.breakpoints) / (found**2).mean())


def indicators(solid: AxisymmetricElasticity, displacement: Array, energies: Array) -> Array:
    """(m,) energy of the stresses of highest degree over the energy of each state, the greatest of the states.

    Parameters
    ----------
    displacement : (states, functions, 2)
    energies : (states,)
    """
    out, mapping = np.zeros(solid.mesh.nelements), solid.mesh.mapping()
    for batch in solid.batches:
        points, weights = rule(batch.element, 2 * batch.degree + 2)
        _, stress = stresses(solid, displacement, batch.elements, points)
        # what polynomials of two degrees below the displacement's do not hold
        smooth = projection(element_of_degree(solid.mesh, max(batch.degree - 2, 0)), points, weights, points)
        density = _energy_density(stress - np.einsum("smqc,qp->smpc", stress, smooth, optimize=True), solid.poisson_ratio)
        radius = mapping.F(points, batch.elements)[0]
        measure = 2 * np.pi * radius * np.abs(mapping.detDF(points, batch.elements)) * weights
        out[batch.elements] = (np.sum(density * measure, axis=2) / energies[:, None]).max(axis=0)
    return out


def _energy_density(stress: Array, poisson_ratio: float) -> Array:
    """Twice the strain energy of stresses (..., 4) rr, zz, rz, hoop, per volume."""
    _, shear = moduli(poisson_ratio)
    rr, zz, rz, hoop = np.moveaxis(stress, -1, 0)
    squares = rr**2 + zz**2 + hoop**2 + 2 * rz**2
    return (squares - poisson_ratio / (1 + poisson_ratio) * (rr + zz + hoop) ** 2) / (2 * shear)


def _largest(values: Array) -> Indices:
    """The largest values that together hold most of the sum."""
    order = np.argsort(values)[::-1]
    before = np.cumsum(values[order]) - values[order]
    return order[before < SHARE * values.sum()]


def adapted(
    start: Nested, wear: Array, poisson_ratio: float, tolerance: float, most_unknowns: int = 60_000, degree: int = 4
) -> Iterator[Round]:
    """Rounds of solving and refining, until the estimate is below the tolerance or the unknowns run out."""
    nested = start
    for _ in range(MOST_MESHES):
        now = solved(nested.mesh, nested.edges, wear, poisson_ratio, degree)
        yield now
        if now.estimate <= tolerance or now.half_space.unknowns > most_unknowns:
            return
        nested = nested.refined(now.marked)
