"""Direct integration against quadrature in 30 digits, which knows no elliptic integrals."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from conftest import Prepare
from mpmath import mp

from ringwear.mdr import direct
from ringwear.meshes import ring_areas

EDGES = np.array([0.0, 0.25, 0.3, 0.8, 1.0])
WEAR = np.array([0.2, 1.0, 0.05, 0.6])
PRESSURES = direct.steady_pressures(EDGES, WEAR)
STEPS = direct.pressure_steps(PRESSURES)
RADII = [0.0, 1e-3, 0.1, 0.27, 0.29999, 0.5, 0.79, 0.95, 0.9999]
# RMS gradient of the homogeneous punch of unit pressure, over the radius and over the area
HOMOGENEOUS = {"line": 0.97399573592, "area": 4 / np.pi}


def chord_integral(disc: float, radius: float, slope: bool) -> Any:
    """Displacement or slope at `radius` by unit pressure on a disc.

    The kernel ``1 / (pi distance)`` makes the displacement the integral of the length of the chord
    through the point over its angle.
    """
    c, r = mp.mpf(disc), mp.mpf(radius)

    def integrand(angle: Any) -> Any:
        half = mp.sqrt(abs(c**2 - (r * mp.sin(angle)) ** 2))
        return -r * mp.sin(angle) ** 2 / half if slope else half

    return 4 / mp.pi * mp.quad(integrand, [0, mp.pi / 2 if r < c else mp.asin(c / r)])


@pytest.fixture(autouse=True)
def _thirty_digits() -> Any:
    with mp.workdps(30):
        yield


@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("slope", [False, True], ids=["displacement", "slope"])
def test_against_chords(radius: float, slope: bool) -> None:
    function = direct.slope if slope else direct.displacement
    expected = STEPS @ [chord_integral(float(disc), radius, slope) for disc in EDGES[1:]]
    assert function(EDGES, PRESSURES, [radius])[0] == pytest.approx(
        float(expected), rel=1e-11, abs=1e-13
    )


@pytest.mark.parametrize("radius", RADII[1:])
def test_against_the_ring_kernel(radius: float) -> None:
    """Eqs. 19 and 21 as printed, with ``K`` as an arithmetic-geometric mean."""
    r = mp.mpf(radius)

    def kernel(ring: Any) -> Any:
        return 2 * ring / mp.agm(r + ring, max(abs(r - ring), mp.mpf(10) ** -40))

    expected = mp.mpf(0)
    for pressure, (inner, outer) in zip(PRESSURES, pairwise(EDGES), strict=True):
        ends = [inner, min(max(radius, inner), outer), outer]
        expected += mp.mpf(float(pressure)) * mp.quad(kernel, [mp.mpf(float(end)) for end in ends])
    found = direct.displacement(EDGES, PRESSURES, [radius])[0]
    assert found == pytest.approx(float(expected), rel=1e-10)


@pytest.mark.parametrize(("radius", "ring"), [(0.0, 0.3), (0.4, 0.7), (0.9, 0.1), (0.5, 0.499)])
def test_ring_kernel_is_the_mean_of_the_point_kernel(radius: float, ring: float) -> None:
    r, s = mp.mpf(radius), mp.mpf(ring)

    def inverse_distance(angle: Any) -> Any:
        return 1 / mp.sqrt(r**2 + s**2 - 2 * r * s * mp.cos(angle))

    # the kernel is steep within an angle of the relative distance of the two radii
    expected = mp.quad(inverse_distance, [0, 0.002, 0.02, 0.2, mp.pi]) / mp.pi**2
    found = direct.ring_kernel(np.array(radius), np.array(ring))
    assert found == pytest.approx(float(expected), rel=1e-12)


def test_steady_pressures_carry_the_force_and_wear_alike() -> None:
    """Eqs. 24 and 26: at the rate of the mean wear coefficient, harmonic and weighted by area."""
    mean = np.pi / np.sum(ring_areas(EDGES) / WEAR)
    np.testing.assert_allclose(WEAR * PRESSURES, mean / np.pi, rtol=1e-14)
    pressures = direct.steady_pressures(EDGES, WEAR, force=3.0)
    assert pressures @ ring_areas(EDGES) == pytest.approx(3.0, rel=1e-14)


@pytest.mark.parametrize("average", HOMOGENEOUS)
def test_gradients(average: str) -> None:
    """Of a homogeneous punch, of rings, and of many rings of extreme ratio."""
    homogeneous = direct.rms_slope(EDGES[[0, -1]], np.ones(1), average)
    assert homogeneous == pytest.approx(HOMOGENEOUS[average], rel=1e-10)
    weigh = {"line": lambda _: 1, "area": lambda r: 2 * r}[average]

    def squared(steps: Any, discs: Any) -> Any:
        def slope(r: Any) -> Any:
            total = mp.mpf(0)
            for c, step in zip(map(float, discs), map(float, steps), strict=True):
                m = min(r, c) / max(r, c)
                total += step * (mp.ellipe(m**2) - mp.ellipk(m**2)) * (1 / m if r < c else 1)
            return weigh(r) * (4 / mp.pi * total) ** 2

        # logarithmic poles at ring edges: tanh-sinh takes them at the ends of each piece
        ends = [0.0, *discs]
        return mp.quad(slope, sorted([*ends, *((a + b) / 2 for a, b in pairwise(ends))]))

    with mp.workdps(20):
        of_rings = float(mp.sqrt(squared(STEPS, EDGES[1:])))
        of_one = float(mp.sqrt(squared([1.0], [1.0])))
    assert homogeneous == pytest.approx(of_one, rel=1e-12)
    assert direct.rms_slope(EDGES, PRESSURES, average) == pytest.approx(of_rings, rel=1e-11)
    # on rings of equal area the pressure alternates between twice the mean and zero; where the
    # half-space is plane, u' = -(2/E*) Hilbert p: four is added to the mean square
    edges = np.sqrt(np.arange(201) / 200)
    pressures = direct.steady_pressures(edges, np.where(np.arange(200) % 2, 1e9, 1.0), np.pi)
    expected = np.hypot(HOMOGENEOUS[average], 2)
    assert direct.rms_slope(edges, pressures, average) == pytest.approx(expected, rel=1e-2)


def test_limiting_profile_has_its_minimum_at_zero() -> None:
    profile = direct.limiting_profile(EDGES, PRESSURES, np.linspace(0, 1, 4001))
    assert -1e-15 <= profile.min() <= 1e-7


def test_marches_tend_to_it(prepare: Prepare, method: str) -> None:
    """After forty relaxation times: its pressures, and the method's own limiting profile."""
    punch = prepare("five_rings", method)
    last, steady = punch.wear.history(40 * punch.wear.relaxation_times[:1]), punch.wear.steady
    edges, wear = punch.problem.merged
    pressures = direct.steady_pressures(edges, wear)
    expected = punch.space.ring_indicator() @ pressures
    np.testing.assert_allclose(last.pressure[0], expected, atol=1e-12)
    values = punch.space.matrix(punch.everywhere)
    displacement = last.indentation[0] - values @ last.profile[0]
    np.testing.assert_allclose(displacement, values @ steady.displacement, rtol=1e-11)
    # and that profile is the closed form, but for logarithms next to ring edges
    radii = np.array([0.0, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95])
    exact = direct.displacement(edges, pressures, radii)
    np.testing.assert_allclose(punch.space.matrix(radii) @ steady.displacement, exact, rtol=1e-4)
