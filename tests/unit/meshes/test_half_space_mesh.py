"""Every mesher makes the quarter disc that was asked for, as a scikit-fem mesh.

A broken mesh is refused on arrival.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from skfem import Mesh, MeshQuad, MeshTri

from ringwear.meshes import bisection, gmsh_session, quads, triangles
from ringwear.meshes.errors import MeshError
from ringwear.meshes.half_space import (
    LOWER,
    areas,
    as_half_space,
    contact_radii,
    quality,
    segments,
    truncation,
)
from ringwear.meshes.radial import Array, alternating_edges
from ringwear.meshes.sizes import SizeField, convergence, patch_widths

FIELDS = {
    "flat": SizeField((0.0, 1.0), 1e-6, 1e-2, 0.6, 5.0),
    "rings": SizeField((0.0, 0.2, 0.4, 0.6, 0.8, 1.0), 1e-5, 1e-3, 0.6, 5.0),
    "narrow": SizeField((0.0, 0.31, 0.312, 1.0), 1e-4, 5e-4, 0.5, 8.0),
    "uneven": SizeField((0.0, 1 / 3, 2 / 3, 1.0), 1e-8, (1e-3, 1e-5), 0.6, 50.0),
    "shallow": SizeField((0.0, 0.5, 1.0), 1e-2, 1e-2, 0.3, 2.0),
}


@dataclass(frozen=True, eq=False)
class Layers:
    """Quadrilaterals in geometric layers.

    Sizes at ring edges and rim, and the factor from layer to layer.
    """

    ring_edges: Array
    sizes: Array | float
    rim_size: float
    factor: float = 0.25
    truncation: float = 2.5

    @property
    def graded(self) -> quads.GradedQuads:
        return quads.graded(
            self.ring_edges, self.sizes, self.rim_size, self.factor, 0.8, self.truncation
        )


LAYERS = {
    "flat": Layers(np.array([0.0, 1.0]), 1e-3, 1e-9),
    "five rings": Layers(alternating_edges(5), 1e-4, 1e-8),
    "coarse": Layers(alternating_edges(3), 1.0, 1.0),
    "narrow": Layers(np.array([0.0, 0.5, 0.501, 1.0]), np.array([1e-4, 1e-5]), 1e-7),
    "narrower": Layers(np.array([0.0, 0.3, 0.5, 0.5001, 1.0]), 1e-5, 1e-7, 0.15),
    "narrowest": Layers(np.array([0.0, 0.5, 0.500001, 1.0]), 1e-7, 1e-7),
    "narrow first": Layers(np.array([0.0, 1e-4, 1.0]), 1e-5, 1e-4),
    "narrow last": Layers(np.array([0.0, 0.4, 1 - 1e-4, 1.0]), 1e-5, 1e-9),
    "many rings": Layers(alternating_edges(256), 1e-4, 1e-7),
    "many unlike rings": Layers(alternating_edges(64, 0.05), 1e-4, 1e-7),
    "far": Layers(alternating_edges(3), 1e-3, 1e-5, truncation=1e4),
}
Made = tuple[Mesh, Array, float]


@pytest.fixture(
    scope="module",
    params=[
        *(("bisection", name) for name in FIELDS),
        *(pytest.param(("gmsh", name), marks=pytest.mark.gmsh) for name in FIELDS),
        *(pytest.param(("quads", name), marks=pytest.mark.gmsh) for name in LAYERS),
    ],
    ids="-".join,
)
def made(request: pytest.FixtureRequest) -> Made:
    """A mesh, its ring edges and the truncation radius asked for."""
    mesher, name = request.param
    if mesher == "quads":
        return LAYERS[name].graded.mesh, LAYERS[name].ring_edges, LAYERS[name].truncation
    mesh = {"gmsh": triangles.mesh, "bisection": bisection.mesh}[mesher]
    return mesh(FIELDS[name]), np.array(FIELDS[name].ring_edges), FIELDS[name].truncation


def test_boundaries(made: Made) -> None:
    mesh, _, outer = made
    sides = {name: segments(mesh, facets) for name, facets in mesh.boundaries.items()}
    lengths = {
        name: np.linalg.norm(np.diff(side, axis=1), axis=2).sum() for name, side in sides.items()
    }
    assert truncation(mesh) == outer
    assert lengths["contact"] == pytest.approx(1, rel=1e-12)
    assert lengths["free"] == pytest.approx(outer - 1, rel=1e-12)
    assert lengths["axis"] == pytest.approx(outer, rel=1e-12)
    # chords of the arc
    assert 0.9 * np.pi / 2 * outer < lengths["far"] < np.pi / 2 * outer
    assert np.abs(sides["contact"][..., 1]).max() == np.abs(sides["axis"][..., 0]).max() == 0
    np.testing.assert_allclose(np.hypot(*sides["far"].reshape(-1, 2).T), outer, rtol=1e-12)


def test_elements_fill_the_polygon_once(made: Made) -> None:
    mesh, _, _ = made
    far = segments(mesh, mesh.boundaries["far"])
    fan = np.abs(far[:, 0, 0] * far[:, 1, 1] - far[:, 0, 1] * far[:, 1, 0]).sum() / 2
    assert areas(mesh).min() > 0
    assert areas(mesh).sum() == pytest.approx(fan, rel=1e-12)
    # Euler: a disc without holes, nor points that belong to nothing
    assert mesh.nvertices - mesh.nfacets + mesh.nelements == 1
    named = np.sort(np.concatenate(list(mesh.boundaries.values())))
    np.testing.assert_array_equal(named, np.sort(mesh.boundary_facets()))


def test_ring_edges_are_vertices(made: Made) -> None:
    mesh, edges, _ = made
    assert np.abs(contact_radii(mesh)[:, None] - edges).min(axis=0).max() <= 1e-15
    assert (np.diff(contact_radii(mesh)) > 0).all()


@pytest.mark.parametrize("name", FIELDS)
@pytest.mark.parametrize(
    "mesher", [pytest.param(triangles.mesh, marks=pytest.mark.gmsh), bisection.mesh]
)
def test_triangles_follow_the_size_field(mesher: Callable[[SizeField], MeshTri], name: str) -> None:
    field = FIELDS[name]
    mesh = mesher(field)
    corners = mesh.p[:, mesh.t]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=0).max(axis=0)
    assert (longest / field(corners.mean(axis=1).T)).max() <= 3
    assert np.median(quality(mesh)) >= 0.55
    assert quality(mesh).min() >= 0.05
    widths = np.diff(contact_radii(mesh))
    # a mesher's size is that of a triangle, which the field lets grow with its distance
    assert widths[-1] <= 4 * field.rim_size
    for edge, size in zip(field.ring_edges[1:-1], field.ring_sizes, strict=True):
        at = np.searchsorted(contact_radii(mesh), edge - 1e-12)
        assert max(widths[at - 1], widths[at]) <= 4 * size


@pytest.mark.gmsh
@pytest.mark.parametrize("name", LAYERS)
def test_layers_shrink_to_the_wanted_size(name: str) -> None:
    asked = LAYERS[name]
    mesh, radii = asked.graded.mesh, contact_radii(asked.graded.mesh)
    assert isinstance(mesh, MeshQuad)
    assert quality(mesh).min() >= 0.025
    wanted = np.append(np.broadcast_to(asked.sizes, len(asked.ring_edges) - 2), asked.rim_size)
    inside = asked.ring_edges[1:] - radii[np.searchsorted(radii, asked.ring_edges[1:]) - 1]
    assert (inside <= wanted * (1 + 1e-6) + 1e-15).all()
    # smaller by the last factor only, and at least one layer
    assert (
        inside
        >= 0.6 * asked.factor * np.minimum(wanted, patch_widths(asked.ring_edges).min(axis=1))
    ).all()


@pytest.mark.gmsh
def test_degrees_fall_towards_the_singular_points() -> None:
    graded = LAYERS["five rings"].graded
    mesh = graded.mesh
    parts = {int(name.removeprefix(LOWER)): elements for name, elements in mesh.subdomains.items()}
    # as if nothing had been blunted: by the root of the distance at ring edges, not at all at the
    # rim
    spared = (
        np.log(graded.factor**-0.5) / convergence(graded.factor) * np.arange(graded.layers[0] + 1)
    )
    assert set(parts) == set(spared.astype(int)) - {0}
    r, z = mesh.p[:, mesh.t].mean(axis=1)
    distance = np.hypot(r[:, None] - graded.ring_edges[1:], z[:, None]).min(axis=1)
    means = [distance[parts[k]].max() for k in sorted(parts)]
    assert (np.diff(means) < 0).all()


@pytest.mark.gmsh
def test_a_layer_less() -> None:
    graded = LAYERS["five rings"].graded
    mesh, coarser = graded.mesh, graded.coarser().mesh
    assert mesh.nelements - coarser.nelements == 4 * 5
    assert len(contact_radii(mesh)) - len(contact_radii(coarser)) == 9
    assert np.diff(contact_radii(coarser)).min() > np.diff(contact_radii(mesh)).min()
    flat = LAYERS["coarse"].graded
    assert flat.coarser().mesh.nelements == flat.mesh.nelements


@pytest.mark.gmsh
def test_few_elements_for_many_layers() -> None:
    """Each further decimal place costs the elements of its layers only."""
    coarse, fine = (Layers(np.array([0.0, 1.0]), 1.0, size).graded.mesh for size in (1e-3, 1e-9))
    assert fine.nelements - coarse.nelements == 4 * 10


@pytest.mark.parametrize(
    "mesher",
    [
        pytest.param(lambda: triangles.mesh(FIELDS["rings"]), marks=pytest.mark.gmsh),
        lambda: bisection.mesh(FIELDS["rings"]),
        pytest.param(lambda: LAYERS["five rings"].graded.mesh, marks=pytest.mark.gmsh),
    ],
    ids=["gmsh", "bisection", "quads"],
)
def test_same_mesh_every_time(mesher: Callable[[], Mesh]) -> None:
    one, other = mesher(), mesher()
    np.testing.assert_array_equal(one.p, other.p)
    np.testing.assert_array_equal(one.t, other.t)


def test_quality() -> None:
    """The sine of 60 and of 45 degrees in triangles.

    One in squares, less in rhombi, negative in what bends inwards.
    """
    points = np.array([[0, 0], [1, 0], [0.5, np.sqrt(0.75)], [0, 1]]).T
    mesh = MeshTri(points, np.array([[0, 1, 2], [0, 1, 3]]).T)
    np.testing.assert_allclose(quality(mesh), [np.sqrt(0.75), np.sqrt(0.5)], rtol=1e-14)
    np.testing.assert_allclose(areas(mesh), [np.sqrt(3) / 4, 0.5], rtol=1e-14)
    points = np.array(
        [[0, 0], [1, 0], [1, 1], [0, 1], [1.5, np.sqrt(0.75)], [0.5, np.sqrt(0.75)], [0.8, 0.8]]
    ).T
    mesh = MeshQuad(points, np.array([[0, 1, 2, 3], [0, 1, 4, 5], [0, 3, 2, 1], [1, 2, 3, 6]]).T)
    shape = quality(mesh)
    np.testing.assert_allclose(shape[:3], [1, np.sqrt(0.75), 1], rtol=1e-14)
    assert shape[3] < 0


@pytest.fixture(scope="module")
def good() -> MeshTri:
    return bisection.mesh(FIELDS["rings"])


EDGES = np.array(FIELDS["rings"].ring_edges)


def test_orphans_are_dropped(good: MeshTri) -> None:
    points = np.append(good.p, [[0.5], [0.5]], axis=1)
    assert as_half_space(MeshTri(points, good.t), EDGES).nvertices == good.nvertices


@pytest.mark.parametrize("number", [0, 1, 100, -1])
def test_a_hole_is_refused(good: MeshTri, number: int) -> None:
    """Wherever it is: inside, on the contact, on the axis, or on the arc."""
    with pytest.raises(MeshError):
        as_half_space(MeshTri(good.p, np.delete(good.t, number, axis=1)), EDGES)


@pytest.mark.parametrize("name", ["contact", "free", "axis", "far"])
def test_a_bite_out_of_each_boundary_is_refused(good: MeshTri, name: str) -> None:
    for number in good.f2t[0, good.boundaries[name][:3]]:
        with pytest.raises(MeshError):
            as_half_space(MeshTri(good.p, np.delete(good.t, number, axis=1)), EDGES)


@pytest.mark.parametrize(
    ("spoil", "named"),
    [
        (lambda points: points * [[1], [1.001]], "axis"),
        (lambda points: points * 1.001, "contact|no vertex"),
        (lambda points: np.where(points == points[0].max(), 5.001, points), "free|far|hole|gap"),
    ],
    ids=["stretched", "scaled", "pulled"],
)
def test_a_spoilt_mesh_is_refused(good: MeshTri, spoil: Callable, named: str) -> None:
    with pytest.raises(MeshError, match=named):
        as_half_space(MeshTri(spoil(good.p), good.t), EDGES)


def test_a_missing_ring_edge_is_refused(good: MeshTri) -> None:
    with pytest.raises(MeshError, match=r"ring edge at r = 0\.500000001 a.*ring_size"):
        as_half_space(good, np.array([0.0, 0.5 + 1e-9, 1.0]))


def test_a_doubled_element_is_refused(good: MeshTri) -> None:
    with pytest.raises(MeshError):
        as_half_space(MeshTri(good.p, np.append(good.t, good.t[:, :1], axis=1)), EDGES)


def inside(mesh: Mesh) -> int:
    return int(np.setdiff1d(np.arange(mesh.nvertices), mesh.boundary_nodes())[0])


def test_a_folded_mesh_is_refused(good: MeshTri) -> None:
    points = good.p.copy()
    points[:, inside(good)] += 0.9
    with pytest.raises(MeshError, match=r"overlap|degenerate"):
        as_half_space(replace(good, doflocs=points), EDGES)


def test_a_degenerate_element_is_refused(good: MeshTri) -> None:
    points, vertex = good.p.copy(), inside(good)
    triangle = good.t[:, (good.t == vertex).any(axis=0)][:, 0]
    points[:, vertex] = points[:, triangle[triangle != vertex]].mean(axis=1) * (1 + 1e-9)
    with pytest.raises(MeshError, match="degenerate"):
        as_half_space(replace(good, doflocs=points), EDGES)


def test_what_is_too_narrow_is_refused() -> None:
    with pytest.raises(MeshError, match=r"narrower than 1e-12"):
        bisection.mesh(SizeField((0.0, 0.5, 0.5 + 1e-13, 1.0), 1e-3, 1e-3, 0.6, 5.0))
    with pytest.raises(MeshError, match=r"narrower than 1e-10.*merge"):
        _ = Layers(np.array([0.0, 0.5, 0.5 + 1e-12, 1.0]), 1e-3, 1e-3).graded


def test_without_gmsh_the_remedy_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        gmsh_session,
        "unavailable",
        lambda: f"gmsh cannot be loaded: {gmsh_session.SYSTEM_PACKAGES}",
    )
    with pytest.raises(MeshError, match="libgomp1"):
        _ = LAYERS["flat"].graded


@pytest.mark.gmsh
def test_gmsh_leaves_signals_to_python() -> None:
    """Its start takes SIGTERM and SIGPIPE away, and a study that was ended lost its rows."""
    code = """
import signal
from ringwear.meshes.gmsh_session import session

heard = []
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda late, _: heard.append(late))
with session():
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGPIPE):
        signal.raise_signal(number)
print(*heard)
"""
    told = subprocess.run(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, check=False
    )
    assert (told.returncode, told.stdout) == (0, "2 15\n")


def test_size_field() -> None:
    field = FIELDS["uneven"]
    points = np.array([[1.0, 0.0], [1 / 3, 0.0], [2 / 3, 0.0], [1.0, 2.0]])
    np.testing.assert_allclose(field(points)[:3], [1e-8, 1e-3, 1e-5], rtol=1e-12)
    assert field(points)[3] == pytest.approx(1e-8 + 0.6 * 2)
