"""Every mesher covers the quarter disc with the wanted sizes, and broken meshes are refused."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from skfem import MeshQuad, MeshTri

from ringwear import MeshError, SizeField, alternating_edges, bisection
from ringwear.meshes.by_gmsh import quads, triangles
from ringwear.meshes.half_space import (
    LOWERED_DEGREE_PREFIX,
    as_half_space,
    contact_radii,
    quality,
    segments,
    truncation,
)
from ringwear.meshes.radial import Array
from ringwear.meshes.sizes import convergence, patch_widths

RINGS = SizeField((0.0, 0.2, 0.4, 0.6, 0.8, 1.0), 1e-5, 1e-3, 0.6, 5.0)
FIELDS = {
    "flat": SizeField((0.0, 1.0), 1e-6, 1e-2, 0.6, 5.0),
    "rings": RINGS,
    "narrow": SizeField((0.0, 0.31, 0.312, 1.0), 1e-4, 5e-4, 0.5, 8.0),
    "uneven": SizeField((0.0, 1 / 3, 2 / 3, 1.0), 1e-8, (1e-3, 1e-5), 0.6, 50.0),
    "shallow": SizeField((0.0, 0.5, 1.0), 1e-2, 1e-2, 0.3, 2.0),
}


@dataclass(frozen=True, eq=False)
class Layers:
    """Sizes of geometric layers at ring edges and rim, and the factor from layer to layer."""

    ring_edges: Sequence[float]
    sizes: Array | float
    rim_size: float
    factor: float = 0.25
    truncation: float = 2.5


LAYERS = {
    "flat": Layers((0.0, 1.0), 1e-3, 1e-9),
    "five rings": Layers(alternating_edges(5), 1e-4, 1e-8),
    "coarse": Layers(alternating_edges(3), 1.0, 1.0),
    "narrow": Layers((0.0, 0.5, 0.501, 1.0), np.array([1e-4, 1e-5]), 1e-7),
    "narrower": Layers((0.0, 0.3, 0.5, 0.5001, 1.0), 1e-5, 1e-7, 0.15),
    "narrowest": Layers((0.0, 0.5, 0.500001, 1.0), 1e-7, 1e-7),
    "narrow first": Layers((0.0, 1e-4, 1.0), 1e-5, 1e-4),
    "narrow last": Layers((0.0, 0.4, 1 - 1e-4, 1.0), 1e-5, 1e-9),
    "many rings": Layers(alternating_edges(256), 1e-4, 1e-7),
    "many unlike rings": Layers(alternating_edges(64, 0.05), 1e-4, 1e-7),
    "far": Layers(alternating_edges(3), 1e-3, 1e-5, truncation=1e4),
}


def graded(layers):
    edges, *sizes = np.array(layers.ring_edges), layers.sizes, layers.rim_size, layers.factor
    return quads.graded(edges, *sizes, 0.8, layers.truncation)


def mesh_quads(layers):
    return graded(layers).mesh


@cache
def meshed(mesher, wanted):
    return mesher(wanted)


def cases(mesher, sizes, *marks):
    return [
        pytest.param(mesher, wanted, id=f"{mesher.__module__}-{name}", marks=marks)
        for name, wanted in sizes.items()
    ]


TRIANGLES = cases(bisection.mesh, FIELDS) + cases(triangles.mesh, FIELDS, pytest.mark.gmsh)
QUADS = cases(mesh_quads, LAYERS, pytest.mark.gmsh)


@pytest.mark.parametrize(("mesher", "wanted"), TRIANGLES + QUADS)
def test_meshes_cover_the_quarter_disc(mesher, wanted):
    """The mesh has named boundaries, no holes, all ring edges, and is the same each time.

    `as_half_space` checks lengths and areas; the tests of refusals below show this.
    """
    mesh = meshed(mesher, wanted)
    assert truncation(mesh) == wanted.truncation
    # chords of the arc
    far = np.linalg.norm(np.diff(segments(mesh, mesh.boundaries["far"]), axis=1), axis=2).sum()
    assert 0.9 * np.pi / 2 < far / wanted.truncation < np.pi / 2
    # Euler's formula: no holes, and no points without an element
    assert mesh.nvertices - mesh.nfacets + mesh.nelements == 1
    named = np.sort(np.concatenate(list(mesh.boundaries.values())))
    np.testing.assert_array_equal(named, np.sort(mesh.boundary_facets()))
    radii = contact_radii(mesh)
    assert np.abs(radii[:, None] - wanted.ring_edges).min(axis=0).max() <= 1e-15
    assert (np.diff(radii) > 0).all()
    again = mesher(wanted)
    np.testing.assert_array_equal(again.p, mesh.p)
    np.testing.assert_array_equal(again.t, mesh.t)


FIELD_OF_HOLE = {"hollow": SizeField((0.4, 0.7, 1.0), 1e-5, (1e-4, 1e-3), 0.6, 5.0)}
LAYERS_OF_HOLE = {"hollow": Layers((0.4, 0.7, 1.0), np.array([1e-9, 1e-4]), 1e-9)}


@pytest.mark.parametrize(
    ("mesher", "wanted"),
    [
        *cases(bisection.mesh, FIELD_OF_HOLE),
        *cases(triangles.mesh, FIELD_OF_HOLE, pytest.mark.gmsh),
        *cases(mesh_quads, LAYERS_OF_HOLE, pytest.mark.gmsh),
    ],
)
def test_the_surface_in_a_hole_is_free(mesher, wanted):
    """The mesh is that of a full punch with one more ring, which is not in contact."""
    mesh = mesher(wanted)
    full = mesher(replace(wanted, ring_edges=(0.0, *wanted.ring_edges)))
    np.testing.assert_array_equal(mesh.p, full.p)
    radii = contact_radii(full)
    np.testing.assert_array_equal(contact_radii(mesh), radii[radii > 0.4 - 1e-15])
    on_surface = segments(mesh, mesh.boundaries["free"])[..., 0]
    in_hole = on_surface[on_surface.max(axis=1) <= 0.5]
    assert np.ptp(in_hole) == pytest.approx(0.4, rel=1e-15)
    assert np.diff(in_hole, axis=1).sum() == pytest.approx(0.4, rel=1e-12)


@pytest.mark.parametrize(("mesher", "field"), TRIANGLES)
def test_triangles_follow_the_size_field(mesher, field):
    mesh = meshed(mesher, field)
    corners = mesh.p[:, mesh.t]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=0).max(axis=0)
    assert (longest / field(corners.mean(axis=1).T)).max() <= 3
    assert np.median(quality(mesh)) >= 0.55
    assert quality(mesh).min() >= 0.05
    radii = contact_radii(mesh)
    widths = np.diff(radii)
    # the size of a triangle is that of the field at its centre, where the field is larger
    assert widths[-1] <= 4 * field.rim_size
    at = np.searchsorted(radii, np.array(field.ring_edges[1:-1]) - 1e-12)
    assert (np.maximum(widths[at - 1], widths[at]) <= 4 * field.sizes[1:-1]).all()


@pytest.mark.parametrize(("mesher", "wanted"), QUADS)
def test_layers_shrink_to_the_wanted_size(mesher, wanted):
    mesh = meshed(mesher, wanted)
    edges, radii = np.array(wanted.ring_edges[1:]), contact_radii(mesh)
    assert isinstance(mesh, MeshQuad)
    assert quality(mesh).min() >= 0.025
    sizes = np.append(np.broadcast_to(wanted.sizes, len(edges) - 1), wanted.rim_size)
    inside = edges - radii[np.searchsorted(radii, edges) - 1]
    assert (inside <= sizes * (1 + 1e-6) + 1e-15).all()
    # sizes are smaller by at most one factor, and there is at least one layer
    widths = patch_widths(np.array(wanted.ring_edges)).min(axis=1)
    assert (inside >= 0.6 * wanted.factor * np.minimum(sizes, widths)).all()


@pytest.mark.gmsh
def test_coarsening_removes_one_layer_at_each_edge():
    """A decade of the size at the rim costs a fixed number of layers."""
    whole, coarsest = graded(LAYERS["five rings"]), graded(LAYERS["coarse"])
    mesh, coarser = whole.mesh, whole.coarser().mesh
    assert mesh.nelements - coarser.nelements == 4 * 5
    assert np.diff(contact_radii(coarser)).min() > np.diff(contact_radii(mesh)).min()
    assert coarsest.coarser().mesh.nelements == coarsest.mesh.nelements
    fine, rough = (graded(Layers((0.0, 1.0), 1.0, size)).mesh for size in (1e-9, 1e-3))
    assert fine.nelements - rough.nelements == 4 * 10


@pytest.mark.gmsh
def test_degrees_fall_inwards():
    """Degrees fall towards ring edges, for a solution that varies as the root of the distance."""
    whole = graded(LAYERS["five rings"])
    mesh = whole.mesh
    parts = {
        int(name.removeprefix(LOWERED_DEGREE_PREFIX)): elements
        for name, elements in mesh.subdomains.items()
        if name.startswith(LOWERED_DEGREE_PREFIX)
    }
    layers = np.arange(whole.layers[0] + 1)
    lowered_degrees = np.log(whole.factor**-0.5) / convergence(whole.factor) * layers
    assert set(parts) == set(lowered_degrees.astype(int)) - {0}
    r, z = mesh.p[:, mesh.t].mean(axis=1)
    distance = np.hypot(r[:, None] - whole.ring_edges[1:], z[:, None]).min(axis=1)
    furthest = [distance[parts[k]].max() for k in sorted(parts)]
    assert (np.diff(furthest) < 0).all()


@pytest.mark.gmsh
@pytest.mark.parametrize("inner_radius", [0.0, 0.4])
@pytest.mark.parametrize("width", [2.0, 4.0, 8.0])
def test_thin_layers_are_divided_into_upright_columns(inner_radius, width):
    """Limits on sizes under the face hold, and no element is degenerate, on any thin layer."""
    edges = np.array([0.0, 1.0]) if inner_radius == 0 else np.array([0.0, inner_radius, 1.0])
    for thickness in (0.01, 0.0137, 0.02, 0.033, 0.05):
        for below in ((), (2.5 * thickness,)):
            under_face = np.where(edges[:-1] < inner_radius, np.inf, width * thickness)
            mesh = quads.graded(
                edges,
                1e-6,
                rim_size=1e-6,
                factor=0.25,
                growth=0.5,
                outer=2.5,
                interfaces=(thickness, *below),
                rigid=True,
                under_face=under_face,
            ).mesh
            assert quality(mesh).min() >= 0.05
            radii = contact_radii(mesh)
            face = radii >= inner_radius
            assert np.diff(radii[face]).max() <= 1.1 * width * thickness
            # sizes grow by half of the distance from the patches; beyond, sides are upright
            middle, largest = (1 + inner_radius) / 2, width * thickness
            room = (1 - inner_radius) / 2 - largest / 0.5
            if room < largest:
                continue
            sides = mesh.p[:, mesh.facets]
            columns = (sides[1].max(axis=0) <= thickness) & (
                np.abs(sides[0] - middle).max(axis=0) < room
            )
            assert columns.any()
            r, z = np.abs(np.diff(sides[:, :, columns], axis=1))[:, 0]
            assert (np.minimum(r, z) <= 1e-9).all()


def test_quality():
    """Quality is the least sine of a corner: 1 in squares, negative at reentrant corners."""
    height = np.sqrt(0.75)
    corners = [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, height], [1.5, height], [0.8, 0.8]]
    points = np.array(corners).T
    mesh = MeshTri(points, np.array([[0, 1, 4], [0, 1, 3]]).T)
    np.testing.assert_allclose(quality(mesh), [height, np.sqrt(0.5)], rtol=1e-14)
    mesh = MeshQuad(points, np.array([[0, 1, 2, 3], [0, 1, 5, 4], [0, 3, 2, 1], [1, 2, 3, 6]]).T)
    *convex, bent = quality(mesh)
    np.testing.assert_allclose(convex, [1, height, 1], rtol=1e-14)
    assert bent < 0


def test_orphans_are_dropped():
    mesh = meshed(bisection.mesh, RINGS)
    orphaned = MeshTri(np.insert(mesh.p, 0, 0.5, axis=1), mesh.t + 1)
    np.testing.assert_array_equal(as_half_space(orphaned, RINGS.ring_edges).p, mesh.p)


def fold_smallest(mesh):
    """Return the mesh with the inner vertex nearest to the rim moved across an opposite side.

    The triangles there are so small that the sum of all areas hardly changes.
    """
    points, inner = mesh.p.copy(), mesh.interior_nodes()
    vertex = inner[np.linalg.norm(points[:, inner].T - [1, 0], axis=1).argmin()]
    triangle = mesh.t[:, (mesh.t == vertex).any(axis=0)][:, 0]
    middle = points[:, triangle[triangle != vertex]].mean(axis=1)
    points[:, vertex] = middle + 0.5 * (middle - points[:, vertex])
    return MeshTri(points, mesh.t)


def flatten(mesh):
    points, vertex = mesh.p.copy(), mesh.interior_nodes()[0]
    triangle = mesh.t[:, (mesh.t == vertex).any(axis=0)][:, 0]
    points[:, vertex] = points[:, triangle[triangle != vertex]].mean(axis=1) * (1 + 1e-9)
    return MeshTri(points, mesh.t)


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda mesh: mesh.scaled((1, 1.001)), "boundary point"),
        (lambda mesh: mesh.scaled(1.001), "no vertex"),
        (lambda mesh: MeshTri(mesh.p, mesh.t[:, [0, *range(mesh.nelements)]]), "facet|overlap"),
        (fold_smallest, "overlap"),
        (flatten, "degenerate"),
    ],
)
def test_a_spoilt_mesh_is_refused(spoil, reason):
    spoilt = spoil(meshed(bisection.mesh, RINGS))
    with pytest.raises(MeshError, match=reason):
        as_half_space(spoilt, RINGS.ring_edges)


@pytest.mark.parametrize("boundary", [None, "contact", "free", "axis", "far"])
def test_a_hole_is_refused(boundary):
    mesh = meshed(bisection.mesh, RINGS)
    lost = mesh.f2t[0, mesh.boundaries[boundary][:3]] if boundary else [0, 1, 100]
    for number in lost:
        with pytest.raises(MeshError):
            as_half_space(mesh.remove_elements(np.array([number])), RINGS.ring_edges)


def test_ring_edges_that_cannot_be_meshed_are_refused():
    with pytest.raises(MeshError, match=r"r = 0\.500000001 a.*ring_size"):
        as_half_space(meshed(bisection.mesh, RINGS), np.array([0.0, 0.5 + 1e-9, 1.0]))
    with pytest.raises(MeshError, match=r"narrower than 1e-10.*merge"):
        graded(Layers((0.0, 0.5, 0.5 + 1e-12, 1.0), 1e-3, 1e-3))


@pytest.mark.gmsh
def test_gmsh_leaves_signals_to_python(script):
    """gmsh replaces handlers of SIGTERM and SIGPIPE; once, a study that was ended lost its rows."""
    code = """
