"""Random scenes: methods against an independent solution, which is tested first, or each other."""

import numpy as np
import pytest
from groups import nightly, nightly_but
from independent import CONSTANT, solved
from natural import natural
from random_layers import random_layers
from random_punches import random_punch
from random_scenes import KINDS, draw, hold
from test_hollow import random_hollow

from ringwear import Scene, differences, run

FIVE = Scene.load("five_rings")


@pytest.mark.slow
def test_the_independent_solution_against_the_stored_history(reference):
    """The history of the five rings agrees with the stored one, which is accurate to 1e-10."""
    times = [state["time"] for state in reference["states"]]
    scene = FIVE.changed(wear__times=[0.0, *times], output__radii=reference["radii"])
    problem = scene.problem
    results, _, punch = solved(problem, 1e-6)
    units = problem.units
    slowest = results["relaxation_time"][:3] * units.time
    assert slowest == pytest.approx(reference["slowest_relaxation_times"], rel=1e-9)
    for name, unit, rtol, first in (
        ("indentation", units.displacement, 3e-10, 0),
        ("displacement_centre", units.displacement, 1e-9, 0),
        ("rms_slope", units.slope, 1e-5, 3),
    ):
        known = [state.get(name, state.get("rms_slope_line")) for state in reference["states"]]
        assert results[name][1 + first :] * unit == pytest.approx(known[first:], rel=rtol), name
    pressures = punch.pressures(CONSTANT, problem.times[1:])
    worn = punch.worn(results["indentation"][1:], pressures)
    of_pressures, of_heights, _ = punch.fields(np.array(reference["radii"]))
    fields = {"pressure": pressures @ of_pressures.T, "profile": worn @ of_heights.T}
    for name, values in fields.items():
        known = [state[name] for state in reference["states"][3:]]
        unit = units.pressure if name == "pressure" else units.displacement
        np.testing.assert_allclose(values[3:] * unit, known, rtol=2e-6)
    assert punch.least_pressure(pressures) > 0


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("kind", nightly_but(("flat", "graded", "load", "held"), KINDS))
def test_every_number_beyond_rtol_is_reported(kind, random_seed):
    """A method may overestimate its errors and be undecided."""
    row = hold(draw(kind, 7, random_seed), "mdr", "fem")
    assert not row.silent
    assert not row.first
    assert row.verdict in ("agree", "undecided")


SLOPES, FIELDS = {"rms_slope", "steady_rms_slope"}, {"rms_slope", "pressure"}
LATER, THIRDS = [0.0, 0.01, 0.1, 0.5, 2.0], [1 / 3, 2 / 3, 1]
TWELVE = np.cumsum(np.tile([2, 1], 6) / 18).round(15).tolist()
RUBBER = {"plane_strain_modulus": 1.0, "poisson_ratio": 0.5}
HELD = {"load": {"indentation": 0.3, "sliding_speed": 1.0}}
JUMP = {"times": [0.0, 0.5, 0.5 + 1e-9], "values": [0.2, 0.2, 1.0]}
SIX = [0.1077, 0.233, 0.52, 0.7571, 0.9116, 1], [0.996, 0.609, 1, 0.887, 0.531, 0.671]
RAMP = {"radii": [0.0, 0.74956, 0.74992, 1.0], "values": [1.0, 1.0, 1e-4, 1e-4]}
# ring edges, wear coefficients, times, rtol, what need not be promised, and other parts of a scene
EXTREMES = {
    "a narrow ring on the axis": ([1e-8, 1], [1e-3, 1], [0.0, 0.01, 1.0], 1e-4, SLOPES),
    "a narrow ring": ([0.5, 0.501, 1], [1, 10], LATER, 1e-3, ()),
    "a rim that hardly wears": ([0.5, 1], [1e4, 1], LATER, 1e-3, ()),
    "a rim that wears fast": ([0.99, 1], [1, 10], LATER, 1e-3, ()),
    "layers thinner than roundoff": (THIRDS, [1, 0.5], [1e-11, 0.1], 1e-4, ()),
    "layers of a slow ring": ([0.42, 1], [1, 3e-6], [5e-5, 1e-3], 1e-5, ()),
    "roundoff of early wear": ([0.02, 1], [1, 6e4], [1.5e-11, 1e-9, 1e-8], 1e-5, ()),
    "rings that never wear": (np.arange(0.2, 1.1, 0.2).tolist(), [1, 1e-12], [1e-6], 1e-3, FIELDS),
    "incompressible": ([1], [1, 1], [1e-10, 0.1], 1e-6, FIELDS, {"half_space": RUBBER}),
    "one late time": (TWELVE, [1, 0.01], [50.0], 1e-4, ()),
    "a jump of the force": (
        *(THIRDS, [1, 0.1], [0.5 + 1e-5], 1e-5, ()),
        {"load": {"normal_force": JUMP, "sliding_speed": 1.0}},
    ),
    # elements overlapped in a small part of the mesh, and pressures there were 20 % off
    "a steep ramp": (
        *([1], None, [0.0, 6.8e-5, 2.4e-3], 4e-5, ()),
        {"punch": {"radius": 1.0, "wear_coefficient": RAMP}},
    ),
    "held, late": (*SIX, [0.66, 16.3], 1e-6, (), HELD),
    "held, worn evenly": ([1], [1, 1], [0.1, 172.75], 1e-7, (), HELD),
    "held, hardly worn": ([0.42, 1], [1, 3.6e-6], [5e-5, 5e-4, 1.5e-3], 2e-5, (), HELD),
}


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("name", nightly_but([*EXTREMES][::2], EXTREMES))
def test_numbers_at_extremes_are_right_or_left_out(name):
    edges, wear, times, rtol, left_out, *more = EXTREMES[name]
    tables = {"punch": {"ring_edges": edges, "wear_coefficients": wear}} | dict(*more)
    row = hold(natural(tables.pop("punch"), times, rtol, **tables), "mdr", "fem")
    assert not row.silent
    assert row.excluded.keys() <= {*left_out}
    assert row.verdict == ("undecided" if left_out is SLOPES else "agree")


