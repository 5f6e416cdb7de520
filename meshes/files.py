"""A half-space mesh that the user brings, as a file that meshio reads.

No names are needed: what is contact, free surface, axis and far boundary follows from where it
lies. Whatever is wrong with the mesh is refused here, with what and where; lengths in messages are
those of the file.
"""

import contextlib
import io
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from skfem import Mesh
from skfem.io.meshio import from_meshio

from .errors import MeshError
from .half_space import as_half_space
from .radial import Array

# relative: how far a coordinate may be from where it belongs, so that files with nine digits are
# welcome
SLACK = 1e-8


def read(path: str | Path, ring_edges: Array, radius: float = 1.0) -> tuple[Mesh, str]:
    """Read the quarter disc from a file; returns the mesh, and what was done to it beyond reading.

    Parameters
    ----------
    path : file that meshio reads, first coordinate the radius, second the depth, the surface at
        depth 0, ring edges where they are in punch radii or at `radius` times that. A half-space
        drawn below its surface, with negative depths throughout, is turned over
    ring_edges : (N+1,) ring edges in punch radii, 0 to 1; each must be a vertex
    radius : radius of the punch in the units of the file

    Raises
    ------
    MeshError
        if the file is not such a mesh; the message says what is wrong, where, and the remedy
    """
    try:
        mesh, remark = _upright(_mesh(Path(path)))
        return as_half_space(_snapped(mesh, ring_edges, radius), ring_edges), remark
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


def _mesh(path: Path) -> Mesh:
    content = content_of(path)
    kinds = {block.type for block in content.cells if len(block.data)}
    higher = sorted(kind for kind in kinds if re.match(r"(line|triangle|quad)\d", kind))
    if higher:
        raise MeshError(
            f"it holds cells of second or higher order ({', '.join(higher)}): export straight "
            "cells of first order; in gmsh set Mesh.ElementOrder = 1; the displacement's degree is "
            "accuracy.fem.degree, not the mesh's"
        )
    strange = sorted(kinds - {"vertex", "line", "triangle", "quad"})
    if strange:
        raise MeshError(f"it holds cells of kind {', '.join(strange)}: mesh in two dimensions")
    shapes = sorted(kinds & {"triangle", "quad"})
    if not shapes:
        raise MeshError(
            "it holds neither triangles nor quadrilaterals: in gmsh a physical group of the "
            "surface is needed too (or Mesh.SaveAll = 1), else only the named lines are saved"
        )
    if len(shapes) > 1:
        raise MeshError(
            "it holds triangles and quadrilaterals: give one kind only, in gmsh recombine all or "
            "nothing"
        )
    points = np.asarray(content.points, dtype=float)
    used = points[np.unique(content.cells_dict[shapes[0]])]
    if points.shape[1] > 2 and np.ptp(used[:, 2]) > SLACK * np.abs(used).max():
        raise MeshError(
            "the third coordinate varies: the first must be the radius, the second the depth"
        )
    return from_meshio(content, ignore_orientation=True)


def content_of(path: Path) -> Any:
    """Return what meshio reads of a file.

    Raises
    ------
    MeshError
        if that is nothing
    """
    import meshio

    if not path.is_file():
        what = "this is a directory" if path.is_dir() else "no such file"
        raise MeshError(f"{what}; give a mesh file")
    printed = io.StringIO()
    try:
        # meshio prints its complaints, and leaves by SystemExit where no reader understands a file
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            return meshio.read(path)
    except (Exception, SystemExit) as error:
        told = isinstance(error, Exception) and str(error)
        reason = told or "no reader of meshio understands it"
        raise MeshError(
            f"not a mesh that meshio can read ({reason}): give a .msh of gmsh, a .vtu, ..."
        ) from error


def _upright(mesh: Mesh) -> tuple[Mesh, str]:
    """The mesh with depths positive, and what was done to it."""
    used = mesh.p[:, np.unique(mesh.t)]
    slack = SLACK * np.abs(used).max()
    if used[0].min() < -slack:
        r, z = used[:, used[0].argmin()]
        remedy = (
            "mesh one side of the axis only"
            if used[0].max() > slack
            else "multiply the first coordinate by -1"
        )
        raise MeshError(f"the vertex at ({r:.6g}, {z:.6g}) has a negative radius; {remedy}")
    below, above = used[:, used[1] > slack], used[:, used[1] < -slack]
    if below.size and above.size:
        stray = min(below, above, key=np.size)
        r, z = stray[:, np.abs(stray[1]).argmax()]
        raise MeshError(
            f"{below.shape[1]} vertices have a positive depth and {above.shape[1]} a negative one, "
            f"among the fewer ({r:.6g}, {z:.6g}); the half-space must lie on one side of depth 0"
        )
    remark = "turned over: its second coordinate points out of the half-space" if above.size else ""
    return replace(mesh, doflocs=np.stack([mesh.p[0], np.abs(mesh.p[1])])), remark


def _snapped(mesh: Mesh, ring_edges: Array, radius: float) -> Mesh:
    """The mesh in punch radii, vertices that are off by rounding put where they belong."""
    used = np.unique(mesh.t)
    size = mesh.p[0, used].max()
    surface = used[mesh.p[1, used] < SLACK * size]
    if not len(surface):
        raise MeshError(
            f"no vertex lies at depth 0, the least depth is {mesh.p[1, used].min():.6g}: shift the "
            "mesh"
        )
    on_surface = mesh.p[0, surface]
    for scale in (radius, 1.0):
        distance = np.abs(on_surface[:, None] / scale - ring_edges)
        lost = ring_edges[distance.min(axis=0) >= SLACK]
        if not len(lost):
            break
    else:
        raise MeshError(
            f"no vertex of the mesh lies on the ring edge at r = {lost[0]:.9g} a on the surface: "
            "put a point of the geometry there; the first coordinate must be the radius"
        )
    points = mesh.p / scale
    # elements may be far smaller than what coordinates are off by in a coarser mesh
    shortest = float(np.linalg.norm(np.diff(points[:, mesh.facets], axis=1)[:, 0], axis=0).min())
    points[points < min(SLACK, 1e-3 * shortest)] = 0.0
    points[0, surface[distance.argmin(axis=0)]] = ring_edges
    outer, rho = points[0, used].max(), np.hypot(*points)
    arc = np.abs(rho / outer - 1) < SLACK
    points[:, arc] *= outer / rho[arc]
    return replace(mesh, doflocs=points)