import signal
from ringwear.meshes.by_gmsh.session import session

for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda late, _: print(late))
with session():
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGPIPE):
        signal.raise_signal(number)
"""
    assert script(code).stdout.split() == ["2", "15"]


@pytest.mark.gmsh
def test_a_signal_while_gmsh_starts_waits_for_the_handler_of_python(script):
    code = """
import os, signal
os.environ["OPENBLAS_NUM_THREADS"] = "1"
import gmsh
from ringwear.meshes.by_gmsh.session import session

signal.signal(signal.SIGTERM, lambda number, _: print(number))
initialize = gmsh.initialize
def interrupted(**options):
    initialize(**options)
    os.kill(os.getpid(), signal.SIGTERM)
gmsh.initialize = interrupted
with session():
    print("meshing")
"""
    assert script(code).stdout.split() == ["15", "meshing"]


def test_meshes_by_a_gmsh_without_its_libraries_are_refused_with_the_remedy(tmp_path, monkeypatch):
    reason = "libGL.so.1: cannot open shared object file"
    (tmp_path / "gmsh.py").write_text(f'raise OSError("{reason}")', "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "gmsh", raising=False)
    with pytest.raises(MeshError, match=r"libGL.*apt-get install.* libglu1-mesa"):
        triangles.mesh(SizeField((0.0, 1.0), 1e-2, 1e-2, 0.6, 5.0))
