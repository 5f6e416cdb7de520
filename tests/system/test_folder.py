"""The contents of an output folder after a run, a failure or a signal.

The folder has the old or the new files as a whole, files of other people are untouched, and numbers
are written even if a figure fails.
"""

import logging
import os
import signal
import subprocess
import sys
import time
from itertools import product

import jinja2
import meshio
import netCDF4
import pytest
from groups import nightly
from matplotlib.figure import Figure

from ringwear import Scene
from ringwear.studies.crosscheck import cores

QUICK = "run flat_punch --rtol 1e-2"
DIRECT = f"{QUICK} --methods direct"
FULL_DISK = OSError(28, "No space left on device")


def contents(out):
    files = (entry for entry in out.iterdir() if entry.is_file())
    return {file.name: file.read_bytes() for file in files if file.name != ".ringwear.json"}


def fail(patch, place, raised):
    """Raise an error at a message in the log, or wherever a function of a library is called."""

    def stop(*_, **__):
        raise raised

    class Stop(logging.Handler):
        def emit(self, record):
            if place in record.getMessage():
                raise raised

    if isinstance(place, str):
        log = logging.getLogger("ringwear")
        patch.setattr(log, "handlers", [*log.handlers, Stop()])
    else:
        patch.setattr(*place, stop)


@pytest.mark.parametrize(
    ("place", "raised", "message"),
    [
        ("integrating ...", KeyboardInterrupt(), "stopped"),
        ("output  writing", KeyboardInterrupt(), "stopped"),
        ((Figure, "savefig"), KeyboardInterrupt(), "stopped"),
        ((jinja2.Template, "render"), KeyboardInterrupt(), "stopped"),
        ((netCDF4, "Dataset"), FULL_DISK, "could not be written"),
        ((netCDF4, "Dataset"), RuntimeError("NetCDF: HDF error"), "could not be written"),
    ],
)
def test_a_run_that_does_not_end_leaves_the_old_files(
    place,
    raised,
    message,
    command,
    tmp_path,
    monkeypatch,
):
    line = f"{DIRECT} --out new/out"
    with monkeypatch.context() as patch:
        fail(patch, place, raised)
        command(line, 1)
    assert list(tmp_path.iterdir()) == []
    command(f"{line} --no-figures")
    before = contents(tmp_path / "new" / "out")
    fail(monkeypatch, place, raised)
    assert message in command(line, 1).err
    assert contents(tmp_path / "new" / "out") == before


@pytest.mark.slow
def test_a_figure_that_fails_does_not_affect_other_files(command, tmp_path, monkeypatch):
    lost, savefig = {"half_space.vtu", "steady_state.png", "stress.png"}, Figure.savefig

    def fill_disk(self, path, **options):
        if path.name in lost:
            path.write_bytes(b"half")
            raise FULL_DISK
        savefig(self, path, **options)

    monkeypatch.setattr(Figure, "savefig", fill_disk)
    monkeypatch.setattr(meshio.Mesh, "write", fill_disk)
    streams = command(f"{QUICK} --out out", 1)
    reasons = [line for line in streams.err.splitlines() if "No space left" in line]
    assert all(any(file in line for line in reasons) for file in lost)
    # the answer is printed nevertheless
    assert "steady wear rate" in streams.out
    drawn = {"profiles_and_pressures", "history", "difference", "mesh"}
    assert contents(tmp_path / "out").keys() == {
        *("results.nc", "summary.json", "report.html"),
        *(f"{name}.png" for name in drawn),
    }


# a process without other threads, whose second process fails or is killed while it draws
SECOND_PROCESS = """
import multiprocessing, os, signal, sys
from pathlib import Path
from matplotlib.figure import Figure
from ringwear import main

first, savefig, killed = os.getpid(), Figure.savefig, sys.argv[1] == "killed"

def lose(self, path, **options):
    if os.getpid() != first:
        Path("second").touch()
        if killed:
            os.kill(os.getpid(), signal.SIGKILL)
    if path.name == "history.png" and not killed:
        raise OSError(28, "No space left on device")
    savefig(self, path, **options)

Figure.savefig = lose
status = main(["run", "flat_punch", "--rtol", "1e-2", "--out", "out"])
assert not multiprocessing.active_children()
sys.exit(status)
"""


