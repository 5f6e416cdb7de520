"""The answer of a run against closed forms, an independent history, and balances.

Its units, and how it is told.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from closed_forms import disc_energies

from ringwear import Scene, run
from ringwear.mdr import direct
from ringwear.meshes.errors import SceneError
from ringwear.meshes.radial import alternating_edges, ring_areas
from ringwear.studies.crosscheck.scope import time_scale
from ringwear.studies.problem.unit_names import UnitNames
from ringwear.studies.report.printed import print_account
from ringwear.studies.report.words import Account, defaults_taken
from ringwear.studies.wear.time_scale import slowest_relaxation_time

EDGES, K = alternating_edges(5), np.array([1.0, 10.0, 1.0, 10.0, 1.0])


@pytest.fixture(scope="module")
def five():
    return run(Scene.load("five_rings").changed(methods=["mdr", "direct"]))


def test_running_in_against_an_independent_history(five, reference):
    """What the approach has made of its way at a reference's times leads back to these times."""
    wear = five.solutions["mdr"].wear
    assert wear is not None
    slowest = reference["slowest_relaxation_times"][0]
    assert five.answers["mdr"]["running_in_time"] == pytest.approx(slowest, rel=1e-9)
    # where the approach, less steady wear, ends for a force of 2: d F = int u p dA
    pressures = 2 * direct.steady_pressures(EDGES, K)
    rate, steps = K[0] * pressures[0], direct.pressure_steps(pressures)
    end = steps @ disc_energies(EDGES[1:]) @ steps / 2.0
    for state in reference["states"]:
        way = (state["indentation"] - rate * state["time"] - 1.0) / (end - 1.0)
        # ten times as fast as the unit of the scene, for the greatest coefficient is ten
        time = wear.time_until(1 - way) * five.scene.problem.units.time
        assert time == pytest.approx(state["time"], rel=1e-6)


def test_start_and_steady_state_in_closed_form(five):
    close, answer, root = np.testing.assert_allclose, five.answers["mdr"], np.sqrt(1 - EDGES**2)
    with np.errstate(divide="ignore"):
        pressures = 1 / np.pi / root
    close(answer["indentation_start"], 1.0, rtol=1e-8)
    close(answer["pressure_min"][0], pressures[:-1], rtol=1e-4)
    close(answer["pressure_max"][0], pressures[1:], rtol=1e-4)
    close(answer["force_share"][0], -np.diff(root), rtol=0, atol=1e-8)
    steady = 2 * direct.steady_pressures(EDGES, K)
    for answer in five.answers.values():
        close(answer["pressure_min"][1], steady, rtol=1e-10)
        close(answer["pressure_max"][1], steady, rtol=1e-10)
        close(answer["force_share"][1], steady * ring_areas(EDGES) / 2, rtol=1e-10)
        close(answer["steady_wear_rate"], steady[0], rtol=1e-10)


@pytest.mark.parametrize(
    "coefficients", [[1.0, 10.0], [3.0, 3.0]], ids=["five materials", "one material"]
)
def test_worn_volume_is_what_the_force_has_worn(coefficients):
    """Sum of V / k over the rings is F v0 t, also where rings are of one material.

    Units that are not one.
    """
    scene = Scene.load("five_rings").changed(
        methods=["mdr"],
        punch__wear_coefficients=coefficients,
        punch__radius=2.0,
        load__normal_force=5.0,
        load__sliding_speed=3.0,
    )
    data = run(scene).dataset.sel(solver="mdr")
    volumes = data.worn_volume
    assert float((volumes / data.wear_coefficient).sum()) == pytest.approx(30.0, rel=1e-6)
    if coefficients[0] == coefficients[1]:
        # nothing happens at the edges: the profile itself, integrated over the second ring
        data = run(scene.changed(output__radii=np.linspace(0.4, 0.8, 2001).tolist())).dataset
        rings = 2 * np.pi * data.radius * data.profile[0, -1]
        assert float(volumes[1]) == pytest.approx(float(rings.integrate("radius")), rel=1e-6)


def test_the_paper_s_algorithm_answers_what_it_knows():
    scene = Scene.load("five_rings").changed(methods=["mdr", "mdr-grid"], wear__steady=False)
    exact, grid = run(scene).answers.values()
    assert np.isnan(grid["running_in_time"])
    np.testing.assert_allclose(grid["worn_volume"], exact["worn_volume"], rtol=1e-2)


def test_summary_and_dataset_hold_the_answer(five):
    told = json.loads(json.dumps(five.summary["answer"], allow_nan=False))
    assert set(told) == {"mdr", "direct"}
    assert told["direct"]["running_in_time"] is None
    assert told["mdr"]["pressure_max"][0][-1] is None
    dataset = five.dataset
    assert dataset.pressure_min.dims == ("solver", "state", "ring")
    assert dataset.state.values.tolist() == ["start", "steady"]
    np.testing.assert_array_equal(dataset.wear_coefficient, K)
    np.testing.assert_array_equal(dataset.ring_outer_radius, EDGES[1:])
    np.testing.assert_array_equal(dataset.sel(solver="mdr").worn_volume, told["mdr"]["worn_volume"])


