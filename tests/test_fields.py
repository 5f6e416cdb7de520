"""The inside of the half-space under a flat punch against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import Prepare, Prepared

from fem.fields import displacements, vertex_stresses, von_mises
from meshes.radial import Array
from studies.contact import flat_start

P0 = 1 / (2 * np.pi)


def flat(prepare: Prepare, mesher: str, poisson_ratio: float) -> tuple[Prepared, Array]:
    punch = prepare("flat_punch", mesher, half_space__poisson_ratio=poisson_ratio)
    assert punch.model.half_space is not None
    return punch, displacements(punch.model.half_space, flat_start(punch.compliance).pressure[None])


@pytest.mark.parametrize("mesher", ["gmsh", "bisection"])
@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.45, 0.4999, 0.5])
def test_stresses_on_the_axis(prepare: Prepare, mesher: str, poisson_ratio: float) -> None:
    """``zz = -p0 (1 + 3 s^2)/(1 + s^2)^2`` and ``rr = -p0 [(1 + 2 nu)/2/(1 + s^2) - s^2/(1 + s^2)^2]`` at depth s."""
    punch, moved = flat(prepare, mesher, poisson_ratio)
    solid = punch.model.half_space.solid
    radii, depths = solid.mesh.points.T
    axis = (radii == 0) & (depths > 0) & (depths < 3)
    s = depths[axis] ** 2
    rr, zz, rz, hoop = vertex_stresses(solid, moved)[0, axis].T
    tolerance = 1e-2 * P0
    assert np.abs(zz + P0 * (1 + 3 * s) / (1 + s) ** 2).max() <= tolerance
    assert np.abs(rr + P0 * ((0.5 + poisson_ratio) / (1 + s) - s / (1 + s) ** 2)).max() <= tolerance
    np.testing.assert_allclose(hoop, rr, atol=1e-12)
    assert np.abs(rz).max() <= tolerance


@pytest.mark.parametrize("mesher", ["gmsh", "bisection"])
@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.5])
def test_surface(prepare: Prepare, mesher: str, poisson_ratio: float) -> None:
    """Flat under the punch, and ``(2 d0/pi) arcsin(1/r)`` around it, far beyond any truncation being felt."""
    punch, moved = flat(prepare, mesher, poisson_ratio)
    solid = punch.model.half_space.solid
    axial = moved[0, :, 1]
    inside, around = solid.boundary("contact"), solid.boundary("free")
    # within 1e-3 of the rim the slope is infinite
    inside = inside[solid.positions[inside, 0] < 0.999]
    np.testing.assert_allclose(axial[inside], 0.5, rtol=1e-3)
    np.testing.assert_allclose(axial[around], np.arcsin(1 / solid.positions[around, 0]) / np.pi, rtol=1e-3)


@pytest.mark.parametrize("mesher", ["gmsh", "bisection"])
def test_pressure_is_the_traction(prepare: Prepare, mesher: str) -> None:
    punch, moved = flat(prepare, mesher, 0.3)
    solid = punch.model.half_space.solid
    contact = np.unique(solid.mesh.boundaries["contact"])
    contact = contact[solid.mesh.points[contact, 0] < 0.8]
    _, zz, rz, _ = vertex_stresses(solid, moved)[0, contact].T
    expected = P0 / np.sqrt(1 - solid.mesh.points[contact, 0] ** 2)
    np.testing.assert_allclose(-zz, expected, rtol=5e-2)
    assert np.abs(rz).max() <= 5e-2 * P0


def test_von_mises_of_simple_states() -> None:
    pull, pressure, shear = [0.0, 2.0, 0.0, 0.0], [3.0, 3.0, 0.0, 3.0], [0.0, 0.0, 1.0, 0.0]
    np.testing.assert_allclose(von_mises(np.array([pull, pressure, shear])), [2, 0, np.sqrt(3)])
