"""Recognise the sawtooth of a wear step that is longer than a mesh allows, in a table of pressures.

An update that is too long makes the pressure of a node jump up and down from row to row. Where
negative pressures are set to zero, the jumps saturate between zero and about twice the right
pressure, and the indentation remains right. The tables have consecutive updates. Non-dimensional.
"""

from dataclasses import dataclass

import numpy as np

from ...meshes import Array, Indices, MeshError
from ..crosscheck import Problem
from .contact_nodes import ELEMENTS, TREATMENTS, ContactNodes, contact_nodes
from .explicit import ROWS, ExplicitWear, wear_at_nodes
from .limits import mesh_below

SMALL, STEADY_RATIO = 0.02, 0.97
"""Least size of jumps over the mean pressure, and least ratio of successive jumps: small ones must
not decay. Noise has the ratio 2/3."""
LARGE, LASTING_RATIO, LASTING_GROWTH = 0.1, 0.7, 0.85
"""The same for jumps that may be irregular but must last, and least size of the later ones over the
earlier ones."""
MODEL_ROWS = 40
"""Number of the last rows in which a sawtooth is sought, and to which models are compared."""
FEWEST_RADII = 3
"""Least number of radii of a table."""


@dataclass(frozen=True)
class Sawtooth:
    """Pressures that jump up and down from update to update.

    Parameters
    ----------
    size : of the jumps at the worst radius, over the mean pressure
    number : number of that radius
    step : mean step between the rows
    limit : the longest stable step of a mesh with nodes at the radii; NaN if none can be made
    element : element of that mesh
    """

    size: float
    number: int
    step: float
    limit: float = np.nan
    element: str = ""


def bends(values: Array, times: Array) -> Array:
    """Return half the distances (T - 2, ...) of values (T, ...) from lines through neighbours."""
    shares = (times[1:-1] - times[:-2]) / (times[2:] - times[:-2])
    shares = shares.reshape((-1,) + (1,) * (values.ndim - 1))
    return np.asarray((values[1:-1] - (1 - shares) * values[:-2] - shares * values[2:]) / 2)


def find(times: Array, pressures: Array, mean: float) -> Sawtooth | None:
    """Return the sawtooth in rows near the end of a table, without its limit; None without one.

    Far beyond the limit pressures are irregular, and some rows show it, but others do not.

    Parameters
    ----------
    times : (T,) increasing
    pressures : (T, R) pressures of nodes, from inside to outside
    mean : mean pressure
    """
    if pressures.shape[1] < FEWEST_RADII:
        return None
    ends = range(len(times), max(ROWS, len(times) - MODEL_ROWS) - 1, -ROWS // 2)
    windows = (slice(end - ROWS, end) for end in ends)
    found = (_in_rows(times[rows], pressures[rows], mean) for rows in windows)
    return next(filter(None, found), None)


def _in_rows(times: Array, pressures: Array, mean: float) -> Sawtooth | None:
    """Return the sawtooth in some rows, without its limit; None if there is none."""
    bent = bends(pressures, times)
    alternates = (bent[1:] * bent[:-1] < 0).all(axis=0)
    sizes = np.where(alternates, np.median(np.abs(bent), axis=0), 0.0) / mean
    number = int(sizes.argmax())
    near = bent[:, max(0, number - 1) : number + 2]
    squares, half = (near**2).sum(axis=1), len(near) // 2
    if not squares[:-1].sum() > 0 or not squares[:half].sum() > 0:
        return None
    ratio = -(near[1:] * near[:-1]).sum() / squares[:-1].sum()
    growth = np.sqrt(squares[-half:].sum() / squares[:half].sum())
    size = float(sizes[number])
    steady = size > SMALL and ratio > STEADY_RATIO
    lasting = size > LARGE and ratio > LASTING_RATIO and growth > LASTING_GROWTH
    if not (steady or lasting):
        return None
    return Sawtooth(size, number, float(np.diff(times).mean()))


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
    times, pressures = times[-MODEL_ROWS:], pressures[-MODEL_ROWS:]
    touches = pressures > 1e-9 * np.abs(pressures).max()
    used = touches[:-2] & touches[1:-1] & touches[2:]
    changes = np.diff(np.diff(pressures, axis=0), axis=0)[used]
    best = np.inf, np.nan, ""
    if not len(changes) or not (changes**2).sum() > 0:
        return best[1:]
    for nodes in _models(problem, radii, element):
        places = np.abs(nodes.radii[:, None] - radii).argmin(axis=0)
        # nodes that the table does not have, such as those at ring edges, are between others; the
        # wear rate k p is continuous there
        rates = pressures[:-1] * wear_at_nodes(problem.merged, radii)
        everywhere = np.array([np.interp(nodes.radii, radii, row) for row in rates])
        for treatment in TREATMENTS:
            update = explicit(problem, nodes, treatment)
            worn = everywhere * np.diff(times)[:, None]
            predicted = np.diff(-(worn @ update.relief.T)[:, places], axis=0)[used]
            scale = (predicted * changes).sum() / (predicted**2).sum()
            if not scale > 0:
                continue
            rest = ((changes - scale * predicted) ** 2).sum() / (changes**2).sum()
            if rest < best[0]:
                best = float(rest), update.limit / float(scale), nodes.element
    # a model that allows the step does not describe the program
    return best[1:] if best[1] < np.diff(times).mean() else (np.nan, "")


def explicit(problem: Problem, nodes: ContactNodes, treatment: str) -> ExplicitWear:
    """Return the explicit updates of a problem on all nodes of a mesh."""
    everywhere: Indices = np.arange(len(nodes.radii))
    force = None if problem.indentation is not None else 1.0
    wear = wear_at_nodes(problem.merged, nodes.radii)
    return ExplicitWear(nodes, treatment, wear, force, everywhere)


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
