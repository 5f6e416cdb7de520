"""Shared fixtures.

The reference history of the five rings, and methods made ready once for many tests.
"""

import json
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from ringwear import Scene
from ringwear.meshes.by_gmsh.session import unavailable
from ringwear.studies.methods.base import method as find_method
from ringwear.studies.problem.problem import Problem
from ringwear.studies.progress import Stages
from ringwear.studies.wear.full_contact import RunningIn

# workers of the tests have it, and lines would be broken as on a terminal
os.environ.pop("COLUMNS", None)


def pytest_addoption(parser):
    """Options of `tests/physics/test_estimates.py`: the scenes that it draws at random."""
    for name, default in (("seed", 3), ("scenes", 20), ("rings", 3)):
        parser.addoption(f"--{name}", type=int, default=default, help="of scenes drawn at random")


class Prepared(NamedTuple):
    """One method, ready for a scene."""

    problem: Problem
    wear: RunningIn

    @property
    def compliance(self):
        return self.wear.compliance

    @property
    def space(self):
        return self.wear.compliance.space

    @property
    def everywhere(self):
        """Sixteen radii in each element."""
        start, width = self.space.breakpoints[:-1, None], np.diff(self.space.breakpoints)[:, None]
        return (start + width * np.arange(16) / 16).ravel()


Prepare = Callable[..., Prepared]

MESHERS = ("quads", "gmsh", "bisection")
WITHOUT_GMSH = unavailable()


def pytest_collection_modifyitems(items):
    """Where gmsh cannot be loaded, what needs it is skipped, with the reason."""
    for item in items:
        if WITHOUT_GMSH and "gmsh" in item.keywords:
            item.add_marker(pytest.mark.skip(reason=WITHOUT_GMSH))


@pytest.fixture(scope="session", autouse=True)
def _one_thread():
    """The matrices are small, and pytest-xdist has a process for each core.

    Threads would only wait on each other.
    """
    with threadpool_limits(1):
        yield


@pytest.fixture(scope="session")
def prepare():
    """``prepare(scene, name, **changes)``: a method by its name, or finite elements by a mesher."""

    @cache
    def prepare(scene, name, **changes):
        if WITHOUT_GMSH and name in ("quads", "gmsh"):
            pytest.skip(WITHOUT_GMSH)
        if name in MESHERS:
            name, changes = "fem", {"accuracy__fem__mesher": name, **changes}
        problem = Scene.load(scene).changed(**changes).problem
        compliance = find_method(name).discretise(problem, Stages(name)).compliance
        return Prepared(problem, RunningIn(compliance, problem.merged.wear_coefficients))

    return prepare


@pytest.fixture(params=["mdr", "bem", *MESHERS])
def method(request):
    """The methods that every invariant is tested on."""
    return str(request.param)


@pytest.fixture(scope="session")
def reference():
    """An independent whole history of the five rings, with its accuracy (see its last key)."""
    return json.loads((Path(__file__).parent / "five_rings.json").read_text("utf-8"))
