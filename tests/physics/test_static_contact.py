"""Static contact on part of the face.

Closed forms, an independent package, annuli, and what contact has to satisfy.
"""

from __future__ import annotations

from functools import cache, partial

import numpy as np
import pytest
from closed_forms import PowerPunch, annulus_stiffness, thin_ring_stiffness

from ringwear.fem.contact_meshes import even_half_space, fitted_half_space
from ringwear.mdr import energy, ring_kernel
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.contact_cells import ContactCells, fitted_space
from ringwear.meshes.errors import SolverError
from ringwear.meshes.radial import Array
from ringwear.studies.problem.profile import InitialProfile, power
from ringwear.studies.wear.fitted_press import FittedContact, FittedPress
from ringwear.studies.wear.moments import moments
from ringwear.studies.wear.unilateral import Contact, Interval, Load

DEGREE = 8
METHODS = ["mdr", "bem", pytest.param("fem", marks=pytest.mark.gmsh)]
# F / (E* a d) of flat annuli by inner radius: digits of an independent computation
ANNULI = {0.3: 1.992418655, 0.6: 1.930144257, 0.9: 1.642059559}


@cache
def on(
    method: str, edges: tuple[float, ...], infinite: tuple[bool, ...], degree: int = DEGREE
) -> Compliance:
    if method == "fem":
        return fitted_half_space(edges, infinite, degree, 0.3).compliance()
    make = energy.compliance if method == "mdr" else ring_kernel.compliance
    return make(fitted_space(edges, infinite, degree))


def rings(edges: list[float], recess: list[float], *heights: object) -> InitialProfile:
    return InitialProfile(np.array(edges), np.array(recess), heights)  # type: ignore[arg-type]


def pressed(method: str, exponent: float, load: Load, start: float = 0.5) -> FittedPress:
    contact = FittedContact(rings([0, 1], [0], power(1.0, exponent)), load, partial(on, method))
    return contact.press((Interval(0.0, start, outer_free=True),))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("exponent", [1, 2, 4, 6, 8])
def test_powers(method: str, exponent: int) -> None:
    known, radius = PowerPunch(1.0, exponent), 0.6
    found = pressed(method, exponent, Load(known.force(radius)))
    assert found.indentation == pytest.approx(known.indentation(radius), rel=1e-8)
    assert found.radius == pytest.approx(radius, rel=1e-7)
    radii = np.linspace(1e-3, 0.7, 700)
    difference = found.pressure_at(radii) - known.pressure(radius, radii)
    assert np.sqrt(radii @ difference**2 / (radii @ known.pressure(radius, radii) ** 2)) < 1e-4
    # the same press, held by its indentation
    held = pressed(method, exponent, Load(None, known.indentation(radius)))
    assert held.force == pytest.approx(known.force(radius), rel=1e-8)
    assert held.evaluations <= 12


def test_closed_forms_against_an_independent_package() -> None:
    hertz = pytest.importorskip("ContactMechanics.ReferenceSolutions.Hertz")
    cone = pytest.importorskip("ContactMechanics.ReferenceSolutions.Cone")
    curvature, force, slope = 3.0, 0.2, 0.4
    radius, greatest = hertz.radius_and_pressure(force, curvature, 1.0)
    for found in (PowerPunch(1 / (2 * curvature), 2),):
        assert found.contact_radius(force) == pytest.approx(radius, rel=1e-12)
        assert found.indentation(radius) == pytest.approx(
            hertz.penetration(force, curvature, 1.0), rel=1e-12
        )
        assert found.pressure(radius, np.zeros(1))[0] == pytest.approx(greatest, rel=1e-12)
    known, angle = PowerPunch(slope, 1), np.pi / 2 - np.arctan(slope)
    over_depth, _ = cone.contact_radius_and_area(angle)
    _, mean = cone.load_and_mean_pressure(angle)
    assert 0.7 / known.indentation(0.7) == pytest.approx(over_depth, rel=1e-12)
    assert known.force(0.7) / (np.pi * 0.7**2) == pytest.approx(mean, rel=1e-12)


def test_closed_form_of_pressure_carries_the_force() -> None:
    node, weight = np.polynomial.legendre.leggauss(60)
    angle, weight = (1 + node) * np.pi / 4, weight * np.pi / 4
    for exponent in (1.0, 1.5, 2.0, 3.0, 5.0):
        known = PowerPunch(0.7, exponent)
        radii = 0.8 * np.sin(angle)
        force = np.sum(
            2 * np.pi * radii * known.pressure(0.8, radii) * 0.8 * np.cos(angle) * weight
        )
        assert force == pytest.approx(known.force(0.8), rel=1e-4)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("inner", ANNULI)
def test_annuli(method: str, inner: float) -> None:
    tall = rings([0, inner, 1], [100.0, 0.0])
    found = FittedContact(
        tall, Load(1.0), lambda *edges: on(method, *edges, 9 if method == "fem" else DEGREE)
    ).press((Interval(inner, 1.0),))
    assert 1 / found.indentation == pytest.approx(
        ANNULI[inner], rel=5e-9 if method == "fem" else 1e-9
    )


