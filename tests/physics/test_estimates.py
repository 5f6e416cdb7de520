"""Stated errors are honest: on scenes drawn at random, and where sizes are too coarse."""

import logging
from collections import Counter, defaultdict
from dataclasses import replace

import numpy as np
import pytest
from wear_reference import random_scenes, true_errors

from ringwear import Scene, run
from ringwear.meshes.radial import ring_areas
from ringwear.studies.crosscheck.accuracy import solved_to_accuracy
from ringwear.studies.methods.mdr import Mdr
from ringwear.studies.progress import Stages

FIVE = Scene.load("five_rings")


@pytest.mark.slow
@pytest.mark.parametrize("mesher", [pytest.param("quads", marks=pytest.mark.gmsh), "bisection"])
def test_random_scenes(mesher, pytestconfig):
    """No verdict is wrong, and the accuracy is reached, or said not to be.

    Estimates are seldom below the truth, and not far above. Prints the tables of the README.
    """
    seed, count, rings = (pytestconfig.getoption(name) for name in ("seed", "scenes", "rings"))
    verdicts, values, below, missed = Counter[str](), Counter[str](), Counter[str](), 0
    effectivities = defaultdict[str, list[float]](list)
    for scene in random_scenes(seed, count, rings, accuracy__fem={"mesher": mesher}):
        result = run(scene)
        verdicts[result.verdict] += 1
        for name in ("mdr", "fem"):
            for quantity, (error, estimate) in true_errors(result)[name].items():
                values[quantity] += len(error)
                below[quantity] += int(np.sum(error > estimate))
                missed += bool(
                    ((error > scene.accuracy.rtol) & (estimate <= scene.accuracy.rtol)).any()
                )
                counted = error > 3e-13  # above roundoff
                if counted.any():
                    effectivities[quantity].append(
                        float(np.median(estimate[counted] / error[counted]))
                    )
    print(f"\n{dict(verdicts)}")
    for quantity, ratios in effectivities.items():
        told = f"{below[quantity]} of {values[quantity]} errors above their estimate"
        print(f"{quantity}: {told}, estimate over error {np.median(ratios):.1f}")
    assert not verdicts["disagree"]
    assert below.total() <= 0.015 * values.total()
    assert not below["indentation"]
    assert missed <= 0.01 * 2 * count * len(values)
    # one factor for all: beside what converges fast, a degree less is far off; what triangles of
    # low degree state is cautious
    for quantity, ratios in effectivities.items() if mesher == "quads" else ():
        assert len(ratios) < 8 or np.median(ratios) <= 100, quantity


@pytest.mark.parametrize(
    "settings",
    [
        {"far_field": "fixed", "truncation": 20.0},
        {"rim_size": 0.1, "ring_size": 0.1, "growth": 2.0, "degree": 2, "mesher": "gmsh"},
        {"poles": 1, "truncation": 2.0},
    ],
    ids=["fixed boundary at 20 a", "coarse mesh", "one pole at 2 a"],
)
def test_coarse_settings_do_not_pass_for_agreement(settings):
    scene = FIVE.changed(methods=["mdr", "fem"], accuracy={"rtol": 1e-3, "fem": settings})
    result = run(scene)
    assert result.verdict != "agree"
    assert "fem" in result.short_of


@pytest.mark.parametrize("march", ["implicit", "modal"])
def test_time_steps_are_estimated(march):
    step = {"step": 0.01} if march == "implicit" else {}
    wear = {"times": [0.01, 0.1, 0.5], "steady": True, "march": march} | step
    result = run(FIVE.changed(methods=["mdr"], wear=wear))
    error, estimate = (values.max() for values in true_errors(result)["mdr"]["indentation"])
    # an indentation is not known better than to 1e-5 of the accuracy asked for
    assert error <= estimate <= 50 * error + 2e-9
    assert ("mdr" in result.short_of) == (march == "implicit")


def test_forces_add_up():
    dataset = run(FIVE.changed(methods=["mdr", "bem", "fem"])).dataset
    np.testing.assert_allclose(dataset.ring_force.sum("ring"), FIVE.load_.normal_force, rtol=1e-12)
    # in the last state the slow rings carry almost what they do in the steady state
    slow = dataset.steady_pressure.max("radius") * ring_areas(np.linspace(0, 1, 6))[::2].sum()
    last = dataset.ring_force.isel(time=-1, ring=[0, 2, 4]).sum("ring")
    np.testing.assert_allclose(last, slow, rtol=1e-2)


class Hopeful(Mdr):
    """An MDR whose sizes promise far more accuracy than they give."""

    def discretise(self, problem, stages):
        hopeful = replace(problem, rtol=min(0.1, 1e2 * problem.rtol))
        return super().discretise(hopeful, stages)


def test_refined_until_the_accuracy_is_reached(caplog):
    """Sizes that are far too hopeful are noticed by the estimate, and made up for."""
    scene = FIVE.changed(methods=["mdr"], accuracy__rtol=1e-5)
    with caplog.at_level(logging.INFO, "ringwear"):
        (solution,) = solved_to_accuracy(Hopeful(), [scene.problem], Stages("mdr"))
    errors = true_errors(replace(run(scene), solutions={"mdr": solution}))["mdr"]
    for error, estimate in errors.values():
        assert (error <= estimate).all()
        assert (estimate <= 1.5e-5).all()
    assert any("refined" in note for note in solution.notes)
    assert "refining" in caplog.text


def test_sizes_of_the_user_are_not_refined():
    for sizes in ({"ring_size": 0.1}, {"ring_size": 0.1, "rim_size": 0.1, "degree": 2}):
        result = run(FIVE.changed(methods=["mdr"], accuracy={"rtol": 1e-6, "mdr": sizes}))
        assert result.solutions["mdr"].settings["ring_size"] == 0.1
        assert not result.notes
    assert "mdr" in result.short_of


@pytest.mark.slow
@pytest.mark.parametrize("poisson_ratio", [0.4999, 0.5])
def test_nothing_locks(poisson_ratio):
    """Unequal rings, near incompressibility: of degree 3 at ring edges, errors exceed the
    estimate.
    """
    scene = FIVE.changed(
        methods=["fem"],
        punch={
            "radius": 1.0,
            "ring_edges": [0.003, 0.08, 0.091, 0.816, 0.818, 1.0],
            "wear_coefficients": [240.0, 170.0, 0.0013, 18.0, 0.001, 1.0],
        },
        half_space__poisson_ratio=poisson_ratio,
        wear={"times": [0.0, 0.0017, 0.0089, 0.042]},
        accuracy__rtol=1e-4,
    )
    error, estimate = (values.max() for values in true_errors(run(scene))["fem"]["indentation"])
    assert error <= estimate <= 1e-4
