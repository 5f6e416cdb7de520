"""Wear with moving contact edges: balances, the worn sphere, modes and steady states."""

from dataclasses import replace

import numpy as np
import pytest
from closed_forms import PowerPunch, worn_sphere

from ringwear import (
    ContactCells,
    InitialProfile,
    Load,
    Loading,
    Rings,
    WearingPunch,
    energy,
    even_half_space,
    evolve,
    evolve_in_equal_steps,
    moments,
)
from ringwear.mdr.direct import steady_pressures
from ringwear.studies.crosscheck.wear.contact_edges import nodes, worn_edges
from ringwear.studies.crosscheck.wear.evolution import Stepping
from ringwear.studies.crosscheck.wear.relaxing import Relaxing

FIVE, THREE = Rings.alternating(5, 1.0, 10.0), Rings.alternating(3, 1.0, 0.01)
ONE = Rings.constant(np.array([0.0, 1.0]), np.ones(1))


def power(coefficient, exponent):
    return lambda radii: coefficient * radii**exponent


def rounded_rim(flat, curvature):
    return lambda radii: np.maximum(radii - flat, 0.0) ** 2 / (2 * curvature)


def waves(count):
    return lambda radii: 0.3 * (1 - np.cos(count * np.pi * radii))


def face(rings, recess, *heights):
    recess = np.broadcast_to(np.asarray(recess, dtype=float), rings.widths.shape)
    return rings, InitialProfile(rings.ring_edges, recess, heights)


FACES = {
    "recessed": face(FIVE, [0, 0.3, 0, 0.3, 0]),
    "recessed, k to 100": face(THREE, [0, 0.2, 0]),
    "sphere": face(FIVE, 0, power(1.0, 2)),
    "cone": face(FIVE, 0, power(1.0, 1)),
    "waves and recesses": face(THREE, [0.2, 0, 0.3], waves(5)),
    "rounded rim": face(FIVE, 0, rounded_rim(0.6, 0.1)),
}


BY_FORCE = Load(1.0)


def punch_on(compliance, face, load=BY_FORCE):
    rings, profile = face
    moved = moments(profile, compliance.space)
    return WearingPunch(compliance, rings.wear_coefficients, moved, load)


def wear(punch, times, tolerance):
    return evolve(punch, times[-1], tolerance).at(times)


def cells(rings, count=160, edge=2e-4):
    return ContactCells(tuple(rings.ring_edges), 1 / count, edge)


def theory(rings, *sizes):
    return energy.compliance(cells(rings, *sizes).space())


def check(history, weights, gap=1e-14):
    """Assert complementarity: no tension, no penetration beyond roundoff, no pressure at gaps."""
    pressure, depth = history.pressure, history.indentation
    assert pressure.min() >= 0
    assert (history.gap >= -gap * np.outer(depth, weights)).all()
    products = np.sum(np.abs(pressure * history.gap), axis=1)
    assert (products <= 1e-12 * history.force * depth + 1e-25).all()


def edges_in_time(history, space):
    states = zip(history.contact, history.profile, strict=True)
    return [worn_edges(space, *state) for state in states]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name != "recessed")) for name in FACES]
)
def test_every_face_wears_to_the_steady_state_of_the_flat_punch(name):
    rings, times = FACES[name][0], np.array([0.0, *np.geomspace(1e-2, 1e3, 11), 1e4])
    half_space = even_half_space(cells(rings)).compliance()
    space = half_space.space
    evolution, of_elements = (
        evolve(punch_on(compliance, FACES[name]), times[-1], 2e-5)
        for compliance in (energy.compliance(space), half_space)
    )
    history, by_elements = evolution.at(times), of_elements.at(times)
    (_, ring), (edges, (fast, _)) = nodes(space), rings
    # finite elements agree with the MDR at all times
    assert by_elements.indentation == pytest.approx(history.indentation, rel=1e-4)
    assert np.abs(by_elements.profile - history.profile).max() < 1e-4 * history.indentation.min()
    # the steady state is that of a flat punch with these rings
    assert history.contact[-1].all()
    assert history.pressure[-1] == pytest.approx(steady_pressures(edges, fast)[ring], rel=1e-12)
    # sum of V / k over the rings = F v0 t
    check(history, space.weights)
    carried = history.profile[1:] / fast[ring]
    assert carried @ space.weights == pytest.approx(times[1:], rel=1e-12)
    # few iterations, although edges move over several cells in a step. "recessed, k to 100" needs
    # more, most of them while a whole ring comes into contact
    assert np.mean(evolution.statistics.iterations) <= (
        1.75 if name == "recessed, k to 100" else 1.5
    )
    assert max(evolution.statistics.iterations) <= 10


