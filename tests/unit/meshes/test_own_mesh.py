"""Meshes of users: files of gmsh and meshio, and refusals that state what is wrong and where."""

from itertools import pairwise

import meshio
import numpy as np
import pytest

from ringwear import MeshError, SizeField, bisection
from ringwear.meshes.by_gmsh import session as gmsh_session
from ringwear.meshes.files import read
from ringwear.meshes.half_space import areas, contact_radii, truncation

EDGES = np.array([0.0, 0.5, 1.0])


@pytest.fixture(scope="module")
def ours():
    return bisection.mesh(SizeField((0.0, 0.5, 1.0), 0.05, 0.1, 0.6, 4.0))


def as_meshio(mesh, scale=1.0):
    """Return the mesh for meshio, without names of boundaries."""
    points = np.column_stack([scale * mesh.p.T, np.zeros(mesh.nvertices)])
    return meshio.Mesh(points, [("triangle", mesh.t.T.copy())])


def gmsh_file(path, version=4.1, recombine=False, order=1, surface=True):
    """Write a quarter disc by gmsh, with or without a physical group for its surface."""
    with gmsh_session.session() as gmsh:
        gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 1)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.RecombineAll", int(recombine))
        gmsh.option.setNumber("Mesh.RecombinationAlgorithm", 3)
        geo = gmsh.model.geo
        sizes = ((0, 0, 0.3), (0.5, 0, 0.1), (1, 0, 0.05), (4, 0, 1), (0, 4, 1))
        p = [geo.addPoint(r, z, 0, h) for r, z, h in sizes]
        lines = [geo.addLine(a, b) for a, b in pairwise(p[:4])]
        lines += [geo.addCircleArc(p[3], p[0], p[4]), geo.addLine(p[4], p[0])]
        disc = geo.addPlaneSurface([geo.addCurveLoop(lines)])
        geo.synchronize()
        gmsh.model.addPhysicalGroup(1, lines, name="outline")
        if surface:
            gmsh.model.addPhysicalGroup(2, [disc], name="solid")
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(path))
    return path


@pytest.mark.gmsh
@pytest.mark.parametrize(("version", "recombine"), [(2.2, False), (4.1, False), (4.1, True)])
def test_a_file_of_gmsh_is_read(tmp_path, version, recombine):
    mesh = read(gmsh_file(tmp_path / "disc.msh", version, recombine), EDGES)
    assert len(mesh.t) == (4 if recombine else 3)
    assert truncation(mesh) == 4.0
    assert set(EDGES) <= set(contact_radii(mesh))
    assert all(len(facets) for facets in mesh.boundaries.values())


@pytest.mark.parametrize("ending", [".vtu", ".vtk"])
@pytest.mark.parametrize("scale", [1.0, 0.003])
def test_a_file_of_meshio_gives_the_same_mesh_back(tmp_path, ours, ending, scale):
    path = tmp_path / f"disc{ending}"
    as_meshio(ours, scale).write(path)
    mesh = read(path, EDGES, radius=scale)
    np.testing.assert_allclose(mesh.p, ours.p, rtol=1e-14, atol=1e-14)
    np.testing.assert_array_equal(mesh.t, ours.t)
    np.testing.assert_equal(dict(mesh.boundaries), dict(ours.boundaries))


@pytest.mark.parametrize("surface", [1e-12, -1e-12])
def test_rounding_at_the_surface_and_on_the_arc_is_corrected(tmp_path, ours, surface):
    content = as_meshio(ours)
    content.points[:, 1] = np.where(ours.p[1] == 0, surface, ours.p[1])
    arc = np.isclose(np.hypot(*ours.p), truncation(ours), rtol=1e-9)
    content.points[arc & (ours.p[1] > 0)] *= 1 + 1e-10
    content.write(tmp_path / "disc.vtk")
    mesh = read(tmp_path / "disc.vtk", EDGES)
    assert areas(mesh).min() > 0
    np.testing.assert_allclose(mesh.p, ours.p, rtol=1e-14, atol=1e-14)


