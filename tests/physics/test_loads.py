"""Varying loads against superposition, other marches, balances and the sliding distance."""

import numpy as np
import pytest
from scipy.integrate import quad

from ringwear import (
    ContactCells,
    InitialProfile,
    Load,
    Loading,
    Rings,
    RunningIn,
    Scene,
    WearingPunch,
    energy,
    evolve,
    moments,
    run,
)

FIVE = Rings.alternating(5, 1.0, 10.0)


def random_loading(count, rising, seed=1):
    """Return a load with random knots; force and speed are zero at some of them."""
    draw = np.random.default_rng(seed)
    forces = draw.uniform(0, 1, count + 1)
    forces[[0, count // 3]] = 0.0
    speeds = draw.uniform(0, 1, count + 1) * (draw.uniform(0, 1, count + 1) > 0.2)
    forces = np.sort(forces) if rising else forces
    return Loading(np.append(0, np.cumsum(draw.uniform(0.1, 1, count))) / count, forces, speeds)


def compliance(cells=40, edge=1e-3):
    return energy.compliance(ContactCells(tuple(FIVE.ring_edges), 1 / cells, edge).space())


def wear_by_modes(half_space, loading):
    wear = FIVE.wear_coefficients
    return RunningIn(half_space, wear, continuous=False, loading=loading)


def march(half_space, loading, tolerance, times, height=None):
    heights = () if height is None else (height,)
    moved = moments(InitialProfile(FIVE.ring_edges, np.zeros(5), heights), half_space.space)
    punch = WearingPunch(half_space, FIVE.wear_coefficients, moved, Load(1.0), loading)
    return evolve(punch, times[-1], tolerance).at(times)


@pytest.mark.parametrize("at", [0.0, 0.31, 0.87])
def test_integrals_of_a_loading(at):
    loading = random_loading(7, rising=False)
    forces, speeds = (
        lambda time, values=values: np.interp(time, loading.times, values)
        for values in (loading.forces, loading.speeds)
    )
    knots = {"points": loading.times[1:], "epsabs": 1e-15}
    slid, work = (quad(of, 0, at, **knots)[0] for of in (speeds, lambda t: forces(t) * speeds(t)))
    state = loading.at(np.array([at]))
    values = state.force[0], state.distance[0], state.work[0]
    assert values == pytest.approx((forces(at), slid, work), abs=1e-14)
    assert loading.time_at(slid, int(state.knot[0])) == pytest.approx(at, abs=1e-12)


def check_same(space, history, depths, pressures, profiles):
    """Assert that indentations, and fields in the root mean square, are equal up to roundoff."""
    np.testing.assert_allclose(history.indentation, depths, rtol=1e-12)
    for values, exact in ((history.pressure, pressures), (history.profile, profiles)):
        wrong, whole = (
            np.sqrt(np.sum(field * (space.mass() @ field.T).T, axis=1))
            for field in (values - exact, exact)
        )
        assert (wrong <= 1e-12 * whole).all()


def test_a_force_added_at_a_stop_acts_as_a_second_flat_punch(prepare):
    punch = prepare("five_rings", "mdr")
    # half the force first; the other half is added during a stop, after the distance 0.05
    loading = Loading(
        np.array([0.0, 0.1, 0.2, 0.3]), np.array([0.5, 0.5, 1.0, 1.0]), np.array([1.0, 0, 0, 1])
    )
    history = RunningIn(punch.compliance, punch.wear.wear_coefficients, loading=loading).modal(
        np.array([0.05, 0.15, 0.2, 0.35, 2.0])
    )
    distances = history.distances
    assert distances[1:3] == pytest.approx([0.05, 0.05], rel=1e-14)
    first, second = punch.wear.modal(distances), punch.wear.modal(np.maximum(distances - 0.05, 0))
    later = np.array([0.0, 0.25, 0.5, 0.5, 0.5])
    exact = (
        (0.5 * getattr(first, name).T + later * getattr(second, name).T).T
        for name in ("indentation", "pressure", "profile")
    )
    check_same(punch.space, history, *exact)


def test_a_force_added_at_a_stop_is_infinite_at_the_rim():
    times, radius = [0.0, 0.1, 0.2, 0.3], 1 - 1e-10
    load = {
        "normal_force": {"times": times, "values": [1.0, 1.0, 2.0, 2.0]},
        "sliding_speed": {"times": times, "values": [1.0, 0.0, 0.0, 1.0]},
    }
    scene = Scene.load("five_rings").changed(
        methods=["mdr"], load=load, wear__times=times[1:3], output__radii=[radius]
    )
    before, after = run(scene).dataset.pressure.sel(radius=radius).squeeze().values
    assert after - before == pytest.approx(1 / (2 * np.pi) / np.sqrt(1 - radius**2), rel=1e-6)


def test_steps_agree_with_the_modes_while_the_force_rises(monkeypatch):
    half_space, loading, times = compliance(), random_loading(20, True), np.linspace(0.1, 1.5, 8)
    exact = wear_by_modes(half_space, loading).modal(times)
    # full contact is solved by modes, also from any state of a march
    assert march(half_space, loading, 1e-5, times).indentation == pytest.approx(
        exact.indentation, rel=1e-12
    )
    stages = "ringwear.studies.crosscheck.wear.stages.ContactStages"
    monkeypatch.setattr(f"{stages}.is_full", lambda *_: False)
    errors = []
    for tolerance in (1e-5, 1e-7):
        history = march(half_space, loading, tolerance, times)
        assert history.force == pytest.approx(exact.force, rel=1e-12)
        errors.append(np.abs(history.indentation / exact.indentation - 1).max())
    assert errors[0] < 1e-4
    # steps scale with the cube root of the tolerance, errors with the square of the steps
    assert 0 < errors[1] < errors[0] / 10


@pytest.mark.parametrize("height", [None, lambda radii: 0.5 * radii**2], ids=["flat", "sphere"])
def test_unloading_and_reloading_during_a_stop_changes_nothing(height):
    half_space, times = compliance(), np.array([0.1, 0.5, 1.0, 2.0])
    stop = Loading(
        np.array([0.0, 0.2, 0.3, 0.4, 0.5, 0.6]),
        np.array([1.0, 1.0, 1.0, 0.0, 1.0, 1.0]),
        np.array([1.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
    )
    distances = stop.at(times).distance
    history = march(half_space, stop, 3e-8, times, height)
    whole = march(half_space, Loading(), 3e-8, distances, height)
    # the punch has worn further after the stop
    assert history.indentation[1:] != pytest.approx(whole.indentation[0], rel=1e-3)
    assert history.indentation == pytest.approx(whole.indentation, rel=3e-6)
    assert np.abs(history.profile - whole.profile).max() < 3e-6 * whole.indentation[-1]


@pytest.mark.parametrize("height", [None, lambda radii: 0.5 * radii**2], ids=["flat", "sphere"])
def test_worn_volume_over_k_is_the_integral_of_the_force(height):
    half_space, loading = compliance(), random_loading(25, rising=False)
    times = np.union1d(loading.times[1:], np.linspace(0.05, 2, 9))
    history = march(half_space, loading, 1e-4, times, height)
    ring = half_space.space.ring_indicator() @ np.arange(5)
    carried = history.profile / FIVE.wear_coefficients[0, ring.astype(int)]
    assert carried @ half_space.space.weights == pytest.approx(loading.at(times).work, rel=1e-10)
    forces = loading.at(times).force
    assert history.pressure @ half_space.space.weights == pytest.approx(forces, rel=1e-10)
    # without force, the punch touches at one point and does not penetrate
    gaps = history.gap[forces == 0] / half_space.space.weights
    assert gaps.min(axis=1) == pytest.approx([0], abs=1e-12)
    assert history.gap.min() >= -1e-12 * np.abs(history.indentation).max()


def test_stored_steps_follow_a_varying_load():
    scene = Scene.load("duty_cycle").changed(output__every_step=True, accuracy__rtol=1e-3)
    stored, load = run(scene, methods=["mdr"]).dataset.isel(solver=0), scene.load_.normal_force
    times = stored.step_time.to_numpy()
    assert (np.diff(times) > 0).all()
    forces = np.interp(times, load.times, load.values)
    assert stored.step_normal_force.to_numpy() == pytest.approx(forces, rel=1e-9, abs=1e-9)
    # the ends of contact, the next application of the brake, and the last stop are among the steps
    assert {4.5, 10.0, 14.5} <= set(times)
