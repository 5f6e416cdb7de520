"""Sweeps whose blocks are computed by executors, by processes of this machine and by threads."""

import os
import subprocess
import sys
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor

import pytest
import xarray
from test_sweep_faults import AXES, BASE, KEEP

from ringwear import SolverError, sweep
from ringwear.studies.sweep import blocks

# a script that starts processes, and does not guard against being imported by them
SCRIPT = """
import ringwear
from ringwear.studies.sweep import blocks
blocks.LEAST_SECONDS_SAVED = 0.0
print("begun")
scene = ringwear.Scene.load("five_rings").changed(accuracy__rtol=1e-1)
found = ringwear.sweep(scene, {"punch.rings": [2, 3, 4, 5, 6, 7, 8, 9, 10]}, keep="indentation",
                       methods="mdr", workers=2)
print(int((found["status"] == 1).sum()))
"""


@pytest.fixture(scope="module")
def here():
    return sweep(BASE, AXES, keep=KEEP, workers=1)


def test_threads_compute_what_this_process_computes(here):
    with ThreadPoolExecutor(2) as executor:
        there = sweep(BASE, AXES, executor=executor, keep=KEEP)
    xarray.testing.assert_identical(there, here)


class Counting(Executor):
    """An executor that computes at once, and counts how many tasks wait for their results."""

    def __init__(self, workers):
        self._max_workers, self.tasks = workers, 0

    def submit(self, function, *arguments):
        self.tasks += 1
        future = Future()
        future.set_result(function(*arguments))
        return future


def test_an_executor_gets_a_task_for_each_block(here):
    executor = Counting(2)
    xarray.testing.assert_identical(sweep(BASE, AXES, executor=executor, keep=KEEP), here)
    assert executor.tasks == 3


class Broken(Counting):
    def submit(self, *_):
        future = Future()
        future.set_exception(BrokenExecutor("a process has died"))
        return future


def test_an_executor_that_is_lost_is_reported():
    with pytest.raises(SolverError, match=r"lost a worker.*--resume"):
        sweep(BASE, AXES, executor=Broken(1), keep=KEEP)


@pytest.mark.slow
def test_a_script_need_not_guard_against_its_processes(tmp_path):
    """It is not run again by each process; nothing but its own lines is printed."""
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert done.stderr == ""
    assert done.stdout.split() == ["begun", "9"]


def deadly(block, blank, compute=blocks._compute):
    """Compute a block, or end the process if the block has punches of nine or more rings."""
    if block.columns["punch.rings"].values[0] >= 9:
        os._exit(1)
    return compute(block, blank)


@pytest.mark.slow
def test_a_block_that_kills_its_processes_fails_and_others_go_on(monkeypatch):
    monkeypatch.setattr(blocks, "LEAST_SECONDS_SAVED", 0.0)
    axes, options = AXES | {"punch.rings": [2, 3, 9, 4, 10, 5]}, {"keep": KEEP, "workers": 2}
    with monkeypatch.context() as patch:
        patch.setattr(blocks, "_compute", deadly)
        found = sweep(BASE, axes, **options)
    assert found["status"].sel(wear_ratio=0.5).values.tolist() == [1, 1, 2, 1, 2, 1]
    assert "lost twice" in str(found["reason"].sel(rings=9).values[0])
    there = sweep(BASE, axes, **options)
    rings = [2, 3, 4, 5]
    xarray.testing.assert_identical(found.sel(rings=rings), there.sel(rings=rings))
