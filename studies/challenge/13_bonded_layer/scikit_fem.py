"""Solve cases of the bonded layer (problem 13) by finite elements as most users would write them.

The layer is a cylinder of five thicknesses beyond the punch, with quadratic triangles. The
displacement of the face is prescribed, and the force is the sum of the reactions.
"""

from itertools import product
from time import perf_counter

import numpy as np
from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, MeshTri, condense, solve
from skfem.helpers import ddot, div, sym_grad


@BilinearForm
def stiffness(u, v, at):
    """Return the integrand of the elastic stiffness for displacements u and v in axial symmetry."""
    volume = at.lame * (div(u) + u[0] / at.x[0]) * (div(v) + v[0] / at.x[0])
    shape = 2 * at.shear * (ddot(sym_grad(u), sym_grad(v)) + u[0] * v[0] / at.x[0] ** 2)
    return 2 * np.pi * at.x[0] * (volume + shape)


start, rows = perf_counter(), []
for radius_over_thickness, ratio in product((0.4, 1, 2, 4), (0.3, 0.45)):
    thickness, modulus = 1 / radius_over_thickness, 1 - ratio**2
    shear = modulus / (2 * (1 + ratio))
    face = 1 - np.geomspace(1, 1e-3, 30)
    beyond = np.geomspace(1 + 1e-3, 1 + 5 * thickness, 30)
    depths = thickness * np.append(0, np.geomspace(1e-2, 1, 20))
    lines = np.concatenate([face, [1], beyond])
    mesh = MeshTri.init_tensor(lines, -depths[::-1]).with_defaults()
    basis = Basis(mesh, ElementVector(ElementTriP2()), intorder=4)
    lame = 2 * shear * ratio / (1 - 2 * ratio)
    matrix = stiffness.assemble(basis, lame=lame, shear=shear)
    base = basis.get_dofs({"bottom", "right"}).all()
    axis = basis.get_dofs("left").all(["u^1"])
    punch = basis.get_dofs(lambda x: (x[1] == 0) & (x[0] < 1)).all(["u^2"])
    given = basis.zeros()
    given[punch] = -1
    fixed = np.unique(np.concatenate([base, axis, punch]))
    displacement = solve(*condense(matrix, x=given, D=fixed))
    force = -(matrix @ displacement)[punch].sum()
    rows.append((radius_over_thickness, ratio, force / 2))
head = f"# {perf_counter() - start:.2f} s\nradius_over_thickness,poisson_ratio,stiffness"
np.savetxt("13_scikit_fem.csv", rows, "%.8g", ",", header=head, comments="")
