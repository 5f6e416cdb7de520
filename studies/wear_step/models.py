"""The longest stable step of the mesh of a table of pressures, by models of it.

A model is a mesh in rows and columns whose nodes are at the radii of the table. Non-dimensional.
"""

from itertools import product

import numpy as np

from ...meshes import Array, MeshError
from ..crosscheck import Problem
from ..estimate.histories import worn_at_nodes
from ..study.own import ELEMENTS
from .contact_nodes import (
    TREATMENTS,
    ContactNodes,
    contact_nodes,
    longest_step,
    relief,
    wear_at_nodes,
)
from .limits import mesh_below

FEWEST_RADII, MOST_RADII = 4, 300
"""Numbers of radii of which results on a mesh are computed; finer meshes have smaller errors."""
BESIDE = 1e-7
"""Distance from ring edges at which wear coefficients of both sides are taken, in punch radii."""


def limit_of_models(
    problem: Problem, times: Array, radii: Array, pressures: Array, element: str | None = None
) -> tuple[float, str]:
    """Return the longest stable step by the model mesh that predicts a table best, and its element.

    The mesh has its nodes at the radii of the table. A model predicts the change of the pressure of
    a node that touches in three rows, ``-G k p dt``, even if others are clipped. Its stiffness is
    scaled to the table. NaN if no model can be made.

    Parameters
    ----------
    problem : the problem
    times : (T,) of consecutive updates
    radii : (R,) radii of the nodes, in punch radii
    pressures : (T, R) their pressures
    element : element of the program, if it is known
    """
    touches = pressures > 1e-9 * np.abs(pressures).max()
    used = touches[:-2] & touches[1:-1] & touches[2:]
    changes = np.diff(np.diff(pressures, axis=0), axis=0)[used]
    best = np.inf, np.nan, ""
    if not len(changes) or not (changes**2).sum() > 0:
        return best[1:]
    # nodes that the table does not have, such as those at ring edges, are between others; the wear
    # rate k p is continuous there
    rates = pressures[:-1] * wear_at_nodes(problem.merged, radii)
    for nodes in _models(problem, radii, element):
        places = np.abs(nodes.radii[:, None] - radii).argmin(axis=0)
        everywhere = np.array([np.interp(nodes.radii, radii, row) for row in rates])
        for treatment in TREATMENTS:
            worn = everywhere * np.diff(times)[:, None]
            changed = -(worn @ relief(problem, nodes, treatment).T)[:, places]
            predicted = np.diff(changed, axis=0)[used]
            scale = (predicted * changes).sum() / (predicted**2).sum()
            if not scale > 0:
                continue
            rest = ((changes - scale * predicted) ** 2).sum() / (changes**2).sum()
            if rest < best[0]:
                limit = longest_step(problem, nodes, treatment)
                best = float(rest), limit / float(scale), nodes.element
    # a model that allows the step does not describe the program
    return best[1:] if best[1] < np.diff(times).mean() else (np.nan, "")


def results_on_mesh(
    problem: Problem, times: Array, radii: Array, pressures: Array, element: str
) -> dict[str, Array]:
    """Return pressure, profile and displacement (T, R) and indentation (T,) on a mesh of elements.

    The mesh has its nodes at the radii, and no error of wear steps. Nodes at ring edges have the
    wear coefficient of the ring inside or outside, or their harmonic mean, and pressures are
    computed per node or by the mass matrix, whichever is nearest to the pressures of the program.
    Empty if no such mesh is known: of a punch that is not flat, of layers, or of a load that
    varies.

    Parameters
    ----------
    problem : the problem
    times : (T,) non-dimensional
    radii : (R,) radii of the nodes, in punch radii
    pressures : (T, R) of the program, non-dimensional
    element : name of the element
    """
    models = list[ContactNodes]()
    steady_load = problem.full_contact and not problem.keeps_contact and not problem.loading.varies
    if steady_load and FEWEST_RADII <= len(radii) <= MOST_RADII:
        models = _models(problem, radii, element)
    best, found = np.inf, dict[str, Array]()
    for nodes, treatment, side in product(models, TREATMENTS, (-1, 0, 1)):
        wear = wear_at_nodes(problem.merged, nodes.radii)
        if side:
            wear = problem.merged.at(np.clip(nodes.radii + side * BESIDE, nodes.radii[0], 1.0))
        stiffness, forces = (
            nodes.pressures(treatment) @ nodes.stiffness,
            nodes.stiffness.sum(axis=0),
        )
        worn = worn_at_nodes(stiffness, forces, wear, times, problem.indentation is None)
        fields = {
            "pressure": worn.pressures,
            "profile": worn.profiles,
            "displacement": worn.indentations[:, None] - worn.profiles,
        }
        results = {
            name: np.array([np.interp(radii, nodes.radii, row) for row in values])
            for name, values in fields.items()
        }
        distance = float(np.nanmedian(np.abs(results["pressure"] - pressures)))
        if distance < best:
            best, found = distance, results | {"indentation": worn.indentations}
    scale = 1.0 if problem.indentation is None else problem.indentation
    return {name: scale * values for name, values in found.items()}


def _models(problem: Problem, radii: Array, element: str | None) -> list[ContactNodes]:
    """Return contact nodes of meshes in rows and columns with nodes at given radii.

    Quadratic elements are possible only if every second node is midway between its neighbours.
    """
    if problem.ground.layered:
        return []
    inner = problem.inner_radius
    # tables often leave out ring edges, at which pressures jump, and the rim
    edges = problem.merged.ring_edges
    nodes = np.union1d(radii, [edge for edge in edges if np.abs(radii - edge).min() > 1e-6])
    nodes[[0, -1]] = inner, 1.0
    middles = (nodes[:-2:2] + nodes[2::2]) / 2
    midway = (
        len(nodes) % 2 == 1 and np.abs(nodes[1::2] - middles).max() < 1e-3 * np.diff(nodes).min()
    )
    names = [element] if element else list(ELEMENTS)
    models = []
    for name in names:
        if name.endswith("1"):
            vertices = nodes
        elif midway or element:
            vertices = nodes[::2] if midway else nodes
        else:
            continue
        if inner:
            # the mesh reaches to the axis below a hole
            step = vertices[1] - vertices[0]
            count = max(1, int(np.ceil(inner / step)))
            vertices = np.append(np.linspace(0, inner, count, endpoint=False), vertices)
        try:
            mesh = mesh_below(vertices, name, np.array([inner, 1.0]))
        except MeshError:
            continue
        models.append(contact_nodes(mesh, name, problem.ground))
    return models
