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
from ...fem.stresses import stresses
from ...fem.weak_form import element_of_degree, projection
from ...meshes import bisection
from ...meshes.half_space import contact_facets, truncation
from ...meshes.radial import Array, Indices
from ...meshes.sizes import SizeField
from ..problem.defaults import WIDER_TRUNCATION, pole_orders
from ..problem.problem import Problem
from ..wear.flat_contact import press_flat
from ..wear.full_contact import RunningIn

DEGREE = 4
"""Of the displacement on triangles."""


class SolvedMesh(NamedTuple):
    """What a mesh gives, and where it is wrong.

    Parameters
    ----------
    half_space, wear : of the mesh
    estimate : relative error of displacements: the part of the energy in doubt, or what the
        pressure space does not hold
    worst : elements to refine
    """

    half_space: HalfSpace
    wear: RunningIn
    estimate: float
    worst: Indices


def uniform_mesh(ring_edges: Array) -> MeshTri:
    """Mesh in triangles of one size, smaller only where a ring edge would not be a vertex."""
    size, edges = 1.2, tuple(ring_edges.tolist())
    return bisection.mesh(SizeField(edges, size, size, 0.0, WIDER_TRUNCATION, size))


def refine_adaptively(problem: Problem, mesh: MeshTri, tolerance: float) -> Iterator[SolvedMesh]:
    """Solve and refine in rounds, until the estimate is below the tolerance or the unknowns are too
    many.
    """
    # of a mesh of the quarter disc, by the middle of a facet
    boundaries = {
        "contact": lambda x: (x[1] == 0) & (x[0] < 1),
        "free": lambda x: (x[1] == 0) & (x[0] > 1),
        "axis": lambda x: x[0] == 0,
        "far": lambda x: (x[0] > 0) & (x[1] > 0),
    }
    yield (solved := solve_on(problem, mesh, DEGREE))
    while solved.estimate > tolerance and solved.half_space.unknowns < 60_000:
        # local refinement by scikit-fem loses the names of boundaries, and warns of it
        mesh = MeshTri(mesh.p, mesh.t).refined(solved.worst).with_boundaries(boundaries)
        yield (solved := solve_on(problem, mesh, DEGREE))


def solve_on(problem: Problem, mesh: Mesh, degree: int) -> SolvedMesh:
    """Solve the finite elements of a degree on a mesh, and find the worst of them."""
    rings, solid = problem.merged, AxisymmetricElasticity(mesh, degree, problem.poisson_ratio)
    poles = pole_orders(problem, truncation(mesh))
    half_space = HalfSpace(solid, pressure_space(solid, rings.ring_edges), poles)
    compliance = half_space.compliance()
    wear = RunningIn(compliance, rings.wear_coefficients)
    states = np.array([press_flat(compliance).pressure, wear.steady.pressure])
    energies = np.sum((states @ compliance.factor.T) ** 2, axis=1)
    moved = half_space.displacements(states)
    in_doubt = indicators(solid, moved, energies)
    lost = lost_displacement(half_space, wear, moved[1, : solid.nodes, 1])
    energy, displacement = float(in_doubt.sum()), float(np.sqrt(lost.sum()))
    worst = adaptive_theta(in_doubt)
    if displacement > energy:
        worst = np.union1d(worst, mesh.f2t[0, contact_facets(mesh)[adaptive_theta(lost)]])
    return SolvedMesh(half_space, wear, max(energy, displacement), worst)


def lost_displacement(half_space: HalfSpace, wear: RunningIn, axial: Array) -> Array:
    """Return the mean square (n,), by contact facet, of the part of the steady displacement, by
    its axial coefficients (nodes,), that the pressure space does not hold.
    """
    solid, space = half_space.solid, half_space.space
    count = solid.degree + 1
    local = (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2
    whole = (solid.trace(contact_facets(solid.mesh), local) @ axial).reshape(-1, count)
    inside = (space.on_elements(2 * local - 1) @ wear.steady.displacement).reshape(whole.shape)
    square = ((whole - inside) ** 2).mean(axis=1) / (whole**2).mean()
    return np.asarray(square * np.diff(space.breakpoints))


def indicators(solid: AxisymmetricElasticity, displacement: Array, energies: Array) -> Array:
    """Return the energy (m,) of the stresses of highest degree over the energy of each state, the
    greatest of the states.

    Parameters
    ----------
    displacement : (states, functions, 2) coefficients
    energies : (states,)
    """
    out, nu = np.zeros(solid.mesh.nelements), solid.poisson_ratio
    for batch in solid.batches:
        basis = CellBasis(
            solid.mesh, solid.element, elements=batch.elements, intorder=2 * batch.degree + 2
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
