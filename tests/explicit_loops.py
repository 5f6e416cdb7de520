"""Explicit wear loops on meshes in scikit-fem, as users write them, without ringwear.

A half-space is condensed to the nodes of its contact; the profile is then updated by
``f += k p dt``. The plane strain modulus and the radius of the punch are 1.
"""

import numpy as np
from scipy.sparse.linalg import splu
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad1,
    ElementQuad2,
    ElementQuadS2,
    ElementTriP1,
    ElementTriP2,
    ElementVector,
)
from skfem.helpers import ddot, div, sym_grad

ELEMENTS = {
    "P1": ElementTriP1,
    "P2": ElementTriP2,
    "Q1": ElementQuad1,
    "Q2": ElementQuad2,
    "Q2S": ElementQuadS2,
}


def condensed(mesh, element, ratio=0.3, shear=None, plane=False):
    """Return radii of the contact nodes and their stiffness; the outer boundary is clamped.

    Parameters
    ----------
    mesh : its depths are positive
    shear : function of the depth that returns the shear modulus; without it, that of E* = 1
    plane : whether the strain is plane; forces are then per length
    """
    shear = shear or (lambda _: (1 - ratio) / 2)

    @BilinearForm
    def form(u, v, at):
        radius, depth = at.x
        hoop, hoop_v = (0.0, 0.0) if plane else (u[0] / radius, v[0] / radius)
        volume = ratio / (1 - 2 * ratio) * (div(u) + hoop) * (div(v) + hoop_v)
        shape = ddot(sym_grad(u), sym_grad(v)) + hoop * hoop_v
        around = 2.0 if plane else 2 * np.pi * radius
        return around * 2 * shear(depth) * (volume + shape)

    basis = Basis(mesh, ElementVector(ELEMENTS[element]()), intorder=6)
    stiffness = form.assemble(basis).tocsc()
    r, z = basis.doflocs
    functions = basis.elem.doflocs.shape[0]
    axial = np.zeros(basis.N, dtype=bool)
    axial[np.unique(basis.element_dofs[np.arange(1, functions, 2)])] = True
    outer = mesh.facets_satisfying(lambda middle: middle.min(axis=0) > 1e-12, boundaries_only=True)
    fixed = ~axial & (r < 1e-12)
    fixed[basis.get_dofs(outer).flatten()] = True
    contact = axial & (z < 1e-12) & (r < 1 + 1e-9)
    nodes = np.flatnonzero(contact)
    nodes = nodes[np.argsort(r[nodes])]
    inside = np.flatnonzero(~fixed & ~contact)
    coupling = stiffness[inside][:, nodes].toarray()
    reaction = stiffness[nodes][:, nodes] - coupling.T @ splu(stiffness[inside][:, inside]).solve(
        coupling
    )
    return r[nodes], np.asarray(reaction)


def areas_of(radii):
    """Return the annuli between the midpoints of neighbouring nodes."""
    ends = np.concatenate([radii[:1], (radii[1:] + radii[:-1]) / 2, radii[-1:]])
    return np.diff(np.pi * ends**2)


def mass_of(radii, degree):
    """Return the consistent mass matrix of the contact line, of linear or quadratic sides."""
    points, weights = np.polynomial.legendre.leggauss(4)
    points, weights = (points + 1) / 2, weights / 2
    functions = np.array([1 - points, points])
    if degree == 2:
        functions = np.array(
            [(1 - points) * (1 - 2 * points), 4 * points * (1 - points), points * (2 * points - 1)]
        )
    mass = np.zeros((len(radii), len(radii)))
    for first in range(0, len(radii) - degree, degree):
        side = slice(first, first + degree + 1)
        width = radii[first + degree] - radii[first]
        area = 2 * np.pi * (radii[first] + width * points) * weights * width
        mass[side, side] += functions * area @ functions.T
    return mass


def pressures_of(radii, element, consistent):
    """Return the matrix from the forces on the nodes to their pressures."""
    mass = mass_of(radii, int(element[1]))
    if consistent:
        return np.linalg.inv(mass)
    if element.endswith("1"):
        return np.diag(1 / areas_of(radii))
    matrix = np.diag(1 / np.maximum(mass.sum(axis=1), 1e-300))
    if radii[0] == 0:
        matrix[0] = (4 * matrix[1] - matrix[2]) / 3
    return matrix


def march(stiffness, to_pressures, wear, force, step, count, clipped=False):
    """Return times, pressures, indentations and profiles before each of so many updates."""
    rigid, profile, rows = stiffness.sum(axis=0), np.zeros(len(wear)), []
    for number in range(count):
        depth = (force + rigid @ profile) / rigid.sum()
        pressure = to_pressures @ (stiffness @ (depth - profile))
        if clipped:
            pressure = np.maximum(pressure, 0.0)
        rows.append((number * step, pressure, depth, profile))
        profile = profile + step * wear * pressure
    return [np.array(column) for column in zip(*rows, strict=True)]
