"""Static contact on part of the face: closed forms, annuli and complementarity."""

from functools import cache, partial

import numpy as np
import pytest
from closed_forms import ANNULI, PowerPunch, thin_ring_stiffness

from ringwear import (
    ContactCells,
    InitialProfile,
    Load,
    SolverError,
    WearingPunch,
    energy,
    even_half_space,
    evolve,
    moments,
    ring_kernel,
)
from ringwear.fem.contact_meshes import fitted_half_space
from ringwear.meshes.contact_cells import fitted_space
from ringwear.meshes.ground.ground import HALF_SPACE
from ringwear.studies.crosscheck.wear import unilateral
from ringwear.studies.crosscheck.wear.fitted_press import fit_press, fit_presses
from ringwear.studies.crosscheck.wear.unilateral import Contact, Factor, Interval

DEGREE = 8
METHODS = ["mdr", "bem", pytest.param("fem", marks=pytest.mark.gmsh)]


@cache
def compliance_on(method, degree, edges, sizes, _):
    if method == "fem":
        return fitted_half_space(edges, sizes, degree, HALF_SPACE).compliance()
    make = energy.compliance if method == "mdr" else ring_kernel.compliance
    return make(fitted_space(edges, sizes, degree))


def rings(edges, recess, *heights):
    return InitialProfile(np.array(edges), np.array(recess), heights)


def parabola(radii):
    return radii**2


SPHERE = rings([0, 1], [0], parabola)


def press(method, profile, load, *parts, degree=DEGREE):
    return fit_press(profile, load, parts, partial(compliance_on, method, degree))[0]


def ring_stiffness(method, inner, degree=DEGREE):
    """Return ``F / (E* d)`` of a flat ring."""
    tall, parts = rings([0, inner, 1], [100.0, 0.0]), Interval(inner, 1.0)
    return 1 / press(method, tall, Load(1.0), parts, degree=degree).indentation


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("exponent", [1, 2, 4, 6, 8])
def test_power_profiles_against_closed_forms(method, exponent):
    exact, radius, start = PowerPunch(1.0, exponent), 0.6, Interval(0.0, 0.5, outer_free=True)
    force, depth = exact.force(radius), exact.indentation(radius)
    profile = rings([0, 1], [0], lambda radii: radii**exponent)
    pressed = press(method, profile, Load(force), start)
    assert pressed.indentation == pytest.approx(depth, rel=1e-8)
    assert pressed.radius == pytest.approx(radius, rel=1e-7)
    radii = np.linspace(1e-3, 0.7, 700)
    pressure = exact.pressure(radius, radii)
    difference = pressed.pressure_at(radii) - pressure
    assert np.sqrt(radii @ difference**2 / (radii @ pressure**2)) < 1e-4
    # the same contact at the given indentation
    pressed = press(method, profile, Load(None, depth), start)
    assert pressed.force == pytest.approx(force, rel=1e-8)


