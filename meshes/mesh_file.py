"""A half-space mesh that the user brings as a file: anything that meshio reads, with the boundaries named as ours.

Names are taken from gmsh physical groups, from cell sets, or from cell data on the line cells: an array called as a
boundary that marks its lines, or the array into which meshio turns cell sets for formats without any. Whatever is
wrong with the mesh is refused here, with what and where; lengths in messages are those of the file.
"""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

import numpy as np

from .errors import MeshError
from .half_space import HalfSpaceMesh, assemble
from .radial import Array, Indices

BOUNDARIES = ("contact", "free", "axis", "far")
# relative: how far a coordinate may be from where it belongs, so that files with nine digits are welcome
SLACK = 1e-8
TURNED = ", turned over (its second coordinate points out of the half-space)"
FIRST_ORDER = "in gmsh set Mesh.ElementOrder = 1; the displacement's degree is accuracy.fem.degree, not the mesh's"


def read(path: str | Path, edges: Array, radius: float = 1.0) -> HalfSpaceMesh:
    """Read the quarter disc from a file.

    Parameters
    ----------
    path : file that meshio reads, first coordinate the radius, second the depth, whose contact is at depth 0 and ends at
        1 (natural units) or at `radius`. A half-space drawn below its surface, as in the files that ringwear itself
        writes, has negative depths throughout: it is turned over, and `mesher` says so
    edges : (N+1,) ring edges in natural units, 0 to 1; each must be a vertex
    radius : radius of the punch in the units of the file

    Raises
    ------
    MeshError
        if the file is not such a mesh; the message says what is wrong, where, and the remedy
    """
    content = _content(Path(path))
    triangles = _triangles(content, path)
    points = _plane(np.asarray(content.points, dtype=float), triangles, path)
    turned = points[triangles.ravel(), 1].sum() < 0
    points[:, 1] = np.abs(points[:, 1])
    named = _named_facets(content, path)
    _refuse_inverted(points, triangles, path)
    scale = _scale(points, named["contact"], radius, path)
    _refuse_gaps(points, triangles, named["contact"], scale, path)
    snapped = _snapped(points / scale, named, edges, path)
    # told by its boundaries: `assemble` finds them from the coordinates, and the file's names must say the same
    try:
        made = assemble(snapped, triangles, edges, f"file {Path(path).name}{TURNED if turned else ''}")
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error
    _refuse_misnamed(made, snapped, named, path)
    return made


def _content(path: Path) -> Any:
    import meshio

    if not path.is_file():
        raise MeshError(f"{path}: {'this is a directory' if path.is_dir() else 'no such file'}; give a mesh file")
    printed = io.StringIO()
    try:
        # meshio prints its complaints, and leaves by SystemExit where no reader understands a file
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            return meshio.read(path)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        reason = str(error) if isinstance(error, Exception) and str(error) else "no reader of meshio understands it"
        raise MeshError(f"{path} is not a mesh that meshio can read ({reason}): give a .msh of gmsh, a .vtu, ...") from error


def _triangles(content: Any, path: str | Path) -> Indices:
    kinds = {block.type for block in content.cells}
    higher = sorted(kind for kind in kinds if kind.startswith(("line", "triangle")) and kind not in ("line", "triangle"))
    if higher:
        raise MeshError(f"{path} holds cells of second or higher order ({', '.join(higher)}): "
                        f"export straight triangles of first order; {FIRST_ORDER}")  # fmt: skip
    strange = sorted(kinds - {"vertex", "line", "triangle"})
    if strange:
        raise MeshError(f"{path} holds cells of kind {', '.join(strange)}: only triangles are supported, and lines for the "
                        "boundaries; in gmsh do not recombine, and mesh in two dimensions")  # fmt: skip
    found = [block.data for block in content.cells if block.type == "triangle" and len(block.data)]
    if not found:
        raise MeshError(f"{path} holds no triangles: in gmsh a physical group of the surface is needed too "
                        "(or Mesh.SaveAll = 1), else only the named lines are saved")  # fmt: skip
    return np.concatenate(found).astype(np.int64)


