"""Meshes that refine themselves.

An error indicator of the finite elements, and local refinement where it is large.

The indicator of an element is the energy of the part of its stress that has the highest degree:
what the next lower degree could not hold. It is local, costs one evaluation of stresses, and is
taken in both the flat start (singular at the rim) and the steady state (singular at ring edges), so
that one mesh serves the whole history.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from skfem import CellBasis, Mesh, MeshTri, adaptive_theta

from ...fem.elasticity import AxisymmetricElasticity
from ...fem.half_space import HalfSpace, pressure_space
from ...fem.stresses import displacements, stresses
from ...fem.weak_form import element_of_degree, projection
from ...meshes import bisection
from ...meshes.half_space import contact_facets, truncation
from ...meshes.radial import Array, Indices
from ...meshes.sizes import SizeField
from ..problem.defaults import WIDER_TRUNCATION, pole_orders
from ..problem.problem import Problem
from ..wear.archard import RunningIn
from ..wear.contact import press_flat

SIZE = 1.2  # of the elements of the uniform mesh
DEGREE = 4
MOST_UNKNOWNS = 60_000
# of a mesh of the quarter disc, by the middle of a facet
BOUNDARIES = {
    "contact": lambda x: (x[1] == 0) & (x[0] < 1),
    "free": lambda x: (x[1] == 0) & (x[0] > 1),
    "axis": lambda x: x[0] == 0,
    "far": lambda x: (x[0] > 0) & (x[1] > 0),
}


def uniform(ring_edges: Array) -> MeshTri:
    """Triangles of one size, and smaller ones only where a ring edge would not be a vertex."""
    return bisection.mesh(
        SizeField(tuple(ring_edges.tolist()), SIZE, SIZE, 0.0, WIDER_TRUNCATION, SIZE)
    )


class Solved(NamedTuple):
    """What a mesh gives, and where it is wrong.

    The estimated relative error of displacements is the part of the energy in doubt, or what the
    pressure space does not hold; the worst elements are those to refine.
    """

    half_space: HalfSpace
    wear: RunningIn
    estimate: float
    worst: Indices


def solved(problem: Problem, mesh: Mesh, degree: int) -> Solved:
    """The finite elements of a degree on a mesh, with their indicators."""
    rings, solid = problem.merged, AxisymmetricElasticity(mesh, degree, problem.poisson_ratio)
    half_space = HalfSpace(
        solid, pressure_space(solid, rings.ring_edges), pole_orders(problem, truncation(mesh))
    )
    wear = RunningIn(half_space.compliance(), rings.wear_coefficients)
    states = np.array([press_flat(wear.compliance).pressure, wear.steady.pressure])
    energies = np.sum((states @ wear.compliance.factor.T) ** 2, axis=1)
    in_doubt, lost = (
        indicators(solid, displacements(half_space, states), energies),
        _lost(half_space, wear),
    )
    energy, displacement = float(in_doubt.sum()), float(np.sqrt(lost.sum()))
    worst = adaptive_theta(in_doubt)
    if displacement > energy:
        worst = np.union1d(worst, mesh.f2t[0, contact_facets(mesh)[adaptive_theta(lost)]])
    return Solved(half_space, wear, max(energy, displacement), worst)


def _lost(half_space: HalfSpace, wear: RunningIn) -> Array:
    """(n,) mean square, by contact facet, of the part of the steady displacement that the pressure
    space does not hold.
    """
    count = half_space.solid.degree + 1
    local = (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2
    _, whole, _ = half_space.contact_displacement(wear.steady.pressure, local)
    held = (half_space.space.on_elements(2 * local - 1) @ wear.steady.displacement).reshape(
        whole.shape
    )
    return np.asarray(
        ((whole - held) ** 2).mean(axis=1)
        * np.diff(half_space.space.breakpoints)
        / (whole**2).mean()
    )


def indicators(solid: AxisymmetricElasticity, displacement: Array, energies: Array) -> Array:
    """(m,) energy of the stresses of highest degree over the energy of each state, the greatest of
    the states.

    Displacements are (states, functions, 2) coefficients, energies (states,).
    """
    out, nu = np.zeros(solid.mesh.nelements), solid.poisson_ratio
    for batch in solid.batches:
        basis = CellBasis(
            solid.mesh, batch.element, elements=batch.elements, intorder=2 * batch.degree + 2
        )
        _, stress = stresses(solid, displacement, batch.elements, basis.X)
        # what polynomials of two degrees below the displacement's do not hold
        lower = element_of_degree(solid.mesh, max(batch.degree - 2, 0))
        rough = stress - np.einsum(
            "smqc,qp->smpc", stress, projection(lower, basis.X, basis.W, basis.X), optimize=True
        )
        # twice the strain energy by stresses rr, zz, rz, hoop
        squares, trace = rough**2 @ [1.0, 1.0, 2.0, 1.0], rough @ [1.0, 1.0, 0.0, 1.0]
        density = (squares - nu / (1 + nu) * trace**2) / (1 - nu)
        energy = np.sum(density * 2 * np.pi * basis.global_coordinates()[0] * basis.dx, axis=2)
        out[batch.elements] = (energy / energies[:, None]).max(axis=0)
    return out


def adapted(problem: Problem, mesh: MeshTri, tolerance: float) -> Iterator[Solved]:
    """Rounds of solving and refining, until the estimate is below the tolerance or the unknowns run
    out.
    """
    yield (now := solved(problem, mesh, DEGREE))
    while now.estimate > tolerance and now.half_space.unknowns < MOST_UNKNOWNS:
        # local refinement by scikit-fem loses the names of boundaries, and warns of it
        mesh = MeshTri(mesh.p, mesh.t).refined(now.worst).with_boundaries(BOUNDARIES)
        yield (now := solved(problem, mesh, DEGREE))