@pytest.mark.parametrize(
    ("stated", "units"),
    [
        (
            "SI",
            {"pressure": "Pa", "worn_volume": "m^3", "steady_wear_rate": "m/s", "rms_slope": "1"},
        ),
        ("mm, N, MPa, s", {"pressure": "MPa", "worn_volume": "mm^3", "time_to_90": "s"}),
        ("", {"pressure": "1", "worn_volume": "1", "time_to_90": "1"}),
    ],
)
def test_each_variable_has_its_own_unit(five, stated, units):
    dataset = replace(five, scene=five.scene.changed(units=stated)).dataset
    assert {name: dataset[name].attrs["units"] for name in units} == units


@pytest.mark.parametrize(
    ("value", "kind", "told"),
    [
        (1.234e-5, "displacement", "12.34 µm"),
        (0.02, "length", "20 mm"),
        (3e5, "pressure", "300 kPa"),
        (1e6, "time", "11.57 days"),
        (1e-9, "volume", "1 mm³"),
        (7e-14, "wear_rate", "2.209 µm/year"),
        (2e-15, "wear_coefficient", "2e-06 mm³/(N m)"),
        (0.5, "slope", "0.5"),
        (np.inf, "pressure", "infinite"),
        (np.nan, "time", "not computed"),
        (0.0, "length", "0 m"),
        (1e-20, "length", "1e-20 m"),
    ],
)
def test_numbers_for_people(value, kind, told):
    assert UnitNames.of("SI").write(value, kind) == told


def test_the_answer_is_printed_before_all_else(five, capsys):
    for verbose in (False, True):
        print_account(Account(five), verbose)
        told = capsys.readouterr().out
        parts = ("0.4995", "1.273", "0.9947", "The methods agree")
        if verbose:
            parts += ("0.3441", "to infinity", "Accuracy", "Modelled", "Left out")
        assert [told.index(part) for part in parts] == sorted(told.index(part) for part in parts)
        assert verbose or len(told.splitlines()) < 16


def test_defaults_taken_are_said():
    table = Scene.load("five_rings").table()
    del table["half_space"]["poisson_ratio"], table["load"]["sliding_speed"]
    ratio, speed = defaults_taken(Scene.from_table(table))
    assert "poisson_ratio is not given: 0.3" in ratio
    assert "sliding_speed is not given: 1" in speed


def test_times_in_units_of_the_running_in():
    table = Scene.load("five_rings").table() | {"wear": {"times": {"tau": [0.0, 0.5, 2.0]}}}
    scene = Scene.from_table(table)
    # 0.3440589 of the reference, to three digits
    assert scene.wear.times == [0.0, 0.172, 0.688]
    np.testing.assert_allclose(scene.problem.times, [0.0, 1.72, 6.88])
    near = Scene.from_table(table | {"wear": {"times": {"tau": [1.0, 1.00001]}}})
    assert near.wear.times[0] < near.wear.times[1]
    assert Scene.from_toml(scene.to_toml()).wear.times == scene.wear.times
    # of another punch they are other times
    assert scene.changed(load__sliding_speed=2.0).wear.times == [0.0, 0.086, 0.344]
    named = Scene.from_table(table | {"wear": {"times": "running-in"}})
    assert (named.wear.times[0], named.wear.times[-1]) == (0.0, 1.72)
    assert scene.changed(wear__times=[1.0]).wear.times == [1.0]


@pytest.mark.parametrize(
    "times",
    ["running in", {"tau": [1.0, 0.5]}, {"tau": "all"}, {"taus": [1.0]}, {"tau": [-1.0]}],
    ids=str,
)
def test_times_that_cannot_be_are_refused(times):
    with pytest.raises(SceneError, match="times"):
        Scene.from_table(Scene.load("five_rings").table() | {"wear": {"times": times}})


@pytest.mark.parametrize(
    ("rings", "ratio", "width"),
    [(2, 1e-3, 1.0), (3, 50.0, 0.02), (7, 1e5, 5.0), (1, 1.0, 1.0)],
    ids=str,
)
def test_the_time_scale_is_known_beforehand(rings, ratio, width):
    scene = Scene.load("five_rings").changed(
        methods=["mdr"],
        punch__rings=rings,
        punch__width_ratio=width,
        punch__wear_coefficients=[1.0, ratio],
    )
    computed = run(scene).solutions["mdr"].results["relaxation_time"]
    assert slowest_relaxation_time(scene.problem.rings, False) == pytest.approx(
        float(computed[0]), rel=1e-4
    )


@pytest.mark.parametrize(
    ("times", "told"),
    [([0.0, 1e-5], "before the running-in"), ([50.0], "after the running-in"), ([0.1, 1.0], "")],
)
def test_times_that_miss_the_running_in_are_told(times, told):
    scene = Scene.load("five_rings").changed(
        wear__times=times, methods=["mdr"], accuracy__rtol=1e-2
    )
    before = time_scale(scene)
    assert "slowest relaxation time of the full face 0.344" in before[0]
    for lines in (before, Account(run(scene)).remarks):
        missed = [line for line in lines if "the running-in, " in line]
        assert bool(missed) == bool(told)
        assert all(told in line for line in missed)
