"""Solve the three layers (problem 15) by finite elements as most users would write them.

The ground is a cylinder of 300 inches that is fixed outside, with quadratic triangles. Stresses are
projected on linear functions in each element, so that they may jump at interfaces.
"""

from time import perf_counter

import numpy as np
from skfem import (
    Basis,
    BilinearForm,
    ElementDG,
    ElementTriP1,
    ElementTriP2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshTri,
    condense,
    solve,
)
from skfem.helpers import ddot, div, sym_grad

RADIUS, PRESSURE = 5.99, 100.0
BOTTOMS = np.array([6.0, 16.0, np.inf])
MODULI, RATIOS = np.array([5e5, 4e4, 1e4]), np.array([0.35, 0.4, 0.45])
SHEARS = MODULI / (2 * (1 + RATIOS))
LAMES = 2 * SHEARS * RATIOS / (1 - 2 * RATIOS)


@BilinearForm
def stiffness(u, v, at):
    """Return the integrand of the elastic stiffness for displacements u and v in axial symmetry."""
    volume = at.lame * (div(u) + u[0] / at.x[0]) * (div(v) + v[0] / at.x[0])
    shape = 2 * at.shear * (ddot(sym_grad(u), sym_grad(v)) + u[0] * v[0] / at.x[0] ** 2)
    return 2 * np.pi * at.x[0] * (volume + shape)


@LinearForm
def load(v, at):
    """Return the integrand of the work of the pressure."""
    return -2 * np.pi * at.x[0] * PRESSURE * v[1]


start = perf_counter()
lines = np.concatenate([np.linspace(0, RADIUS, 25), np.geomspace(RADIUS + 0.25, 300, 30)])
depths = np.concatenate(
    [np.linspace(0, 6, 19), np.linspace(6.5, 16, 20), np.geomspace(17, 300, 30)]
)
mesh = MeshTri.init_tensor(lines, -depths[::-1]).with_defaults()
layer = np.searchsorted(BOTTOMS, -mesh.p[1, mesh.t].mean(axis=0))
basis = Basis(mesh, ElementVector(ElementTriP2()), intorder=4)
lame, shear = LAMES[layer][:, None], SHEARS[layer][:, None]
face = mesh.facets_satisfying(lambda x: (x[1] == 0) & (x[0] < RADIUS), boundaries_only=True)
forces = load.assemble(FacetBasis(mesh, basis.elem, facets=face))
fixed = basis.get_dofs({"bottom", "right"}).all()
axis = basis.get_dofs("left").all(["u^1"])
matrix = stiffness.assemble(basis, lame=lame, shear=shear)
solution = solve(*condense(matrix, forces, D=np.union1d(fixed, axis)))

u, r = basis.interpolate(solution), basis.global_coordinates()[0]
strain = sym_grad(u)
trace = strain[0, 0] + strain[1, 1] + u[0] / r
broken = basis.with_element(ElementDG(ElementTriP1()))
zz, rr = (broken.project(lame * trace + 2 * shear * strain[way, way]) for way in (1, 0))
rows = []
for number, depth in (0, 0.0), (0, 6.0), (1, 6.0), (1, 16.0), (2, 16.0):
    x, y = broken.doflocs[:, broken.element_dofs]
    here = broken.element_dofs[(x == 0) & (y == -depth) & (layer == number)]
    node = np.flatnonzero((mesh.p[0] == 0) & (mesh.p[1] == -depth))[0]
    displacement = -solution[basis.nodal_dofs[1, node]]
    rows.append((depth, number + 1, displacement, zz[here].mean(), rr[here].mean()))
head = f"# {perf_counter() - start:.2f} s\ndepth,layer,displacement,stress_zz,stress_rr"
np.savetxt("15_scikit_fem.csv", rows, "%.8g", ",", header=head, comments="")
