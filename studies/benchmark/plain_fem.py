"""For comparison: scikit-fem as its examples use it, no more. Uniform P2 mesh of a box, clamped at 20 a, vector form,
the whole contact system solved again at every step of an implicit march.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from scipy.sparse import bmat, csc_matrix, csr_matrix
from scipy.sparse.linalg import spsolve

from ringwear.meshes.radial import Array, ring_of
from ringwear.studies.problem.problem import Problem


@dataclass(frozen=True, eq=False)
class PlainHistory:
    """Indentations (steps,), unknowns, seconds before the march and of each step."""

    indentation: Array
    unknowns: int
    seconds_before: float
    seconds_per_step: float


def plain_history(problem: Problem, unknowns: int, times: Array, size: float = 20.0) -> PlainHistory:
    """March in implicit steps that end at `times`; non-dimensional, force 1."""
    from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, MeshTri
    from skfem.helpers import ddot, sym_grad, trace

    start = time.perf_counter()
    # a multiple of the size, so that the rim is a vertex
    grid = np.linspace(0, size, round(size) * max(1, round(np.sqrt(unknowns / 8) / size)) + 1)
    basis = Basis(MeshTri.init_tensor(grid, grid), ElementVector(ElementTriP2()), intorder=6)
    nu = problem.poisson_ratio
    shear = (1 - nu) / 2
    lame = 2 * shear * nu / (1 - 2 * nu)

    @BilinearForm
    def stiffness(u, v, w):  # type: ignore[no-untyped-def]
        r = w.x[0]
        eu, ev = sym_grad(u), sym_grad(v)
        hoop = 2 * shear * u[0] * v[0] / r**2
        volume = lame * (trace(eu) + u[0] / r) * (trace(ev) + v[0] / r)
        return 2 * np.pi * r * (2 * shear * ddot(eu, ev) + hoop + volume)

    matrix = stiffness.assemble(basis)
    # pressure and profile at the surface nodes of the punch; a node outside it carries none
    contact = basis.get_dofs(lambda x: (x[1] == 0) & (x[0] <= 1 + 1e-9)).all(["u^2"])
    contact = contact[np.argsort(basis.doflocs[0, contact])]
    radii = basis.doflocs[0, contact]
    area = np.pi * np.diff(np.concatenate([[0.0], (radii[1:] + radii[:-1]) / 2, [1.0]]) ** 2)
    coefficient = problem.merged.wear_coefficients[ring_of(problem.merged.ring_edges, radii)]
    axis = basis.get_dofs(lambda x: x[0] == 0).all(["u^1"])
    outside = basis.get_dofs(lambda x: (x[0] == size) | (x[1] == size)).all()
    free = np.setdiff1d(np.arange(matrix.shape[0]), np.union1d(axis, outside))
    rows = np.searchsorted(free, contact)
    coupling = csr_matrix((area, (rows, np.arange(len(radii)))), shape=(len(free), len(radii)))
    inside, weights = matrix[free][:, free], csr_matrix(area[None])
    before, start = time.perf_counter() - start, time.perf_counter()
    now, profile, indentations = 0.0, np.zeros(len(radii)), []
    for instant in times:
        # u = d - f - dt k p at every contact node, weighted by its area
        softness = csc_matrix(np.diag(-(instant - now) * coefficient * area))
        system = bmat([[inside, -coupling, None], [-coupling.T, softness, weights.T], [None, weights, None]], format="csc")
        solution = spsolve(system, np.concatenate([np.zeros(len(free)), area * profile, [1.0]]))
        profile = profile + (instant - now) * coefficient * solution[len(free) : -1]
        now = instant
        indentations.append(solution[-1])
    return PlainHistory(np.array(indentations), matrix.shape[0], before, (time.perf_counter() - start) / len(times))
