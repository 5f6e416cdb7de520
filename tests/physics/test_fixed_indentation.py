"""Punches at a fixed indentation: the force decays, and wear ends."""

from functools import cache

import numpy as np
import pytest
from closed_forms import FrettedSphere
from groups import nightly, slow
from independent import CONSTANT, Pieces, Punch

from ringwear import (
    Scene,
    run,
)

# slowest relaxation time of one ring, and a late time, at which an error of TAU by 1e-4 changes the
# force by 9e-4
TAU, LATE = 1.7275, 8.7 * 1.7275
TIMES = [0.0, 1e-3, 0.1, 1.0, LATE]


def scene_of(name="flat_punch", **changes):
    # not in natural units: the force is 2 a E* d = 2 at the start
    scene = Scene.load(name).changed(load={"indentation": 1.0}, wear={"times": TIMES})
    return scene.changed(methods=["mdr", "fem"], **changes)


@pytest.fixture(scope="module", params=["flat_punch", *slow("five_rings")])
def result(request):
    return run(scene_of(request.param))


@cache
def pressed(problem):
    """Return an independent punch whose indentation is fixed."""
    pieces = Pieces.of(problem)
    smallest = np.append(np.inf, np.full(len(pieces.inner), 1e-9))
    return Punch(pieces, smallest, 14, fixed_indentation=True)


def force_at(problem, times):
    """Return the slowest relaxation time and the force (T,) at times > 0, independently."""
    punch = pressed(problem)
    return punch.times[0], punch.pressures(CONSTANT, times) @ punch.weights


def test_the_answer_reports_forces_and_the_time_to_half_force(result):
    problem, answers = result.scene.problem, result.answers["mdr"]
    slowest, _ = force_at(problem, problem.times[1:])
    unit = problem.units.time
    assert answers["force_start"] == pytest.approx(problem.units.force, rel=1e-7)
    last = float(result.dataset.normal_force[0, -1])
    assert answers["force_end"] == pytest.approx(last, rel=1e-14)
    assert answers["running_in_time"] == pytest.approx(slowest * unit, rel=1e-8)
    half = np.array([float(answers["time_to_half_force"]) / unit])
    assert force_at(problem, half)[1] == pytest.approx([0.5], rel=1e-6)
    assert np.isnan(answers["time_to_90"])


@pytest.mark.gmsh
def test_wear_ends_when_the_whole_overlap_is_worn_off(result):
    assert result.verdict == "agree"
    scene = result.scene.changed(wear__times=[1e3 * result.scene.problem.units.time * TAU])
    end = run(scene, methods=["mdr"]).dataset
    assert end.ring_worn_volume.sum() == pytest.approx(np.pi, rel=1e-12)
    # the roundoff of the modes is 3e-12
    assert end.profile.values == pytest.approx(1.0, rel=1e-11)
    assert "steady state" in result.summary["left_out"]


@pytest.mark.parametrize("march", ["implicit", "explicit"])
def test_time_steps_at_a_fixed_indentation_are_of_first_order(march):
    exact = run(scene_of(), methods=["mdr"]).dataset.normal_force.values[0, 3]
    wrong = []
    for step in (2e-3, 1e-3):
        scene = scene_of(accuracy__rtol=1e-2, accuracy__mdr={"degree": 1, "rim_size": 0.05})
        scene = scene.changed(wear={"times": [1.0], "march": march, "step": step})
        coarse = scene.changed(wear={"times": [1.0]})
        forces = [run(each, methods=["mdr"]).dataset.normal_force[0, 0] for each in (scene, coarse)]
        assert forces[1] == pytest.approx(exact, rel=1e-2)
        wrong.append(float(forces[0] - forces[1]))
    # first order: half the step, half the error
    assert wrong[0] / wrong[1] == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("name", ["flat_punch", "sphere"])
def test_the_force_is_constant_during_a_stop(name):
    """The speed falls to zero and rises again; two output times lie within the stop."""
    speed = {"times": [0.0, 0.5, 0.6, 1.0, 1.1], "values": [1.0, 1.0, 0.0, 0.0, 1.0]}
    scene = Scene.load(name).changed(
        methods=["mdr"],
        load={"indentation": 0.1, "sliding_speed": speed},
        wear={"times": [0.0, 0.3, 0.7, 0.9, 2.0]},
        accuracy__rtol=1e-3,
    )
    result = run(scene)
    assert result.verdict != "disagree"
    forces = result.dataset.normal_force[0].values
    assert forces[2] == pytest.approx(forces[3], rel=1e-12)
    assert (np.diff(forces)[[0, 1, 3]] < 0).all()


def fixed_sphere(depth, edges, wear, times, rtol):
    """Return a scene of a sphere with curvature radius 1 at a fixed indentation."""
    return Scene.load("sphere").changed(
        methods=["mdr", "fem"],
        punch={"radius": 1.0, "ring_edges": edges, "wear_coefficients": wear},
        punch__profile={"kind": "parabola", "curvature_radius": 1.0},
        load={"indentation": depth},
        wear={"times": times},
        accuracy__rtol=rtol,
    )


@pytest.mark.slow
@pytest.mark.parametrize(("stick", "rtol"), [*nightly((0.3, 3e-4)), (0.5, 1e-4)])
def test_a_stick_zone_leads_to_popovs_limiting_shape(stick, rtol):
    """Outside the stick zone the face wears until it no longer presses."""
    scene = fixed_sphere(0.4, [stick, 1.0], [1e-9, 1.0], [0.0, 30.0], rtol)
    exact = FrettedSphere(1.0, 0.4, stick)
    table = run(scene).dataset.isel(time=1)
    wrong_force = np.abs(table.normal_force / exact.force - 1)
    assert (wrong_force <= table.normal_force_error).all()
    assert wrong_force.max() < 0.2 * rtol
    wrong = np.abs(table.profile - exact.heights(table.radius.values)).max("radius") / 0.4
    assert (wrong <= table.profile_error).all()
    assert wrong.max() < 2e-3
    # nothing has worn inside the stick zone
    assert table.ring_worn_volume[:, 0].max() < 1e-7


@pytest.mark.parametrize(
    ("depth", "rtol", "overlap", "tolerance"),
    [
        (0.8, 1e-2, np.pi * (0.8 - 0.25), 1e-12),
        *slow((0.2, 1e-4, np.pi * 0.2**2, 2e-5)),
    ],
    ids=["of all of the face", "of a part"],
)
def test_full_slip_wears_off_the_whole_overlap(depth, rtol, overlap, tolerance):
    """If the whole face is within d, the overlap is ``pi a^2 d`` minus the profile's volume."""
    scene = fixed_sphere(depth, [0.3, 0.6, 1.0], [1.0, 0.2, 0.5], [0.0, 1e4], rtol)
    worn = run(scene).dataset.ring_worn_volume.isel(time=1).sum("ring")
    np.testing.assert_allclose(worn, overlap, rtol=tolerance)
