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
from skfem import MeshTri

from fem.compliance import MULTIPLIER_DEGREE, HalfSpace, pressure_space
from fem.elasticity import AxisymmetricElasticity, moduli
from fem.fields import displacements, stresses
from meshes.bisection import MOST_ROUNDS, _dyadic_image, _moved, _on_the_arc, _polar_quarter_disc, _spans_an_edge
from meshes.compliance import Compliance
from meshes.errors import MeshError
from meshes.half_space import HalfSpaceMesh, assemble
from meshes.pressure_space import PressureSpace
from meshes.radial import Array, Indices

from .contact import flat_start, steady_state

# marked in a round: the triangles with the largest indicators that together hold this share
SHARE = 0.5
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
    def mesh(self) -> HalfSpaceMesh:
        """The triangles, in the same order, as a checked mesh."""
        return assemble(_moved(self.dyadic.p.T, self.image, self.edges), self.dyadic.t.T, self.edges, "nested refinement")

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
    def mesh(self) -> HalfSpaceMesh:
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
            chosen = np.union1d(chosen, _triangles_on_the_contact(self.mesh)[facets])
        return chosen


def solved(mesh: HalfSpaceMesh, edges: Array, wear: Array, poisson_ratio: float, degree: int = 4) -> Round:
    """The finite elements on a mesh, with the indicator of each triangle."""
    solid = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    half_space = HalfSpace(solid, pressure_space(mesh, edges, MULTIPLIER_DEGREE[degree]))
    compliance = half_space.compliance()
    steady = steady_state(compliance, wear)
    states = np.array([flat_start(compliance).pressure, steady.pressure])
    energies = np.einsum("si,ij,sj->s", states, compliance.matrix, states)
    displacement = displacements(half_space, states)
    defects = _defects(solid, half_space.space, displacement[1, :, 1], steady.displacement)
    return Round(solid, half_space, compliance, indicators(solid, displacement, energies), defects)


def _defects(solid: AxisymmetricElasticity, space: PressureSpace, displacement: Array, held: Array) -> Array:
    """(n,) see `Round`: of the axial displacement of all nodes, against the coefficients `held` on the pressure space."""
    contact = solid.boundary("contact")
    radii = solid.positions[contact, 0]
    order = np.argsort(radii)
    lost = displacement[contact] - space.matrix(radii) @ held
    rows = solid.degree * np.arange(len(space.degrees))[:, None] + np.arange(solid.degree + 1)
    squares = (lost[order][rows] ** 2).mean(axis=1) * np.diff(space.breakpoints)
    return np.asarray(squares / (displacement[contact] ** 2).mean())


def _triangles_on_the_contact(mesh: HalfSpaceMesh) -> Indices:
    """(n,) the triangle at each contact facet, from the axis to the rim."""
    on_contact = np.isin(mesh.triangles, np.unique(mesh.boundaries["contact"]))
    triangles = np.flatnonzero(on_contact.sum(axis=1) == 2)
    radii = np.where(on_contact[triangles], mesh.points[mesh.triangles[triangles], 0], 0.0)
    return triangles[np.argsort(radii.sum(axis=1))]


def indicators(solid: AxisymmetricElasticity, displacement: Array, energies: Array) -> Array:
    """(m,) energy of the stresses of highest degree over the energy of each state, the greatest of the states.

    Parameters
    ----------
    displacement : (states, nodes, 2)
    energies : (states,)
    """
    points, weights = _triangle_rule(solid.degree + 1)
    stress = stresses(solid, displacement, points)
    # the values that polynomials of two degrees below the displacement's take at the points, made orthonormal
    powers = [points[0] ** i * points[1] ** j for i in range(solid.degree - 1) for j in range(solid.degree - 1 - i)]
    root = np.sqrt(weights)
    basis, _ = np.linalg.qr(root[:, None] * np.array(powers).T)
    weighted = stress * root[:, None]
    weighted = weighted - np.einsum("qk,pk,smpc->smqc", basis, basis, weighted, optimize=True)
    barycentric = np.stack([1 - points[0] - points[1], points[0], points[1]])
    radius = np.einsum("vm,vq->mq", solid.corners[0], barycentric)
    _, area = solid.inverse_jacobian
    density = np.einsum("smq,mq->sm", _energy_density(weighted, solid.poisson_ratio), radius)
    return np.asarray((2 * np.pi * area * density / energies[:, None]).max(axis=0))


def _triangle_rule(count: int) -> tuple[Array, Array]:
    """(2, q) points and weights, all positive, on the reference triangle: Gauss points on the square, collapsed."""
    node, weight = np.polynomial.legendre.leggauss(count)
    x, y = ((1 + part.ravel()) / 2 for part in np.meshgrid(node, node, indexing="ij"))
    return np.stack([x, (1 - x) * y]), np.outer(weight, weight).ravel() / 4 * (1 - x)


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
