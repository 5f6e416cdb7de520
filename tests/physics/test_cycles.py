"""A force or a speed over time that is repeated in cycles."""

import numpy as np
import pytest

from ringwear import Scene, SceneError, run

# a force that falls to zero while the punch stands still
FORCE = {"times": [0.0, 1.0, 1.2, 2.0, 2.2], "values": [5.0, 5.0, 0.0, 0.0, 5.0]}
SPEED = {"times": [0.0, 1.1, 1.3, 1.9, 2.2], "values": [1.0, 1.0, 0.0, 0.0, 1.0]}
RINGS = {"radius": 1.0, "rings": 2, "wear_coefficients": [1e-2, 3e-2]}
BALL = {"wear_coefficient": 1e-3, "profile": {"kind": "ball", "ball_radius": 4.0}}


def scene(count, punch=RINGS, times="each cycle", force=FORCE, speed=SPEED):
    load = {"normal_force": force, "sliding_speed": speed}
    return Scene.from_table(
        {
            "methods": ["mdr"],
            "punch": punch,
            "half_space": {"plane_strain_modulus": 100.0},
            "load": load | ({"repeat": count} if count else {}),
            "wear": {"times": times},
            "accuracy": {"rtol": 1e-2},
        }
    )


def in_full(curve, count):
    """Return a curve with the knots of all cycles, which follow one another."""
    times, values = np.array(curve["times"]), curve["values"]
    later = np.add.outer(2.2 * np.arange(1, count), times[1:]).ravel().tolist()
    return {"times": curve["times"] + later, "values": values + values[1:] * (count - 1)}


@pytest.mark.parametrize("punch", [pytest.param(RINGS, marks=pytest.mark.slow), BALL])
def test_twenty_cycles_are_those_that_are_written_in_full(punch):
    repeated = scene(20, punch)
    ends = repeated.wear.times
    np.testing.assert_allclose(ends, 2.2 * np.arange(21))
    written = scene(None, punch, ends, in_full(FORCE, 20), in_full(SPEED, 20))
    ours, theirs = run(repeated), run(written)
    assert ours.verdict != "disagree"
    for name in ("indentation", "ring_worn_volume", "pressure", "profile"):
        scale = float(np.abs(theirs.dataset[name]).max())
        np.testing.assert_allclose(
            ours.dataset[name], theirs.dataset[name], rtol=0, atol=1e-8 * scale
        )
    # the worn volumes over k are the work of the load: 20 times the same
    volumes = ours.dataset.ring_worn_volume[0] / np.array(repeated.punch.coefficients)
    np.testing.assert_allclose(np.diff(volumes.sum("ring")), float(volumes[1].sum()), rtol=1e-5)


def test_cycles_are_kept_in_the_table_of_the_scene():
    own = scene(3)
    assert own.table()["wear"]["times"] == "each cycle"
    assert Scene.from_toml(own.to_toml()).problem.times == pytest.approx(own.problem.times)
    assert len(own.changed(load__repeat=7).wear.times) == 8
    constant_first = {"times": [0.5, 1.0, 2.2], "values": [5.0, 1.0, 5.0]}
    loading = scene(2, force=constant_first, speed=1.0).problem.loading
    force = loading.at(np.array([0.2, 1.0, 2.2, 2.5, 3.2, 4.4]) / scene(2).problem.units.time)
    assert force.force == pytest.approx(np.array([5, 1, 5, 5, 1, 5]) / 5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"force": 5.0, "speed": 1.0}, "repeat needs a cycle"),
        ({"force": {"times": [0.0, 1.0], "values": [5.0, 0.0]}, "speed": 1.0}, "must end with"),
        ({"force": {"times": [0.0, 1.0, 3.0], "values": [5.0, 0.0, 5.0]}}, "up to the same time"),
        ({"count": None, "force": 5.0, "speed": 1.0}, "'each cycle' needs a cycle"),
        ({"count": 0.5}, "load.repeat"),
    ],
)
def test_impossible_cycles_are_refused(changes, words):
    with pytest.raises(SceneError, match=words):
        scene(**{"count": 2} | changes)
