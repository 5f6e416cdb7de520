"""The yardstick: scikit-fem as its examples use it, no more. Uniform P2 mesh of a box, clamped at 20 a, vector form,
the whole contact system solved again at every step of an implicit march.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from ringwear.meshes.radial import Array
from ringwear.studies.problem.problem import NaturalScene
from scipy.sparse import bmat, csc_matrix, csr_matrix
from scipy.sparse.linalg import spsolve


@dataclass(frozen=True, eq=False)
class PlainHistory:
    """Indentations (steps,), unknowns, seconds before the march and of each step."""

    indentation: Array
    unknowns: int
    seconds_before: float
    seconds_per_step: float


def plain_history(natural: NaturalScene, unknowns: int, times: Array, size: float = 20.0) -> PlainHistory:
    """March the wear of a scene in implicit steps that end at `times`; natural units, force 1."""
    from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, MeshTri
    from skfem.helpers import ddot, sym_grad, trace

    start = time.perf_counter()
    # a multiple of the size, so that the rim is a vertex
    cells = round(size) * max(1, round(np.sqrt(unknowns / 8) / size))
    grid = np.linspace(0, size, cells + 1)
    mesh = MeshTri.init_tensor(grid, grid)
    basis = Basis(mesh, ElementVector(ElementTriP2()), intorder=6)
    nu = natural.scene.half_space.poisson_ratio
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
    on_surface = basis.get_dofs(lambda x: (x[1] == 0) & (x[0] <= 1 + 1e-9)).all(["u^2"])
    radii = basis.doflocs[0, on_surface]
    order = np.argsort(radii)
    on_surface, radii = on_surface[order], radii[order]
    borders = np.concatenate([[0.0], (radii[1:] + radii[:-1]) / 2, [1.0]])
    area = np.pi * np.diff(borders**2)
    edges, wear = natural.phases
    coefficient = wear[np.clip(np.searchsorted(edges, radii, side="right") - 1, 0, len(wear) - 1)]
    held = np.unique(
        np.concatenate([
            basis.get_dofs(lambda x: x[0] == 0).all(["u^1"]),
            basis.get_dofs(lambda x: (x[0] == size) | (x[1] == size)).all(),
        ])
    )  # fmt: skip
    free = np.setdiff1d(np.arange(matrix.shape[0]), held)
    position = np.full(matrix.shape[0], -1)
    position[free] = np.arange(len(free))
    count = len(radii)
    coupling = csr_matrix((area, (position[on_surface], np.arange(count))), shape=(len(free), count))
    weights = csr_matrix(area[None])
    before = time.perf_counter() - start
    start, now, profile, indentations = time.perf_counter(), 0.0, np.zeros(count), []
    for instant in times:
        # u = d - f - dt k p at every contact node, weighted by its area
        softness = csc_matrix(np.diag(-(instant - now) * coefficient * area))
        system = bmat(
            [[matrix[free][:, free], -coupling, None], [-coupling.T, softness, weights.T], [None, weights, None]],
            format="csc",
        )
        right = np.concatenate([np.zeros(len(free)), area * profile, [1.0]])
        solution = spsolve(system, right)
        pressure = solution[len(free) : -1]
        profile = profile + (instant - now) * coefficient * pressure
        now = instant
        indentations.append(solution[-1])
    per_step = (time.perf_counter() - start) / len(times)
    return PlainHistory(np.array(indentations), matrix.shape[0], before, per_step)
