"""The limit of many rings that Figs. 6 and 7 of the paper show."""

import numpy as np
import pytest

from ringwear import Rings, direct
from ringwear.studies.paper.theory import homogeneous, many_rings


def gradients_of(count, wear_ratios, width_ratio=1.0):
    """Return (2, M) normalised RMS gradients of alternating rings by direct integration."""
    rings = [Rings.alternating(count, width_ratio, ratio) for ratio in wear_ratios]
    pressures = np.stack(
        [np.pi * direct.steady_pressures(edges, wear) for edges, (wear, _) in rings], axis=1
    )
    edges = rings[0].ring_edges
    slopes = [direct.rms_slope(edges, pressures, average) for average in ("line", "area")]
    return np.array(slopes) / homogeneous()[:, None]


@pytest.mark.slow
def test_many_rings_approach_their_limit_from_both_sides():
    ratios = np.array([1e-4, 0.1, 10.0, 1e4])
    limit = many_rings(ratios, np.ones(1))
    np.testing.assert_allclose(limit, limit[:, ::-1], rtol=1e-14)
    extreme = many_rings(np.array([0.0, 1e16]), np.ones(1))
    np.testing.assert_allclose(extreme.T, [np.sqrt(1 + 4 / homogeneous() ** 2)] * 2)
    distances = np.array([gradients_of(count, ratios) - limit for count in (32, 64, 128, 256)])
    assert (distances[:, :, :2] < 0).all()
    assert (distances[:, :, 2:] > 0).all()
    assert (np.abs(distances[1:] / distances[:-1]) < 0.65).all()


@pytest.mark.slow
def test_many_rings_of_unequal_width():
    ratio = np.array([0.01])
    for width_ratio in (0.1, 10.0):
        limit = many_rings(ratio, np.array([width_ratio]))
        distances = [
            np.abs(gradients_of(count, ratio, width_ratio) / limit - 1) for count in (64, 128, 256)
        ]
        assert (np.diff(distances, axis=0) < 0).all()
        assert (distances[-1] < 0.02).all()
    # if one material covers nearly all of the face, the punch is homogeneous
    assert many_rings(ratio, np.array([1e9])) == pytest.approx(1.0, abs=1e-6)
