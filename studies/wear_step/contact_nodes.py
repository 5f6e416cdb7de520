"""The contact nodes of a mesh below a punch: stiffness, pressures, and explicit updates of wear.

Programs with elements compute the pressure of a node from the force on it in one of two ways:

- per node: the force over the weight of the node, which is the area between the midpoints of
  neighbouring nodes for linear elements, and the row sum of the mass matrix (1/6, 4/6 and 1/6 of
  the area of a side) for quadratic ones
- consistent: by the mass matrix of the contact line

A program with elements updates the profile at its contact nodes by ``f += k v p dt``. In contact,
``p = g F - G f`` under a given force F, with a matrix G of the mesh. Euler's explicit method is
stable if

    dt <= 2 Re(l) / |l|^2    for all eigenvalues l of k v G.

Beyond that, the modes of the largest eigenvalues, which change their sign from node to node, grow
by the factor ``|1 - l dt|`` with each update. Non-dimensional:
punch radius 1, plane strain modulus of the ground 1, time unit a / (E* k v) with the greatest wear
coefficient k.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import skfem
from scipy.sparse.linalg import eigs
from skfem import Mesh, MeshTri

from ...fem import AxisymmetricElasticity, HalfSpace, enough_poles, pressure_space
from ...meshes import Array, Ground, Indices, SceneError, contact_radii, truncation
from ..crosscheck import Problem, Rings
from ..study.own import ELEMENTS

PER_NODE, CONSISTENT = "per node", "consistent"
TREATMENTS = PER_NODE, CONSISTENT
"""Ways to compute the pressure of a node from the forces on the nodes."""
FAR_FIELD_ERROR = 1e-9
"""Relative error of the energy that poles may leave of the truncation; it sets their number."""

MOST_DENSE = 600
"""Greatest number of nodes of which all eigenvalues are computed, and not only the largest one."""
ITERATION_TOLERANCE = 1e-4
"""Relative residual of the largest eigenvalue of more nodes; those next to it are close."""
LEAST_PART = 1e-3
"""Eigenvalues below this part of the largest one do not limit the step."""


@dataclass(frozen=True, eq=False)
class ContactNodes:
    """The nodes of a mesh below a punch.

    Parameters
    ----------
    element : name of the element (`ELEMENTS` in `study/own.py`)
    radii : (n,) radii of the nodes, from inside to outside
    stiffness : (n, n) forces on the nodes for axial displacements of them, with everything else
        eliminated
    """

    element: str
    radii: Array
    stiffness: Array

    @property
    def degree(self) -> int:
        """Degree of the element: there are so many nodes for each side on the contact."""
        return int(self.element[1])

    @property
    def cells(self) -> Array:
        """(m + 1,) ends of the m sides of elements on the contact."""
        return self.radii[:: self.degree]

    @cached_property
    def mass(self) -> Array:
        """(n, n) consistent mass matrix ``int phi_i phi_j 2 pi r dr`` of the contact line."""
        return contact_mass(self.radii, self.degree, np.ones_like)

    @cached_property
    def compliance(self) -> Array:
        """(n, n) axial displacements of the nodes for forces on them."""
        return np.asarray(np.linalg.inv(self.stiffness), dtype=float)

    @cached_property
    def weights(self) -> Array:
        """(n,) areas by which the forces on nodes are divided; 0 on the axis if quadratic."""
        if self.degree == 2:
            return self.mass.sum(axis=1)
        middles = (self.radii[1:] + self.radii[:-1]) / 2
        ends = np.concatenate([self.radii[:1], middles, self.radii[-1:]])
        return np.pi * np.diff(ends**2)

    def pressures(self, treatment: str) -> Array:
        """Return the matrix (n, n) from the forces on the nodes to the pressures of the nodes."""
        if treatment == CONSISTENT:
            return np.asarray(np.linalg.inv(self.mass), dtype=float)
        weights = self.weights
        matrix = np.diag(1 / np.maximum(weights, np.finfo(float).tiny))
        if self.degree == 2 and self.radii[0] == 0:
            # the node on the axis has no weight: the pressure is even in the radius
            matrix[0] = (4 * matrix[1] - matrix[2]) / 3
        return matrix


def contact_nodes(mesh: Mesh, element: str, ground: Ground) -> ContactNodes:
    """Condense the half-space on a mesh to its contact nodes.

    Parameters
    ----------
    mesh : quarter disc with named boundaries
    element : name of the element
    ground : its Poisson's ratio and its layers

    Raises
    ------
    SceneError
        if the mesh does not have cells of that kind
    """
    on_triangles = isinstance(mesh, MeshTri)
    if on_triangles != element.startswith("P"):
        kind, names = "quadrilaterals", "Q1, Q2 or Q2S"
        if on_triangles:
            kind, names = "triangles", "P1 or P2"
        raise SceneError(f"element = {element}: the mesh has {kind}: give {names}")
    vertices = contact_radii(mesh)
    solid = AxisymmetricElasticity(
        mesh, int(element[1]), ground, getattr(skfem, ELEMENTS[element])()
    )
    poles = enough_poles(truncation(mesh), FAR_FIELD_ERROR)
    space = pressure_space(solid, vertices[[0, -1]])
    half_space = HalfSpace(solid, space, poles).without_dependent_poles()
    radii = vertices
    if element[1] == "2":
        radii = np.sort(np.append(vertices, (vertices[1:] + vertices[:-1]) / 2))
    return ContactNodes(element, radii, half_space.contact_stiffness())


def contact_mass(radii: Array, degree: int, factor: Callable[[Array], Array]) -> Array:
    """Return the mass matrix (n, n) ``int c phi_i phi_j 2 pi r dr`` of shape functions phi.

    Parameters
    ----------
    radii : (n,) of the nodes from inside to outside, including those in the middles of sides
    degree : of the shape functions, 1 or 2
    factor : function c from radii to a factor
    """
    element = skfem.ElementLineP2() if degree == 2 else skfem.ElementLineP1()
    basis = skfem.Basis(skfem.MeshLine(radii[::degree]), element, intorder=7)
    product = skfem.BilinearForm(lambda u, v, w: 2 * np.pi * w.x[0] * factor(w.x[0]) * u * v)
    order = np.argsort(basis.doflocs[0])
    return np.asarray(product.assemble(basis).toarray()[np.ix_(order, order)])


def wear_at_nodes(rings: Rings, radii: Array) -> Array:
    """Return the wear coefficients (n,) at nodes, over the greatest; harmonic means at ring edges.

    The steady pressure is proportional to 1 / k, so that the harmonic mean is that of the mean
    pressure of both sides. With the arithmetic mean, pressures beside an edge err by 15 %.
    """
    inside, outside = (
        rings.at(np.clip(radii + shift, rings.ring_edges[0], 1.0)) for shift in (-1e-7, 1e-7)
    )
    return 2 / (1 / inside + 1 / outside)


def relief(
    problem: Problem, nodes: ContactNodes, treatment: str, touching: Indices | None = None
) -> Array:
    """Return the matrix G (n, n) of ``p = g F - G f`` at the n nodes in contact.

    Parameters
    ----------
    problem : the problem, which gives the force, or the indentation: then ``p = p0 - G f``
    nodes : the nodes
    treatment : how pressures are computed from the forces on the nodes
    touching : numbers of the nodes in contact; the others carry no force; by default all
    """
    stiffness, to_pressures = nodes.stiffness, nodes.pressures(treatment)
    if touching is not None and len(touching) < len(stiffness):
        part = np.ix_(touching, touching)
        stiffness, to_pressures = np.linalg.inv(nodes.compliance[part]), to_pressures[part]
    matrix = np.asarray(to_pressures @ stiffness)
    if problem.indentation is not None:
        return matrix
    forces = stiffness.sum(axis=0)
    return matrix - np.outer(matrix.sum(axis=1), forces) / forces.sum()


def longest_step(
    problem: Problem, nodes: ContactNodes, treatment: str, touching: Indices | None = None
) -> float:
    """Return the longest stable step of explicit updates; the parameters are those of `relief`."""
    radii = nodes.radii if touching is None else nodes.radii[touching]
    wear = wear_at_nodes(problem.merged, radii)
    operator = wear[:, None] * relief(problem, nodes, treatment, touching)
    if len(operator) <= MOST_DENSE:
        values = np.linalg.eigvals(operator)
    else:
        start = (-1.0) ** np.arange(len(operator))
        values = eigs(operator, k=1, v0=start, tol=ITERATION_TOLERANCE)[0]
    values = values[np.abs(values) > LEAST_PART * np.abs(values).max()]
    return float((2 * values.real / np.abs(values) ** 2).min())
