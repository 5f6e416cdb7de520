"""Sweeps on a Dask cluster.

Workers that compute otherwise, or not at all, are told in a line; what is finished stays.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
import xarray
from test_sweep_faults import contents, installed_copy

from ringwear.studies.cli import main

pytestmark = pytest.mark.slow

# six blocks of eight scenes
FILE = """
base = "five_rings"
keep = ["steady_rms_slope"]
[axes]
"methods" = [["mdr"]]
"accuracy.rtol" = [1e-2]
"punch.rings" = [2, 3, 4, 5, 6, 7]
"punch.wear_ratio" = { geomspace = [0.5, 4.0, 8] }
"""
# run by each worker as it starts: blocks do something before they are computed
PRELOAD = """
import os, time
from pathlib import Path
from ringwear.studies.sweep import compute
# a worker may run this twice
compute.whole = getattr(compute, "whole", compute._compute_together)
def before(scenes, *arguments):
    {}
    return compute.whole(scenes, *arguments)
compute._compute_together = before
"""
DEADLY = PRELOAD.format("""
    if any(scene.punch.rings == 4 for scene, _ in scenes.values()):
        os._exit(1)
""")
ENDLESS = PRELOAD.format("time.sleep(1000)")
# until a file is gone, from the second block on
HALTING = PRELOAD.format("""
    while Path("halt").exists():
        time.sleep(0.1)
    Path("halt").touch()
""")
# a machine without ringwear
WITHOUT = """
import sys
sys.modules["ringwear"] = None
"""


class Cluster:
    """A scheduler and workers, each a process of its own in a directory."""

    def __init__(self, directory: Path, processes: ExitStack) -> None:
        self.directory, self._processes = directory, processes
        self.scheduler = self._started(
            "scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", "at.json"
        )
        found = directory / "at.json"
        while not (found.exists() and found.read_text()):
            time.sleep(0.1)
        self.address = str(json.loads(found.read_text())["address"])

    def worker(
        self, preload: str = "", path: Path | None = None, nanny: bool = False
    ) -> subprocess.Popen[bytes]:
        """Start a worker, which runs some code first, or with a directory on its path.

        Return once it is known.
        """
        (self.directory / "preload.py").write_text(preload)
        before = self.workers()
        arguments = [
            "--nthreads",
            "1",
            "--preload",
            "preload.py",
            "--nanny" if nanny else "--no-nanny",
        ]
        started = self._started("worker", self.address, *arguments, path=path)
        while self.workers() == before:
            time.sleep(0.2)
        return started

    def workers(self) -> set[str]:
        from distributed import Client

        with Client(self.address, set_as_default=False) as client:
            return set(client.scheduler_info(n_workers=-1)["workers"])

    def sweep(self, *arguments: str) -> subprocess.Popen[str]:
        """Begin the command on this cluster."""
        (self.directory / "sweep.toml").write_text(FILE)
        command = [sys.executable, "-m", "ringwear.studies.cli", "sweep", "sweep.toml"]
        command += ["--out", "out", "--scheduler", self.address]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        begun = subprocess.Popen([*command, *arguments], cwd=self.directory, text=True, **pipes)  # type: ignore[call-overload]
        self._processes.callback(begun.kill)
        return begun

    def statuses(self) -> list[int]:
        store = self.directory / "out" / "sweep.zarr"
        return xarray.open_zarr(store)["status"].values.ravel().tolist() if store.exists() else []

    def _started(
        self, what: str, *arguments: str, path: Path | None = None
    ) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "dask", what, "--no-dashboard", *arguments]
        environment = os.environ | ({"PYTHONPATH": str(path)} if path else {})
        with (self.directory / f"{what}.log").open("ab") as log:
            started = subprocess.Popen(
                command, cwd=self.directory, env=environment, stdout=log, stderr=log
            )
        self._processes.callback(started.wait)
        # a nanny ends its worker, if it is asked to end; the others may be in a block without end
        self._processes.callback(started.terminate if "--nanny" in arguments else started.kill)
        return started


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    with ExitStack() as processes:
        yield Cluster(tmp_path, processes)


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sweep without any cluster."""
    directory = tmp_path_factory.mktemp("here")
    (directory / "sweep.toml").write_text(FILE)
    command = ["sweep", str(directory / "sweep.toml"), "--out", str(directory / "out")]
    assert main([*command, "--workers", "1"]) == 0
    return directory / "out"


