"""Press the ball on the pad (problem 14) by finite elements as most users would write them.

The pad is a cylinder of radius 3, with linear triangles. Nodes that would be pulled are released
one after another.
"""

from time import perf_counter

import numpy as np
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementTriP1, ElementVector, MeshTri, enforce
from skfem.helpers import ddot, div, sym_grad


@BilinearForm
def stiffness(u, v, at):
    """Return the integrand of the elastic stiffness for displacements u and v in axial symmetry."""
    volume = at.lame * (div(u) + u[0] / at.x[0]) * (div(v) + v[0] / at.x[0])
    shape = 2 * at.shear * (ddot(sym_grad(u), sym_grad(v)) + u[0] * v[0] / at.x[0] ** 2)
    return 2 * np.pi * at.x[0] * (volume + shape)


def press(compliance, heights, force):
    """Return the indentation and the number of nodes in contact, which begin at the axis."""
    for count in range(len(heights), 0, -1):
        rows = np.block([[compliance[:count, :count], -np.ones((count, 1))], [np.ones(count), 0]])
        *forces, depth = np.linalg.solve(rows, np.append(-heights[:count], force))
        if min(forces) >= 0:
            break
    return depth, count


start, rows = perf_counter(), []
for ratio in 0.3, 0.45:
    shear = (1 - ratio) / 2
    lame = 2 * shear * ratio / (1 - 2 * ratio)
    lines = np.append(np.linspace(0, 0.8, 81), np.geomspace(0.82, 3, 30))
    mesh = MeshTri.init_tensor(lines, np.linspace(-0.25, 0, 26))
    basis, (r, z) = Basis(mesh, ElementVector(ElementTriP1())), mesh.p
    across, down = basis.nodal_dofs
    far = (r == 3) | (z == -0.25)
    fixed, contact = np.append(across[far | (r == 0)], down[far]), down[(z == 0) & (r <= 0.8)]
    loads = np.zeros((basis.N, len(contact)))
    loads[contact, range(len(contact))] = 1
    matrix = stiffness.assemble(basis, lame=lame, shear=shear)
    compliance = splu(enforce(matrix, D=fixed).tocsc()).solve(loads)[contact]
    heights = 10 - np.sqrt(100 - lines[:81] ** 2)
    for force in 1e-3, 1e-2, 1e-1:
        depth, count = press(compliance, heights, force)
        rows.append((force, ratio, depth, (lines[count - 1] + lines[count]) / 2))
head = f"# {perf_counter() - start:.2f} s\nnormal_force,poisson_ratio,indentation,contact_radius"
np.savetxt("14_scikit_fem.csv", rows, "%.8g", ",", header=head, comments="")
