"""Both meshers make the quarter disc that was asked for; a broken mesh is refused on arrival."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from meshes import bisection, gmsh_mesher
from meshes.errors import MeshError
from meshes.half_space import HalfSpaceMesh, SizeField, assemble

MESHERS = {"gmsh": gmsh_mesher.mesh, "bisection": bisection.mesh}
FIELDS = {
    "flat": SizeField((0.0, 1.0), 1e-6, 1e-2, 0.6, 5.0),
    "rings": SizeField((0.0, 0.2, 0.4, 0.6, 0.8, 1.0), 1e-5, 1e-3, 0.6, 5.0),
    "narrow": SizeField((0.0, 0.31, 0.312, 1.0), 1e-4, 5e-4, 0.5, 8.0),
    "uneven": SizeField((0.0, 1 / 3, 2 / 3, 1.0), 1e-8, (1e-3, 1e-5), 0.6, 50.0),
    "shallow": SizeField((0.0, 0.5, 1.0), 1e-2, 1e-2, 0.3, 2.0),
}


@pytest.fixture(scope="module", params=[(mesher, field) for mesher in MESHERS for field in FIELDS], ids="-".join)
def made(request: pytest.FixtureRequest) -> tuple[HalfSpaceMesh, SizeField]:
    mesher, field = request.param
    return MESHERS[mesher](FIELDS[field]), FIELDS[field]


def test_boundaries(made: tuple[HalfSpaceMesh, SizeField]) -> None:
    mesh, field = made
    sides = {name: mesh.points[facets] for name, facets in mesh.boundaries.items()}
    lengths = {name: np.linalg.norm(np.diff(side, axis=1), axis=2).sum() for name, side in sides.items()}
    outer = field.truncation
    assert lengths["contact"] == pytest.approx(1, rel=1e-12)
    assert lengths["free"] == pytest.approx(outer - 1, rel=1e-12)
    assert lengths["axis"] == pytest.approx(outer, rel=1e-12)
    # chords of the arc
    assert 0.9 * np.pi / 2 * outer < lengths["far"] < np.pi / 2 * outer
    assert np.abs(sides["contact"][..., 1]).max() == np.abs(sides["axis"][..., 0]).max() == 0
    np.testing.assert_allclose(np.hypot(*sides["far"].reshape(-1, 2).T), outer, rtol=1e-12)


def test_area_and_orientation(made: tuple[HalfSpaceMesh, SizeField]) -> None:
    """The triangles fill the polygon of the outer boundary, once."""
    mesh, _ = made
    far = mesh.points[mesh.boundaries["far"]]
    fan = np.abs(far[:, 0, 0] * far[:, 1, 1] - far[:, 0, 1] * far[:, 1, 0]).sum() / 2
    assert mesh.areas.min() > 0
    assert mesh.areas.sum() == pytest.approx(fan, rel=1e-12)
    # Euler: a disc without holes
    edges = np.unique(np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    assert len(mesh.points) - len(edges) + len(mesh.triangles) == 1


def test_ring_edges_are_vertices(made: tuple[HalfSpaceMesh, SizeField]) -> None:
    mesh, field = made
    for edge in field.edges:
        assert np.abs(mesh.contact_radii - edge).min() <= 1e-15
    assert (np.diff(mesh.contact_radii) > 0).all()


def test_sizes_and_shapes(made: tuple[HalfSpaceMesh, SizeField]) -> None:
    mesh, field = made
    corners = mesh.points[mesh.triangles]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    assert (longest / field(corners.mean(axis=1))).max() <= 3
    assert np.median(mesh.quality) >= 0.6
    assert mesh.quality.min() >= 0.05
    widths = np.diff(mesh.contact_radii)
    # a mesher's size is that of a triangle, which the field lets grow with its distance
    assert widths[-1] <= 4 * field.rim_size
    for edge, size in zip(field.edges[1:-1], field.ring_sizes, strict=True):
        at = np.searchsorted(mesh.contact_radii, edge - 1e-12)
        assert max(widths[at - 1], widths[at]) <= 4 * size


@pytest.mark.parametrize("mesher", MESHERS.values(), ids=MESHERS.keys())
def test_same_mesh_every_time(mesher: Callable[[SizeField], HalfSpaceMesh]) -> None:
    one, other = mesher(FIELDS["rings"]), mesher(FIELDS["rings"])
    np.testing.assert_array_equal(one.points, other.points)
    np.testing.assert_array_equal(one.triangles, other.triangles)


def test_quality() -> None:
    """One for an equilateral triangle, ``2 (sqrt 2 - 1)`` for half a square."""
    points = np.array([[0, 0], [1, 0], [0.5, np.sqrt(0.75)], [0, 1]], dtype=float)
    mesh = HalfSpaceMesh(points, np.array([[0, 1, 2], [0, 1, 3]]), {}, "test")
    np.testing.assert_allclose(mesh.quality, [1, 2 * (np.sqrt(2) - 1)], rtol=1e-14)
    np.testing.assert_allclose(mesh.areas, [np.sqrt(3) / 4, 0.5], rtol=1e-14)


@pytest.fixture(scope="module")
def good() -> HalfSpaceMesh:
    return bisection.mesh(FIELDS["rings"])


EDGES = np.array(FIELDS["rings"].edges)


def test_orphans_are_dropped_and_triangles_turned(good: HalfSpaceMesh) -> None:
    points = np.concatenate([good.points, [[0.5, 0.5]]])
    mesh = assemble(points, good.triangles[:, ::-1], EDGES, "test")
    assert len(mesh.points) == len(good.points)
    assert mesh.areas.min() > 0


@pytest.mark.parametrize("number", [0, 1, 100, -1])
def test_a_hole_is_refused(good: HalfSpaceMesh, number: int) -> None:
    """Wherever it is: inside, on the contact, on the axis, or on the arc."""
    with pytest.raises(MeshError):
        assemble(good.points, np.delete(good.triangles, number, axis=0), EDGES, "test")


@pytest.mark.parametrize("name", ["contact", "free", "axis", "far"])
def test_a_bite_out_of_each_boundary_is_refused(good: HalfSpaceMesh, name: str) -> None:
    for facet in good.boundaries[name][:3]:
        (number,) = np.flatnonzero(np.isin(good.triangles, facet).sum(axis=1) == 2)
        with pytest.raises(MeshError):
            assemble(good.points, np.delete(good.triangles, number, axis=0), EDGES, "test")


@pytest.mark.parametrize(
    ("spoil", "named"),
    [
        (lambda points: points * [1, 1.001], "axis"),
        (lambda points: points * 1.001, "contact|no vertex"),
        (lambda points: np.where(points == points[:, :1].max(), 5.001, points), "free|far|hole|gap"),
    ],
    ids=["stretched", "scaled", "pulled"],
)
def test_a_spoilt_mesh_is_refused(good: HalfSpaceMesh, spoil: Callable, named: str) -> None:
    with pytest.raises(MeshError, match=named):
        assemble(spoil(good.points), good.triangles, EDGES, "test")


def test_a_missing_ring_edge_is_refused(good: HalfSpaceMesh) -> None:
    with pytest.raises(MeshError, match=r"ring edge at r = 0\.500000001 a.*ring_size"):
        assemble(good.points, good.triangles, np.array([0.0, 0.5 + 1e-9, 1.0]), "test")


def test_a_doubled_triangle_is_refused(good: HalfSpaceMesh) -> None:
    with pytest.raises(MeshError):
        assemble(good.points, np.concatenate([good.triangles, good.triangles[:1]]), EDGES, "test")


def test_a_degenerate_triangle_is_refused(good: HalfSpaceMesh) -> None:
    points = good.points.copy()
    inside = np.setdiff1d(np.arange(len(points)), np.concatenate([f.ravel() for f in good.boundaries.values()]))
    vertex = inside[0]
    triangle = good.triangles[(good.triangles == vertex).any(axis=1)][0]
    points[vertex] = points[triangle[triangle != vertex]].mean(axis=0) * (1 + 1e-9)
    with pytest.raises(MeshError, match="degenerate"):
        assemble(points, good.triangles, EDGES, "test")


def test_rings_too_narrow_for_bisection_are_told() -> None:
    with pytest.raises(MeshError, match="narrower than 1e-12"):
        bisection.mesh(SizeField((0.0, 0.5, 0.5 + 1e-13, 1.0), 1e-3, 1e-3, 0.6, 5.0))


def test_size_field() -> None:
    field = FIELDS["uneven"]
    points = np.array([[1.0, 0.0], [1 / 3, 0.0], [2 / 3, 0.0], [1.0, 2.0]])
    np.testing.assert_allclose(field(points)[:3], [1e-8, 1e-3, 1e-5], rtol=1e-12)
    assert field(points)[3] == pytest.approx(1e-8 + 0.6 * 2)
