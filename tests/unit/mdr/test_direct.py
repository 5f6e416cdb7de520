"""Direct integration against quadrature in 30 digits, which knows neither Eq.

25 nor elliptic integrals.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from conftest import Prepare
from mpmath import mp

from ringwear.mdr import direct
from ringwear.meshes.radial import ring_areas

EDGES = np.array([0.0, 0.25, 0.3, 0.8, 1.0])
WEAR = np.array([0.2, 1.0, 0.05, 0.6])
RADII = [0.0, 1e-3, 0.1, 0.27, 0.29999, 0.5, 0.79, 0.95, 0.9999]


def pressure_steps() -> list[tuple[float, float]]:
    """Radius and pressure of the discs that add up to the rings."""
    pressures = direct.steady_pressures(EDGES, WEAR)
    return [
        (float(c), float(p - after))
        for c, p, after in zip(EDGES[1:], pressures, [*pressures[1:], 0.0], strict=True)
    ]


def chord_integral(disc: float, radius: float, slope: bool) -> Any:
    """Displacement or slope at `radius` by unit pressure on a disc, over the chords through that
    point.

    The kernel ``1 / (pi distance)`` makes the displacement the integral of the chord's length over
    its angle.
    """
    c, r = mp.mpf(disc), mp.mpf(radius)
    ends = [0, mp.pi / 2] if r < c else [0, mp.asin(c / r)]

    def integrand(angle: Any) -> Any:
        half = mp.sqrt(abs(c**2 - (r * mp.sin(angle)) ** 2))
        return -r * mp.sin(angle) ** 2 / half if slope else half

    return 4 / mp.pi * mp.quad(integrand, ends)


@pytest.fixture(autouse=True)
def _thirty_digits() -> Any:
    with mp.workdps(30):
        yield


@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("slope", [False, True], ids=["displacement", "slope"])
def test_against_chords(radius: float, slope: bool) -> None:
    function = direct.slope if slope else direct.displacement
    found = function(EDGES, direct.steady_pressures(EDGES, WEAR), np.array([radius]))[0]
    expected = sum(step * chord_integral(disc, radius, slope) for disc, step in pressure_steps())
    assert found == pytest.approx(float(expected), rel=1e-11, abs=1e-13)


@pytest.mark.parametrize("radius", RADII[1:])
def test_against_the_ring_kernel(radius: float) -> None:
    """Eqs.

    19 and 21 as printed, with ``K`` as an arithmetic-geometric mean: no loss where the rings meet.
    """
    r = mp.mpf(radius)

    def kernel(ring: Any) -> Any:
        return 2 * ring / mp.agm(r + ring, max(abs(r - ring), mp.mpf(10) ** -40))

    pressures = direct.steady_pressures(EDGES, WEAR)
    expected = mp.mpf(0)
    for pressure, (inner, outer) in zip(pressures, pairwise(EDGES), strict=True):
        ends = [inner, radius, outer] if inner < radius < outer else [inner, outer]
        expected += mp.mpf(float(pressure)) * mp.quad(kernel, [mp.mpf(float(end)) for end in ends])
    assert direct.displacement(EDGES, pressures, np.array([radius]))[0] == pytest.approx(
        float(expected), rel=1e-10
    )


@pytest.mark.parametrize(("radius", "ring"), [(0.0, 0.3), (0.4, 0.7), (0.9, 0.1), (0.5, 0.499)])
def test_ring_kernel_is_the_mean_of_the_point_kernel(radius: float, ring: float) -> None:
    r, s = mp.mpf(radius), mp.mpf(ring)

    def inverse_distance(angle: Any) -> Any:
        return 1 / mp.sqrt(r**2 + s**2 - 2 * r * s * mp.cos(angle))

    # the kernel is steep within an angle of the relative distance of the two radii
    expected = mp.quad(inverse_distance, [0, 0.002, 0.02, 0.2, mp.pi]) / mp.pi**2
    assert direct.ring_kernel(np.array(radius), np.array(ring)) == pytest.approx(
        float(expected), rel=1e-12
    )


def test_steady_pressures_carry_the_force_and_wear_alike() -> None:
    pressures = direct.steady_pressures(EDGES, WEAR, force=3.0)
    assert pressures @ ring_areas(EDGES) == pytest.approx(3.0, rel=1e-14)
    np.testing.assert_allclose(WEAR * pressures, WEAR[0] * pressures[0], rtol=1e-14)


def test_wear_rate_is_the_harmonic_mean() -> None:
    """Eqs. 24 and 26: the wear rate of the mean wear coefficient, harmonic and weighted by area."""
    mean = np.pi / np.sum(ring_areas(EDGES) / WEAR)
    assert WEAR[0] * direct.steady_pressures(EDGES, WEAR)[0] == pytest.approx(
        mean / np.pi, rel=1e-14
    )


def test_gradient_of_a_homogeneous_punch() -> None:
    """``4/pi`` over the area; over the radius ``(4/pi) sqrt(int ((E - K)/r)^2 dr)``."""
    edges, pressure = np.array([0.0, 1.0]), np.ones(1)
    line = mp.quad(lambda r: ((mp.ellipe(r**2) - mp.ellipk(r**2)) / r) ** 2, [0, 0.5, 1])
    assert direct.rms_slope(edges, pressure, "area") == pytest.approx(4 / np.pi, rel=1e-12)
    assert direct.rms_slope(edges, pressure, "line") == pytest.approx(
        float(4 / mp.pi * mp.sqrt(line)), rel=1e-12
    )
    assert direct.rms_slope(edges, pressure, "line") == pytest.approx(0.97399573592, rel=1e-10)


@pytest.mark.parametrize("average", ["line", "area"])
def test_gradient_of_rings(average: str) -> None:
    discs = pressure_steps()

    def slope(r: Any) -> Any:
        total = mp.mpf(0)
        for c, step in discs:
            m = min(r, c) / max(r, c)
            total += step * (mp.ellipe(m**2) - mp.ellipk(m**2)) * (1 / m if r < c else 1)
        return 4 / mp.pi * total

    with mp.workdps(20):
        # logarithmic poles at ring edges: tanh-sinh takes them at the ends of each piece
        ends = [*EDGES[:-1], *(EDGES[1:] + EDGES[:-1]) / 2, 1.0]
        power = {"line": 0, "area": 1}[average]
        expected = mp.sqrt(mp.quad(lambda r: (2 * r) ** power * slope(r) ** 2, sorted(ends)))
    found = direct.rms_slope(EDGES, direct.steady_pressures(EDGES, WEAR), average)
    assert found == pytest.approx(float(expected), rel=1e-11)


def test_limiting_profile_has_its_minimum_at_zero() -> None:
    pressures = direct.steady_pressures(EDGES, WEAR)
    profile = direct.limiting_profile(EDGES, pressures, np.linspace(0, 1, 4001))
    assert -1e-15 <= profile.min() <= 1e-7


def test_marches_tend_to_it(prepare: Prepare, method: str) -> None:
    """After forty relaxation times.

    The pressures of direct integration, and the method's own limiting profile.
    """
    punch = prepare("five_rings", method)
    last, steady = punch.wear.history(40 * punch.wear.relaxation_times[:1]), punch.wear.steady
    edges, wear = punch.problem.merged
    pressures = direct.steady_pressures(edges, wear)
    np.testing.assert_allclose(
        last.pressure[0], punch.space.ring_indicator() @ pressures, atol=1e-12
    )
    values = punch.space.matrix(punch.everywhere)
    displacement = last.indentation[0] - values @ last.profile[0]
    np.testing.assert_allclose(displacement, values @ steady.displacement, rtol=1e-11)
    # and that profile is the one that direct integration knows, but for logarithms next to ring
    # edges
    radii = np.array([0.0, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95])
    found = punch.space.matrix(radii) @ steady.displacement
    np.testing.assert_allclose(found, direct.displacement(edges, pressures, radii), rtol=1e-4)


@pytest.mark.parametrize(("average", "homogeneous"), [("line", 0.97399573592), ("area", 4 / np.pi)])
def test_many_rings_of_extreme_ratio(average: str, homogeneous: float) -> None:
    """The pressure alternates between twice the mean and zero, which adds a mean square slope of
    four.

    Far below the radius of a ring the half-space is plane, and there ``u' = -(2/E*) Hilbert p``:
    the mean square of the slope is four times that of the pressure.
    """
    # rings of equal area: the mean pressure is the same everywhere
    edges = np.sqrt(np.arange(201) / 200)
    pressures = direct.steady_pressures(edges, np.where(np.arange(200) % 2, 1e9, 1.0), np.pi)
    assert direct.rms_slope(edges, pressures, average) == pytest.approx(
        np.hypot(homogeneous, 2), rel=1e-2
    )
