"""A quarter disc of quadrilaterals in rows and columns below the punch, with shells around it.

Below the punch, a square is the product of radii and depths. Around it, the quadrilaterals grow
geometrically with the distance from the centre, up to the arc of radius R. Non-dimensional: the
punch has radius 1, and depth is positive into the half-space.
"""

import numpy as np
from skfem import MeshQuad, MeshTri

from .radial import Array

SQUARE = 2.0
"""Side of the square below the punch, in punch radii."""
ROUND_FROM = 6.0
"""Distance from the centre, in punch radii, at which the shells around the square, which begin as
squares, have become arcs."""
GROWTH = 0.3
"""Growth of the sizes of elements per distance beyond the rim and below the first row."""


def growing_distances(length: float, first: float, largest: float, growth: float) -> Array:
    """Return distances from 0 to a length, in steps that grow with the distance.

    The steps are about ``min(first + growth * distance, largest)``: the distances are equally
    spaced in the integral of the inverse of this size.
    """
    first = min(first, largest)
    # distance, and number of steps, after which the steps no longer grow
    growth_end = (largest - first) / growth
    growth_steps = np.log(largest / first) / growth
    if length <= growth_end:
        steps = np.log1p(growth * length / first) / growth
    else:
        steps = growth_steps + (length - growth_end) / largest
    positions = np.linspace(0, steps, int(np.ceil(steps - 1e-9)) + 1)
    growing = first * np.expm1(growth * np.minimum(positions, growth_steps)) / growth
    distances = growing + largest * np.maximum(positions - growth_steps, 0.0)
    distances[-1] = length
    return distances


def shells_around(reach: float, growth: float) -> Array:
    """Return the distances of shells from the centre, from the side of the square to the reach."""
    return np.geomspace(SQUARE, reach, 2 + int(np.log(reach / SQUARE) / np.log1p(growth)))


def quarter_disc(radii: Array, depths: Array, shells: Array) -> MeshQuad:
    """Return the mesh of the square and of the shells around it, without names of boundaries.

    Parameters
    ----------
    radii, depths : of the vertices of the square
    shells : distances of the shells from the centre, the first one the side of the square
    """
    rows, columns = len(depths), len(radii)
    square = np.arange(rows * columns).reshape(rows, columns)
    r, z = (grid.ravel() for grid in np.meshgrid(radii, depths))
    # boundary of the square, from the surface down its outer side and along its bottom to the axis
    side = np.append(square[:, -1], square[-1, -2::-1])
    start = np.stack([r[side], z[side]])
    direction = start / np.hypot(*start)
    # 0 for the shape of the square, 1 for an arc
    roundness = np.minimum(np.log(shells[1:] / SQUARE) / np.log(ROUND_FROM / SQUARE), 1.0)
    roundness, distance = roundness[:, None, None], shells[1:, None, None]
    points = distance * ((1 - roundness) * start / SQUARE + roundness * direction)
    outside = r.size + np.arange(points.shape[0] * side.size).reshape(-1, side.size)
    shell_nodes = np.vstack([side, outside])
    cells = [
        np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]).reshape(4, -1)
        for grid in (square, shell_nodes)
    ]
    vertices = np.hstack([[r, z], points.transpose(1, 0, 2).reshape(2, -1)])
    return MeshQuad(vertices, np.hstack(cells))


def below_nodes(on_contact: Array, reach: float, first_row: float | None = None) -> MeshQuad:
    """Return quadrilaterals below given vertices of the contact.

    Parameters
    ----------
    on_contact : (n,) radii of the vertices, from 0 to 1
    reach : radius of the quarter disc
    first_row : thickness of the first row, by default the least distance of two vertices
    """
    cells = np.diff(on_contact)
    thickness = float(cells.min()) if first_row is None else first_row
    beyond = 1 + growing_distances(SQUARE - 1, float(cells[-1]), SQUARE / 4, GROWTH)
    beyond[-1] = SQUARE
    depths = growing_distances(SQUARE, thickness, SQUARE / 4, GROWTH)
    radii = np.append(on_contact, beyond[1:])
    return quarter_disc(radii, depths, shells_around(reach, GROWTH))


def in_triangles(mesh: MeshQuad) -> MeshTri:
    """Return the mesh with each quadrilateral divided into two triangles.

    The diagonal of the square leads from the axis at the surface down.
    """
    first, second, third, fourth = mesh.t
    triangles = [[first, second, third], [first, third, fourth]]
    return MeshTri(mesh.p, np.hstack([np.stack(corners) for corners in triangles]))
