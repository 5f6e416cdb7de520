"""The error indicator: exact values for simple fields, and the triangles that are marked."""

import itertools

import numpy as np
import pytest
from skfem import Basis, MeshQuad

from ringwear import MeshError, PressureSpace, SizeField, bisection
from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.error_indicator import fewest_with_share, squared_indicators
from ringwear.fem.half_space import pressure_space
from ringwear.fem.weak_form import moduli
from ringwear.meshes.ground.ground import Ground

EDGES = np.array([0.0, 0.5, 1.0])
RATIO = 0.3
LAME, SHEAR = moduli(RATIO)


@pytest.fixture(params=[2, 3, 4])
def solid(request):
    mesh = bisection.mesh(SizeField(tuple(EDGES), 0.1, 0.1, 0.5, 3.0))
    return AxisymmetricElasticity(mesh, request.param, Ground.half_space(RATIO))


def places(solid):
    """Return radius and depth of the nodes."""
    return Basis(solid.mesh, solid.element).doflocs


def indicate(solid, radial, axial, pressure):
    """Return squared indicators (m,) of a field at the nodes, under a uniform pressure."""
    field = np.stack(np.broadcast_arrays(radial, axial), axis=-1)[None]
    space = pressure_space(solid, EDGES)
    return squared_indicators(solid, field, space, pressure * space.uniform[None])[0]


def test_the_indicator_vanishes_on_a_bent_plate_which_the_elements_hold_exactly(solid):
    # equal bending moments in all directions: the surface is free, and nothing else acts
    curvature = LAME / (LAME + 2 * SHEAR)
    r, z = places(solid)
    indicator = indicate(solid, r * z, -(r**2) / 2 - curvature * z**2, 0.0)
    # for comparison: a field of the same size whose surface is not free of stress
    scale = indicate(solid, r * z, r**2, 0.0).sum()
    assert indicator.sum() < 1e-20 * scale


def test_a_missing_pressure_beside_the_contact_is_indicated_exactly(solid):
    # uniform compression needs the pressure 1 everywhere, but it acts on the contact only
    indicator = indicate(solid, 0.0, -places(solid)[1] / (LAME + 2 * SHEAR), 1.0)
    mesh, expected = solid.mesh, np.zeros(solid.mesh.nelements)
    for facet in mesh.boundaries["free"]:
        inner, outer = np.sort(mesh.p[0, mesh.facets[:, facet]])
        area, size = np.pi * (outer**2 - inner**2), outer - inner
        expected[mesh.f2t[0, facet]] += size / (2 * SHEAR * solid.degree) * area
    np.testing.assert_allclose(indicator, expected, rtol=1e-9, atol=1e-14 * expected.max())


def test_a_residual_inside_is_indicated_with_its_weight(solid):
    # u_z = z^2 / 2 has the residual lambda + 2 mu along the axis, and no stress on the surface
    indicator = indicate(solid, 0.0, places(solid)[1] ** 2 / 2, 0.0)
    mesh = solid.mesh
    inside = ~np.isin(np.arange(mesh.nelements), mesh.f2t[0, mesh.boundary_facets()])
    corners = mesh.p[:, mesh.t[:, inside]]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=0).max(axis=0)
    (r0, r1, r2), (z0, z1, z2) = corners
    area = np.abs((r1 - r0) * (z2 - z0) - (r2 - r0) * (z1 - z0)) / 2
    volume = 2 * np.pi * area * (r0 + r1 + r2) / 3
    weight = longest**2 / (2 * SHEAR * solid.degree**2)
    np.testing.assert_allclose(
        indicator[inside], weight * (LAME + 2 * SHEAR) ** 2 * volume, rtol=1e-9
    )


def test_quadrilaterals_are_refused():
    solid = AxisymmetricElasticity(MeshQuad(), 4, Ground.half_space(RATIO))
    space = PressureSpace(EDGES, np.ones(2, dtype=int), EDGES)
    with pytest.raises(MeshError, match="triangles"):
        squared_indicators(solid, np.zeros((1, 25, 2)), space, np.zeros((1, space.size)))


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("seed", range(4))
def test_the_fewest_triangles_with_the_wanted_share_are_marked(seed, share):
    indicators = np.random.default_rng(seed).exponential(size=9) ** 2
    marked = fewest_with_share(indicators, share)
    wanted = share * indicators.sum()
    assert indicators[marked].sum() >= wanted
    fewer = itertools.combinations(indicators, len(marked) - 1)
    assert max(map(sum, fewer)) < wanted
