"""Direct integration against quadrature in 30 digits without elliptic integrals."""

import numpy as np
import pytest
from mpmath import mp

from ringwear import PressureSpace, direct, energy, ring_areas
from ringwear.meshes.radial import graded_breakpoints, layer_degrees

EDGES = np.array([0.0, 0.25, 0.3, 0.8, 1.0])
WEAR = np.array([0.2, 1.0, 0.05, 0.6])
PRESSURES = direct.steady_pressures(EDGES, WEAR)
# RMS gradient of the homogeneous punch of unit pressure, over the radius and over the area
HOMOGENEOUS = {"line": 0.97399573592, "area": 4 / np.pi}


@pytest.fixture(autouse=True)
def _thirty_digits():
    with mp.workdps(30):
        yield


@pytest.mark.parametrize("radius", [0.0, 1e-3, 0.1, 0.27, 0.29999, 0.5, 0.79, 0.95, 0.9999])
@pytest.mark.parametrize("function", [direct.disc_displacement, direct.disc_slope])
def test_discs_against_integrals_over_chords(radius, function):
    """The displacement under a disc of unit pressure is an integral of chord lengths.

    The kernel is ``1 / (pi distance)``; the integral is over the angle of the chord through the
    point.
    """
    expected, r = mp.mpf(0), mp.mpf(radius)
    discs, steps = direct.pressure_steps(EDGES, PRESSURES)
    for disc, step in zip(discs, steps, strict=True):
        c = mp.mpf(float(disc))

        def integrand(angle, c=c):
            half = mp.sqrt(abs(c**2 - (r * mp.sin(angle)) ** 2))
            return half if function is direct.disc_displacement else -r * mp.sin(angle) ** 2 / half

        widest = mp.pi / 2 if r < c else mp.asin(c / r)
        expected += mp.mpf(float(step)) * 4 / mp.pi * mp.quad(integrand, [0, widest])
    value = function(discs, np.array(radius)) @ steps
    assert value == pytest.approx(float(expected), rel=1e-11, abs=1e-13)


def test_steady_pressures_carry_the_force_and_wear_alike():
    """Eqs. 24 and 26: the wear rate is that of the harmonic mean, over the area, of k."""
    mean = np.pi / np.sum(ring_areas(EDGES) / WEAR)
    np.testing.assert_allclose(WEAR * PRESSURES, mean / np.pi, rtol=1e-14)
    assert PRESSURES @ ring_areas(EDGES) == pytest.approx(1.0, rel=1e-14)


def quadrature():
    """Return radii and weights (4, n) on each ring, for logarithmic singularities at edges."""
    node, weight = np.polynomial.legendre.leggauss(40)
    node, weight = (1 + node) / 2, weight / 2
    half = np.diff(EDGES)[:, None] / 2
    # the fourth power removes the singularity
    radii = np.hstack([EDGES[:-1, None] + half * node**4, EDGES[1:, None] - half * node**4])
    return radii, np.tile(half * 4 * node**3 * weight, 2)


@pytest.mark.parametrize("average", HOMOGENEOUS)
def test_rms_slopes_against_quadrature_and_limits(average):
    """RMS slopes of a homogeneous punch, of rings, and of many rings of extreme wear ratio."""
    homogeneous = direct.rms_slope(EDGES[[0, -1]], np.ones(1), average)
    assert homogeneous == pytest.approx(HOMOGENEOUS[average], rel=1e-10)
    radii, weights = quadrature()
    discs, steps = direct.pressure_steps(EDGES, PRESSURES)
    slopes = direct.disc_slope(discs, radii.reshape(-1, 1)) @ steps
    squares = slopes**2 * weights.ravel()
    expected = np.sqrt(np.sum(squares * (2 * radii.ravel() if average == "area" else 1)))
    assert direct.rms_slope(EDGES, PRESSURES, average) == pytest.approx(expected, rel=1e-11)
    # on rings of equal area the pressure alternates between twice the mean and zero; where the
    # half-space is plane, u' = -(2/E*) Hilbert p: four is added to the mean square
    edges = np.sqrt(np.arange(201) / 200)
    pressures = np.pi * direct.steady_pressures(edges, np.where(np.arange(200) % 2, 1e9, 1.0))
    expected = np.hypot(HOMOGENEOUS[average], 2)
    assert direct.rms_slope(edges, pressures, average) == pytest.approx(expected, rel=1e-2)


def test_energies_of_rings_by_the_mdr():
    """``int u p dA = 2 int q^2 dx``, which is 16/3 for the disc."""
    breakpoints, _ = graded_breakpoints(EDGES, 1e-4, 0.2)
    space = PressureSpace(breakpoints, layer_degrees(breakpoints, EDGES, 6, rise=1), EDGES)
    rings = space.ring_indicator()
    energies = rings.T @ energy.compliance(space).matrix @ rings
    assert energies.sum() == pytest.approx(16 / 3, rel=1e-13)
    radii, weights = quadrature()
    displacements = direct.displacement(EDGES, np.eye(4), radii.ravel()).reshape(*radii.shape, 4)
    expected = np.einsum("rn,rns->rs", 2 * np.pi * radii * weights, displacements)
    np.testing.assert_allclose(energies, expected, rtol=1e-11)


def test_limiting_profile_has_its_minimum_at_zero():
    profile = direct.limiting_profile(EDGES, PRESSURES, np.linspace(0, 1, 4001))
    assert -1e-15 <= profile.min() <= 1e-7


def test_histories_tend_to_the_steady_state(prepare, method):
    """After forty relaxation times, pressures and displacements are those of the steady state."""
    punch = prepare("five_rings", method)
    last = punch.wear.history(40 * punch.wear.relaxation_times[:1])
    edges, (wear, _) = punch.problem.merged
    expected = punch.space.ring_indicator() @ direct.steady_pressures(edges, wear)
    np.testing.assert_allclose(last.pressure[0], expected, rtol=0, atol=1e-12)
    values = punch.space.matrix(punch.everywhere)
    displacement = last.indentation[0] - values @ last.profile[0]
    np.testing.assert_allclose(displacement, values @ punch.wear.steady.displacement, rtol=1e-11)