def _plane(points: Array, triangles: Indices, path: str | Path) -> Array:
    """(n, 2) radius and depth, the depths of the triangles all of one sign."""
    slack = SLACK * np.abs(points).max()
    used = points[np.unique(triangles)]
    if points.shape[1] > 2 and np.ptp(used[:, 2]) > slack:
        raise MeshError(f"{path}: the third coordinate varies: the first must be the radius, the second the depth")
    if used[:, 0].min() < -slack:
        r, z = used[used[:, 0].argmin(), :2]
        remedy = "mesh one side of the axis only" if used[:, 0].max() > slack else "multiply the first coordinate by -1"
        raise MeshError(f"{path}: the vertex at ({r:.6g}, {z:.6g}) has a negative radius; {remedy}")
    below, above = used[used[:, 1] > slack], used[used[:, 1] < -slack]
    if len(below) and len(above):
        stray = min(below, above, key=len)
        r, z = stray[np.abs(stray[:, 1]).argmax(), :2]
        raise MeshError(f"{path}: {len(below)} vertices have a positive depth and {len(above)} a negative one, among the "
                        f"fewer ({r:.6g}, {z:.6g}); the half-space must lie on one side of depth 0")  # fmt: skip
    return points[:, :2].copy()


def _named_facets(content: Any, path: str | Path) -> dict[str, Indices]:
    """(k, 2) vertices of the line cells of each boundary."""
    found: dict[str, list[Indices]] = {name: [] for name in BOUNDARIES}
    for block, lines in enumerate(content.cells):
        if lines.type == "line":
            for name in BOUNDARIES:
                chosen = _chosen(content, name, block)
                if len(chosen):
                    found[name].append(lines.data[chosen].astype(np.int64))
    missing = [name for name, parts in found.items() if not parts]
    if missing:
        marks = (name for key in content.cell_data for name in (key, *key.split("-")))
        known = {*content.field_data, *(key for key in content.cell_sets if ":" not in key), *marks}
        present = sorted(name for name in known if "-" not in name) or ["none at all"]
        raise MeshError(f"{path}: no line cells are named {' or '.join(missing)} (names in the file: {', '.join(present)}); "
                        "name the boundaries contact, free, axis and far, in gmsh by physical groups of curves")  # fmt: skip
    return {name: np.unique(np.sort(np.concatenate(parts), axis=1), axis=0) for name, parts in found.items()}


def _chosen(content: Any, name: str, block: int) -> Indices:
    """Cells of a block that carry a boundary's name, by whichever way the file tells it."""
    if name in content.cell_sets:
        cells = content.cell_sets[name][block]
        return np.empty(0, dtype=np.int64) if cells is None else np.asarray(cells, dtype=np.int64)
    if name in content.field_data and "gmsh:physical" in content.cell_data:
        return np.flatnonzero(content.cell_data["gmsh:physical"][block] == content.field_data[name][0])
    if name in content.cell_data:
        return np.flatnonzero(np.asarray(content.cell_data[name][block]) > 0)
    for key, values in content.cell_data.items():
        names = key.split("-")
        if len(names) > 1 and name in names:
            return np.flatnonzero(np.asarray(values[block]) == names.index(name))
    return np.empty(0, dtype=np.int64)


def _refuse_inverted(points: Array, triangles: Indices, path: str | Path) -> None:
    """One orientation throughout is only a convention; a mixture is a mesh folded over itself."""
    first, second, third = (points[triangles[:, i]] for i in range(3))
    p, q = second - first, third - first
    areas = (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) / 2
    backwards = np.flatnonzero(areas < 0) if (areas > 0).sum() >= (areas < 0).sum() else np.flatnonzero(areas > 0)
    for bad, what in ((backwards, "inverted"), (np.flatnonzero(areas == 0), "flat (of no area)")):
        if len(bad):
            r, z = points[triangles[bad[0]]].mean(axis=0)
            raise MeshError(f"{path}: {len(bad)} of {len(areas)} triangles are {what}, the first of them triangle {bad[0]} "
                            f"at radius {r:.6g}, depth {z:.6g}")  # fmt: skip