def test_closed_forms_against_an_independent_package():
    hertz = pytest.importorskip("ContactMechanics.ReferenceSolutions.Hertz")
    cone = pytest.importorskip("ContactMechanics.ReferenceSolutions.Cone")
    curvature, force, slope = 3.0, 0.2, 0.4
    radius, greatest = hertz.radius_and_pressure(force, curvature, 1.0)
    depth = hertz.penetration(force, curvature, 1.0)
    sphere = PowerPunch(1 / (2 * curvature), 2)
    assert sphere.contact_radius(force) == pytest.approx(radius, rel=1e-12)
    assert sphere.indentation(radius) == pytest.approx(depth, rel=1e-12)
    assert sphere.pressure(radius, np.zeros(1))[0] == pytest.approx(greatest, rel=1e-12)
    exact, angle = PowerPunch(slope, 1), np.pi / 2 - np.arctan(slope)
    over_depth, _ = cone.contact_radius_and_area(angle)
    _, mean = cone.load_and_mean_pressure(angle)
    assert 0.7 / exact.indentation(0.7) == pytest.approx(over_depth, rel=1e-12)
    assert exact.force(0.7) / (np.pi * 0.7**2) == pytest.approx(mean, rel=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("inner", ANNULI)
def test_flat_annuli_have_the_known_stiffnesses(method, inner):
    degree, tolerance = (9, 5e-9) if method == "fem" else (DEGREE, 1e-9)
    assert ring_stiffness(method, inner, degree) == pytest.approx(ANNULI[inner], rel=tolerance)


@pytest.mark.parametrize("width", [1e-2, 1e-3])
def test_thin_rings_tend_to_their_limit(width):
    limit = thin_ring_stiffness(1 - width, 1.0)
    assert ring_stiffness("mdr", 1 - width) == pytest.approx(limit, rel=width**2)


def wavy(radii):
    return 0.2 * (1 - np.cos(7 * np.pi * radii))


@pytest.mark.parametrize(
    "load", [Load(0.05), Load(1.0), Load(None, 0.1), Load(None, 1e-3)], ids=str
)
@pytest.mark.parametrize("recess", [[0.0, 0.3, 0.0], [0.2, 0.0, 0.05]], ids=str)
def test_contact_is_complementary(load, recess):
    compliance = energy.compliance(ContactCells((0.0, 0.3, 0.7, 1.0), 1 / 100, 1e-3).space())
    matrix, weights = compliance.matrix, compliance.space.weights
    of_profile = moments(rings([0, 0.3, 0.7, 1], recess, wavy), compliance.space)
    contact = Contact(matrix, weights)
    pressed = contact.press(of_profile, load)
    gap = matrix @ pressed.pressure + of_profile - pressed.indentation * weights
    assert pressed.pressure.min() >= 0
    assert gap.min() >= -1e-14 * np.abs(of_profile).max()
    assert pressed.pressure @ np.abs(gap) <= 1e-12 * pressed.force * pressed.indentation
    assert pressed.iterations <= 20
    # the contact is unique: the search finds it from any start
    for start in (np.ones(len(gap), dtype=bool), np.arange(len(gap)) % 3 == 0):
        again = contact.press(of_profile, load, start)
        assert again.indentation == pytest.approx(pressed.indentation, rel=1e-12)
        assert np.array_equal(again.contact, pressed.contact)


def press_on(compliance, profile, force):
    contact = Contact(compliance.matrix, compliance.space.weights)
    return contact.press(moments(profile, compliance.space), Load(force))


def test_a_pressed_sphere_by_finite_elements_agrees_with_mdr():
    by_elements = even_half_space(ContactCells((0.0, 1.0), 1 / 100, 1e-3)).compliance()
    by_theory = energy.compliance(by_elements.space)
    first, second = (press_on(compliance, SPHERE, 0.2) for compliance in (by_elements, by_theory))
    assert first.indentation == pytest.approx(second.indentation, rel=2e-6)
    assert np.array_equal(first.contact, second.contact)


@pytest.mark.parametrize(
    ("part", "words"),
    [
        # such a wide contact would need tension
        (Interval(0.0, 1.0), "more parts"),
        (Interval(0.1, 0.5, True, True), "other than its outermost one"),
    ],
)
def test_contacts_of_the_wrong_shape_are_refused(part, words):
    on_edges = partial(compliance_on, "mdr", DEGREE)
    with pytest.raises(SolverError, match=words):
        fit_presses(SPHERE, Load(0.1), (part,), (on_edges, on_edges))


def test_contacts_of_a_march_share_factors_and_are_those_of_own_factors(monkeypatch):
    factors = []

    def counted(*arguments):
        factors.append(Factor(*arguments))
        return factors[-1]

    def wear():
        compliance = energy.compliance(ContactCells((0.0, 1.0), 1 / 100, 1e-3).space())
        of_profile = moments(SPHERE, compliance.space)
        punch = WearingPunch(compliance, np.ones(1), of_profile, Load(0.2))
        return evolve(punch, 0.1, 1e-4)

    monkeypatch.setattr(unilateral, "Factor", counted)
    bordered, shared = wear(), len(factors)
    monkeypatch.setattr(unilateral, "MOST_CHANGES", 0)
    factored = wear()
    # steps of other lengths have other matrices
    assert shared < 0.7 * (len(factors) - shared)
    assert bordered.statistics.taken == factored.statistics.taken
    first, second = (each.at(np.array([0.01, 0.1])) for each in (bordered, factored))
    np.testing.assert_allclose(first.indentation, second.indentation, rtol=2e-15)
    np.testing.assert_allclose(first.profile, second.profile, rtol=0, atol=1e-13)
