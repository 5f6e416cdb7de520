"""Meshes that users bring: good ones by gmsh and by meshio, and every refusal with what and where."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from meshes import bisection
from meshes.errors import MeshError
from meshes.half_space import HalfSpaceMesh, SizeField
from meshes.mesh_file import read

EDGES = np.array([0.0, 0.5, 1.0])
Change = Callable[[meshio.Mesh], None]


@pytest.fixture(scope="module")
def ours() -> HalfSpaceMesh:
    return bisection.mesh(SizeField((0.0, 0.5, 1.0), 0.05, 0.1, 0.6, 4.0))


def as_meshio(mesh: HalfSpaceMesh, scale: float = 1.0) -> meshio.Mesh:
    """The mesh as meshio knows it, boundaries as cell sets."""
    lines = np.concatenate(list(mesh.boundaries.values()))
    ends = np.cumsum([0, *(len(facets) for facets in mesh.boundaries.values())])
    sets = {
        name: [np.arange(low, high), np.empty(0, int)]
        for name, low, high in zip(mesh.boundaries, ends[:-1], ends[1:], strict=True)
    }
    points = np.column_stack([scale * mesh.points, np.zeros(len(mesh.points))])
    return meshio.Mesh(points, [("line", lines), ("triangle", mesh.triangles.copy())], cell_sets=sets)


def gmsh_file(path: Path, *, order: int = 1, surface: bool = True, version: float = 4.1, recombine: bool = False) -> Path:
    """The quarter disc by gmsh itself, with physical groups."""
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.RecombineAll", int(recombine))
        geo = gmsh.model.geo
        sizes = ((0, 0, 0.3), (0.5, 0, 0.1), (1, 0, 0.05), (4, 0, 1), (0, 4, 1))
        p = [geo.addPoint(r, z, 0, h) for r, z, h in sizes]
        lines = [geo.addLine(a, b) for a, b in itertools.pairwise(p[:4])]
        lines += [geo.addCircleArc(p[3], p[0], p[4]), geo.addLine(p[4], p[0])]
        disc = geo.addPlaneSurface([geo.addCurveLoop(lines)])
        geo.synchronize()
        for name, curves in {"contact": lines[:2], "free": lines[2:3], "far": lines[3:4], "axis": lines[4:]}.items():
            gmsh.model.addPhysicalGroup(1, curves, name=name)
        if surface:
            gmsh.model.addPhysicalGroup(2, [disc], name="solid")
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_a_file_of_gmsh_is_read_with_its_physical_groups(tmp_path: Path, version: float) -> None:
    mesh = read(gmsh_file(tmp_path / "disc.msh", version=version), EDGES)
    assert mesh.truncation == 4.0
    assert {0.0, 0.5, 1.0} <= set(mesh.contact_radii)
    assert {name: len(facets) > 0 for name, facets in mesh.boundaries.items()} == dict.fromkeys(mesh.boundaries, True)


@pytest.mark.parametrize("ending", [".vtu", ".vtk"])
@pytest.mark.parametrize("scale", [1.0, 0.003])
def test_a_file_of_meshio_gives_the_same_mesh_back(tmp_path: Path, ours: HalfSpaceMesh, ending: str, scale: float) -> None:
    path = tmp_path / f"disc{ending}"
    as_meshio(ours, scale).write(path)
    mesh = read(path, EDGES, radius=0.003)
    np.testing.assert_allclose(mesh.points, ours.points, atol=1e-14)
    np.testing.assert_array_equal(mesh.triangles, ours.triangles)
    for name, facets in ours.boundaries.items():
        np.testing.assert_array_equal(mesh.boundaries[name], facets)


def test_marks_on_line_cells_name_the_boundaries_too(tmp_path: Path, ours: HalfSpaceMesh) -> None:
    content = as_meshio(ours)
    marks = {}
    for name, (lines, _) in content.cell_sets.items():
        marks[name] = [np.zeros(len(content.cells[0].data), int), np.zeros(len(ours.triangles), int)]
        marks[name][0][lines] = 1
    meshio.Mesh(content.points, content.cells, cell_data=marks).write(tmp_path / "marked.vtu")
    assert len(read(tmp_path / "marked.vtu", EDGES).triangles) == len(ours.triangles)


def test_a_half_space_drawn_below_its_surface_is_turned_over_and_says_so(tmp_path: Path, ours: HalfSpaceMesh) -> None:
    """As in the files that ringwear itself writes."""
    content = as_meshio(ours)
    content.write(tmp_path / "downwards.vtu")
    assert read(tmp_path / "downwards.vtu", EDGES).mesher == "file downwards.vtu"
    content.points[:, 1] *= -1
    content.write(tmp_path / "upwards.vtu")
    mesh = read(tmp_path / "upwards.vtu", EDGES)
    assert mesh.areas.min() > 0
    assert "turned over" in mesh.mesher
    np.testing.assert_allclose(mesh.points, ours.points, atol=1e-14)


@pytest.mark.parametrize("noise", [1e-12, -1e-12])
def test_rounding_at_the_surface_turns_nothing_over(tmp_path: Path, ours: HalfSpaceMesh, noise: float) -> None:
    content = as_meshio(ours)
    content.points[content.points[:, 1] == 0, 1] = noise
    content.write(tmp_path / "rounded.vtu")
    mesh = read(tmp_path / "rounded.vtu", EDGES)
    assert "turned over" not in mesh.mesher
    np.testing.assert_allclose(mesh.points, ours.points, atol=1e-14)


def test_a_file_of_meshio_with_physical_groups(tmp_path: Path, ours: HalfSpaceMesh) -> None:
    content = as_meshio(ours)
    numbers = {name: number for number, name in enumerate(content.cell_sets, start=1)}
    physical = [np.zeros(len(content.cells[0].data), int), np.full(len(ours.triangles), 9)]
    for name, (lines, _) in content.cell_sets.items():
        physical[0][lines] = numbers[name]
    groups = {name: np.array([number, 1]) for name, number in numbers.items()} | {"solid": np.array([9, 2])}
    data = {"gmsh:physical": physical, "gmsh:geometrical": physical}
    path = tmp_path / "disc.msh"
    meshio.Mesh(content.points, content.cells, cell_data=data, field_data=groups).write(path, file_format="gmsh22")
    np.testing.assert_array_equal(read(path, EDGES).triangles, ours.triangles)


def inverted(content: meshio.Mesh) -> None:
    content.cells[1].data[7] = content.cells[1].data[7][::-1]


def unnamed(content: meshio.Mesh) -> None:
    del content.cell_sets["axis"]


def gapped(content: meshio.Mesh) -> None:
    lines, rest = content.cell_sets["contact"]
    r = content.points[content.cells[0].data[lines], 0].max(axis=1)
    content.cell_sets["contact"] = [lines[np.argsort(r)[[0, 1, *range(3, len(r))]]], rest]


def torn(content: meshio.Mesh) -> None:
    r, z, _ = content.points.T
    vertex = int(np.argmin(np.hypot(r - 0.5, z)))
    beyond = content.points[content.cells[1].data, 0].mean(axis=1) > 0.5
    content.points = np.concatenate([content.points, content.points[vertex : vertex + 1]])
    data = content.cells[1].data
    data[(data == vertex) & beyond[:, None]] = len(content.points) - 1


def holed(content: meshio.Mesh) -> None:
    inside = np.argmin(np.hypot(*(content.points[content.cells[1].data].mean(axis=1)[:, :2] - [1.5, 1.5]).T))
    content.cells[1].data = np.delete(content.cells[1].data, inside, axis=0)
    content.cell_sets = {name: [parts[0], np.empty(0, int)] for name, parts in content.cell_sets.items()}


def too_wide(content: meshio.Mesh) -> None:
    content.points *= 1.5


def no_ring_edge(content: meshio.Mesh) -> None:
    near = np.abs(content.points[:, 0] - 0.5) + np.abs(content.points[:, 1]) < 1e-9
    content.points[near, 0] += 0.01


def misnamed(content: meshio.Mesh) -> None:
    lines, rest = content.cell_sets["far"]
    content.cell_sets["far"] = [lines[1:], rest]


def out_of_plane(content: meshio.Mesh) -> None:
    content.points[:, 2] = content.points[:, 0]


def behind_the_axis(content: meshio.Mesh) -> None:
    content.points[:, 0] -= 0.5


def mirrored_at_the_axis(content: meshio.Mesh) -> None:
    content.points[:, 0] *= -1


def exchanged(content: meshio.Mesh) -> None:
    content.points[:, [0, 1]] = content.points[:, [1, 0]]


def from_the_bottom(content: meshio.Mesh) -> None:
    content.points[:, 1] = 4 - content.points[:, 1]


def beyond_the_surface(content: meshio.Mesh) -> None:
    r, z, _ = content.points.T
    content.points[int(np.argmin(np.hypot(r - 2, z - 0.3))), 1] = -0.25


def beyond_the_surface_upwards(content: meshio.Mesh) -> None:
    beyond_the_surface(content)
    content.points[:, 1] *= -1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (unnamed, r"no line cells are named axis \(names in the file: contact, far, free\)"),
        (inverted, r"1 of \d+ triangles are inverted, the first of them triangle 7 at radius"),
        (gapped, "contact has a gap from radius"),
        (torn, r"1 vertices are there twice, the first at radius 0.5, depth 0"),
        (holed, "hole or a gap"),
        (too_wide, r"contact ends at radius 1.5 and should end at 1"),
        (no_ring_edge, "no vertex of the mesh lies on the ring edge at r = 0.5 a"),
        (misnamed, "1 sides of the far boundary do not carry its name"),
        (out_of_plane, "third coordinate varies"),
        (behind_the_axis, r"vertex at \(-0.5, 0\) has a negative radius; mesh one side of the axis only"),
        (mirrored_at_the_axis, "negative radius; multiply the first coordinate by -1"),
        (exchanged, "contact lies on the axis: .* exchange them"),
        (from_the_bottom, "contact lies at depth 4 and should lie at 0: shift the mesh"),
        (beyond_the_surface, r"and 1 a negative one, among the fewer \(\d.*, -0.25\)"),
        (beyond_the_surface_upwards, r"1 vertices have a positive depth and \d+ a negative one, .*, 0.25\)"),
    ],
)
def test_a_broken_mesh_is_refused_with_what_and_where(
    tmp_path: Path, ours: HalfSpaceMesh, change: Change, message: str
) -> None:
    content = as_meshio(ours)
    change(content)
    content.write(tmp_path / "bad.vtu")
    with pytest.raises(MeshError, match=message):
        read(tmp_path / "bad.vtu", EDGES)


def test_second_order_quads_and_a_lost_surface_say_how_to_export(tmp_path: Path) -> None:
    for settings, message in (
        ({"order": 2}, "ElementOrder = 1"),
        ({"recombine": True}, "cells of kind quad"),
        ({"surface": False}, "physical group of the surface"),
    ):
        with pytest.raises(MeshError, match=message):
            read(gmsh_file(tmp_path / "disc.msh", **settings), EDGES)


def test_what_is_not_a_mesh_is_refused(tmp_path: Path, capsys: Any) -> None:
    for name, message in (("absent.msh", "no such file"), ("text.msh", "not a mesh"), ("text.xyz", "not a mesh")):
        if name.startswith("text"):
            (tmp_path / name).write_text("nothing of the kind\n")
        with pytest.raises(MeshError, match=message):
            read(tmp_path / name, EDGES)
    with pytest.raises(MeshError, match="directory"):
        read(tmp_path, EDGES)
    assert capsys.readouterr().out == ""
