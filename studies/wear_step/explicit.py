"""Explicit updates of a worn profile: their longest stable step, and the limit of short steps.

A program with elements updates the profile at its contact nodes by ``f += k v p dt``. In contact,
``p = g F - G f`` under a given force F, with a matrix G of the mesh. Euler's explicit method is
stable if

    dt <= 2 Re(l) / |l|^2    for all eigenvalues l of k v G.

Beyond that, the modes of the largest eigenvalues, which change their sign from node to node, grow
by the factor ``|1 - l dt|`` with each update. Non-dimensional: time unit a / (E* k v) with the
greatest wear coefficient k.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse.linalg import eigs

from ...meshes import Array, Indices
from ..crosscheck import Problem, Rings
from ..estimate.strips import worn_profiles
from .contact_nodes import ContactNodes

MOST_DENSE = 600
"""Greatest number of nodes of which all eigenvalues are computed, and not only the largest one."""
ITERATION_TOLERANCE = 1e-4
"""Relative residual of the largest eigenvalue of more nodes; those next to it are close."""
LEAST_PART = 1e-3
"""Eigenvalues below this part of the largest one do not limit the step."""


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


class WornOnMesh(NamedTuple):
    """Contain what explicit updates with infinitely short steps give at T times and n nodes.

    Parameters
    ----------
    profiles, pressures : (T, n) arrays
    indentations : (T,) array
    """

    profiles: Array
    pressures: Array
    indentations: Array


def worn_on_mesh(
    problem: Problem, nodes: ContactNodes, treatment: str, wear: Array, times: Array
) -> WornOnMesh:
    """Return what the updates of a flat punch in full contact give without any error of steps.

    Parameters
    ----------
    problem, nodes, treatment : as for `relief`
    wear : (n,) wear coefficients of the nodes, over the greatest
    times : (T,)
    """
    forces, matrix = nodes.stiffness.sum(axis=0), relief(problem, nodes, treatment)
    start = (nodes.pressures(treatment) @ nodes.stiffness).sum(axis=1)
    if problem.indentation is None:
        start = start / forces.sum()
    profiles = worn_profiles(matrix, start, wear, times)
    depths = (1 + profiles @ forces) / forces.sum()
    if problem.indentation is not None:
        depths = np.ones(len(times))
    return WornOnMesh(profiles, start - profiles @ matrix.T, depths)
