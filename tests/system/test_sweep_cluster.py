"""Sweeps on a Dask cluster.

A line reports workers that compute differently or not at all; finished scenes stay.
"""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import ExitStack
from functools import partial

import pytest
from test_sweep_faults import contents, statuses

from ringwear import main

pytestmark = pytest.mark.nightly

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
def before(problems, *arguments):
    {}
    return compute.whole(problems, *arguments)
compute._compute_together = before
"""
DEADLY = PRELOAD.format("""
    if any(len(problem.ring_edges) == 5 for problem in problems.values()):
        os._exit(1)
""")
# from the second block on, wait until a file is removed
HALTING = PRELOAD.format("""
    Path("begun").touch()
    while Path("halt").exists():
        time.sleep(0.1)
    Path("halt").touch()
""")
# another version of ringwear
OTHER = """
from ringwear.studies.crosscheck.versions import package_versions
package_versions()["ringwear"] = "0"
"""


def wait_until(condition, what, seconds=120):
    """Wait for a condition, and fail if it takes too long."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"it takes more than {seconds} s until {what}"
        time.sleep(0.2)


class Cluster:
    """A scheduler and workers in one directory, each in its own process."""

    def __init__(self, directory, processes):
        self.directory, self._processes = directory, processes
        self.out = directory / "out"
        self.scheduler = self._start(
            "scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", "at.json"
        )
        file = directory / "at.json"
        wait_until(lambda: file.exists() and file.read_text(), "the scheduler listens")
        self.address = str(json.loads(file.read_text())["address"])

    def worker(self, preload="", nanny=False):
        """Start a worker, which runs some code first; return once it has registered.

        A process that hangs while it starts, which happens now and then, is started again.
        """
        (self.directory / "preload.py").write_text(preload)
        arguments = ["--nthreads", "1", "--preload", "preload.py"]
        arguments.append("--nanny" if nanny else "--no-nanny")
        for seconds in (40, 40, 120):
            awaited = self.registrations() + 1
            worker = self._start("worker", self.address, *arguments)
            try:
                wait_until(partial(self.has_registered, awaited), "a worker registers", seconds)
            except AssertionError:
                worker.kill()
                continue
            return worker
        raise AssertionError((self.directory / "worker.log").read_text("utf-8"))

    def has_registered(self, count):
        """Whether workers have registered so often; the scheduler may have dropped them again."""
        return self.registrations() >= count

    def registrations(self):
        """Return how often workers have registered with the scheduler, from their log."""
        log = self.directory / "worker.log"
        return log.read_text("utf-8").count("Registered to:") if log.exists() else 0

    def sweep(self, *arguments):
        """Start the command on this cluster."""
        (self.directory / "sweep.toml").write_text(FILE)
        command = [sys.executable, "-m", "ringwear.studies.cli", "sweep", "sweep.toml"]
        command += ["--out", "out", "--scheduler", self.address, *arguments]
        sweep = subprocess.Popen(command, cwd=self.directory, text=True, stderr=subprocess.PIPE)
        self._processes.callback(sweep.kill)
        return sweep

    def _start(self, what, *arguments):
        command = [sys.executable, "-m", "dask", what, "--no-dashboard", *arguments]
        # one death of a worker is enough: its block is not given to other workers
        settings = os.environ | {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
        with (self.directory / f"{what}.log").open("ab") as log:
            process = subprocess.Popen(
                command, cwd=self.directory, stdout=log, stderr=log, env=settings
            )
        self._processes.callback(process.wait)
        # a nanny ends its worker, if it is asked to end; the others may be in a block without end
        self._processes.callback(process.terminate if "--nanny" in arguments else process.kill)
        return process


@pytest.fixture
def cluster(tmp_path):
    with ExitStack() as processes:
        yield Cluster(tmp_path, processes)


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    """Return the sweep without a cluster."""
    directory = tmp_path_factory.mktemp("here")
    (directory / "sweep.toml").write_text(FILE)
    command = ["sweep", str(directory / "sweep.toml"), "--out", str(directory / "out")]
    assert main([*command, "--workers", "1"]) == 0
    return directory / "out"


def expect(sweep, status, word, timeout=120):
    """Assert that the command ends with a status and one line that contains a word."""
    _, errors = sweep.communicate(timeout=timeout)
    assert sweep.returncode == status, errors
    assert "Traceback" not in errors
    assert len([line for line in errors.splitlines() if word in line]) == 1, errors


def test_workers_of_another_version_are_refused(cluster, here):
    """None of their results is stored."""
    worker = cluster.worker()
    expect(cluster.sweep(), 0, "6 of 6 blocks")
    assert contents(cluster.out) == contents(here)
    worker.kill()
    cluster.worker(OTHER)
    expect(cluster.sweep("--out", "other"), 1, "has another ringwear")
    assert not any(statuses(cluster.directory / "other"))


def test_a_block_that_kills_its_workers_fails(cluster, here):
    cluster.worker(DEADLY, nanny=True)
    expect(cluster.sweep(), 1, "6 of 6 blocks", timeout=400)
    assert statuses(cluster.out) == [1] * 16 + [2] * 8 + [1] * 24
    # other workers compute it
    file = str(cluster.directory / "sweep.toml")
    assert main(["sweep", file, "--out", str(cluster.out), "--retry-failed"]) == 0
    assert contents(cluster.out) == contents(here)


def test_a_sweep_ends_if_its_scheduler_is_lost(cluster):
    cluster.worker(HALTING)
    sweep = cluster.sweep()
    wait_until(lambda: 1 in statuses(cluster.out), "a block is stored")
    cluster.scheduler.send_signal(signal.SIGKILL)
    expect(sweep, 1, "--resume")
    assert 0 < statuses(cluster.out).count(1) < 48


def test_a_sweep_waits_if_its_worker_is_lost(cluster, here):
    """Another worker finishes the sweep."""
    (cluster.directory / "halt").touch()
    first = cluster.worker(HALTING)
    sweep = cluster.sweep()
    wait_until((cluster.directory / "begun").exists, "a block has begun")
    first.kill()
    assert sweep.stderr is not None
    while "no block has been finished" not in (line := sweep.stderr.readline()):
        assert line
    cluster.worker()
    expect(sweep, 0, "6 of 6 blocks")
    assert contents(cluster.out) == contents(here)
