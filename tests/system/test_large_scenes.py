"""Scenes and tables with a great many times or radii: computed in parts, or refused at once.

Extremes are tested by what is predicted, not by filling the memory.
"""

import resource
import sys
import time

import numpy as np
import pandas as pd
import pytest

from ringwear import Scene, SceneError, check, plan, run

FIVE = Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-3)
SPHERE = Scene.load("sphere").changed(methods=["mdr"], accuracy__rtol=1e-2)


def with_times(scene, count, last=2.0):
    """Return a scene with evenly spaced times."""
    return scene.changed(wear__times=np.linspace(0, last, count).tolist())


def within(seconds, call, *arguments):
    """Return the result of a call that takes at most so many processor seconds."""
    start = time.process_time()
    result = call(*arguments)
    assert time.process_time() - start < seconds
    return result


def planned_memory(scene):
    """Return the GiB that a plan predicts."""
    (line,) = [line for line in plan(scene) if line.startswith("memory: about ")]
    return float(line.split()[2])


def is_refused(scene, memory):
    """Return whether a plan within a memory is a refusal."""
    return plan(scene, memory)[0].startswith("refused: ")


def count_that_fits(error):
    """Return the number of times that a refusal says would fit."""
    text = str(error.value)
    return int(text.partition("give at most ")[2].partition(" of the ")[0])


@pytest.mark.slow
def test_a_million_times_are_refused_with_the_number_that_fits():
    limit = 8.0
    scene = with_times(FIVE, 1_000_000)
    with pytest.raises(SceneError, match="GiB are needed, and 8 are allowed") as error:
        run(scene, memory=limit)
    fitting = count_that_fits(error)
    assert "of the 1000000 times" in str(error.value)
    assert "['history', 'steady']" in str(error.value)
    # three fields at 321 radii need at least this
    assert fitting * 321 * 3 * 8 < limit * 2**30
    assert not is_refused(with_times(FIVE, fitting), limit)
    assert is_refused(with_times(FIVE, int(1.2 * fitting)), limit)
    # without fields the run fits
    assert not is_refused(scene.changed(output__quantities=["history", "steady"]), limit)


@pytest.mark.parametrize(
    ("count", "changes", "words"),
    [
        (1000, {"output__radii": np.linspace(0, 1, 1_000_000).tolist()}, "1000000 output.radii"),
        (1000, {"punch__rings": 100_000}, "give fewer punch.rings"),
        (100_000, {"wear__march": "implicit", "wear__step": 1e-3}, "of the 100000 times"),
    ],
    ids=["radii", "rings", "steps"],
)
def test_other_extremes_are_refused_at_once(count, changes, words):
    scene = with_times(FIVE, count).changed(**changes)
    (line,) = within(3, plan, scene, 8.0)
    assert line.startswith("refused: ")
    assert words in line
    with pytest.raises(SceneError) as error:
        run(scene, memory=8.0)
    assert line.removeprefix("refused: ") == str(error.value)


def test_commands_refuse_in_one_line_and_write_nothing(command, tmp_path):
    scene = with_times(FIVE, 20_000)
    table = pd.DataFrame({"time": np.linspace(0, 2, 20_000), "radius": 0.3, "pressure": 1.0})
    table.to_csv("theirs.csv", index=False)
    for call in ("run scene.toml --out out", "plan scene.toml", "check scene.toml theirs.csv"):
        (line,) = command(f"{call} --memory 0.5", 2, scene).err.splitlines()
        assert "GiB are needed, and 0.5 are allowed: give at most " in line
        assert "of the 20000 times" in line
    assert {path.name for path in tmp_path.iterdir()} == {"scene.toml", "theirs.csv"}


@pytest.mark.parametrize("memory", [0, -1, "8 GB"])
def test_a_memory_that_is_no_positive_number_is_refused(memory):
    with pytest.raises(SceneError, match="give GiB as a positive number"):
        run("flat_punch", memory=memory)


def test_a_march_with_too_many_times_is_refused_before_it_begins():
    """A contact problem is solved at each of 300 000 times."""
    scene = with_times(SPHERE, 300_000, 1.0).changed(output__quantities=["history"])
    with pytest.raises(SceneError, match="3e\\+05 steps are needed") as error:
        run(scene)
    assert "a contact problem is solved at each of wear.times" in str(error.value)


def million_rows(kind):
    """Return a table with a million rows, and as many different times."""
    count = 1_000_000
    table = pd.DataFrame({"time": np.linspace(0, 2, count)})
    if kind == "depths":
        return table.assign(indentation=1 + table["time"])
    # each time has its own radius, or one of five
    radii = (np.arange(count) * 0.618) % 0.99 if kind == "radii" else np.resize([0.1, 0.5], count)
    return table.assign(radius=radii, pressure=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["times", "radii", "depths"])
