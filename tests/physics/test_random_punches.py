"""Random punches: methods agree on nearly all of them, within a limited time."""

import time

import numpy as np
import pytest
from random_punches import KINDS, random_punch

from ringwear import run

# upper limit for one punch on an idle machine
MOST_SECONDS = 30


def decide(seed):
    """Return results of a random punch, and the seconds of processor time."""
    began = time.process_time()
    result = run(random_punch(seed))
    if result.verdict == "agree":
        # only quantities without a promise may be undecided
        undecided = {row.quantity for row in result.agreement if not row.agrees}
        assert undecided <= {row.quantity for row in result.left_out_of_promise}
        assert not undecided & {"indentation", "normal_force", "relaxation_time"}
    return result, time.process_time() - began


@pytest.mark.nightly
def test_at_most_one_of_12_punches_is_undecided():
    """Two punches of each kind; results for forty are in studies/crosscheck/verdict/README.md."""
    runs = [decide(seed) for seed in range(10, 10 + 2 * len(KINDS))]
    verdicts = [result.verdict for result, _ in runs]
    assert "disagree" not in verdicts
    assert verdicts.count("undecided") <= 1
    assert np.max([seconds for _, seconds in runs]) < MOST_SECONDS


def test_the_greatest_change_between_two_long_steps_counts():
    """The rate of the indentation changes its sign: anchors hold although no step ends there."""
    result = run(random_punch(1008), methods=["mdr"])
    remaining = [anchor for anchor in result.anchors if "remaining part" in anchor.name]
    assert len(remaining) == 2
    assert all(anchor.holds for anchor in result.anchors)


def test_a_table_with_a_tip_at_the_axis_has_no_mean_slope():
    """The average along the radius diverges; no warning about numbers is an error of this test."""
    slopes = run(random_punch(2026), methods=["mdr"]).dataset.rms_slope
    # all of the face is worn at the last time
    assert np.isfinite(slopes.values[0]).tolist() == [False, False, False, False, True]


@pytest.mark.slow
@pytest.mark.gmsh
def test_estimates_of_contact_radii_include_the_cell_at_the_edge():
    """A part of the contact has just opened; both meshes of a method have the edge in one cell."""
    result, _ = decide(24)
    assert result.verdict == "agree"
    radii, errors = (result.dataset[name] for name in ("contact_radius", "contact_radius_error"))
    differ = np.abs(np.diff(radii, axis=0)[0])
    assert differ.max() > 2e-3
    assert (differ <= errors.sum("solver").to_numpy()).all()