@pytest.mark.parametrize("method", ["mdr", "bem"])
@pytest.mark.parametrize("hole", [0.15, 0.2, 0.3])
def test_annuli_with_small_holes_follow_the_published_series(method: str, hole: float) -> None:
    tall = rings([0, hole, 1], [100.0, 0.0])
    found = FittedContact(tall, Load(1.0), partial(on, method)).press((Interval(hole, 1.0),))
    # the term after the last, of which 0.02 is left: the last one is 0.007 e^8
    assert 1 / (2 * found.indentation) == pytest.approx(
        annulus_stiffness(hole), rel=0, abs=0.03 * hole**9
    )


@pytest.mark.parametrize("width", [1e-2, 1e-3])
def test_thin_rings_tend_to_their_limit(width: float) -> None:
    found = FittedContact(
        rings([0, 1 - width, 1], [100.0, 0.0]), Load(1.0), partial(on, "mdr")
    ).press((Interval(1 - width, 1.0),))
    assert 1 / found.indentation == pytest.approx(thin_ring_stiffness(1 - width, 1.0), rel=width**2)


def wavy(radii: Array) -> Array:
    return 0.2 * (1 - np.cos(7 * np.pi * radii))


@pytest.mark.parametrize(
    "load", [Load(0.05), Load(1.0), Load(None, 0.1), Load(None, 1e-3)], ids=str
)
@pytest.mark.parametrize("recess", [[0.0, 0.3, 0.0], [0.2, 0.0, 0.05]], ids=str)
def test_contact_is_complementary(load: Load, recess: list[float]) -> None:
    compliance = energy.compliance(ContactCells((0.0, 0.3, 0.7, 1.0), 1 / 100, 1e-3).space())
    of_profile = moments(rings([0, 0.3, 0.7, 1], recess, wavy), compliance.space)
    contact = Contact(compliance.matrix, compliance.space.weights)
    found = contact.press(of_profile, load)
    gap = (
        compliance.matrix @ found.pressure
        + of_profile
        - found.indentation * compliance.space.weights
    )
    assert found.pressure.min() >= 0
    assert gap.min() >= -1e-14 * np.abs(of_profile).max()
    assert np.abs(found.pressure) @ np.abs(gap) <= 1e-12 * found.force * found.indentation
    assert found.iterations <= 20
    # there is but one such contact, wherever the search begins
    for start in (np.ones(len(gap), dtype=bool), np.arange(len(gap)) % 3 == 0):
        again = contact.press(of_profile, load, start)
        assert again.indentation == pytest.approx(found.indentation, rel=1e-12)
        assert np.array_equal(again.contact, found.contact)


def test_linear_pressures_converge() -> None:
    known, errors = PowerPunch(1.0, 2), []
    for cells in (50, 100, 200):
        space = ContactCells((0.0, 1.0), 1 / cells, 1e-3, spots=((0.0, 0.6, 1 / cells),)).space()
        contact = Contact(energy.compliance(space).matrix, space.weights)
        found = contact.press(
            moments(rings([0, 1], [0], power(1.0, 2)), space), Load(known.force(0.6))
        )
        errors.append(abs(found.indentation / known.indentation(0.6) - 1))
    assert errors[0] < 2e-4
    assert errors[2] < 2e-5


def test_one_disc_in_finite_elements_as_in_theory() -> None:
    cells = ContactCells((0.0, 1.0), 1 / 100, 1e-3)
    half_space = even_half_space(cells, 0.3)
    of_profile = moments(rings([0, 1], [0], power(1.0, 2)), half_space.space)
    by_elements, by_theory = (
        Contact(one.matrix, half_space.space.weights).press(of_profile, Load(0.2))
        for one in (half_space.compliance(), energy.compliance(half_space.space))
    )
    assert by_elements.indentation == pytest.approx(by_theory.indentation, rel=2e-6)
    assert np.array_equal(by_elements.contact, by_theory.contact)


def test_condensed_contact_is_that_of_the_saddle_point() -> None:
    half_space = even_half_space(ContactCells((0.0, 0.5, 1.0), 1 / 12, 2e-2), 0.3)
    of_profile = moments(rings([0, 0.5, 1], [0, 0.1], wavy), half_space.space)
    compliance = half_space.compliance()
    condensed = Contact(compliance.matrix, half_space.space.weights).press(of_profile, Load(0.4))
    pressure, gap, indentation = half_space.unilateral_saddle_point(of_profile, 0.4)
    assert 0 < condensed.contact.sum() < len(gap)
    assert np.array_equal(condensed.contact, pressure > 0)
    assert indentation == pytest.approx(condensed.indentation, rel=1e-9)
    assert pressure == pytest.approx(condensed.pressure, abs=1e-8 * pressure.max())
    assert gap == pytest.approx(condensed.gap, abs=1e-9 * np.abs(of_profile).max())


def test_a_contact_of_another_kind_is_found_out() -> None:
    # between two flat rings the half-space stands up, and touches the ring in the middle
    ends = (Interval(0.0, 0.3), Interval(0.7, 1.0))
    for depth in (1e-3, 1.0):
        contact = FittedContact(
            rings([0, 0.3, 0.7, 1], [0.0, depth, 0.0]), Load(1.0), partial(on, "mdr")
        )
        press = contact.press(ends)
        if depth == 1.0:
            press.check()
        else:
            with pytest.raises(SolverError, match="between the parts"):
                press.check()
    # where nothing holds it down, pressures of a contact too wide are negative
    wide = FittedContact(rings([0, 1], [0], power(1.0, 2)), Load(0.1), partial(on, "mdr")).press(
        (Interval(0.0, 1.0),)
    )
    with pytest.raises(SolverError, match="more parts"):
        wide.check()