FAMILIES = {
    "hollow": random_hollow,
    "layers": random_layers,
    "punches": random_punch,
    "layers, shaped": lambda seed: random_layers(seed, shaped=True, rtol=1e-3),
}


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("family", FAMILIES)
def test_methods_differ_by_at_most_their_estimates(family, random_seed):
    """Where a stiff layer bends away from a flat punch, contact moves and may be undecided."""
    result = run(FAMILIES[family](random_seed))
    assert result.verdict != "disagree"
    assert result.verdict == "agree" or family == "hollow" or not result.scene.problem.full_contact
    assert not [row for row in result.agreement if row.difference > row.uncertainty]


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("number", [5, *nightly(13)])
def test_early_layers_under_a_full_face_are_resolved(number):
    """Under loads that vary, fields at early times were up to 400 rtol off, and not promised."""
    row = hold(draw("load", 7, number), "mdr", "fem")
    assert row.verdict == "agree"
    assert not row.excluded
    assert not row.beyond


def test_thin_layers_are_the_reason_if_no_edge_of_the_contact_moves():
    """Fields of a gentle sphere, all of which is in contact at once, are left out."""
    punch = {
        "ring_edges": [0.3, 0.6, 0.8, 1.0],
        "wear_coefficients": [1.0, 0.1, 1.0, 0.3],
        "profile": {"kind": "parabola", "curvature_radius": 1000.0},
    }
    left_out = run(natural(punch, [1e-5, 1e-4], methods="mdr")).left_out_of_promise
    assert {row.quantity for row in left_out} == {"pressure", "rms_slope"}
    assert all("layers that wear has made" in row.reason for row in left_out)


@pytest.mark.slow
def test_layers_where_the_rim_loses_contact_under_a_falling_force():
    """Steps resolve the slopes of thin layers, and estimates compare pressures at equal radii.

    The RMS slope was 132 rtol off where 0.5 was stated, because few steps in time suffice for the
    worn depth. Pressures were right, but 458 rtol were stated.
    """
    scene = draw("load", 8, 39)
    rtol, problem = scene.accuracy.rtol, scene.problem
    solution, finer = (
        run(each, methods=["mdr"]).solutions["mdr"]
        for each in (scene, scene.changed(accuracy__rtol=rtol / 30))
    )
    assert finer.evolution.path[:, 3].min() < 1
    errors = differences(solution.compared, finer.compared, problem.face)
    for name in ("pressure", "rms_slope", "profile"):
        stated = solution.errors[name]
        assert (errors[name] <= stated).all()
        assert (stated <= 3 * rtol).all()


def test_the_face_resolves_layers_beside_rings_that_hardly_wear():
    """The RMS slope was right, but an anchor computed it on a face that missed the layers."""
    scene = draw("load", 9, 9)
    result = run(scene, methods=["mdr"])
    (anchor,) = [each for each in result.anchors if each.name == "RMS slope of the profile"]
    assert anchor.difference < scene.accuracy.rtol
    assert result.verdict != "disagree"


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize("quantities", [["rms_slope"], ["rms_slope", "indentation"], ["history"]])
def test_slopes_of_hardly_worn_rings_do_not_depend_on_what_is_asked(quantities):
    """Modes whose relaxation times are near roundoff made slopes up to three times too large."""
    rings = {"rings": 3, "wear_coefficients": [1.0, 1e-10]}
    methods = "mdr" if "history" in quantities else "mdr fem"
    given = natural(rings, [0.01, 1.0], 1e-3, methods, output={"quantities": quantities})
    exact, _, _ = solved(given.problem, 1e-3)
    for solution in run(given).solutions.values():
        wrong = np.abs(solution.compared["rms_slope"] / exact["rms_slope"] - 1)
        assert (wrong <= 1e-3).all()
        assert (solution.errors["rms_slope"] <= 1e-3).all()
