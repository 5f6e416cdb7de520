"""Wear coefficients along the radius: the limit of many rings."""

import numpy as np
import pytest

from ringwear import Scene, run
from ringwear.mdr import energy
from ringwear.meshes.errors import SceneError
from ringwear.studies.methods.norms import differences
from ringwear.studies.methods.spaces import pressure_spaces
from ringwear.studies.wear.full_contact import RunningIn

SPHERE = {"profile": {"kind": "parabola", "curvature_radius": 1.0}}


def scene(methods=("mdr",), times=(0.0, 0.001, 0.01, 0.1, 0.3, 1.0), output=None, **punch):
    return Scene.from_table(
        {
            "methods": list(methods),
            "punch": {"radius": 1.0, **punch},
            "half_space": {"plane_strain_modulus": 1.0},
            "load": {"normal_force": 1.0},
            "wear": {"times": list(times)},
            "output": output or {},
        }
    )


def along(radii, values):
    return {"wear_coefficient": {"radii": radii, "values": values}}


def wear_rate(first, last):
    """``F / int dA / k`` of a coefficient that is linear from the centre to the rim."""
    slope = last - first
    return slope / (2 * np.pi * (1 - first / slope * np.log(last / first)))


@pytest.mark.parametrize("shape", [{}, SPHERE])
def test_a_constant_table_is_the_plain_number(shape):
    table, number = (
        run(scene(**punch, **shape)).solutions["mdr"].results
        for punch in (along([0.0, 1.0], [3.0, 3.0]), {"rings": 1, "wear_coefficients": [3.0]})
    )
    for name, values in number.items():
        np.testing.assert_allclose(table[name], values, rtol=1e-13, atol=1e-13)


def test_a_slope_of_zero_is_a_constant():
    problem = scene(rings=3, wear_coefficients=[1.0, 0.2, 0.5]).problem
    compliance, wear = energy.compliance(pressure_spaces(problem)[0]), problem.wear_coefficients
    linear, constant = (
        RunningIn(compliance, coefficients).modal(problem.times)
        for coefficients in (np.array([wear, wear]), wear)
    )
    weights = compliance.space.weights
    np.testing.assert_allclose(linear.indentation, constant.indentation, rtol=1e-13)
    np.testing.assert_allclose(linear.profile @ weights, constant.profile @ weights, atol=1e-13)


def test_many_rings_tend_to_it_at_second_order():
    output, counts, errors = (
        {"quantities": ["indentation", "relaxation_time"]},
        2 ** np.arange(1, 8, 2),
        [],
    )
    graded = run(scene(output=output, **along([0.0, 1.0], [1.0, 4.0]))).dataset
    for count in counts:
        edges = np.arange(count + 1) / count
        means = 1 + 1.5 * (edges[1:] + edges[:-1])
        rings = {"ring_edges": edges[1:].tolist(), "wear_coefficients": means.tolist()}
        table = run(scene(output=output, **rings)).dataset
        depth = np.abs(table["indentation"] / graded["indentation"] - 1).max()
        slowest = (table["relaxation_time"] / graded["relaxation_time"])[0, 0]
        errors.append([float(depth), abs(float(slowest) - 1)])
    orders = np.diff(np.log(errors), axis=0) / -np.diff(np.log(counts))[:, None]
    assert (np.abs(orders[1:] - 2) < 0.15).all()
    assert (np.array(errors[-1]) < [1e-5, 3e-5]).all()


@pytest.mark.parametrize(
    ("radii", "values"),
    [([0.0, 1.0], [1.0, 4.0]), ([0.0, 1.0], [1.0, 0.01]), ([0.3, 0.4, 0.4, 1.0], [1, 2, 0.5, 1])],
)
def test_methods_agree_and_errors_stated_are_above_the_true_ones(radii, values):
    given = scene(("mdr", "fem", "bem"), **along(radii, values))
    result = run(given)
    assert result.summary["verdict"] == "agree"
    assert all(anchor.holds for anchor in result.anchors)
    assert {"power", "worn volume over k"} <= {row.name.split(",")[0] for row in result.anchors}
    finer = run(given.changed(accuracy__rtol=1e-7), methods=["bem"]).solutions["bem"].checked
    for solution in result.solutions.values():
        for name, error in differences(solution.checked, finer, given.problem.face).items():
            error, stated = np.atleast_1d(error)[:3], np.atleast_1d(solution.errors[name])[:3]
            assert (error <= stated).all(), name


@pytest.mark.parametrize("ends", [(1.0, 4.0), (1.0, 0.01)])
def test_steady_pressure_is_the_wear_rate_over_the_coefficient(ends):
    table = run(scene(("mdr", "fem"), (), rings=2, **along([0.0, 1.0], list(ends)))).dataset
    rate, k = wear_rate(*ends), ends[0] + (ends[1] - ends[0]) * table["radius"].values
    np.testing.assert_allclose(table["steady_wear_rate"], rate, rtol=1e-9)
    np.testing.assert_allclose(table["steady_pressure"], np.tile(rate / k, (2, 1)), rtol=1e-5)
    # coefficients of rings are harmonic means, by which the rings share the force
    forces = rate * np.pi * np.array([0.25, 0.75]) / table["wear_coefficient"]
    np.testing.assert_allclose(table["force_share"].sel(state="steady")[0], forces, rtol=1e-6)


def test_a_sphere_wears_down_to_the_same_rate():
    punch = along([0.0, 0.4, 0.4, 1.0], [2.0, 2.0, 1.0, 4.0])
    result = run(scene(("mdr", "fem"), [0.0, 0.1, 4.0, 5.0], **punch, **SPHERE))
    assert result.summary["verdict"] != "disagree"
    assert all(anchor.holds for anchor in result.anchors)
    rates = result.dataset["indentation"].diff("time").values[:, -1]
    np.testing.assert_allclose(rates, result.dataset["steady_wear_rate"], rtol=1e-6)


@pytest.mark.parametrize(
    ("punch", "remedy"),
    [
        (along([0.0, 1.0], [1.0]), "give a value for each of radii"),
        (along([0.5, 0.4], [1.0, 2.0]), "that do not decrease"),
        (along([0.0, 2.0], [1.0, 2.0]), "from 0 to 1.0"),
        (along([0.0, 1.0], [1.0, 0.0]), r"wear_coefficient.values.1 = 0.0.*positive"),
        (along([0.0, 1.0], [1.0, 2.0]) | {"wear_ratio": 2.0}, "give either wear_coefficients"),
    ],
)
def test_tables_that_make_no_sense_are_refused(punch, remedy):
    with pytest.raises(SceneError, match=remedy):
        scene(**punch)


@pytest.mark.parametrize("method", ["direct", "mdr-grid"])
def test_methods_that_know_constants_refuse_it(method):
    with pytest.raises(SceneError, match="many rings"):
        run(scene([method], **along([0.0, 1.0], [1.0, 2.0])))
    run(scene([method], **along([0.5, 0.5], [1.0, 2.0])))
