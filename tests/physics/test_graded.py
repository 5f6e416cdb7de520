"""Wear coefficients that vary along the radius, which are the limit of many rings."""

from itertools import pairwise

import numpy as np
import pytest
from closed_forms import GradedSteadyState
from groups import nightly, nightly_but, slow
from independent import true_errors
from natural import natural

from ringwear import SceneError, pressure_spaces, run
from ringwear.studies.crosscheck.sizes.shared import covering

SPHERE = {"profile": {"kind": "parabola", "curvature_radius": 1.0}}


def scene(methods="mdr", **punch):
    return natural(punch, [0.0, 0.001, 0.01, 0.1, 0.3, 1.0, 4.0, 5.0], 1e-4, methods)


def along(*values, radii=(0.0, 1.0)):
    return {"wear_coefficient": {"radii": list(radii), "values": list(values)}}


@pytest.mark.parametrize("shape", [{}, SPHERE])
def test_a_constant_table_equals_a_plain_number(shape):
    constant = {"rings": 1, "wear_coefficients": [3.0]}
    table, number = (run(scene(**punch, **shape)).dataset for punch in (along(3.0, 3.0), constant))
    for name in number.data_vars:
        np.testing.assert_allclose(table[name], number[name], rtol=1e-13, atol=1e-13)


def assert_estimates_bound_the_errors(result):
    for method, errors in true_errors(result).items():
        for quantity, (error, estimate) in errors.items():
            assert (error <= estimate).all(), (method, quantity)


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(
    "table",
    [
        along(1.0, 4.0),
        *nightly(along(1.0, 0.01), along(1.0, 2.0, 0.5, 1.0, radii=(0.3, 0.4, 0.4, 1))),
    ],
)
def test_methods_agree_and_estimates_bound_their_errors(table):
    result = run(scene("mdr fem bem", **table))
    assert result.verdict == "agree"
    assert_estimates_bound_the_errors(result)


@pytest.mark.slow
def test_estimates_bound_the_errors_at_an_edge_with_almost_no_kink():
    """An edge without layers of small elements has the same mesh in the coarser solution."""
    rings = {"ring_edges": [0.4, 0.95, 1.0], **along(1.0, 0.9)}
    result = run(scene(**rings).changed(accuracy__rtol=1e-6, wear={"times": [1e-4, 1e-3]}))
    assert not result.notes
    assert_estimates_bound_the_errors(result)


@pytest.mark.parametrize(("last", "shape"), [(4.0, {}), (0.1, {}), *slow((4.0, SPHERE))])
def test_steady_pressure_is_the_wear_rate_over_the_coefficient(last, shape):
    result = run(scene("mdr fem", rings=2, **along(1.0, last), **shape))
    table, slope = result.dataset, last - 1
    # F / int 1/k dA
    rate = slope / (2 * np.pi * (1 - np.log(last) / slope))
    np.testing.assert_allclose(table["steady_wear_rate"], rate, rtol=1e-9)
    for pressures in table["steady_pressure"]:
        np.testing.assert_allclose(pressures, rate / (1 + slope * table["radius"]), rtol=1e-5)
    # `wear_coefficient` has the harmonic means over the area of each ring
    forces = rate * np.pi * np.array([0.25, 0.75]) / table["wear_coefficient"]
    np.testing.assert_allclose(table["force_share"][0, 1], forces, rtol=1e-6)
    # from t = 4 to 5, the indentation grows at the steady wear rate
    np.testing.assert_allclose(table["indentation"].diff("time")[:, -1], rate, rtol=1e-4)


def test_methods_for_constant_coefficients_accept_tables_of_steps():
    for method in ("direct", "mdr-grid"):
        with pytest.raises(SceneError, match="many rings"):
            run(scene(method, **along(1.0, 2.0)))
        run(scene(method, **along(1.0, 2.0, radii=(0.5, 0.5))))


def test_scenes_that_share_a_discretisation_resolve_steep_wear_as_well_as_alone():
    steep = scene(**along(1e-3, 1.0)).changed(accuracy__rtol=1e-2)
    problems = [steep.changed(wear__times=[0.0, time]).problem for time in (1.0, 2.0)]
    shared = pressure_spaces(covering(problems))[0]
    for problem in problems:
        alone = pressure_spaces(problem)[0]
        assert shared.size >= alone.size
        assert shared.degrees.min() >= alone.degrees.min()


