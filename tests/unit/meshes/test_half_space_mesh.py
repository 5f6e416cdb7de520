"""Every mesher makes the quarter disc that it should, and a broken mesh is refused on arrival."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from skfem import Mesh, MeshQuad, MeshTri

from ringwear.meshes import (
    Array,
    MeshError,
    SizeField,
    alternating_edges,
    areas,
    as_half_space,
    bisection,
    contact_radii,
    quads,
    quality,
    segments,
    triangles,
    truncation,
)
from ringwear.meshes.half_space import LOWER
from ringwear.meshes.sizes import convergence, patch_widths

FIELDS = {
    "flat": SizeField((0.0, 1.0), 1e-6, 1e-2, 0.6, 5.0),
    "rings": SizeField((0.0, 0.2, 0.4, 0.6, 0.8, 1.0), 1e-5, 1e-3, 0.6, 5.0),
    "narrow": SizeField((0.0, 0.31, 0.312, 1.0), 1e-4, 5e-4, 0.5, 8.0),
    "uneven": SizeField((0.0, 1 / 3, 2 / 3, 1.0), 1e-8, (1e-3, 1e-5), 0.6, 50.0),
    "shallow": SizeField((0.0, 0.5, 1.0), 1e-2, 1e-2, 0.3, 2.0),
}


@dataclass(frozen=True, eq=False)
class Layers:
    """Sizes of geometric layers at ring edges and rim, and the factor from layer to layer."""

    ring_edges: Array
    sizes: Array | float
    rim_size: float
    factor: float = 0.25
    truncation: float = 2.5


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


def graded(layers: Layers) -> quads.GradedQuads:
    edges, *sizes = layers.ring_edges, layers.sizes, layers.rim_size, layers.factor
    return quads.graded(edges, *sizes, 0.8, layers.truncation)


MESHERS: dict[str, tuple[dict, Callable]] = {
    "bisection": (FIELDS, bisection.mesh),
    "gmsh": (FIELDS, triangles.mesh),
    "quads": (LAYERS, lambda layers: graded(layers).mesh),
}


@cache
def meshed(mesher: str, name: str) -> Mesh:
    sizes, mesh = MESHERS[mesher]
    return mesh(sizes[name])


def cases(*meshers: str) -> list:
    return [
        pytest.param(mesher, name, marks=() if mesher == "bisection" else pytest.mark.gmsh)
        for mesher in meshers
        for name in MESHERS[mesher][0]
    ]


@pytest.mark.parametrize(("mesher", "name"), cases(*MESHERS))
def test_it_is_the_quarter_disc(mesher: str, name: str) -> None:
    mesh, wanted = meshed(mesher, name), MESHERS[mesher][0][name]
    outer = wanted.truncation
    sides = {side: segments(mesh, facets) for side, facets in mesh.boundaries.items()}
    lengths = {
        side: np.linalg.norm(np.diff(ends, axis=1), axis=2).sum() for side, ends in sides.items()
    }
    assert truncation(mesh) == outer
    assert lengths["contact"] == pytest.approx(1, rel=1e-12)
    assert lengths["free"] == pytest.approx(outer - 1, rel=1e-12)
    assert lengths["axis"] == pytest.approx(outer, rel=1e-12)
    # chords of the arc
    assert 0.9 * np.pi / 2 * outer < lengths["far"] < np.pi / 2 * outer
    assert np.abs(sides["contact"][..., 1]).max() == np.abs(sides["axis"][..., 0]).max() == 0
    np.testing.assert_allclose(np.hypot(*sides["far"].reshape(-1, 2).T), outer, rtol=1e-12)
    # its elements fill the polygon once; Euler: no holes, nor points that belong to nothing
    assert areas(mesh).min() > 0
    fan = np.abs(np.linalg.det(sides["far"])).sum() / 2
    assert areas(mesh).sum() == pytest.approx(fan, rel=1e-12)
    assert mesh.nvertices - mesh.nfacets + mesh.nelements == 1
    named = np.sort(np.concatenate(list(mesh.boundaries.values())))
    np.testing.assert_array_equal(named, np.sort(mesh.boundary_facets()))
    # ring edges are vertices
    radii = contact_radii(mesh)
    assert np.abs(radii[:, None] - wanted.ring_edges).min(axis=0).max() <= 1e-15
    assert (np.diff(radii) > 0).all()


@pytest.mark.parametrize(("mesher", "name"), cases("bisection", "gmsh"))
def test_triangles_follow_the_size_field(mesher: str, name: str) -> None:
    mesh, field = meshed(mesher, name), FIELDS[name]
    corners = mesh.p[:, mesh.t]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=0).max(axis=0)
    assert (longest / field(corners.mean(axis=1).T)).max() <= 3
    assert np.median(quality(mesh)) >= 0.55
    assert quality(mesh).min() >= 0.05
    radii = contact_radii(mesh)
    widths = np.diff(radii)
    # a mesher's size is that of a triangle, which the field lets grow with its distance
    assert widths[-1] <= 4 * field.rim_size
    at = np.searchsorted(radii, np.array(field.ring_edges[1:-1]) - 1e-12)
    assert (np.maximum(widths[at - 1], widths[at]) <= 4 * np.array(field.ring_sizes)).all()
    np.testing.assert_allclose(
        field(np.stack([field.ring_edges[1:-1], 0 * at], 1)), field.ring_sizes
    )


@pytest.mark.gmsh
@pytest.mark.parametrize("name", LAYERS)
def test_layers_shrink_to_the_wanted_size(name: str) -> None:
    wanted, mesh = LAYERS[name], meshed("quads", name)
    edges, radii = wanted.ring_edges[1:], contact_radii(mesh)
    assert isinstance(mesh, MeshQuad)
    assert quality(mesh).min() >= 0.025
    sizes = np.append(np.broadcast_to(wanted.sizes, len(edges) - 1), wanted.rim_size)
    inside = edges - radii[np.searchsorted(radii, edges) - 1]
    assert (inside <= sizes * (1 + 1e-6) + 1e-15).all()
    # smaller by the last factor only, and at least one layer
    widths = patch_widths(wanted.ring_edges).min(axis=1)
    assert (inside >= 0.6 * wanted.factor * np.minimum(sizes, widths)).all()


@pytest.mark.gmsh
def test_layers() -> None:
    """One less is coarser, each decimal place costs its own only, and degrees fall inwards."""
    whole = graded(LAYERS["five rings"])
    mesh, coarser = whole.mesh, whole.coarser().mesh
    assert mesh.nelements - coarser.nelements == 4 * 5
    radii, fewer = contact_radii(mesh), contact_radii(coarser)
    assert len(radii) - len(fewer) == 9
    assert np.diff(fewer).min() > np.diff(radii).min()
    coarsest = graded(LAYERS["coarse"])
    assert coarsest.coarser().mesh.nelements == coarsest.mesh.nelements
    flat = (graded(Layers(np.array([0.0, 1.0]), 1.0, size)).mesh.nelements for size in (1e-9, 1e-3))
    assert next(flat) - next(flat) == 4 * 10
    # as if nothing had been blunted: by the root of the distance at ring edges
    parts = {int(name.removeprefix(LOWER)): elements for name, elements in mesh.subdomains.items()}
    layers = np.arange(whole.layers[0] + 1)
    spared = np.log(whole.factor**-0.5) / convergence(whole.factor) * layers
    assert set(parts) == set(spared.astype(int)) - {0}
    r, z = mesh.p[:, mesh.t].mean(axis=1)
    distance = np.hypot(r[:, None] - whole.ring_edges[1:], z[:, None]).min(axis=1)
    furthest = [distance[parts[k]].max() for k in sorted(parts)]
    assert (np.diff(furthest) < 0).all()


@pytest.mark.parametrize(
    ("mesher", "name"), [case for case in cases(*MESHERS) if "rings" in case.values[1]]
)
def test_same_mesh_every_time(mesher: str, name: str) -> None:
    sizes, mesh = MESHERS[mesher]
    again, first = mesh(sizes[name]), meshed(mesher, name)
    np.testing.assert_array_equal(again.p, first.p)
    np.testing.assert_array_equal(again.t, first.t)


def test_quality() -> None:
    """The least sine of a corner: 1 in squares, negative where an element bends inwards."""
    points = np.array([[0, 0], [1, 0], [0.5, np.sqrt(0.75)], [0, 1]]).T
    mesh = MeshTri(points, np.array([[0, 1, 2], [0, 1, 3]]).T)
    np.testing.assert_allclose(quality(mesh), [np.sqrt(0.75), np.sqrt(0.5)], rtol=1e-14)
    np.testing.assert_allclose(areas(mesh), [np.sqrt(3) / 4, 0.5], rtol=1e-14)
    points = np.array(
        [[0, 0], [1, 0], [1, 1], [0, 1], [1.5, np.sqrt(0.75)], [0.5, np.sqrt(0.75)], [0.8, 0.8]]
    ).T
    mesh = MeshQuad(points, np.array([[0, 1, 2, 3], [0, 1, 4, 5], [0, 3, 2, 1], [1, 2, 3, 6]]).T)
    *convex, bent = quality(mesh)
    np.testing.assert_allclose(convex, [1, np.sqrt(0.75), 1], rtol=1e-14)
    assert bent < 0


EDGES = np.array(FIELDS["rings"].ring_edges)


def changed(change: Callable[[Mesh, Array], object]) -> Mesh:
    """The mesh of rings with its points changed in place, or with the triangles returned."""
    mesh = meshed("bisection", "rings")
    points = mesh.p.copy()
    t = change(mesh, points)
    return MeshTri(points, mesh.t if t is None else t)


def test_orphans_are_dropped() -> None:
    mesh = meshed("bisection", "rings")
    points = np.append(mesh.p, [[0.5], [0.5]], axis=1)
    assert as_half_space(MeshTri(points, mesh.t), EDGES).nvertices == mesh.nvertices


@pytest.mark.parametrize("place", [0, 1, 100, -1, "contact", "free", "axis", "far"])
def test_a_hole_is_refused(place: int | str) -> None:
    mesh = meshed("bisection", "rings")
    lost = [place] if isinstance(place, int) else mesh.f2t[0, mesh.boundaries[place][:3]]
    for number in lost:
        with pytest.raises(MeshError):
            as_half_space(changed(lambda mesh, _: np.delete(mesh.t, number, axis=1)), EDGES)  # noqa: B023


def stretch(_: Mesh, points: Array) -> None:
    points[1] *= 1.001


def scale(_: Mesh, points: Array) -> None:
    points *= 1.001


def pull(_: Mesh, points: Array) -> None:
    points[points == points[0].max()] = 5.001


def double(mesh: Mesh, _: Array) -> Array:
    return np.append(mesh.t, mesh.t[:, :1], axis=1)


def fold(mesh: Mesh, points: Array) -> None:
    points[:, mesh.interior_nodes()[0]] += 0.9


def flatten(mesh: Mesh, points: Array) -> None:
    vertex = mesh.interior_nodes()[0]
    triangle = mesh.t[:, (mesh.t == vertex).any(axis=0)][:, 0]
    points[:, vertex] = points[:, triangle[triangle != vertex]].mean(axis=1) * (1 + 1e-9)


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (stretch, "axis"),
        (scale, "contact|no vertex"),
        (pull, "free|far|hole|gap"),
        (double, "surface|facet|overlap"),
        (fold, "overlap|degenerate"),
        (flatten, "degenerate"),
    ],
)
def test_a_spoilt_mesh_is_refused(spoil: Callable, reason: str) -> None:
    with pytest.raises(MeshError, match=reason):
        as_half_space(changed(spoil), EDGES)


def test_what_cannot_be_meshed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(MeshError, match=r"ring edge at r = 0\.500000001 a.*ring_size"):
        as_half_space(meshed("bisection", "rings"), np.array([0.0, 0.5 + 1e-9, 1.0]))
    with pytest.raises(MeshError, match=r"narrower than 1e-12"):
        bisection.mesh(SizeField((0.0, 0.5, 0.5 + 1e-13, 1.0), 1e-3, 1e-3, 0.6, 5.0))
    with pytest.raises(MeshError, match=r"narrower than 1e-10.*merge"):
        graded(Layers(np.array([0.0, 0.5, 0.5 + 1e-12, 1.0]), 1e-3, 1e-3))
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(MeshError, match=r"apt-get install .*libgomp1"):
        graded(LAYERS["flat"])


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
    told = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert (told.returncode, told.stdout) == (0, "2 15\n")
