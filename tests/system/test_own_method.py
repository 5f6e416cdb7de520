"""A method of a user's own, in a script: it stands in results, figures and verdict as ours do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ringwear import Scene, run
from ringwear.meshes import Compliance, PressureSpace
from ringwear.studies.figures.catalogue import PICTURES
from ringwear.studies.methods.base import Discretised
from ringwear.studies.methods.pipeline import ComplianceMethod
from ringwear.studies.methods.spaces import pressure_spaces
from ringwear.studies.output.files import draw
from ringwear.studies.problem.problem import Problem
from ringwear.studies.progress import Stages
from ringwear.studies.report.words import Account


class Winkler(ComplianceMethod):
    """A foundation of springs that do not feel each other."""

    name = "winkler"

    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        fine, coarse = (self.springs(space) for space in pressure_spaces(problem))
        return Discretised(fine, lambda: coarse)

    @staticmethod
    def springs(space: PressureSpace) -> Compliance:
        """Return the compliance of springs that let the flat punch in as deep as a half-space."""
        stiffness = 2 / np.pi
        return Compliance(space, np.linalg.cholesky(space.mass().toarray()).T / stiffness**0.5)


@pytest.mark.parametrize("name", ["five_rings", "sphere"])
def test_a_method_of_ones_own(name: str, tmp_path: Path) -> None:
    result = run(Scene.load(name), methods=["mdr", Winkler()])
    dataset, summary = result.dataset, result.summary
    assert dataset.solver.values.tolist() == ["mdr", "winkler"]
    assert np.isfinite(dataset.indentation.sel(solver="winkler")).all()
    assert np.isfinite(dataset.indentation_error.sel(solver="winkler")).all()
    # springs are no half-space, and the verdict says so
    assert summary["verdict"] == "disagree"
    assert any("winkler" in line for line in summary["modelled"])
    assert "winkler" in str(Account(result).methods)
    assert not draw(result, PICTURES, tmp_path)
    assert (tmp_path / "history.png").exists()


def test_springs_wear_as_springs_do() -> None:
    """Under a flat punch each spring relaxes by itself: rings of one wear share the load evenly."""
    scene = Scene.load("flat_punch").changed(wear__times=[0.0, 1.0, 10.0], wear__steady=True)
    dataset = run(scene, methods=[Winkler()]).dataset.isel(solver=0)
    pressure = scene.problem.units.force / (np.pi * scene.punch.radius**2)
    np.testing.assert_allclose(dataset.pressure, pressure, rtol=1e-9)
    depth = dataset.indentation - dataset.steady_wear_rate * dataset.time
    np.testing.assert_allclose(depth, float(depth[0]), rtol=1e-9)
