"""Read a half-space mesh from the user's file, by gmsh or meshio.

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
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from skfem import Mesh, MeshQuad, MeshTri
from skfem.io.meshio import from_meshio

from .by_gmsh.session import nodes, session, unavailable
from .decks import CornerMesh, read_deck
from .errors import MeshError
from .half_space import as_half_space
from .radial import Array, Indices

if TYPE_CHECKING:
    import meshio

# Largest relative error of a coordinate that is corrected: the surface and the arc relative to the
# outer radius, the ring edges relative to the punch radius. It allows for files with nine digits.
COORDINATE_TOLERANCE = 1e-8
# numbers of corners of cells in a plane, by the beginnings of their names in meshio and gmsh
PLANE_CELLS = {"triangle": 3, "quad": 4}
# files that gmsh reads in all their variants: parametric or partitioned ones, all versions
OF_GMSH = (".msh", ".unv", ".uff", ".bdf", ".nas", ".med")
# files that nobody reads here, and what to export instead
UNREAD = {
    ".mphtxt": "a mesh of COMSOL: export it as NASTRAN (.nas)",
    ".cdb": "an archive of Ansys: export the mesh as an input deck of Abaqus (.inp) or as NASTRAN",
    ".pvd": "a list of files of ParaView: give one of the .vtu files that it names",
}
# factors between units of length that a message tries
UNIT_FACTORS = [10.0**power for power in range(-9, 10) if power] + [25.4, 1 / 25.4]
# greatest number of bodies of which the largest is the half-space; more are torn apart
MOST_BODIES = 8
# number of radii of vertices that a message lists
MOST_LISTED = 8


def read(path: str | Path, ring_edges: Array, radius: float = 1.0) -> Mesh:
    """Read the quarter disc from a file.

    Parameters
    ----------
    path : input deck of Abaqus or CalculiX (.inp), universal file (.unv), or a file that meshio can
        read. The first coordinate is the radius, on either side of the axis; the other one is the
        depth or the height, and the surface is at 0. Cells of second order are read by their
        corners
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
    """Return the mesh of corners in the plane of radius and depth, both positive.

    Raises
    ------
    MeshError
        if the file has no mesh in a plane, or cells of two kinds
    """
    corners = _corners(path)
    if len(corners.triangles) and len(corners.quads):
        raise MeshError(
            f"it holds {len(corners.triangles)} triangles and {len(corners.quads)} quadrilaterals, "
            "but the cells must be all of one kind: in gmsh recombine all elements or none"
        )
    cells = _largest_body(corners.triangles if len(corners.triangles) else corners.quads, corners)
    used, cells = np.unique(cells, return_inverse=True)
    points = corners.points[used]
    spans = np.ptp(points, axis=0)
    plane = [0, *np.flatnonzero(spans[1:] > COORDINATE_TOLERANCE * spans.max()) + 1]
    if len(plane) != 2 or not spans[0]:
        raise MeshError(
            "its cells do not lie in the plane of the first coordinate, the radius, and another "
            "one, the depth: give a mesh of the quarter disc in that plane"
        )
    points = points[:, plane].T
    # the axis may be on the right, and the height may point upwards
    for row in points:
        if row.max() <= COORDINATE_TOLERANCE * spans.max():
            row *= -1
    shape = 3 if len(corners.triangles) else 4
    kind = MeshTri if shape == 3 else MeshQuad
    mesh = kind(np.ascontiguousarray(points), np.ascontiguousarray(cells.reshape(-1, shape).T))
    parts = corners.subdomains
    if parts and sum(map(len, parts.values())) <= mesh.nelements == corners.size:
        mesh = replace(mesh, _subdomains=parts)
    return mesh


def _largest_body(cells: Indices, corners: CornerMesh) -> Indices:
    """Return the cells of the largest of a few bodies, such as a half-space and a punch."""
    count = len(corners.points)
    pairs = np.stack([cells.ravel(), np.roll(cells, 1, axis=1).ravel()])
    graph = coo_matrix((np.ones(pairs.shape[1], dtype=bool), pairs), shape=(count, count))
    _, bodies = connected_components(graph, directed=False)
    of_cells = bodies[cells[:, 0]]
    numbers = np.unique(of_cells)
    if not 1 < len(numbers) <= MOST_BODIES:
        return cells
    spans = [np.ptp(corners.points[np.unique(cells[of_cells == each])]) for each in numbers]
    return cells[of_cells == numbers[int(np.argmax(spans))]]


def _corners(path: Path) -> CornerMesh:
    """Return the corners of the plane cells of a file."""
    suffix = path.suffix.lower()
    if path.is_file():
        if suffix in UNREAD:
            raise MeshError(f"this is {UNREAD[suffix]}")
        if suffix == ".inp":
            return read_deck(path)
        # without gmsh, meshio reads the commonest of its files
        if suffix in OF_GMSH and not (suffix == ".msh" and unavailable()):
            return _read_with_gmsh(path)
    content = read_with_meshio(path)
    points = np.zeros((len(content.points), 3))
    points[:, : content.points.shape[1]] = content.points
    subdomains = dict[str, Indices]()
    first_order = {block.type for block in content.cells} & {"triangle", "quad"}
    if first_order and (content.cell_sets or content.cell_data):
        subdomains = from_meshio(content, ignore_orientation=True).subdomains or {}
    blocks = [(block.type, block.data) for block in content.cells if len(block.data)]
    return _plane(points, blocks)._replace(subdomains=subdomains)


