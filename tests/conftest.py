"""Shared fixtures.

The reference history of the five rings, and methods made ready once for many tests.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from ringwear import Scene
from ringwear.meshes import Array, Compliance, PressureSpace
from ringwear.meshes.gmsh_session import unavailable
from ringwear.studies.methods.base import Discretised
from ringwear.studies.methods.base import method as named
from ringwear.studies.methods.pipeline import ComplianceMethod
from ringwear.studies.problem.problem import Problem
from ringwear.studies.progress import Stages
from ringwear.studies.wear.full_contact import RunningIn


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of `tests/physics/test_estimates.py`: the scenes that it draws at random."""
    for name, default in (("seed", 3), ("scenes", 20), ("rings", 3)):
        parser.addoption(f"--{name}", type=int, default=default, help="of scenes drawn at random")


@dataclass(frozen=True, eq=False)
class Prepared:
    """One method, ready for a scene."""

    problem: Problem
    made: Discretised
    wear: RunningIn

    @property
    def compliance(self) -> Compliance:
        return self.made.compliance

    @property
    def space(self) -> PressureSpace:
        return self.made.compliance.space

    @property
    def everywhere(self) -> Array:
        """Sixteen radii in each element."""
        start, width = self.space.breakpoints[:-1, None], np.diff(self.space.breakpoints)[:, None]
        return (start + width * np.arange(16) / 16).ravel()


Prepare = Callable[..., Prepared]

# name, method and changes of the scene: the methods that every invariant is tested on
METHODS = {
    "mdr": ("mdr", {}),
    "quads": ("fem", {"accuracy__fem__mesher": "quads"}),
    "gmsh": ("fem", {"accuracy__fem__mesher": "gmsh"}),
    "bisection": ("fem", {"accuracy__fem__mesher": "bisection"}),
}


NEED_GMSH = ("quads", "gmsh")
WITHOUT_GMSH = unavailable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Where gmsh cannot be loaded, what needs it is skipped, with the reason."""
    for item in items:
        if WITHOUT_GMSH and "gmsh" in item.keywords:
            item.add_marker(pytest.mark.skip(reason=WITHOUT_GMSH))


@pytest.fixture(scope="session", autouse=True)
def _one_thread() -> Iterator[None]:
    """The matrices are small, and pytest-xdist has a process for each core.

    Threads would only wait on each other.
    """
    with threadpool_limits(1):
        yield


@pytest.fixture(scope="session")
def prepare() -> Prepare:
    """``prepare(scene, name, **changes)``: a method by its name in `METHODS`, or by its own."""

    @cache
    def make(scene: str, name: str, changes: tuple[tuple[str, Any], ...]) -> Prepared:
        if WITHOUT_GMSH and name in NEED_GMSH:
            pytest.skip(WITHOUT_GMSH)
        kind, sizes = METHODS.get(name, (name, {}))
        listed = {key: list(value) if isinstance(value, tuple) else value for key, value in changes}
        problem, method = Scene.load(scene).changed(**sizes, **listed).problem, named(kind)
        assert isinstance(method, ComplianceMethod)
        made = method.discretise(problem, Stages(kind))
        return Prepared(problem, made, RunningIn(made.compliance, problem.merged.wear_coefficients))

    return lambda scene, name, **changes: make(scene, name, tuple(changes.items()))


@pytest.fixture(params=METHODS)
def method(request: pytest.FixtureRequest) -> str:
    """Each of `METHODS`."""
    return str(request.param)


@pytest.fixture(scope="session")
def reference() -> dict[str, Any]:
    """An independent whole history of the five rings, with its accuracy (see its last key)."""
    return json.loads((Path(__file__).parent / "five_rings.json").read_text("utf-8"))
