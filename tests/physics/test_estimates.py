"""Stated errors are honest: on scenes drawn at random, and where sizes are too coarse."""

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
from ringwear.studies.crosscheck.accuracy import solved_to_accuracy
from ringwear.studies.crosscheck.run import Result
from ringwear.studies.estimates import study
from ringwear.studies.estimates.scenes import random_scenes
from ringwear.studies.methods.pipeline import Discretised
from ringwear.studies.methods.mdr import Mdr
from ringwear.studies.problem.problem import Problem
from ringwear.studies.progress import Stages


def true_errors(result: Result, quantity: str = "indentation") -> dict[str, tuple[float, float]]:
    """Greatest (error, estimate) of a quantity by method, against the independent reference."""
    found = study.true_errors(result)
    return {
        name: (float(one[quantity][0].max()), float(one[quantity][1].max()))
        for name, one in found.items()
    }


@pytest.mark.slow
@pytest.mark.parametrize("mesher", [pytest.param("quads", marks=pytest.mark.gmsh), "bisection"])
def test_random_scenes(mesher: str) -> None:
    """The accuracy is reached, or said not to be.

    Estimates are seldom below the truth, and not far above.
    """
    rows = [
        row
        for scene in random_scenes(3, 20, most_rings=3, accuracy__fem={"mesher": mesher})
        for row in study.rows_of(scene)
        if "quantity" in row
    ]
    assert [row["remark"] for row in rows if row["remark"]] == []
    missed = [row for row in rows if row["verdict"] == "missed"]
    assert len(missed) <= 0.01 * len(rows), missed
    assert sum(row["below"] for row in rows) <= 0.015 * sum(row["values"] for row in rows)
    assert not any(row["below"] for row in rows if row["quantity"] == "indentation")
    # what triangles of low degree state is cautious
    for quantity in {row["quantity"] for row in rows} if mesher == "quads" else ():
        worth = [
            row["effectivity"]
            for row in rows
            if row["quantity"] == quantity and np.isfinite(row["effectivity"])
        ]
        # one factor for all: beside what converges fast, a degree less is far off
        assert len(worth) < 8 or np.median(worth) <= 100, quantity


@pytest.mark.slow
def test_study(tmp_path: Path) -> None:
    conclusions = study.conduct(Scene.load("five_rings"), tmp_path, Namespace(quick=True, seed=2))
    assert len(conclusions) == 2 + 2 * 14
    assert all("miss it; scenes with a false alarm: 0" in line for line in conclusions[:2])
    assert all(": 0 of " in line for line in conclusions[2:] if "indentation" in line)
    with (tmp_path / "estimates.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) >= 8 * 2 * 13
    assert (tmp_path / "estimates.png").exists()


@pytest.mark.parametrize(
    "fault",
    [
        {"accuracy__fem": {"far_field": "fixed", "truncation": 20.0}},
        {
            "accuracy__fem": {
                "rim_size": 0.1,
                "ring_size": 0.1,
                "growth": 2.0,
                "degree": 2,
                "mesher": "gmsh",
            }
        },
        {"accuracy__fem": {"poles": 1, "truncation": 2.0}},
    ],
    ids=["fixed boundary at 20 a", "coarse mesh", "one pole at 2 a"],
)
def test_coarse_settings_do_not_pass_for_agreement(fault: dict[str, object]) -> None:
    result = run(
        Scene.load("five_rings").changed(methods=["mdr", "fem"], accuracy__rtol=1e-3, **fault)
    )
    assert result.verdict != "agree"
    assert result.solutions["fem"].beyond(1e-3)


@pytest.mark.parametrize("march", ["implicit", "modal"])
def test_time_steps_are_estimated(march: str) -> None:
    wear = {"times": [0.01, 0.1, 0.5], "steady": True, "march": march} | (
        {"step": 0.01} if march == "implicit" else {}
    )
    result = run(Scene.load("five_rings").changed(methods=["mdr"], wear=wear))
    error, estimate = true_errors(result)["mdr"]
    # an indentation is not known better than to 1e-5 of the accuracy asked for
    assert error <= estimate <= 50 * error + 2e-9
    assert ("mdr" in result.short_of) == (march == "implicit")


def test_forces_add_up() -> None:
    dataset = run(Scene.load("five_rings").changed(methods=["mdr", "bem", "fem"])).dataset
    force = Scene.load("five_rings").load_.normal_force
    np.testing.assert_allclose(dataset.ring_force.sum("ring"), force, rtol=1e-12)
    # in the last state the slow rings carry almost what they do in the steady state
    slow = dataset.steady_pressure.max("radius") * ring_areas(np.linspace(0, 1, 6))[::2].sum()
    np.testing.assert_allclose(
        dataset.ring_force.isel(time=-1, ring=[0, 2, 4]).sum("ring"), slow, rtol=1e-2
    )


class Hopeful(Mdr):
    """An MDR whose sizes promise far more accuracy than they give."""

    def discretised(self, problem: Problem, stages: Stages, coarser: bool = True) -> Discretised:
        return super().discretised(
            replace(problem, rtol=min(0.1, 1e2 * problem.rtol)), stages, coarser
        )


def test_refined_until_the_accuracy_is_reached(caplog: pytest.LogCaptureFixture) -> None:
    """Sizes that are far too hopeful are noticed by the estimate, and made up for."""
    scene = Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-5)
    with caplog.at_level(logging.INFO, "ringwear"):
        (solution,) = solved_to_accuracy(Hopeful(), [scene.problem], Stages("mdr"))
    assert max(solution.greatest_error(name) for name in solution.errors) <= 1.5e-5
    for error, estimate in study.true_errors(replace(run(scene), solutions={"mdr": solution}))[
        "mdr"
    ].values():
        assert (error <= estimate).all()
    assert any("refined from rtol 1.0e-05" in note for note in solution.notes)
    assert "refining" in caplog.text


def test_sizes_of_the_user_are_not_refined() -> None:
    result = run(
        Scene.load("five_rings").changed(
            methods=["mdr"], accuracy__rtol=1e-6, accuracy__mdr={"ring_size": 0.1}
        )
    )
    assert result.solutions["mdr"].settings["ring_size"] == 0.1
    assert not result.notes
    coarse = {"ring_size": 0.1, "rim_size": 0.1, "degree": 2}
    result = run(
        Scene.load("five_rings").changed(methods=["mdr"], accuracy__rtol=1e-6, accuracy__mdr=coarse)
    )
    assert "mdr" in result.short_of
    assert not result.notes


@pytest.mark.slow
@pytest.mark.parametrize("poisson_ratio", [0.4999, 0.5])
def test_nothing_locks(poisson_ratio: float) -> None:
    """Unequal rings, near incompressibility: of degree 3 at ring edges, errors exceed the
    estimate.
    """
    punch = {
        "radius": 1.0,
        "ring_edges": [0.003, 0.08, 0.091, 0.816, 0.818, 1.0],
        "wear_coefficients": [240.0, 170.0, 0.0013, 18.0, 0.001, 1.0],
    }
    wear = {"times": [0.0, 0.0017, 0.0089, 0.042]}
    changes = {
        "methods": ["fem"],
        "half_space__poisson_ratio": poisson_ratio,
        "accuracy__rtol": 1e-4,
    }
    error, estimate = true_errors(
        run(Scene.load("five_rings").changed(punch=punch, wear=wear, **changes))
    )["fem"]
    assert error <= estimate <= 1e-4
