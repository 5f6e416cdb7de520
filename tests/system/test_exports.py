"""Exports of other programs: files without times, files of steps, and forces on a part."""

import numpy as np
import pandas as pd
import pytest
from flat_export import PRESSURE, SCENE, R

from ringwear import SceneError, check


def test_files_without_times_have_those_that_are_given(tmp_path):
    paths = []
    for number, size in enumerate((1.0, 1.2, 1.3), 1):
        paths.append(tmp_path / f"out_cp_000{number}.csv")
        pd.DataFrame({"x": R, "CPRESS": PRESSURE, "disp_y": -size}).to_csv(paths[-1], index=False)
    with pytest.raises(SceneError, match="--time T if all rows are of one time"):
        check(SCENE, paths[0])
    assert check(SCENE, paths[0], times=[0.0]).passes
    times = [0.0, 1e-12, 2e-12]
    found = check(SCENE, paths, times=times).errors
    assert len(found.solver.unique()) == 1
    errors = found[found.quantity == "displacement"].sort_values("time").error
    assert errors.tolist() == pytest.approx([0.0, 0.2, 0.3], abs=1e-4)
    # the files are at the times of the scene if there are as many
    of_scene = check(SCENE.changed(wear__times=times), paths).errors
    pd.testing.assert_frame_equal(of_scene, found)
    with pytest.raises(SceneError, match="2 times and 3 results: give one time for each file"):
        check(SCENE, paths, times=[0.0, 1.0])


@pytest.mark.parametrize(
    ("part", "words"),
    [(180, "wedge of 2 degrees"), (360, "wedge of 1 degree"), (2 * np.pi, "radian")],
)
def test_forces_on_a_part_of_the_circumference_are_named(part, words):
    table = {"time": [0.0], "indentation": [1.0], "normal_force": [2.0 / part]}
    assert any(words in each.words for each in check(SCENE, table).mistakes()[:1])
