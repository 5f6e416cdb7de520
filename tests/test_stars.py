"""The quarter disc with stars is what was asked for, down to the narrowest rings; a broken one is refused."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from meshes import gmsh_mesher, stars
from meshes.errors import MeshError
from meshes.radial import Array, Indices, alternating_edges
from meshes.stars import StarMesh

OUTER = 5.0


@dataclass(frozen=True, eq=False)
class Asked:
    """What is asked of the mesher."""

    edges: Array
    sizes: Array | float
    rim_size: float
    grading: float = 0.25

    def mesh(self) -> StarMesh:
        return stars.mesh(self.edges, self.sizes, self.rim_size, self.grading, 0.8, OUTER)


CASES = {
    "flat": Asked(np.array([0.0, 1.0]), 1e-3, 1e-9),
    "five rings": Asked(alternating_edges(5), 1e-4, 1e-8),
    "coarse": Asked(alternating_edges(3), 1.0, 1.0),
    "narrow": Asked(np.array([0.0, 0.5, 0.501, 1.0]), np.array([1e-4, 1e-5]), 1e-7),
    "narrower": Asked(np.array([0.0, 0.3, 0.5, 0.5001, 1.0]), 1e-5, 1e-7, 0.15),
    "narrowest": Asked(np.array([0.0, 0.5, 0.500001, 1.0]), 1e-7, 1e-7),
    "narrow first": Asked(np.array([0.0, 1e-4, 1.0]), 1e-5, 1e-4),
    "narrow last": Asked(np.array([0.0, 0.4, 1 - 1e-4, 1.0]), 1e-5, 1e-9),
    "many rings": Asked(alternating_edges(256), 1e-4, 1e-7),
    "many unlike rings": Asked(alternating_edges(64, 0.05), 1e-4, 1e-7),
}


@pytest.fixture(scope="module", params=CASES)
def case(request: pytest.FixtureRequest) -> tuple[Asked, StarMesh]:
    asked = CASES[request.param]
    return asked, asked.mesh()


def corners(mesh: StarMesh) -> tuple[Array, Array]:
    return mesh.points[mesh.quadrilaterals], mesh.points[mesh.triangles]


def area(polygons: Array) -> Array:
    """(m,) signed areas of (m, corners, 2) polygons."""
    following = np.roll(polygons, -1, axis=1)
    return (polygons[..., 0] * following[..., 1] - polygons[..., 1] * following[..., 0]).sum(axis=1) / 2


def facets(mesh: StarMesh) -> tuple[Indices, Indices]:
    """The sides of all elements, sorted, each once, and how many elements have it."""
    sides = [np.stack([own, np.roll(own, -1, axis=1)], axis=2) for own in (mesh.quadrilaterals, mesh.triangles)]
    return np.unique(np.sort(np.concatenate([own.reshape(-1, 2) for own in sides])), axis=0, return_counts=True)


def test_boundaries(case: tuple[Asked, StarMesh]) -> None:
    _, mesh = case
    sides = {name: mesh.points[own] for name, own in mesh.boundaries.items()}
    lengths = {name: np.linalg.norm(np.diff(side, axis=1), axis=2).sum() for name, side in sides.items()}
    assert mesh.truncation == OUTER
    assert lengths["contact"] == pytest.approx(1, rel=1e-12)
    assert lengths["free"] == pytest.approx(OUTER - 1, rel=1e-12)
    assert lengths["axis"] == pytest.approx(OUTER, rel=1e-12)
    np.testing.assert_allclose(np.hypot(*sides["far"].reshape(-1, 2).T), OUTER, rtol=1e-12)
    assert np.abs(sides["contact"][..., 1]).max() == np.abs(sides["axis"][..., 0]).max() == 0


def test_every_inner_side_has_two_elements(case: tuple[Asked, StarMesh]) -> None:
    _, mesh = case
    sides, count = facets(mesh)
    outer = np.sort(np.concatenate(list(mesh.boundaries.values())))
    assert count.max() == 2
    np.testing.assert_array_equal(sides[count == 1], np.unique(outer, axis=0))
    # Euler: a disc without holes, nor points that belong to nothing
    assert len(mesh.points) - len(sides) + len(mesh.quadrilaterals) + len(mesh.triangles) == 1


def test_area_and_orientation(case: tuple[Asked, StarMesh]) -> None:
    """The elements fill the polygon of the outer boundary, once."""
    _, mesh = case
    far = mesh.points[mesh.boundaries["far"]]
    fan = np.abs(far[:, 0, 0] * far[:, 1, 1] - far[:, 0, 1] * far[:, 1, 0]).sum() / 2
    areas = [area(own) for own in corners(mesh)]
    assert min(own.min() for own in areas) > 0
    assert sum(own.sum() for own in areas) == pytest.approx(fan, rel=1e-12)
    assert mesh.quality.min() >= 0.1


def test_ring_edges_are_vertices_exactly(case: tuple[Asked, StarMesh]) -> None:
    asked, mesh = case
    assert np.isin(asked.edges, mesh.contact_radii).all()
    assert (np.diff(mesh.contact_radii) > 0).all()


def test_layers_shrink_to_the_wanted_size(case: tuple[Asked, StarMesh]) -> None:
    asked, mesh = case
    wanted = np.append(np.broadcast_to(asked.sizes, len(asked.edges) - 2), asked.rim_size)
    place = np.searchsorted(mesh.contact_radii, asked.edges[1:])
    inside = asked.edges[1:] - mesh.contact_radii[place - 1]
    assert (inside <= wanted * (1 + 1e-6) + 1e-15).all()
    widths = np.diff(asked.edges)
    narrower = np.minimum(widths, np.append(widths[1:], np.inf))
    # smaller by the last factor only, and at least one layer
    assert (inside >= 0.99 * asked.grading * np.minimum(wanted, narrower * stars.HALF_WIDTH)).all()
    quadrilaterals, _ = corners(mesh)
    nearest = np.abs(quadrilaterals[:, :, 0].mean(axis=1)[:, None] - asked.edges[1:]).argmin(axis=1)
    for number in range(len(asked.edges) - 1):
        own = nearest == number
        size, layer = np.ptp(quadrilaterals[own], axis=1).max(axis=1), mesh.layer[own]
        # two squares in the core and four trapezoids of the innermost shell, then four to a layer
        np.testing.assert_array_equal(np.bincount(layer), [6] + [4] * layer.max())
        np.testing.assert_allclose(size[layer > 0] * asked.grading ** layer[layer > 0], size[layer == 0].max(), rtol=1e-3)


def test_same_mesh_every_time() -> None:
    one, other = (CASES["five rings"].mesh() for _ in range(2))
    np.testing.assert_array_equal(one.points, other.points)
    np.testing.assert_array_equal(one.triangles, other.triangles)


def test_few_elements_for_many_layers() -> None:
    """Each further decimal place costs the elements of its layers only."""
    coarse, fine = (Asked(np.array([0.0, 1.0]), 1.0, size).mesh() for size in (1e-3, 1e-9))
    assert len(coarse.triangles) == len(fine.triangles)
    assert len(fine.quadrilaterals) - len(coarse.quadrilaterals) == 4 * 10


def test_quality() -> None:
    """Squares and equilateral triangles have one, half a square ``2 (sqrt 2 - 1)``, a rhombus the sine of its corner."""
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [1.5, np.sqrt(0.75)], [0.5, np.sqrt(0.75)]], dtype=float)
    mesh = StarMesh(
        points, np.array([[0, 1, 2, 3], [0, 1, 4, 5]]), np.array([[0, 1, 5], [0, 1, 2]]), np.zeros(2), {}, "test"
    )
    np.testing.assert_allclose(mesh.quality, [1, np.sqrt(0.75), 1, 2 * (np.sqrt(2) - 1)], rtol=1e-14)


def test_too_narrow_a_ring_is_refused() -> None:
    with pytest.raises(MeshError, match=r"narrower than 1e-10.*merge"):
        Asked(np.array([0.0, 0.5, 0.5 + 1e-12, 1.0]), 1e-3, 1e-3).mesh()


def test_too_steep_a_grading_is_refused() -> None:
    with pytest.raises(MeshError, match="degenerate"):
        Asked(np.array([0.0, 1.0]), 1e-3, 1e-4, 1e-3).mesh()


def test_without_gmsh_the_remedy_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gmsh_mesher, "unavailable", lambda: f"gmsh cannot be loaded: {gmsh_mesher.SYSTEM_PACKAGES}")
    with pytest.raises(MeshError, match="libgl1"):
        CASES["flat"].mesh()
