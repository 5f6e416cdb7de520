"""Stated errors are honest: on scenes drawn at random, and where a fault was put in."""

from __future__ import annotations

import csv
import logging
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ringwear import Scene, run
from ringwear.meshes.radial import ring_areas
from ringwear.studies import estimates
from ringwear.studies.crosscheck.run import Result, solved_to_accuracy
from ringwear.studies.estimates import random_scenes
from ringwear.studies.methods.by_compliance import Discretised
from ringwear.studies.methods.mdr import Mdr
from ringwear.studies.problem.problem import Problem
from ringwear.studies.progress import Stages


def true_errors(result: Result) -> dict[str, tuple[float, float]]:
    """(error, estimate) of the indentation by method, against a far finer MDR."""
    return {name: errors["indentation"] for name, errors in estimates.true_errors(result).items()}


@pytest.mark.slow
def test_random_scenes() -> None:
    ratios, reached, alarms = [], [], []
    for scene in random_scenes(3, 40):
        result = run(scene)
        alarms.append(not result.agrees)
        for error, estimate in true_errors(result).values():
            ratios.append(error / estimate)
            reached.append(error <= scene.accuracy.rtol)
    share = np.mean([(0.05 <= ratio <= 1.0) for ratio in ratios])
    print(f"estimate honest in {share:.1%}, rtol reached in {np.mean(reached):.1%}, {sum(alarms)} alarms")
    assert share >= 0.95
    assert np.mean([ratio <= 1.0 for ratio in ratios]) >= 0.98
    assert np.mean(reached) >= 0.98
    assert not any(alarms)


def test_study(tmp_path: Path) -> None:
    conclusions = estimates.conduct(Scene.load("five_rings"), tmp_path, Namespace(quick=True, seed=2))
    assert len(conclusions) == 4
    assert all("above 1 for 0.0%" in line for line in conclusions if "indentation" in line)
    with (tmp_path / "estimates.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 8 * 4
    assert (tmp_path / "estimates.png").exists()


@pytest.mark.parametrize(
    "fault",
    [
        {"accuracy__fem": {"far_field": "fixed", "truncation": 20.0}},
        {"accuracy__fem": {"rim_size": 0.1, "ring_size": 0.1, "growth": 2.0, "degree": 2, "mesher": "gmsh"}},
        {"accuracy__fem": {"poles": 1, "truncation": 2.0}},
    ],
    ids=["fixed boundary at 20 a", "coarse mesh", "one pole at 2 a"],
)
def test_faults_are_caught(fault: dict[str, object]) -> None:
    result = run(Scene.load("five_rings").changed(methods=["mdr", "fem"], accuracy__rtol=1e-3, **fault))
    assert not result.agrees or result.short_of


@pytest.mark.parametrize("march", ["implicit", "modal"])
def test_time_steps_are_estimated(march: str) -> None:
    wear = {"times": [0.01, 0.1, 0.5], "steady": True, "march": march} | ({"step": 0.01} if march == "implicit" else {})
    result = run(Scene.load("five_rings").changed(methods=["mdr"], wear=wear))
    error, estimate = true_errors(result)["mdr"]
    assert error <= estimate <= 50 * error
    assert ("mdr" in result.short_of) == (march == "implicit")


def test_forces_add_up() -> None:
    dataset = run(Scene.load("five_rings").changed(methods=["mdr", "bem", "fem"])).dataset
    force = Scene.load("five_rings").load_.normal_force
    np.testing.assert_allclose(dataset.ring_force.sum("ring"), force, rtol=1e-12)
    # in the last state the slow rings carry almost what they do in the steady state
    slow = dataset.steady_pressure.max("radius") * ring_areas(np.linspace(0, 1, 6))[::2].sum()
    np.testing.assert_allclose(dataset.ring_force.isel(time=-1, ring=[0, 2, 4]).sum("ring"), slow, rtol=1e-2)


class Hopeful(Mdr):
    """An MDR whose sizes promise far more accuracy than they give."""

    def discretised(self, problem: Problem, stages: Stages, pairs: bool = True) -> Discretised:
        return super().discretised(replace(problem, rtol=min(0.1, 1e4 * problem.rtol)), stages, pairs)


def test_refined_until_the_accuracy_is_reached(caplog: pytest.LogCaptureFixture) -> None:
    """Sizes that are far too hopeful are noticed by the estimate, and made up for."""
    scene = Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-6)
    with caplog.at_level(logging.INFO, "ringwear"):
        solution = solved_to_accuracy(Hopeful(), scene.problem, Stages("mdr"))
    error, estimate = true_errors(replace(run(scene), solutions={"mdr": solution}))["mdr"]
    assert error <= estimate <= 1e-6
    assert any("refined from rtol 1.0e-06" in note for note in solution.notes)
    assert "refining" in caplog.text


def test_sizes_of_the_user_are_not_refined() -> None:
    result = run(Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-6, accuracy__mdr={"ring_size": 0.1}))
    assert result.solutions["mdr"].settings["ring_size"] == 0.1
    assert not result.notes
    coarse = {"ring_size": 0.1, "rim_size": 0.1, "degree": 2}
    result = run(Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-6, accuracy__mdr=coarse))
    assert "mdr" in result.short_of
    assert not result.notes


@pytest.mark.parametrize("poisson_ratio", [0.4999, 0.5])
def test_nothing_locks(poisson_ratio: float) -> None:
    """Unequal rings, near incompressibility: of degree 3 at ring edges, errors exceed the estimate."""
    punch = {
        "radius": 1.0,
        "ring_edges": [0.003, 0.08, 0.091, 0.816, 0.818, 1.0],
        "wear_coefficients": [240.0, 170.0, 0.0013, 18.0, 0.001, 1.0],
    }
    wear = {"times": [0.0, 0.0017, 0.0089, 0.042]}
    changes = {"methods": ["fem"], "half_space__poisson_ratio": poisson_ratio, "accuracy__rtol": 1e-6}
    error, estimate = true_errors(run(Scene.load("five_rings").changed(punch=punch, wear=wear, **changes)))["fem"]
    assert error <= estimate <= 1e-6
