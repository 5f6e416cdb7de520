"""A half-space mesh that the user brings, as a file that meshio reads.

No names are needed: what is contact, free surface, axis and far boundary follows from where it
lies. Whatever is wrong with the mesh is refused here, with what and where; lengths in messages are
those of the file.
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

# relative: how far a coordinate may be from where it belongs, so that files with nine digits are
# welcome
SLACK = 1e-8


def read(path: str | Path, ring_edges: Array, radius: float = 1.0) -> Mesh:
    """Read the quarter disc from a file.

    Parameters
    ----------
    path : file that meshio reads, first coordinate the radius, second the depth, the surface at
        depth 0
    ring_edges : (N+1,) ring edges in punch radii, 0 to 1; each must be a vertex
    radius : radius of the punch in the units of the file

    Raises
    ------
    MeshError
        if the file is not such a mesh; the message says what is wrong, where, and the remedy
    """
    try:
        return as_half_space(_snapped(_mesh(Path(path)), ring_edges, radius), ring_edges)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


def _mesh(path: Path) -> Mesh:
    content = content_of(path)
    kinds = {block.type for block in content.cells if len(block.data)} - {"vertex", "line"}
    if kinds not in ({"triangle"}, {"quad"}):
        raise MeshError(
            f"it holds cells of kind {', '.join(sorted(kinds)) or 'line'}, and straight triangles "
            "or quadrilaterals are wanted, of one kind: in gmsh set Mesh.ElementOrder = 1, "
            "recombine all or nothing, and make a physical group of the surface"
        )
    return from_meshio(content, ignore_orientation=True)


def content_of(path: Path) -> "meshio.Mesh":
    """Return what meshio reads of a file.

    Raises
    ------
    MeshError
        if that is nothing
    """
    import meshio

    if not path.is_file():
        what = "this is a directory" if path.is_dir() else "no such file"
        raise MeshError(f"{what}: give a mesh file")
    printed = io.StringIO()
    try:
        # meshio prints its complaints, and leaves by SystemExit where no reader understands a file
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            return meshio.read(path)
    except (Exception, SystemExit) as error:
        reason = printed.getvalue().strip() or error
        raise MeshError(
            f"not a mesh that meshio can read ({reason}): give a .msh of gmsh, a .vtu, ..."
        ) from error


def _snapped(mesh: Mesh, ring_edges: Array, radius: float) -> Mesh:
    """Return the mesh in punch radii, vertices that are off by rounding put where they belong."""
    points, used = mesh.p / radius, np.unique(mesh.t)
    outer = points[0, used].max()
    outside = used[points[:, used].min(axis=0) < -SLACK * outer]
    if len(outside):
        r, z = mesh.p[:, outside[0]]
        raise MeshError(
            f"the vertex at ({r:.6g}, {z:.6g}) lies outside of the half-space: radii and depths "
            "must be positive; multiply a coordinate by -1, or mesh one side only"
        )
    surface = used[points[1, used] < SLACK * outer]
    distance = np.abs(points[0, surface, None] - ring_edges)
    lost = ring_edges[distance.min(axis=0, initial=np.inf) >= SLACK]
    if len(lost):
        raise MeshError(
            f"no vertex of the mesh lies on the ring edge at r = {lost[0]:.9g} a at depth 0: put a "
            f"point of the geometry there; a is {radius:.6g} in the units of the file"
        )
    # elements may be far smaller than what coordinates are off by in a coarser mesh
    shortest = float(np.linalg.norm(np.diff(points[:, mesh.facets], axis=1)[:, 0], axis=0).min())
    points[points < min(SLACK, 1e-3 * shortest)] = 0.0
    points[0, surface[distance.argmin(axis=0)]] = ring_edges
    outer, rho = points[0, used].max(), np.hypot(*points)
    arc = np.abs(rho / outer - 1) < SLACK
    points[:, arc] *= outer / rho[arc]
    return replace(mesh, doflocs=points)