def _scale(points: Array, contact: Indices, radius: float, path: str | Path) -> float:
    """Radius of the punch in the file: where the contact ends, which must be one of the two that are allowed."""
    end = float(points[contact, 0].max())
    for allowed in (1.0, radius):
        if abs(end / allowed - 1) <= SLACK:
            return end
    if end <= SLACK * np.abs(points).max():
        raise MeshError(f"{path}: the boundary contact lies on the axis: the first coordinate must be the radius, the "
                        "second the depth; exchange them")  # fmt: skip
    ends = "1" if radius == 1 else f"1 (in natural units) or {radius:.9g} (the radius of the punch)"
    raise MeshError(f"{path}: the boundary contact ends at radius {end:.9g} and should end at {ends}")


def _refuse_gaps(points: Array, triangles: Indices, contact: Indices, scale: float, path: str | Path) -> None:
    """The contact must be one line from the axis to the rim, and the triangles must share their vertices."""
    slack = SLACK * scale
    spans = np.sort(points[contact, 0], axis=1)
    spans = spans[np.argsort(spans[:, 0])]
    depth = points[contact, 1]
    if depth.min() > slack:
        raise MeshError(f"{path}: the boundary contact lies at depth {depth.min():.6g} and should lie at 0: shift the mesh")
    if depth.max() > slack:
        raise MeshError(f"{path}: the boundary contact leaves the surface, down to depth {depth.max():.3g}")
    ends = np.concatenate([[0.0], np.maximum.accumulate(spans[:, 1])])
    gaps = np.flatnonzero(spans[:, 0] > ends[:-1] + slack)
    if len(gaps):
        low, high = ends[gaps[0]], spans[gaps[0], 0]
        raise MeshError(f"{path}: the boundary contact has a gap from radius {low:.9g} to {high:.9g}")
    used = np.unique(triangles)
    rounded = np.round(points[used] / slack)
    _, first, count = np.unique(rounded, axis=0, return_index=True, return_counts=True)
    if count.max() > 1:
        r, z = points[used[first[np.flatnonzero(count > 1)[0]]]]
        raise MeshError(f"{path}: {int((count > 1).sum())} vertices are there twice, the first at radius {r:.6g}, depth "
                        f"{z:.6g}: the mesh is torn there; merge them (in gmsh: Coherence Mesh)")  # fmt: skip


def _snapped(points: Array, named: dict[str, Indices], edges: Array, path: str | Path) -> Array:
    """Vertices of the boundaries put exactly where they belong, if they are off by rounding only."""
    points = points.copy()
    axis, surface = np.unique(named["axis"]), np.unique([*named["contact"].ravel(), *named["free"].ravel()])
    for vertices, coordinate in ((axis, 0), (surface, 1)):
        near = vertices[np.abs(points[vertices, coordinate]) < SLACK]
        points[near, coordinate] = 0.0
    contact = np.unique(named["contact"])
    nearest = np.abs(points[contact, 0][:, None] - edges).argmin(axis=0)
    close = np.abs(points[contact[nearest], 0] - edges) < SLACK
    if not close.all():
        raise MeshError(f"{path}: no vertex of the mesh lies on the ring edge at r = {np.asarray(edges)[~close][0]:.9g} a: "
                        "put a point of the geometry there")  # fmt: skip
    points[contact[nearest], 0] = edges
    far = np.unique(named["far"])
    outer = points[far, 0].max()
    distance = np.hypot(*points[far].T)
    near_arc = np.abs(distance / outer - 1) < SLACK
    points[far[near_arc]] *= (outer / distance[near_arc])[:, None]
    return points


def _refuse_misnamed(made: HalfSpaceMesh, points: Array, named: dict[str, Indices], path: str | Path) -> None:
    for name in BOUNDARIES:
        ours = {tuple(map(tuple, side)) for side in np.round(made.points[made.boundaries[name]] / SLACK)}
        theirs = np.round(points[named[name]] / SLACK)
        sides = {tuple(map(tuple, side)) for side in theirs} | {tuple(map(tuple, side[::-1])) for side in theirs}
        lacking = [side for side in ours if side not in sides]
        if lacking:
            (r, z), _ = sorted(lacking)[0]
            raise MeshError(f"{path}: {len(lacking)} sides of the {name} boundary do not carry its name, the first at "
                            f"r = {r * SLACK:.6g} a, depth {z * SLACK:.6g} a")  # fmt: skip