def tear(content):
    """Separate all triangles, so that each has its own vertices."""
    triangles = content.cells[0].data
    content.points = content.points[triangles.ravel()]
    content.cells[0].data = np.arange(triangles.size).reshape(-1, 3)


def mix(content):
    content.cells.append(meshio.CellBlock("quad", np.array([[0, 1, 2, 3]])))


def move(points):
    """Move all points by a function of their coordinates."""

    def change(content):
        content.points = np.column_stack(points(content.points.T))

    return change


def pull_out(content):
    """Move one vertex outside the half-space."""
    r, z, _ = content.points.T
    content.points[int(np.argmin(np.hypot(r - 2, z - 0.3))), 1] = -0.25


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (tear, "hole or a gap, .* Coherence Mesh"),
        (mix, "1 quadrilaterals, but .* of one kind"),
        (move(lambda p: 1.5 * p), "ring edge at r = 0.5 a"),
        (move(lambda p: (p[0], 4 - p[1], p[2])), "ring edge at"),
        (
            move(lambda p: (p[0] - 0.5, p[1], p[2])),
            r"\(-0.5, 0\) .*radii must have one sign",
        ),
        (pull_out, r"\(\d.*, -0.25\) .*so must depths"),
        (move(lambda p: 10 * p), r"r = 0, .* 10 times the ring edges .* by 1/10, or .* --units"),
        (move(lambda p: p / 1000), "1/1000 times the ring edges .* by 1000"),
    ],
)
def test_a_broken_mesh_is_refused_with_what_and_where(tmp_path, ours, change, message):
    content = as_meshio(ours)
    change(content)
    content.write(tmp_path / "bad.vtu")
    with pytest.raises(MeshError, match=message):
        read(tmp_path / "bad.vtu", EDGES)


@pytest.mark.parametrize(
    "change",
    [
        move(lambda p: (-p[0], p[1], p[2])),
        move(lambda p: (p[0], -p[1], p[2])),
        move(lambda p: (p[0], 0 * p[1], -p[1])),
    ],
    ids=["axis on the right", "height upwards", "height along z"],
)
def test_the_axis_may_be_on_either_side_and_the_height_point_upwards(tmp_path, ours, change):
    content = as_meshio(ours)
    change(content)
    content.write(tmp_path / "disc.vtu")
    mesh = read(tmp_path / "disc.vtu", EDGES)
    np.testing.assert_allclose(mesh.p, ours.p, rtol=1e-14, atol=1e-14)


@pytest.mark.gmsh
def test_the_message_says_how_to_export(tmp_path):
    with pytest.raises(MeshError, match="physical group of the surface"):
        read(gmsh_file(tmp_path / "disc.msh", surface=False), EDGES)


@pytest.mark.gmsh
@pytest.mark.parametrize("recombine", [False, True])
def test_cells_of_second_order_are_read_by_their_corners(tmp_path, recombine):
    first, second = (
        read(gmsh_file(tmp_path / f"{order}.msh", recombine=recombine, order=order), EDGES)
        for order in (1, 2)
    )
    np.testing.assert_allclose(
        np.sort(second.p, axis=1), np.sort(first.p, axis=1), rtol=0, atol=1e-14
    )
    assert second.t.shape == first.t.shape


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("absent.msh", "no such file"),
        ("text.msh", "not a mesh"),
        ("text.xyz", "not a mesh"),
        ("", "this is a directory"),
    ],
)
def test_files_that_are_not_meshes_are_refused(tmp_path, capsys, name, message):
    if "text" in name:
        (tmp_path / name).write_text("nothing of the kind\n")
    with pytest.raises(MeshError, match=message):
        read(tmp_path / name, EDGES)
    assert capsys.readouterr().out == ""
