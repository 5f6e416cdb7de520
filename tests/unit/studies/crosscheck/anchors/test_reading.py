"""The second reading of a scene, by which anchors check the first."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from ringwear import Scene
from ringwear.studies.crosscheck.anchors.reading import Reading

TABLE = {"radii": [0.1, 0.3, 0.5, 0.5, 0.9], "values": [1.0, 1e-6, 2e-6, 0.5, 0.5]}


def punch(**keys):
    return Scene.from_table(
        {
            "punch": {"radius": 2.0, **keys},
            "half_space": {"plane_strain_modulus": 1.0},
            "load": {"normal_force": 1.0},
        }
    )


def test_means_and_extremes_of_a_table_of_wear_coefficients():
    table = TABLE | {"radii": [2 * radius for radius in TABLE["radii"]]}
    edges = [0.4, 0.5, 0.8, 1.0]
    scene = punch(inner_radius=0.1, ring_edges=[2 * e for e in edges], wear_coefficient=table)
    reading = Reading.of(scene)
    radii, values = TABLE["radii"], TABLE["values"]
    expected = [
        sum(
            quad(
                lambda r: 2 * np.pi * r / np.interp(r, radii, values), a, b, epsrel=1e-12, limit=500
            )[0]
            for a, b in pairwise(cuts)
        )
        for cuts in (
            [0.05, 0.1, 0.29, 0.299, 0.2999, 0.29999, 0.299999, 0.3, 0.4],
            [0.4, 0.5 - 1e-15],
            [0.5 + 1e-15, 0.8],
            [0.8, 0.9, 1.0],
        )
    ]
    np.testing.assert_allclose(reading.inverse_wear, expected, rtol=1e-9)
    least, greatest = reading.extremes_of_wear()
    np.testing.assert_allclose(least, [1e-6, 1.5e-6, 0.5, 0.5], rtol=1e-12)
    np.testing.assert_allclose(greatest, [1.0, 2e-6, 0.5, 0.5], rtol=1e-12)


def test_wear_by_rings_is_a_table_with_steps():
    reading = Reading.of(punch(ring_edges=[0.5, 1.5, 2.0], wear_coefficients=[1.0, 4.0]))
    areas = np.pi * np.array([0.25**2, 0.75**2 - 0.25**2, 1 - 0.75**2])
    np.testing.assert_allclose(reading.inverse_wear, areas * [4.0, 1.0, 4.0], rtol=1e-14)
    assert reading.wear_at(np.array([0.0, 0.2, 0.25, 0.7, 0.75, 1.0])).tolist() == [
        *(0.25, 0.25, 1.0, 1.0, 0.25, 0.25)
    ]
    for extreme in reading.extremes_of_wear():
        assert extreme.tolist() == [0.25, 1.0, 0.25]


def test_heights_of_functions_and_recesses():
    scene = punch(rings=2, wear_coefficients=[1.0, 1.0], recess=[0.0, 0.125])
    reading = Reading.of(scene.with_heights(lambda radii: 0.5 * radii, lambda radii: 0 * radii + 1))
    # heights are in units of F / (a E*)
    assert reading.unworn(np.array([0.25, 0.75])).tolist() == pytest.approx([2.5, 3.75])
