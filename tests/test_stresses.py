"""The inside of the half-space against closed forms, on every kind of element."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from conftest import WITHOUT_GMSH
from skfem import Mesh

from ringwear.fem.elasticity import AxisymmetricElasticity
from ringwear.fem.half_space import HalfSpace, pressure_space
from ringwear.fem.stresses import displacements, sampled, von_mises
from ringwear.mdr.direct import displacement as exact_displacement
from ringwear.meshes import bisection, quads, triangles
from ringwear.meshes.half_space import areas
from ringwear.meshes.radial import Array, Indices
from ringwear.meshes.sizes import SizeField

EDGES = np.array([0.0, 0.5, 1.0])
FIELD = SizeField((0.0, 0.5, 1.0), 1e-6, 1e-3, 0.4, 5.0)
# degree, and errors of stresses (over the pressure) and displacements that it may have
MESHERS = {"quads": (8, 1e-4, 2e-6), "gmsh": (4, 5e-3, 1e-4), "bisection": (4, 5e-3, 2e-4)}


def mesh(mesher: str) -> Mesh:
    if WITHOUT_GMSH and mesher != "bisection":
        pytest.skip(WITHOUT_GMSH)
    if mesher == "quads":
        return quads.graded(EDGES, 1e-4, 1e-9, 0.25, 0.8, 2.5).mesh
    return {"gmsh": triangles.mesh, "bisection": bisection.mesh}[mesher](FIELD)


@cache
def half_space(mesher: str, poisson_ratio: float) -> HalfSpace:
    solid = AxisymmetricElasticity(mesh(mesher), MESHERS[mesher][0], poisson_ratio)
    return HalfSpace(solid, pressure_space(solid, EDGES), tuple(range(0, 12, 2)))


Samples = tuple[Array, Indices, Array, Array]


@cache
def loaded(mesher: str, poisson_ratio: float) -> Samples:
    """Unit pressure on the whole contact."""
    whole = half_space(mesher, poisson_ratio)
    return sampled(whole, whole.space.ring_indicator().sum(axis=1)[None], 2)


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.4999, 0.5])
@pytest.mark.parametrize("mesher", MESHERS)
def test_stresses_of_a_loaded_disc(mesher: str, poisson_ratio: float) -> None:
    """Love: ``zz = c^3 - 1`` and ``rr = (1 + nu) c - (1 + 2 nu)/2 - c^3/2`` on the axis, c the cosine to the rim."""
    (r, depth), _, moved, stress = loaded(mesher, poisson_ratio)
    _, tension, shift = MESHERS[mesher]
    near = depth < 2
    axis, surface = (r == 0) & near, depth == 0
    cosine = depth[axis] / np.hypot(1, depth[axis])
    rr, zz, rz, hoop = stress[0, axis].T
    assert np.abs(zz - (cosine**3 - 1)).max() <= tension
    assert np.abs(rr - ((1 + poisson_ratio) * cosine - 0.5 - poisson_ratio - cosine**3 / 2)).max() <= tension
    assert np.abs(hoop - rr).max() <= 1e-11
    assert np.abs(rz).max() <= tension
    # the load, and nothing beside it, but for the last layers at the rim
    _, zz, rz, _ = stress[0, surface].T
    off_rim = np.abs(r[surface] - 1) > 0.05
    load = np.where(r[surface] < 1, -1.0, 0.0)
    assert np.abs(zz - load)[off_rim].max() <= 10 * tension
    assert np.abs(rz)[off_rim].max() <= 10 * tension
    np.testing.assert_allclose(moved[0, surface, 1], exact_displacement(EDGES[[0, 2]], np.ones(1), r[surface]), rtol=shift)


@pytest.mark.parametrize("mesher", MESHERS)
def test_samples_fill_the_half_space_and_agree_on_facets(mesher: str) -> None:
    points, small, moved, _ = loaded(mesher, 0.3)
    a, b, c = points.T[small].transpose(0, 2, 1)
    sizes = np.abs((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])) / 2
    assert sizes.min() > 0
    assert sizes.sum() == pytest.approx(areas(half_space(mesher, 0.3).solid.mesh).sum(), rel=1e-12)
    # points on facets belong to both elements, of different degrees: the displacement is one
    off_rim = np.flatnonzero(np.hypot(points[0] - 1, points[1]) > 1e-3)
    place = np.round(points[:, off_rim].T, 9)
    _, first, same = np.unique(place, axis=0, return_index=True, return_inverse=True)
    assert len(first) < 0.9 * len(place)
    np.testing.assert_allclose(moved[0, off_rim], moved[0, off_rim[first]][same], atol=1e-7)


@pytest.mark.parametrize("mesher", MESHERS)
def test_work_of_the_pressures(mesher: str) -> None:
    """``p . A p`` by the displacements that the pressures make."""
    whole = half_space(mesher, 0.3)
    pressures, contact = whole.space.ring_indicator().T, whole.solid.boundary("contact")
    work = displacements(whole, pressures)[:, contact, 1] @ whole.coupling[: len(contact)] @ pressures.T
    np.testing.assert_allclose(work, pressures @ whole.compliance().matrix @ pressures.T, rtol=1e-9)


def test_von_mises_of_simple_states() -> None:
    pull, pressure, shear = [0.0, 2.0, 0.0, 0.0], [3.0, 3.0, 0.0, 3.0], [0.0, 0.0, 1.0, 0.0]
    np.testing.assert_allclose(von_mises(np.array([pull, pressure, shear])), [2, 0, np.sqrt(3)])
