"""Greatest values in ranges of nearby times."""

import numpy as np

from ringwear.studies.crosscheck.methods.error_factors import error_factor
from ringwear.studies.crosscheck.methods.evaluation import greatest_in_ranges, range_near
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