def said(begun: subprocess.Popen[str], status: int, word: str) -> None:
    """The command ends with a status, and one line that has a word."""
    _, errors = begun.communicate(timeout=120)
    assert begun.returncode == status, errors
    assert "Traceback" not in errors
    assert len([line for line in errors.splitlines() if word in line]) == 1, errors


def test_workers_with_another_code_are_refused(cluster: Cluster, here: Path) -> None:
    """One number in a copy of ringwear of the same version: nothing of its results is stored."""
    tree = installed_copy(cluster.directory)
    # the same code, installed elsewhere, is as good
    cluster.worker(path=tree)
    said(cluster.sweep(), 0, "48 finished")
    assert contents(cluster.directory / "out") == contents(here)
    altered = tree / "ringwear/studies/methods/sampler.py"
    text = altered.read_text("utf-8")
    assert text.count("lambda: self._rms_slope(state.displacement[None], 0.0)[0]") == 1
    altered.write_text(
        text.replace("displacement[None], 0.0)[0]", "displacement[None], 0.0)[0] * 1.01"),
        "utf-8",
    )
    cluster.worker(path=tree)
    said(cluster.sweep("--out", "other"), 1, "has another code")
    other = xarray.open_zarr(cluster.directory / "other" / "sweep.zarr")
    assert (other["status"] == 0).all()


def test_a_worker_without_ringwear_is_told(cluster: Cluster) -> None:
    cluster.worker(WITHOUT)
    said(cluster.sweep(), 1, "has another ringwear")


def test_a_worker_without_ringwear_that_comes_later_is_told(cluster: Cluster) -> None:
    cluster.worker(ENDLESS)
    begun = cluster.sweep()
    while not (cluster.directory / "out").exists():
        time.sleep(0.1)
    cluster.worker(WITHOUT)
    said(begun, 1, "has another ringwear")


def test_a_block_that_kills_its_workers_is_left_out(cluster: Cluster, here: Path) -> None:
    cluster.worker(DEADLY, nanny=True)
    said(cluster.sweep(), 1, "left out")
    assert cluster.statuses() == [1] * 16 + [0] * 8 + [1] * 24
    # and is computed by others
    out = cluster.directory / "out"
    assert (
        main(["sweep", str(cluster.directory / "sweep.toml"), "--out", str(out), "--resume"]) == 0
    )
    assert contents(out) == contents(here)


def test_a_scheduler_that_is_lost(cluster: Cluster) -> None:
    cluster.worker(HALTING)
    begun = cluster.sweep()
    while 1 not in cluster.statuses():
        time.sleep(0.2)
    cluster.scheduler.send_signal(signal.SIGKILL)
    said(begun, 1, "--resume")
    assert 0 < cluster.statuses().count(1) < 48


def test_a_worker_that_is_lost(cluster: Cluster, here: Path) -> None:
    """One that dies leaves the sweep waiting, and another finishes it."""
    (cluster.directory / "halt").touch()
    first = cluster.worker(HALTING)
    begun = cluster.sweep()
    while not cluster.statuses():
        time.sleep(0.2)
    time.sleep(1)
    first.kill()
    assert begun.stderr is not None
    while "from 0 workers" not in (line := begun.stderr.readline()):
        assert line
    cluster.worker()
    _, errors = begun.communicate(timeout=120)
    assert begun.returncode == 0, errors
    assert contents(cluster.directory / "out") == contents(here)
