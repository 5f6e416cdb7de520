"""Stated errors are honest: on scenes drawn at random, and where a fault was put in."""

from argparse import Namespace
from pathlib import Path

import numpy as np
import pytest
from ringwear.meshes.radial import ring_areas
from ringwear.studies import estimates
from ringwear.studies.crosscheck.run import Result, run
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.random_scenes import random_scenes

from ringwear import Scene


def true_errors(result: Result) -> dict[str, tuple[float, float]]:
    """(error, estimate) of the indentation by method, against a far finer MDR."""
    rows = [row for row in estimates.true_errors(result) if row["quantity"] == "indentation"]
    return {row["method"]: (row["error"], row["estimate"]) for row in rows}


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
    conclusions = estimates.conduct(Scene.load("five_rings"), tmp_path, Namespace(quick=True, seed=2), lambda _: None)
    assert len(conclusions) == 4
    assert all("above 1 for 0.0%" in line for line in conclusions if "indentation" in line)
    assert (tmp_path / "estimates.csv").read_text("utf-8").count("\n") == 1 + 8 * 4
    assert (tmp_path / "estimates.png").stat().st_size > 10_000


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


def test_a_wrong_operator_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    import ringwear.fem.half_space as module

    sound = module.exterior_stiffness
    monkeypatch.setattr(module, "exterior_stiffness", lambda *arguments: 3.0 * sound(*arguments))
    result = run(Scene.load("five_rings").changed(methods=["mdr", "fem"], accuracy__rtol=1e-3))
    assert not result.agrees


@pytest.mark.parametrize("march", ["implicit", "modal"])
def test_time_steps_are_estimated(march: str) -> None:
    wear = {"times": [0.01, 0.1, 0.5], "steady": True, "march": march} | ({"step": 0.01} if march == "implicit" else {})
    result = run(Scene.load("five_rings").changed(methods=["mdr"], wear=wear))
    error, estimate = true_errors(result)["mdr"]
    assert error <= estimate <= 50 * error
    assert ("mdr" in result.short_of) == (march == "implicit")


def test_forces_add_up() -> None:
    result = run(Scene.load("five_rings").changed(methods=["mdr", "bem", "fem"]))
    natural = result.scene.natural
    for outcome in result.outcomes.values():
        np.testing.assert_allclose(outcome.ring_force.sum(axis=1), 1.0, rtol=1e-12)
        steady = (outcome.steady_pressure.max() * ring_areas(natural.edges)[::2]).sum()
        assert steady == pytest.approx(outcome.ring_force[-1, ::2].sum(), rel=1e-2)


def test_refined_until_the_accuracy_is_reached(monkeypatch: pytest.MonkeyPatch) -> None:
    """A model of the error that is far too hopeful is found out by the estimate, and made up for."""
    import ringwear.studies.methods.radial as module

    sound = module.mdr_settings

    def hopeful(natural: NaturalScene) -> dict[str, float]:
        rtol = min(0.1, 1e4 * natural.scene.accuracy.rtol)
        return sound(natural.scene.changed(accuracy__rtol=rtol).natural)

    monkeypatch.setattr(module, "mdr_settings", hopeful)
    scene = Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-6)
    lines: list[str] = []
    result = run(scene, lines.append)
    error, estimate = true_errors(result)["mdr"]
    assert error <= estimate <= 1e-6
    assert not result.short_of
    assert any("refined from rtol 1.0e-06" in note for note in result.notes)
    assert any("refining" in line for line in lines)


def test_sizes_of_the_user_are_not_refined() -> None:
    result = run(Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-6, accuracy__mdr={"ring_size": 0.1}))
    assert result.models["mdr"].settings["ring_size"] == 0.1
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
