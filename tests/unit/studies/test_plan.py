"""The plan: sizes are those of the run, and what does not fit is refused before it starts."""

from __future__ import annotations

import re

import numpy as np
import pytest

from ringwear import Scene, plan
from ringwear.studies.crosscheck.plan import coarsen
from ringwear.studies.crosscheck.sizes import predict_memory
from ringwear.studies.methods.base import method
from ringwear.studies.problem.scene import bundled
from ringwear.studies.progress import Stages


@pytest.mark.gmsh
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name == "many_rings")) for name in bundled()],
)
def test_unknowns_are_those_of_the_run(name):
    """Before it is refined, if its estimates fall short."""
    scene = Scene.load(name)
    for of in scene.methods:
        solution = method(of).solve(scene.problem, Stages(of))
        assert method(of).system_size(scene.problem).unknowns == solution.unknowns


def test_a_probe_is_small():
    scene = Scene.load("five_rings").changed(
        methods=["mdr", "mdr-grid"],
        punch__rings=300,
        accuracy={"rtol": 1e-8, "mdr": {"degree": 20, "grid": 4000}},
        wear={"times": np.linspace(0, 1, 1000).tolist(), "march": "implicit", "step": 1e-5},
    )
    problem = coarsen(scene).problem
    assert problem.rtol == 1e-2
    assert not problem.mdr.given
    assert problem.mdr.grid <= 100
    assert len(problem.wear_coefficients) <= 16
    assert problem.times[-1] <= 101 * problem.step


def test_memory_is_told_by_what_needs_it():
    scene, times = Scene.load("five_rings"), np.linspace(0, 1, 100_000).tolist()
    assert predict_memory(scene) < 1
    assert predict_memory(scene.changed(punch__rings=300)) > 1
    assert predict_memory(scene.changed(wear__times=times)) > 1


@pytest.mark.parametrize("load", [{"normal_force": 1.0}, {"indentation": 0.05}], ids=str)
def test_a_plan_tells_seconds_and_gib_of_any_punch(load):
    scene = Scene.load("recessed_binder").changed(methods=["mdr"], load=load, accuracy__rtol=1e-3)
    mdr, total, memory = plan(scene)
    assert re.fullmatch(r"mdr: \d+ unknowns, \d+ pressures, about [\d.]+ s", mdr)
    assert re.match(r"in all: about [\d.]+ s", total)
    assert "GiB" in memory
