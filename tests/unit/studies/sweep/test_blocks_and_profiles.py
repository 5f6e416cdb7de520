"""Blocks of the scenes of a sweep, and the profiles that it reads from files."""

import numpy as np
import pytest

from ringwear import Scene
from ringwear.studies.sweep.axes import Sweep
from ringwear.studies.sweep.results import Store


@pytest.mark.parametrize(
    ("ratios", "more", "shape"),
    [
        # the scenes of a geometry together
        (150, {"punch.rings": [2, 3, 4]}, [64, 1]),
        # many scenes to a file where there are many
        (1000, {"punch.width_ratio": {"linspace": [0.5, 2.0, 61]}}, [448, 1]),
    ],
    ids=["few", "many"],
)
def test_blocks_cover_the_grid(tmp_path, ratios, more, shape):
    """Each scene is in one block."""
    axes = {"punch.wear_ratio": {"geomspace": [0.1, 9.0, ratios]}} | more
    plan = Sweep.of({"base": "five_rings", "keep": ["steady_rms_slope"], "axes": axes})
    blocks = Store(plan, tmp_path, resume=False).unfinished(retry_failed=False)
    assert list(blocks[0].sizes.values()) == shape
    seen = [tuple(changes.values()) for block in blocks.values() for changes in block.changes()]
    assert len(seen) == len(set(seen)) == plan.count


def test_a_profile_is_read_once(tmp_path, monkeypatch):
    """An edit after the start of the sweep has no effect on any scene."""
    monkeypatch.chdir(tmp_path)
    np.savetxt("profile.csv", [[0.0, 0.0], [1.0, 0.5]], delimiter=",")
    base = Scene.load("flat_punch").table()
    base["punch"]["profile"] = {"kind": "table", "file": "profile.csv"}
    axes = {"load.normal_force": [1.0, 2.0]}
    plan = Sweep.of({"base": base, "axes": axes, "keep": ["indentation"]})
    before = plan.problem(next(plan.changes())).profile.sampled()[1]
    np.savetxt("profile.csv", [[0.0, 0.0], [1.0, 0.9]], delimiter=",")
    after = plan.problem(next(plan.changes())).profile.sampled()[1]
    np.testing.assert_array_equal(before, after)
