"""Differences of two reports along the radius: their norms, their places, and what is left out."""

import numpy as np
import pytest
from two_reports import RADII, SCENE, TIMES, differing, report

from ringwear import Scene
from ringwear.studies.crosscheck.methods.sampling.field_differences import compare_fields


def compared(other, reference=None, names=("mdr", "fem"), scene=SCENE):
    with np.errstate(all="raise"):
        return compare_fields(scene.problem, names, reference or report(), other)


def field(comparison, quantity):
    (difference,) = [each for each in comparison.fields if each.quantity == quantity]
    return difference


def test_a_known_difference_of_pressure_is_found_at_its_time_and_radius():
    difference = field(compared(differing("pressure", 2, 70, 0.03 * 3e5)), "pressure")
    assert difference.largest == (2, 70)
    assert difference.radii[70] == pytest.approx(0.0035)
    assert difference.relative[2, 70] == pytest.approx(0.03)
    # root of the fraction of the area within half a spacing of that radius
    share = (0.705**2 - 0.695**2) * 0.03**2
    np.testing.assert_allclose(difference.norms, [0, 0, np.sqrt(share), 0], rtol=1e-12)
    np.testing.assert_array_equal(difference.first_error, 1e-6)


def test_differences_of_the_unworn_pressure_are_weighted_as_in_its_norm():
    # where p = p0 / sqrt(1 - r^2/a^2), the weighted pressure is p0 everywhere
    start = 1 / np.sqrt((1 - RADII[:-1] / 0.005) * (1 + RADII[:-1] / 0.005))
    pressure = report()["pressure"].copy()
    pressure[0] = [*start, np.inf]
    other = pressure.copy()
    other[0, 60] *= 1.02
    difference = field(compared(report(pressure=other), report(pressure=pressure)), "pressure")
    assert difference.largest == (0, 60)
    assert difference.relative[0, 60] == pytest.approx(0.02)
    # both pressures are infinite at the rim
    assert np.isnan(difference.relative[0, -1])
    assert np.isfinite(difference.relative[1:]).all()


def test_a_full_punch_has_no_hole_inside_the_first_radius():
    radii = np.array([0.3, 0.5, 0.9])
    np.testing.assert_allclose(SCENE.problem.sampled_face(radii).edge_weights, 1 - radii**2)
    hollow = Scene.load("washer").problem.sampled_face(np.array([0.7, 0.8]))
    assert hollow.edge_weights[1] == pytest.approx((1 - 0.8**2) * (1 - 0.6 / 0.8))


def test_heights_are_relative_to_the_greatest_indentation_so_far():
    difference = field(compared(differing("profile", 1, 5, 4e-6)), "profile")
    # the indentation was 2e-4 before it came back to 1e-4
    assert difference.relative[1, 5] == pytest.approx(0.02)
    assert difference.norms[1] == pytest.approx(0.02)


def test_times_without_pressure_do_not_divide_by_zero():
    pressure = report()["pressure"].copy()
    pressure[[0, 3]] = 0.0
    rest = pressure.copy()
    rest[3] = 1e-14
    difference = field(compared(report(pressure=rest), report(pressure=pressure)), "pressure")
    assert np.isfinite(difference.relative).all()
    assert difference.relative.max() < 1e-9
    zero = np.zeros_like(pressure)
    names = [each.quantity for each in compared(report(), report(pressure=zero)).fields]
    assert names == ["profile", "displacement"]


def test_missing_values_are_left_out():
    sparse = report()["pressure"] * 1.01
    sparse[:, 1::2] = np.nan
    sparse[0] = np.nan
    other = report(pressure=sparse)
    del other["pressure_error"], other["profile"]
    comparison = compared(other)
    difference = field(comparison, "pressure")
    assert difference.times.tolist() == TIMES[1:]
    np.testing.assert_allclose(difference.radii, RADII[::2])
    np.testing.assert_allclose(difference.norms, 0.01, rtol=1e-10)
    assert np.isnan(difference.second_error).all()
    assert [each.quantity for each in comparison.fields] == ["pressure", "displacement"]


def test_other_radii_are_interpolated_and_other_times_left_out():
    linear = report(profile=np.tile(1e-3 * RADII, (len(TIMES), 1)))
    radii = np.linspace(0.0, 0.004, 7)
    other = report(
        time=np.array([1e3, 5e3, 3e5]), radius=radii, profile=np.tile(1e-3 * radii, (3, 1))
    )
    other = {name: other[name] for name in ("time", "radius", "profile")}
    comparison = compared(other, linear)
    difference = field(comparison, "profile")
    assert comparison.interpolated
    assert difference.times.tolist() == [1e3, 3e5]
    assert difference.radii[-1] == pytest.approx(0.004)
    assert difference.relative.max() < 1e-12


def test_common_times_of_two_reports_are_those_of_all_pairs():
    generator, radii = np.random.default_rng(2), np.linspace(0, 1, 5)
    times = np.sort(generator.choice(1000, 300, replace=False)) / 7.0
    others = np.sort(generator.choice(1000, 300, replace=False)) / 7.0 * (1 + 3e-10)
    first, second = (
        {"time": each, "radius": radii, "indentation": np.ones(len(each)),
         "profile": np.outer(each, np.ones(5))}
        for each in (times, others)
    )  # fmt: skip
    (field,) = compare_fields(Scene.load("five_rings").problem, ("A", "B"), first, second).fields
    same = np.isclose(times[:, None], others, rtol=1e-9, atol=0).any(axis=1)
    np.testing.assert_array_equal(field.times, times[same])
    assert field.relative.max() < 1e-6