def test_a_table_of_a_million_times_is_refused_with_the_number_that_fits(kind):
    """The limit is far below what a million times need, and no array of that size is made."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(SceneError, match="of the 1000000 times") as error:
        check(FIVE, {"theirs": million_rows(kind)}, memory=2.0)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 2**20  # 1 GiB
    # at each time at least the numbers of the table, and our three fields at all radii
    numbers = {"times": 4 * 323, "radii": 4 * 1_000_321, "depths": 2}[kind]
    assert 0 < count_that_fits(error) * numbers * 8 < 2.0 * 2**30
    assert ("tables without fields" in str(error.value)) == (kind != "depths")


@pytest.mark.slow
def test_our_fields_are_left_out_of_a_check_that_does_not_need_them(caplog):
    depths = pd.DataFrame({"time": np.linspace(0, 2, 4000)})
    depths["indentation"] = run(with_times(FIVE, 4000)).dataset.indentation.values[0]
    with caplog.at_level("WARNING", logger="ringwear"):
        checked = check(FIVE, {"theirs": depths}, memory=0.3)
    assert "4000 times are too many for fields" in caplog.text
    assert "pressure" not in checked.result.dataset
    assert max(abs(row.error) for row in checked.rows) < 1e-10
    # fields are there if memory suffices
    assert "pressure" in check(FIVE, {"theirs": depths[:10]}).result.dataset


def test_a_check_computes_the_quantities_of_its_scene_and_of_its_tables():
    scene = FIVE.changed(output__quantities=["indentation"])
    table = pd.DataFrame({"time": [0.0], "radius": [0.5], "profile": [0.0]})
    checked = check(scene, {"theirs": table})
    assert {"indentation", "profile"} <= set(checked.result.dataset)
    assert "rms_slope" not in checked.result.dataset


@pytest.mark.slow
@pytest.mark.parametrize("scene", [FIVE, SPHERE], ids=["full", "moving"])
def test_fields_at_many_radii_are_computed_in_parts_and_are_the_same(scene):
    """Fields at 60 000 radii and 40 times have more than twice the numbers computed at once."""
    radii = np.arange(60_000) / 60_000
    whole, parts = (
        run(with_times(scene, 40).changed(output__radii=each.tolist())).dataset
        for each in (radii[::1000], radii)
    )
    for name, values in whole.items():
        if name.endswith("_error"):
            continue
        there = parts[name].sel(radius=whole.radius) if "radius" in values.dims else parts[name]
        scale = float(np.abs(values.where(np.isfinite(values))).max()) or 1.0
        np.testing.assert_allclose(there, values, rtol=1e-11, atol=1e-12 * scale)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the peak of the memory is read from /proc")
def test_the_predicted_memory_is_that_of_a_run(script):
    """The memory that each time adds is measured in two runs of their own processes."""
    code = (
        "import sys, numpy as np; from ringwear import Scene, run;"
        "scene = Scene.load('five_rings').changed(methods=['mdr', 'bem'], accuracy__rtol=1e-3,"
        "wear__times=np.linspace(0, 2, int(sys.argv[1])).tolist());"
        "result = run(scene); result.summary; result.field_comparisons;"
        "status = open('/proc/self/status').read();"
        "print(1024 * int(status.partition('VmHWM:')[2].split()[0]))"
    )
    counts = 3000, 12_000
    peaks = [float(script(code, str(count)).stdout.split()[-1]) for count in counts]
    measured = (peaks[1] - peaks[0]) / (counts[1] - counts[0])
    few, many = (
        planned_memory(with_times(FIVE, count).changed(methods=["mdr", "bem"])) for count in counts
    )
    predicted = (many - few) * 2**30 / (counts[1] - counts[0])
    assert 0.7 * measured < predicted < 2.5 * measured


CYCLES = 2000


def cycling(low, **changes):
    """Return five rings under a force that goes up and down in 2000 cycles."""
    times = np.linspace(0, 2, 2 * CYCLES + 1)
    values = np.where(np.arange(len(times)) % 2, low, 1.0) * 2.0
    force = {"times": times.tolist(), "values": values.tolist()}
    return FIVE.changed(load__normal_force=force, **changes)


@pytest.mark.parametrize("low", [0.99, 0.5, 0.0])
def test_a_plan_of_thousands_of_load_cycles_is_quick(low):
    """In full contact the run itself is quick; otherwise its steps are counted, not taken."""
    lines = within(3, plan, cycling(low))
    assert lines[-2].startswith("in all: about ")
    # a step ends at each of the 4000 changes of the load, and takes at least a millisecond
    if low < 0.99:
        predicted = float(lines[0].partition("pressures, about ")[2].split()[0])
        assert predicted > 2 * CYCLES * 1e-3


def test_speeds_that_go_up_and_down_are_quick_and_right():
    """Wear depends on the sliding distance only, under a constant force."""
    times = np.linspace(0, 2, 2 * CYCLES + 1)
    speeds = np.where(np.arange(len(times)) % 2, 0.0, 2.0)
    speed = {"times": times.tolist(), "values": speeds.tolist()}
    scene = FIVE.changed(load__sliding_speed=speed, wear__times=[0.0, 0.5, 2.0], wear__steady=False)
    exact = run(FIVE.changed(wear__times=[0.0, 0.5, 2.0]))
    result = within(6, run, scene)
    # the mean speed is 1, at the ends of cycles
    depths, exact_depths = (each.dataset.indentation for each in (result, exact))
    allowed = result.error("indentation") + exact.error("indentation")
    np.testing.assert_allclose(depths, exact_depths, rtol=allowed)
