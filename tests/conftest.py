"""Fixtures that many tests share.

They are the reference history of the five rings, compliances of methods that are computed once, and
commands.
"""

import json
import os
import shlex
import signal
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from groups import nightly
from threadpoolctl import threadpool_limits

from ringwear import Problem, RunningIn, Scene, Stages, main, method as find_method
from ringwear.meshes.by_gmsh.session import unavailable

# pytest-xdist sets COLUMNS in its workers; argparse would then break lines as on a terminal
os.environ.pop("COLUMNS", None)
# tests that send this signal must not depend on whether they were started by `nohup`
signal.signal(signal.SIGHUP, signal.SIG_DFL)


def pytest_addoption(parser):
    """Add the number of scenes that each test of random scenes draws."""
    parser.addoption("--seeds", type=int, default=6, help="number of random scenes of each kind")


def pytest_generate_tests(metafunc):
    """Give tests that take a `random_seed` several; all but the first are for the night."""
    if "random_seed" in metafunc.fixturenames:
        count = metafunc.config.getoption("seeds")
        metafunc.parametrize("random_seed", [0, *nightly(*range(1, count))])


class Prepared(NamedTuple):
    """Discretised problem and wear model of one method for one scene."""

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
        """Sixteen radii in each element of the pressure space."""
        start, width = self.space.breakpoints[:-1, None], np.diff(self.space.breakpoints)[:, None]
        return (start + width * np.arange(16) / 16).ravel()


MESHERS = ("quads", "gmsh", "bisection")
METHODS = ("mdr", "bem", *MESHERS)
WITHOUT_GMSH = unavailable()


def pytest_collection_modifyitems(items):
    """Skip tests marked `gmsh`, with the reason, if gmsh cannot be loaded.

    A nightly case of a slow test is not slow, so that `-m slow` leaves it out.
    """
    for item in items:
        if "nightly" in item.keywords:
            item.own_markers = [mark for mark in item.own_markers if mark.name != "slow"]
        if WITHOUT_GMSH and "gmsh" in item.keywords:
            item.add_marker(pytest.mark.skip(reason=WITHOUT_GMSH))


@pytest.fixture(scope="session", autouse=True)
def _one_thread():
    """Limit linear algebra to one thread.

    The matrices are small, and pytest-xdist runs one process on each core. More threads would only
    wait for each other.
    """
    with threadpool_limits(1):
        yield


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    """Return ``command(line, status=0, scene=None)``, which runs a command in `tmp_path`.

    A scene is written as `scene.toml` there. The exit status is compared, and what was printed is
    returned.
    """
    monkeypatch.chdir(tmp_path)

    def command(line, status=0, scene=None):
        if scene:
            Path("scene.toml").write_text(scene.to_toml(), "utf-8")
        capsys.readouterr()
        try:
            ended = main(shlex.split(line))
        except SystemExit as end:
            ended = end.code
        assert ended == status
        return capsys.readouterr()

    return command


@pytest.fixture
def script(tmp_path):
    """Return ``script(code, *arguments)``, which runs Python in another process in `tmp_path`."""

    def script(code, *arguments):
        call = [sys.executable, "-c", code, *arguments]
        return subprocess.run(call, cwd=tmp_path, text=True, capture_output=True, timeout=300)

    return script


@pytest.fixture(scope="session")
def prepare():
    """Return ``prepare(scene, name, **changes)``; `name` is a method or a mesher of `fem`."""

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


@pytest.fixture(params=METHODS)
def method(request):
    """Name of a method or mesher; each test of an invariant runs once for each."""
    return str(request.param)


@pytest.fixture(scope="session")
def reference():
    """Independent history of the five rings; the last key of the file states its accuracy."""
    return json.loads((Path(__file__).parent / "five_rings.json").read_text("utf-8"))
