"""Greatest values in ranges of nearby times, and the times at which something presses."""

import numpy as np

from ringwear import Scene
from ringwear.studies.crosscheck.methods.error_factors import error_factor
from ringwear.studies.crosscheck.methods.evaluation import greatest_in_ranges, range_near
from ringwear.studies.crosscheck.methods.inside.interior import first_and_last_in_contact
from ringwear.studies.crosscheck.problem.loading import Loading


def test_ranges_of_nearby_times_are_those_of_all_pairs():
    generator = np.random.default_rng(1)
    times, others = (np.sort(np.append(0.0, 10 ** generator.uniform(-6, 6, n))) for n in (50, 80))
    values = generator.random(len(others))
    factor = error_factor("nearby times")
    near = (others >= times[:, None] / factor) & (others <= times[:, None] * factor)
    expected = np.where(near, values, 0.0).max(axis=1)
    earliest, latest = range_near(times, Loading())
    first, last = others.searchsorted(earliest), others.searchsorted(latest, side="right")
    np.testing.assert_array_equal(greatest_in_ranges(values, first, last), expected)


def test_fields_are_shown_at_times_at_which_something_presses():
    """The brake presses from 0 on and until 14.5 s, at which its force is 0."""
    brake = Scene.load("duty_cycle")
    assert first_and_last_in_contact(brake) == [0.1, 14.25]
    assert first_and_last_in_contact(Scene.load("sphere").changed(wear__times=[1.0, 2.0])) == [0, 2]
    released = brake.changed(wear__times=[0.0, 5.0])
    # nothing presses at any of the times
    assert first_and_last_in_contact(released) == [0.0, 5.0]