def test_orders_in_time():
    times, punch = np.array([0.0, 0.2]), punch_on(theory(FIVE, 30, 1e-2), FACES["sphere"])
    exact = wear(punch, times, 1e-9).indentation[-1]
    marched = [evolve_in_equal_steps(punch, times, step).at(times) for step in (0.02, 0.01, 0.005)]
    errors = [history.indentation[-1] - exact for history in marched]
    assert 1.7 < errors[0] / errors[1] < 2.3
    assert 1.7 < errors[1] / errors[2] < 2.3
    few, many = (evolve(punch, times[-1], tolerance) for tolerance in (1e-4, 1e-6))
    assert abs(many.at(times).indentation[-1] / exact - 1) < 1e-5
    # the third order in a step: a hundredth of the error takes 4.6 times the steps
    assert many.statistics.taken < 10 * few.statistics.taken


@pytest.mark.parametrize(
    ("worn", "load", "name", "times"),
    [
        (FACES["cone"], BY_FORCE, "indentation", [2.5, 3.0, 4.0, 6.0]),
        (face(ONE, 0, power(0.2, 2)), Load(None, 0.5), "force", [2.0, 4.0, 8.0]),
    ],
    ids=["force", "fixed indentation"],
)
def test_relaxation_in_full_contact_against_short_implicit_steps(worn, load, name, times):
    times, punch = np.array(times), punch_on(theory(worn[0], 40, 1e-3), worn, load)
    history = wear(punch, times, 1e-7)
    assert history.contact.all()
    exact = getattr(history, name)
    coarse, fine = (
        getattr(evolve_in_equal_steps(punch, times, step).at(times), name) - exact
        for step in (0.01, 0.005)
    )
    assert coarse / fine == pytest.approx(2.0, rel=0.1)
    assert 2 * fine - coarse == pytest.approx(0.0, abs=1e-5 * exact[0])


def test_a_worn_sphere_against_its_late_time_formula():
    first, ratios = 0.08, np.array([5.0, 10.0])  # radius of the first contact; later ones over it
    force = PowerPunch(0.5, 2).force(first)
    times, depths = np.transpose([worn_sphere(1.0, 1.0, force, first * ratio) for ratio in ratios])
    refinements = ((0.0, first, first / 80),)
    space = ContactCells((0.0, 1.0), 0.2, 1e-3, spread=1 / 80, refinements=refinements).space()
    punch = punch_on(energy.compliance(space), face(ONE, 0, power(0.5, 2)), Load(force))
    history = wear(punch, times, 1e-5)
    assert history.profile @ space.weights == pytest.approx(force * times, rel=1e-12)
    assert history.indentation == pytest.approx(depths, rel=1e-4)
    radii = [edges[-1][1] for edges in edges_in_time(history, space)]
    assert radii == pytest.approx(first * ratios, rel=2e-3)


def test_a_part_of_the_contact_opens_and_closes_again():
    """A worn face loses contact at its rim while the force falls, until the force is back."""
    loading = Loading(
        np.array([0.0, 1.0, 1.1, 1.2, 1.3]), np.array([1.0, 1.0, 0.5, 0.5, 1.0]), np.ones(5)
    )
    times, radii = np.array([0.9, 1.1, 1.15, 1.2, 1.3, 1.4]), []
    for compliance in (theory(FIVE), even_half_space(cells(FIVE)).compliance()):
        punch = replace(punch_on(compliance, face(FIVE, 0)), loading=loading)
        evolution = evolve(punch, times[-1], 1e-6)
        history = evolution.at(times)
        # modes solve the history until contact is lost, and steps afterwards
        first, *others = evolution.pieces
        assert isinstance(first, Relaxing)
        assert 1.0 < first.until < 1.1
        assert isinstance(others[0], Stepping)
        assert history.contact.all(axis=1).tolist() == [True, False, False, False, True, True]
        assert history.pressure.min() >= 0
        edges = edges_in_time(history, compliance.space)
        radii.append([edges[row][-1][1] for row in (1, 2, 3)])
    # contact spreads again while the force rests
    assert radii[0] == sorted(radii[0])
    # to the width of a cell
    assert radii[1] == pytest.approx(radii[0], abs=1 / 160)