# the others take several seconds each, and all but four are for the night
SLOW = ("a conical point", "a thousandfold slope", "from the rim", "hollow")
STEEP = {
    "a conical point": ([0.0, 1.0], [0.9, 1.0], 3e-7),
    "a finer conical point": ([0.0, 1.0], [0.958473, 1.0], 1e-7),
    "a thousandfold slope": ([0.0, 1.0], [1e-3, 1.0], 1e-2),
    "from the rim": ([0.0, 1.0], [1.0, 1e-4], 1e-5),
    "hardly any wear at the axis": ([0.0, 1.0], [1e-8, 1.0], 1e-2),
    "eight decades": ([0.0, 0.4, 0.7, 1.0], [1.0, 1e-8, 1e-2, 1e-5], 1e-4),
    "a narrow ramp": ([0.0, 0.5, 0.50001, 1.0], [1.0, 1.0, 0.01, 0.01], 1e-3),
    "a ramp almost to a step": ([0.0, 0.75, 0.75036, 1.0], [1.0, 1.0, 1e-4, 1e-4], 1e-4),
    "a narrow dip": ([0.0, 0.73, 0.7315, 0.7316, 1.0], [1.0, 1.0, 2e-4, 1.0, 1.0], 5e-4),
    "a bump": ([0.0, 0.36, 0.39, 0.393, 1.0], [9e-3, 9e-3, 1.0, 9e-3, 9e-3], 2e-3),
    "a kink": ([0.0, 0.12, 1.0], [4e-4, 1.0, 0.024], 4e-6),
    "hollow": ([0.3, 0.31, 1.0], [1e-4, 1.0, 0.1], 1e-3),
}


@pytest.mark.gmsh
@pytest.mark.slow
@pytest.mark.parametrize("name", nightly_but(SLOW, STEEP))
def test_steady_states_of_steep_wear_in_closed_form(name):
    """The RMS slope was 30 times too large by finite elements, and the verdict could be wrong."""
    radii, values, rtol = STEEP[name]
    exact = GradedSteadyState(np.array(radii), np.array(values))
    shown = np.unique([radii[0] + 1e-6, radii[np.argmin(values)] - 1e-6, 0.35, 0.6, 0.9])
    shown = shown[shown > radii[0]]
    given = scene("mdr fem", **along(*values, radii=radii), inner_radius=radii[0]).changed(
        accuracy__rtol=rtol, wear__times=[0.0, 0.01, 1.0], output__radii=shown.tolist()
    )
    result = run(given)
    assert result.verdict == "agree"
    table = result.dataset
    depth = table["steady_displacement_max"].values
    pairs = {
        "steady_wear_rate": (table["steady_wear_rate"], exact.wear_rate),
        "steady_rms_slope": (table["steady_rms_slope"], exact.rms_slope()),
        "pressure_max": (table["pressure_max"][:, 1, 0], exact.wear_rate / min(values)),
        "steady_profile": ((depth[:, None] - table["steady_profile"]), exact.displacement(shown)),
    }
    for quantity, (value, reference) in pairs.items():
        scale = exact.displacement(shown).max() if quantity == "steady_profile" else reference
        errors = np.abs(np.asarray(value) - reference) / scale
        for method, error in zip(table["solver"].values, errors, strict=True):
            stated = np.nanmax(result.solutions[method].errors[quantity])
            assert error.max() <= max(rtol, stated), (quantity, method)


@pytest.mark.parametrize("further", [[], ["steady_displacement_max"], ["steady_profile"]])
def test_anchors_need_no_steady_state_that_is_not_asked_for(further):
    quantities = ["indentation", *further]
    given = scene("mdr", **along(1.0, 0.1)).changed(output__quantities=quantities)
    result = run(given.changed(accuracy__rtol=1e-2))
    assert result.anchors
    assert result.verdict != "disagree"


def test_half_of_a_force_that_decays_is_checked_without_a_steady_state():
    held = scene("mdr", **along(1.0, 0.1)).changed(load={"indentation": 0.1})
    result = run(held.changed(accuracy__rtol=1e-2))
    names = {anchor.name for anchor in result.anchors}
    assert "time_to_half_force: remaining part of the running-in" in names


def test_steps_of_a_table_need_not_be_ring_edges():
    """Such a table gives the results of rings; once the steady states disagreed."""
    one, two = (
        run(scene("mdr bem", **punch))
        for punch in (
            along(1.0, 1.0, 5.0, 5.0, radii=(0.0, 0.5, 0.5, 1.0)),
            {"ring_edges": [0.5, 1.0], "wear_coefficients": [1.0, 5.0]},
        )
    )
    assert one.verdict == two.verdict == "agree"
    np.testing.assert_allclose(one.dataset.indentation, two.dataset.indentation, rtol=1e-7)


def test_weak_kinks_of_a_table_get_no_layers():
    """Very weak kinks get no layers of small elements; once, 300 points took 5,000 pressures."""
    radii = np.linspace(0, 1, 300)
    wear = 1 + np.sin(7 * radii) ** 2
    many, few = (
        scene(**along(*wear[::step].tolist(), radii=radii[::step].tolist())).problem.merged
        for step in (1, 23)
    )
    assert (many.kinks[:-1] < 0.1).all()
    assert (few.kinks[:-1] > 0.1).any()
    assert all(a < b for a, b in pairwise(many.ring_edges))