def _plane(points: Array, blocks: list[tuple[str, Indices]]) -> CornerMesh:
    """Return the corners of all triangles and of all quadrilaterals.

    Parameters
    ----------
    points : (n, 3) coordinates
    blocks : names of types of cells, such as triangle6 or Quadrilateral 9, and rows of `points`

    Raises
    ------
    MeshError
        if there are none; the message names the types of the others
    """
    triangles, quads = (
        [rows[:, :count] for name, rows in blocks if name.lower().startswith(shape)]
        for shape, count in PLANE_CELLS.items()
    )
    if not (triangles or quads):
        lower = ("vertex", "point", "line")
        others = {name for name, _ in blocks if not name.lower().startswith(lower)}
        raise MeshError(
            f"it holds cells of type {', '.join(sorted(others)) or 'line'}, but they must be "
            "triangles or quadrilaterals in a plane: in gmsh make a physical group of the surface"
        )
    return CornerMesh(
        points,
        np.concatenate([np.empty((0, 3), dtype=np.int64), *triangles]),
        np.concatenate([np.empty((0, 4), dtype=np.int64), *quads]),
    )


def _read_with_gmsh(path: Path) -> CornerMesh:
    """Read the corners of cells with gmsh; a cell of several physical groups counts once.

    Raises
    ------
    MeshError
        if gmsh cannot read the file, or if it has no triangles or quadrilaterals
    """
    blocks = list[tuple[str, Indices]]()
    if path.suffix.lower() == ".msh" and not path.read_bytes()[:32].lstrip().startswith(b"$"):
        raise MeshError(
            "this is not a mesh of gmsh, which begins with $; FreeFEM uses the same suffix: there, "
            "save it as .mesh"
        )
    with session() as gmsh:
        try:
            gmsh.open(str(path))
        except Exception as error:  # gmsh raises bare exceptions
            raise MeshError(
                f"gmsh cannot read it ({error}): export it again as MSH 4.1 or 2.2"
            ) from None
        points, number = nodes(gmsh)
        for kind, _, cells in zip(*gmsh.model.mesh.getElements(), strict=True):
            name, _, _, count, *_ = gmsh.model.mesh.getElementProperties(kind)
            rows = number[cells].reshape(-1, count)
            _, first = np.unique(np.sort(rows, axis=1), axis=0, return_index=True)
            blocks.append((name, rows[np.sort(first)]))
    return _plane(points, blocks)


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
            f"the vertex at ({r:.6g}, {z:.6g}) lies outside the half-space: radii must have one "
            "sign, and so must depths, with the surface at 0; mesh one side only"
        )
    surface = used[points[1, used] < COORDINATE_TOLERANCE * outer]
    distance = np.abs(points[0, surface, None] - ring_edges)
    missing = ring_edges[distance.min(axis=0, initial=np.inf) >= COORDINATE_TOLERANCE]
    if len(missing):
        raise MeshError(
            f"no vertex of the mesh lies on the ring edge at r = {missing[0]:.9g} a at depth 0: "
            f"put a point of the geometry there; a is {radius:.6g} in the units of the file. "
            f"{_other_places(np.sort(points[0, surface]), ring_edges, radius)}"
        )
    # the tolerance is reduced if elements are small, so that none of them collapses
    shortest = float(np.linalg.norm(np.diff(points[:, mesh.facets], axis=1)[:, 0], axis=0).min())
    points[points < min(COORDINATE_TOLERANCE, 1e-3 * shortest)] = 0.0
    points[0, surface[distance.argmin(axis=0)]] = ring_edges
    outer, rho = points[0, used].max(), np.hypot(*points)
    arc = np.abs(rho / outer - 1) < COORDINATE_TOLERANCE
    points[:, arc] *= outer / rho[arc]
    return replace(mesh, doflocs=points)


def _other_places(radii: Array, ring_edges: Array, radius: float) -> str:
    """Say at which radii the vertices on the surface lie, and which factor would fit.

    Parameters
    ----------
    radii : (k,) increasing radii of these vertices, in punch radii
    ring_edges : (N+1,) ring edges in punch radii
    radius : radius of the punch in the units of the file
    """
    if not len(radii):
        return "No vertex has the depth 0"
    shown = np.unique(np.linspace(0, len(radii) - 1, min(len(radii), MOST_LISTED)).astype(int))
    listed = ", ".join(f"{radius * radii[each]:.6g}" for each in shown)
    text = f"There the vertices lie at r = {listed}"
    for factor in UNIT_FACTORS:
        apart = np.abs(radii[:, None] - factor * ring_edges).min(axis=0)
        if (apart < COORDINATE_TOLERANCE * factor).all():
            number = f"{factor:g}" if factor >= 1 else f"1/{1 / factor:g}"
            inverse = f"1/{factor:g}" if factor >= 1 else f"{1 / factor:g}"
            return (
                f"{text}, and {number} times the ring edges are among them: multiply the lengths "
                f"of the file by {inverse}, or give their unit by --units"
            )
    return text