@pytest.mark.skipif(cores() == 1, reason="one core draws all figures in one process")
@pytest.mark.parametrize("end", ["fails", "killed"])
def test_figures_that_a_second_process_loses_are_drawn_or_named_once(end, script, tmp_path):
    done = script(SECOND_PROCESS, end)
    assert done.returncode == (end == "fails")
    assert (tmp_path / "second").exists()
    assert "Traceback" not in done.stderr
    reason = "history.png could not be written: [Errno 28] No space left on device"
    assert done.stderr.count(reason) == (end == "fails")
    figures = {file.name for file in (tmp_path / "out").glob("*.png")}
    expected = {"profiles_and_pressures", "history", "steady_state", "difference", "stress", "mesh"}
    lost = {"history"} if end == "fails" else set()
    assert figures == {f"{name}.png" for name in expected - lost}


# a process without other threads, which may have a copy
TWO_PROCESSES = """
import os
import ringwear, xarray
from ringwear.studies.crosscheck import copies

first = os.getpid()

def fails_apart():
    if os.getpid() != first:
        raise ValueError
    return first

def copy_of_copy():
    (found,) = apart(os.getpid)
    return os.getpid(), found()

with copies() as apart, copies(wanted=False) as here:
    pids, (mine,) = apart(copy_of_copy, os.getpid, fails_apart), here(os.getpid)
    (second, third), again, failed = (pid() for pid in pids)
    assert len({first, second, third}) == 3
    assert (again, failed, mine()) == (second, first, first)
assert ringwear.main(["run", "cone", "--rtol", "1e-2", "--no-figures", "--out", "out"]) != 2
alone = ringwear.run("cone", rtol=1e-2).dataset
xarray.testing.assert_equal(ringwear.load("out").dataset, alone)
"""


@pytest.mark.skipif(cores() == 1, reason="one core does all work in one process")
def test_a_second_process_gives_the_results_of_one(script):
    done = script(TWO_PROCESSES)
    assert done.returncode == 0, done.stderr[-1000:]
    # all methods report their progress
    assert {"mdr", "direct", "fem"} <= {*done.stderr.split()}


def test_any_title_can_be_drawn(command, tmp_path):
    """Titles are plain text, so they cannot fail as mathtext."""
    title = r"$\frac{1 \alpha_ and a long story " + 20 * "again and "
    scene = Scene.load("five_rings").changed(title=title, methods=["direct"])
    command("run scene.toml --out out", scene=scene)
    assert "steady_state.png" in contents(tmp_path / "out")


def test_files_of_other_people_are_not_removed_or_overwritten(command, tmp_path):
    (tmp_path / "notes.txt").write_text("mine", "utf-8")
    command(f"{DIRECT} --out .")
    # old figures are removed, because they show other numbers
    command(f"{DIRECT} --out . --no-figures")
    assert contents(tmp_path).keys() == {"results.nc", "summary.json", "notes.txt"}
    (tmp_path / "history.png").write_text("mine", "utf-8")
    before = contents(tmp_path)
    assert "history.png" in command(f"{DIRECT} --out .", 2).err
    assert contents(tmp_path) == before


# the signal, and the file that exists when the run is stopped: none, numbers, or a figure
@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "seen"),
    [
        (signal.SIGTERM, ""),
        (signal.SIGINT, "results.nc"),
        *nightly(
            *product(
                (signal.SIGTERM, signal.SIGINT), ("summary.json", "half_space.vtu", "history.png")
            )
        ),
    ],
)
def test_signals_end_a_run_cleanly(number, seen, tmp_path):
    # where the tests themselves run in the background, the shell has told them to ignore SIGINT
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    code += "from ringwear import main; raise SystemExit(main())"
    out = tmp_path / "out"
    # thirty-two rings by finite elements take long enough
    scene = ["five_rings", "--rtol", "1e-2"] if seen else ["many_rings", "--rtol", "1e-6"]
    run = subprocess.Popen(
        [sys.executable, "-c", code, "run", *scene, "--out", str(out)],
        stderr=subprocess.PIPE,
        text=True,
    )
    for _ in range(3000):
        if (out / ".writing" / seen).exists():
            break
        time.sleep(0.02)
    os.kill(run.pid, number)
    _, errors = run.communicate(timeout=60)
    assert run.returncode == 1
    assert "stopped" in errors
    assert "Traceback" not in errors
    assert list(tmp_path.iterdir()) == []
