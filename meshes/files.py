"""Read a half-space mesh from the user's file, by meshio.

The file needs no named boundaries: contact, free surface, axis and far boundary are recognised by
their position. A mesh that cannot be used is refused here, with a message that states the fault and
its place in the units of the file.
"""

import contextlib
import io
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from skfem import Mesh
from skfem.io.meshio import from_meshio

from .errors import MeshError
from .half_space import as_half_space
from .radial import Array

if TYPE_CHECKING:
    import meshio

# Largest relative error of a coordinate that is corrected: the surface and the arc relative to the
# outer radius, the ring edges relative to the punch radius. It allows for files with nine digits.
COORDINATE_TOLERANCE = 1e-8


def read(path: str | Path, ring_edges: Array, radius: float = 1.0) -> Mesh:
    """Read the quarter disc from a file.

    Parameters
    ----------
    path : file that meshio can read; the first coordinate is the radius, the second the depth, and
        the surface has depth 0
    ring_edges : (N+1,) ring edges in punch radii, from 0 or the radius of a hole to 1; each must be
        a vertex
    radius : radius of the punch in the units of the file

    Raises
    ------
    MeshError
        if the file holds no such mesh; the message states the fault, its place and the remedy
    """
    try:
        return as_half_space(_snapped(_mesh(Path(path)), ring_edges, radius), ring_edges)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


def _mesh(path: Path) -> Mesh:
    content = read_with_meshio(path)
    kinds = {block.type for block in content.cells if len(block.data)} - {"vertex", "line"}
    if kinds not in ({"triangle"}, {"quad"}):
        raise MeshError(
            f"it holds cells of type {', '.join(sorted(kinds)) or 'line'}, but the cells must be "
            "straight triangles or straight quadrilaterals, and all of one kind: in gmsh set "
            "Mesh.ElementOrder = 1, recombine all elements or none, and make a physical group of "
            "the surface"
        )
    return from_meshio(content, ignore_orientation=True)


def read_with_meshio(path: Path) -> "meshio.Mesh":
    """Read a file with meshio.

    Raises
    ------
    MeshError
        if the file does not exist or meshio cannot read it
    """
    import meshio

    if not path.is_file():
        fault = "this is a directory" if path.is_dir() else "no such file"
        raise MeshError(f"{fault}: give a mesh file")
    printed = io.StringIO()
    try:
        # meshio prints error messages, and raises SystemExit if none of its readers accepts the
        # file
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            return meshio.read(path)
    except (Exception, SystemExit) as error:
        reason = printed.getvalue().strip() or error
        raise MeshError(
            f"not a mesh that meshio can read ({reason}): give a .msh file of gmsh, a .vtu, ..."
        ) from error


def _snapped(mesh: Mesh, ring_edges: Array, radius: float) -> Mesh:
    """Return the mesh in punch radii, with rounding errors of special vertices removed.

    Vertices on the surface, the axis, the ring edges and the arc are moved exactly there.

    Raises
    ------
    MeshError
        if a vertex lies outside the half-space, or a ring edge has no vertex
    """
    points, used = mesh.p / radius, np.unique(mesh.t)
    outer = points[0, used].max()
    outside_vertices = used[points[:, used].min(axis=0) < -COORDINATE_TOLERANCE * outer]
    if len(outside_vertices):
        r, z = mesh.p[:, outside_vertices[0]]
        raise MeshError(
            f"the vertex at ({r:.6g}, {z:.6g}) lies outside the half-space: radii and depths "
            "must be positive; multiply a coordinate by -1, or mesh one side only"
        )
    surface = used[points[1, used] < COORDINATE_TOLERANCE * outer]
    distance = np.abs(points[0, surface, None] - ring_edges)
    missing = ring_edges[distance.min(axis=0, initial=np.inf) >= COORDINATE_TOLERANCE]
    if len(missing):
        raise MeshError(
            f"no vertex of the mesh lies on the ring edge at r = {missing[0]:.9g} a at depth 0: "
            f"put a point of the geometry there; a is {radius:.6g} in the units of the file"
        )
    # the tolerance is reduced if elements are small, so that none of them collapses
    shortest = float(np.linalg.norm(np.diff(points[:, mesh.facets], axis=1)[:, 0], axis=0).min())
    points[points < min(COORDINATE_TOLERANCE, 1e-3 * shortest)] = 0.0
    points[0, surface[distance.argmin(axis=0)]] = ring_edges
    outer, rho = points[0, used].max(), np.hypot(*points)
    arc = np.abs(rho / outer - 1) < COORDINATE_TOLERANCE
    points[:, arc] *= outer / rho[arc]
    return replace(mesh, doflocs=points)
