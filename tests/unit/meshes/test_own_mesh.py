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


def as_meshio(mesh):
    """Return the mesh for meshio, without names of boundaries."""
    points = np.column_stack([mesh.p.T, np.zeros(mesh.nvertices)])
    return meshio.Mesh(points, [("triangle", mesh.t.T.copy())])


def gmsh_file(path, groups=("outline", "solid"), order=1, partitions=0, **options):
    """Write a quarter disc by gmsh, with physical groups of its lines or of its surface."""
    with gmsh_session.session() as gmsh:
        for name, value in {"MeshSizeFromPoints": 1, **options}.items():
            gmsh.option.setNumber(f"Mesh.{name}", value)
        geo = gmsh.model.geo
        sizes = ((0, 0, 0.3), (0.5, 0, 0.1), (1, 0, 0.05), (4, 0, 1), (0, 4, 1))
        p = [geo.addPoint(r, z, 0, h) for r, z, h in sizes]
        lines = [geo.addLine(a, b) for a, b in pairwise(p[:4])]
        lines += [geo.addCircleArc(p[3], p[0], p[4]), geo.addLine(p[4], p[0])]
        disc = geo.addPlaneSurface([geo.addCurveLoop(lines)])
        geo.synchronize()
        for name in groups:
            parts = (1, lines) if name == "outline" else (2, [disc])
            gmsh.model.addPhysicalGroup(*parts, name=name)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        if partitions:
            gmsh.model.mesh.partition(partitions)
        gmsh.write(str(path))
    return path


@pytest.mark.gmsh
@pytest.mark.parametrize("version", [2.2, 4.0, 4.1])
@pytest.mark.parametrize(
    "variant",
    [
        {"RecombineAll": 1, "RecombinationAlgorithm": 3},
        {"RecombineAll": 1, "RecombinationAlgorithm": 3, "order": 2},
        {"order": 2},
        {"groups": ()},
        {"groups": ("solid", "again")},
        {"groups": (), "partitions": 2},
        {"groups": ("solid", "again"), "partitions": 2},
        {"SaveParametric": 1},
    ],
    ids=str,
)
def test_files_of_gmsh_are_read_in_all_variants(tmp_path, version, variant):
    """In several groups or partitions each cell counts once; corners matter, not middles of sides.

    They are the cells of a file without groups, partitions and middles.
    """
    mesh = read(gmsh_file(tmp_path / "disc.msh", MshFileVersion=version, **variant), EDGES)
    recombined = {name: value for name, value in variant.items() if name.startswith("Recomb")}
    plain = read(gmsh_file(tmp_path / "plain.msh", MshFileVersion=2.2, **recombined), EDGES)
    assert len(mesh.t) == (4 if recombined else 3)
    assert truncation(mesh) == 4.0
    assert set(EDGES) <= set(contact_radii(mesh))
    assert all(len(facets) for facets in mesh.boundaries.values())
    np.testing.assert_allclose(
        np.sort(mesh.p, axis=1), np.sort(plain.p, axis=1), rtol=0, atol=1e-14
    )
    assert mesh.t.shape == plain.t.shape


@pytest.mark.gmsh
def test_the_message_says_how_to_export(tmp_path):
    with pytest.raises(MeshError, match="physical group of the surface"):
        read(gmsh_file(tmp_path / "disc.msh", groups=("outline",)), EDGES)


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


def rounded(surface):
    """Round depths at the surface to another value, and radii of the arc."""

    def change(content):
        r, z = content.points.T[:2].copy()
        content.points[:, 1] = np.where(z == 0, surface, z)
        content.points[np.isclose(np.hypot(r, z), 4.0, rtol=1e-9) & (z > 0)] *= 1 + 1e-10

    return change


@pytest.mark.parametrize("ending", [".vtu", ".vtk"])
@pytest.mark.parametrize(
    ("change", "scale"),
    [
        (move(lambda p: p), 1.0),
        (move(lambda p: 0.003 * p), 0.003),
        (move(lambda p: (-p[0], p[1], p[2])), 1.0),
        (move(lambda p: (p[0], -p[1], p[2])), 1.0),
        (move(lambda p: (p[0], 0 * p[1], -p[1])), 1.0),
        (rounded(1e-12), 1.0),
        (rounded(-1e-12), 1.0),
    ],
    ids=["plain", "mm", "axis on the right", "height upwards", "height along z", "above", "below"],
)
def test_a_file_of_meshio_gives_the_same_mesh_back(tmp_path, ours, change, scale, ending):
    """The axis may be on either side, the height upwards, and numbers may be rounded."""
    content, path = as_meshio(ours), tmp_path / f"disc{ending}"
    change(content)
    content.write(path)
    mesh = read(path, EDGES, radius=scale)
    assert areas(mesh).min() > 0
    np.testing.assert_allclose(mesh.p, ours.p, rtol=1e-14, atol=1e-14)
    np.testing.assert_array_equal(np.sort(mesh.t, axis=0), np.sort(ours.t, axis=0))
    np.testing.assert_equal(dict(mesh.boundaries), dict(ours.boundaries))


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


TEXT = b"nothing of the kind\n"


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("absent.msh", None, "no such file"),
        ("text.msh", TEXT, "not a mesh"),
        ("text.xyz", TEXT, "not a mesh"),
        ("", None, "this is a directory"),
        ("free.msh", b"4 2 4\n0 0 1\n", "FreeFEM"),
        ("disc.mphtxt", b"# COMSOL", "a mesh of COMSOL"),
        ("disc.cdb", b"NBLOCK", "an archive of Ansys"),
        ("disc.pvd", b"<VTKFile>", "give one of the .vtu files"),
        pytest.param(
            "cut.msh",
            b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n3 x\n",
            "gmsh cannot read it",
            marks=pytest.mark.gmsh,
        ),
    ],
)
def test_files_that_are_not_meshes_are_refused(tmp_path, capsys, name, content, message):
    if content:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(MeshError, match=message):
        read(tmp_path / name, EDGES)
    assert capsys.readouterr().out == ""
