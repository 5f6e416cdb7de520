"""A method of the user in a script has results, figures and a verdict like any other."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ringwear import (
    Compliance,
    ComplianceMethod,
    Discretised,
    Method,
    Scene,
    load,
    method,
    pressure_spaces,
    run,
)


class Winkler(ComplianceMethod):
    """A foundation of independent springs."""

    name = "winkler"

    def discretise(self, problem, stages):
        fine, coarse = (self.springs(space) for space in pressure_spaces(problem))
        return Discretised(fine, lambda: coarse)

    @staticmethod
    def springs(space):
        """Return the compliance of springs that a flat punch indents like a half-space."""
        stiffness = 2 / np.pi
        return Compliance(space, np.linalg.cholesky(space.mass().toarray()).T / stiffness**0.5)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["five_rings", "sphere"])
def test_own_method(name, tmp_path):
    result = run(Scene.load(name).changed(accuracy__rtol=1e-2), methods=["mdr", Winkler()])
    winkler = result.dataset.sel(solver="winkler")
    assert np.isfinite(winkler.indentation).all()
    assert np.isfinite(winkler.indentation_error).all()
    # springs are no half-space, so the methods disagree
    assert result.verdict == "disagree"
    lines = result.remarks
    disagree = [row for row in result.agreement if row.verdict == "disagree"]
    assert disagree
    for row in disagree:
        text = f"mdr and winkler differ by {row.difference:.1e}; rtol and their error estimates"
        assert any(
            line.startswith(f"disagree: {row.quantity}") and text in line for line in lines
        ), row.quantity
    assert any("winkler" in line for line in result.summary["modelled"])
    assert {*result.summary["methods"]} == {"mdr", "winkler"}
    result.save(tmp_path)
    assert (tmp_path / "history.png").exists()


class WithoutEstimate(Method):
    """Dimensionality reduction whose indentation has no error estimate."""

    name = "without"

    def solve(self, problem, stages):
        solution = method("mdr").solve(problem, stages)
        errors = {key: error for key, error in solution.errors.items() if key != "indentation"}
        return replace(solution, errors=errors)


@pytest.mark.slow
def test_results_of_a_method_without_an_error_estimate_are_saved(tmp_path):
    scene = Scene.load("flat_punch").changed(accuracy__rtol=1e-2)
    result = run(scene, methods=["mdr", WithoutEstimate()])
    assert result.verdict == "undecided"
    (row,) = [row for row in result.agreement if row.quantity == "indentation"]
    assert row.uncertainty == np.inf
    assert "no error estimate" in row.remark
    result.save(tmp_path)
    assert repr(load(tmp_path)) == repr(result)


def test_springs_relax_independently():
    """Under a flat punch rings of one wear coefficient therefore share the load evenly."""
    scene = Scene.load("flat_punch").changed(wear__times=[0.0, 1.0, 10.0])
    dataset = run(scene, methods=[Winkler()]).dataset.isel(solver=0)
    pressure = scene.problem.units.force / (np.pi * scene.punch.radius**2)
    np.testing.assert_allclose(dataset.pressure, pressure, rtol=1e-9)
    depth = dataset.indentation - dataset.steady_wear_rate * dataset.time
    np.testing.assert_allclose(depth, float(depth[0]), rtol=1e-9)


def test_a_method_of_a_file_is_run_from_the_command_line(command):
    Path("mine.py").write_text(
        "from ringwear import method\n"
        "class Mine(type(method('mdr'))):\n"
        "    name = 'mine'\n"
        "number = 1\n"
    )
    line = "run flat_punch --rtol 1e-2 --no-figures --out out --methods mdr,mine.py"
    command(f"{line}:Mine")
    assert load("out").dataset.solver.values.tolist() == ["mdr", "mine"]
    assert "is not a method" in command(f"{line}:number", 2).err
