"""The answer of a run in the dataset, in the summary, with its units, and as printed text."""

import json
import re

import numpy as np
import pytest

from ringwear import Scene, alternating_edges, load, run

EDGES, K = alternating_edges(5), np.array([1.0, 10.0, 1.0, 10.0, 1.0])


RUN = "run scene.toml --out out --no-figures --verbose"


def answers_in(text):
    """Return value and meaning of each answer that a run prints with `--verbose`."""
    lines = text.partition("All answers")[2].splitlines()
    rows = [re.split(r" {2,}", line.strip()) for line in lines]
    return {row[0]: tuple(row[1:]) for row in rows[: rows.index([""])] if len(row) == 3}


@pytest.fixture(scope="module")
def five():
    return run(Scene.load("five_rings").changed(methods=["mdr", "bem", "direct"]))


def test_summary_and_dataset_have_the_answer(five):
    answer = json.loads(json.dumps(five.summary["answer"], allow_nan=False))
    assert set(answer) == {"mdr", "bem", "direct"}
    assert answer["direct"]["running_in_time"] is None
    assert answer["mdr"]["pressure_max"][0][-1] is None
    dataset = five.dataset
    assert dataset.pressure_min.dims == ("solver", "state", "ring")
    assert dataset.state.values.tolist() == ["start", "steady"]
    np.testing.assert_array_equal(dataset.wear_coefficient, K)
    np.testing.assert_array_equal(dataset.ring_outer_radius, EDGES[1:])
    np.testing.assert_array_equal(
        dataset.sel(solver="mdr").worn_volume, answer["mdr"]["worn_volume"]
    )


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
    dataset = run(five.scene.changed(units=stated), methods=["mdr"], rtol=1e-2).dataset
    assert {name: dataset[name].attrs["units"] for name in units} == units


@pytest.mark.parametrize("flags", ["", "--verbose"], ids=["brief", "verbose"])
def test_the_answer_is_printed_first(five, flags, command):
    output = command(f"run scene.toml --out out --no-figures {flags}", scene=five.scene).out
    parts = ("0.4995", "1.273", "0.9947", "The methods agree")
    if flags:
        parts += ("0.3441", "to infinity", "Accuracy", "Modelled", "Left out")
    assert [output.index(part) for part in parts] == sorted(output.index(part) for part in parts)
    assert flags or len(output.splitlines()) < 16


@pytest.mark.slow
def test_a_load_that_varies_is_answered_by_what_each_ring_has_lost(command):
    """Fields that are left out of the promise, at times exactly as in the scene, are no failure."""
    scene = Scene.load("duty_cycle")
    line = "run duty_cycle --methods mdr,bem --out out --no-figures --no-report"
    lines = command(line).out.splitlines()
    assert len([line for line in lines if line.startswith(("  1 ", "  2 ", "  3 "))]) == 3
    (verdict,) = (line for line in lines if line.startswith("The methods agree in "))
    assert " quantities. Undecided while edges of the contact move: " in verdict
    summary = load("out").summary
    excluded = [time for row in summary["left_out_of_promise"] for time in row["times"]]
    assert 14.0 in excluded
    assert set(excluded) <= set(scene.wear.times)


@pytest.mark.parametrize(
    ("times", "words"),
    [([0.0, 1e-5], "before the running-in"), ([50.0], "after the running-in"), ([0.1, 1.0], "")],
)
def test_times_that_miss_the_running_in_give_a_note(times, words, command):
    scene = Scene.load("five_rings").changed(
        wear__times=times, methods=["mdr"], accuracy__rtol=1e-2
    )
    planned = command("plan scene.toml", scene=scene).out.splitlines()
    assert "running-in: slowest relaxation time of the full face 0.344" in planned
    for lines in (planned, run(scene).remarks):
        missed = [line for line in lines if "the running-in, " in line]
        assert bool(missed) == bool(words)
        assert all(words in line for line in missed)


def test_the_answers_of_one_kind_have_one_unit_and_definitions_of_their_own(command):
    washer = Scene.load("washer").changed(methods=["mdr"], accuracy__rtol=1e-2)
    text = command(RUN, scene=washer).out
    answers = {name: value for name, (value, _) in answers_in(text).items()}
    result = load("out")
    times = ("time to 90", "time to 99", "running in time")
    assert len({answers[name].split()[1] for name in times}) == 1
    assert len({answers[name].split()[1] for name in answers if "indentation" in name}) == 1
    names = [long_name.attrs["long_name"] for long_name in result.dataset.values()]
    assert not [name for name in names if "the same for" in name or "that force" in name]
    assert "99 % of the running-in" in result.dataset.time_to_99.attrs["long_name"]


def test_the_running_in_time_of_a_ball_is_said_to_be_that_of_the_full_face(command):
    """Under a force a ball wears for ever; its contact does not reach the rim."""
    sphere = Scene.load("sphere").changed(methods=["mdr"], wear__times=[0.0, 0.1])
    text = command(RUN, scene=sphere).out
    result = load("out")
    assert np.isnan(result.first("time_to_full_contact"))
    _, meaning = answers_in(text)["running in time"]
    assert "slowest relaxation time of the full face" in meaning
    assert meaning == result.dataset.running_in_time.attrs["long_name"]


WITHOUT_SPEED = {
    "methods": ["mdr", "direct"],
    "punch": {"radius": "10 mm", "wear_coefficient": "1e-6 mm^3/(N m)"},
    "half_space": {"youngs_modulus": "2 GPa"},
    "load": {"normal_force": "100 N"},
    "wear": {"times": ["0 m", "0.5 km", "2000 m"]},
    "accuracy": {"rtol": 1e-3},
}


@pytest.mark.parametrize(
    ("units", "metre", "length", "rate"),
    [("SI", 1.0, "m", "318.3 nm/km"), ("mm, N, MPa, s", 1e3, "mm", "0.0003183 mm/km")],
)
def test_without_a_sliding_speed_times_are_sliding_distances(units, metre, length, rate, command):
    """The height lost per distance is k F / (pi a^2), and distances are speed times time."""
    scene = Scene.from_table(WITHOUT_SPEED | {"units": units})
    assert scene.wear.times == pytest.approx([0.0, 500.0 * metre, 2000.0 * metre])
    text = command(RUN, scene=scene).out
    answers = {name: value for name, (value, _) in answers_in(text).items()}
    result = load("out")
    assert answers["steady wear rate"] == rate
    assert all(answers[name].endswith((" m", " km")) for name in ("time to 90", "time to 99"))
    dataset = result.dataset
    assert dataset.steady_wear_rate.attrs["units"] == f"{length}/{length}"
    assert dataset.time.attrs == {"long_name": "sliding distance", "units": length}
    assert dataset.time_to_90.attrs["units"] == length
    times = ["0 s", "1000 s", "4000 s"]
    with_speed = run(scene.changed(load__sliding_speed="0.5 m/s", wear__times=times))
    assert with_speed.dataset.time.attrs["units"] == "s"
    seconds = float(with_speed.first("time_to_90"))
    assert float(result.first("time_to_90")) == pytest.approx(0.5 * metre * seconds, rel=1e-9)


def test_a_sliding_distance_can_be_given_as_a_time_at_the_speed_1():
    for units in ("SI", "mm, N, MPa, s"):
        table = WITHOUT_SPEED | {"units": units, "wear": {"times": ["0 s", "1 h"]}}
        assert Scene.from_table(table).wear.times == [0.0, 3600.0]
