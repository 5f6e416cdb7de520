"""Sweeps that are interrupted or damaged end with the bytes of undisturbed ones or a reason.

Sweeps in memory need no extra libraries.
"""

import json
import logging
import os
import shutil
import signal
import subprocess
import sys
import time
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import tomli_w
import xarray
import zarr
from groups import nightly

from ringwear import RingwearError, Scene, SceneError, __version__, sweep
from ringwear.studies.crosscheck.versions import code
from ringwear.studies.sweep import blocks, compute, results
from ringwear.studies.sweep.results import HIDDEN

# three blocks of eight scenes
BASE = Scene.load("five_rings").changed(methods=["mdr", "direct"], accuracy__rtol=1e-1)
AXES = {"punch.rings": [2, 3, 4], "punch.wear_ratio": {"geomspace": [0.5, 4.0, 8]}}
KEEP = ["steady_displacement_max", "steady_rms_slope"]
# nine blocks of nine scenes, for commands in separate processes
LONG = {
    "base": BASE.changed(accuracy__rtol=1e-2, wear__times=[0.0, 0.1]).table(),
    "keep": ["indentation", "steady_rms_slope"],
    "axes": {
        "punch.rings": {"linspace": [2, 10, 9]},
        "punch.wear_ratio": {"geomspace": [0.5, 4.0, 9]},
    },
}
# the command, and a line in a file for each block that is in the store
CODE = """
import sys
from pathlib import Path
from ringwear import main
from ringwear.studies.sweep import blocks
from ringwear.studies.sweep.results import Store
# start workers although the sweep is short, because the test is about them
blocks.LEAST_SECONDS_SAVED = 0.0
write = Store.write
def counted(self, number, values):
    write(self, number, values)
    with open("out.blocks", "a") as file:
        file.write(f"{number}\\n")
Store.write = counted
if __name__ == "__main__":
    raise SystemExit(main(["sweep", "sweep.toml", "--out", "out", *sys.argv[1:]]))
"""


def contents(directory):
    """Return all files of a store."""
    files = (file for file in (directory / "sweep.zarr").rglob("*") if file.is_file())
    return {str(file.relative_to(directory)): file.read_bytes() for file in files}


def compute_into(directory, **options):
    return sweep(BASE, AXES, directory, keep=KEEP, **options)


def statuses(directory):
    """Return the statuses of all scenes; none before the root of the store is written."""
    path = directory / "sweep.zarr"
    if not (path / "zarr.json").exists():
        return []
    return xarray.open_zarr(path)["status"].values.ravel().tolist()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    directory = tmp_path_factory.mktemp("undisturbed")
    compute_into(directory)
    return directory


@pytest.mark.parametrize(
    "error", [KeyboardInterrupt(), OSError(28, "No space left on device")], ids=str
)
@pytest.mark.parametrize("at", [8, *nightly(0, 13)])
def test_a_sweep_stopped_anywhere_is_resumed(
    tmp_path,
    undisturbed,
    monkeypatch,
    error,
    at,
):
    """Writing fails after a given number of arrays of results."""
    write, written = zarr.Array.__setitem__, list[object]()

    def fail(self, region, values):
        if region != slice(None):
            written.append(region)
        if len(written) > at:
            raise error
        write(self, region, values)

    with monkeypatch.context() as patch:
        patch.setattr(zarr.Array, "__setitem__", fail)
        with pytest.raises(type(error)):
            compute_into(tmp_path)
    assert contents(tmp_path) != contents(undisturbed)
    compute_into(tmp_path, resume=True)
    assert contents(tmp_path) == contents(undisturbed)


def truncate(file):
    file.write_bytes(file.read_bytes()[:-5])


def empty(file):
    file.write_bytes(b"")


def flip(file):
    """Flip a bit in the middle of the compressed data."""
    content = bytearray(file.read_bytes())
    content[len(content) * 3 // 4] ^= 4
    file.write_bytes(content)


RESULTS = ("steady_rms_slope/c/2/0/0", "disagreement/c/2/0", "status/c/2/0")
LABELS = ("status/zarr.json", "rings/c/0")


@pytest.mark.parametrize(
    ("damage", "file"),
    [
        *product((truncate, empty, flip, Path.unlink), RESULTS[:1]),
        *nightly(*product((truncate, empty, flip, Path.unlink), RESULTS[1:])),
        (Path.unlink, "reason/c/2/0"),
        *product((truncate, flip), LABELS),
    ],
)
def test_a_damaged_block_is_detected_and_computed_again(
    tmp_path,
    undisturbed,
    monkeypatch,
    damage,
    file,
):
    """No other block is computed again."""
    shutil.copytree(undisturbed, tmp_path, dirs_exist_ok=True)
    damage(tmp_path / "sweep.zarr" / file)
    written, write = list[int](), results.Store.write

    def count(self, number, values):
        written.append(number)
        write(self, number, values)

    monkeypatch.setattr(results.Store, "write", count)
    compute_into(tmp_path, resume=True)
    assert contents(tmp_path) == contents(undisturbed)
    assert written == ([] if file in LABELS else [2])


@pytest.mark.parametrize("damage", [truncate, empty, Path.unlink])
@pytest.mark.parametrize("keep", [KEEP, KEEP[:1]], ids=["same", "another"])
def test_a_store_without_its_root_is_refused(tmp_path, undisturbed, damage, keep):
    """Without its root, a store does not record by which code and sweep it was computed."""
    shutil.copytree(undisturbed, tmp_path, dirs_exist_ok=True)
    damage(tmp_path / "sweep.zarr" / "zarr.json")
    before = contents(tmp_path)
    with pytest.raises(SceneError, match=r"zarr\.json is damaged or lost"):
        sweep(BASE, AXES, tmp_path, keep=keep, resume=True)
    assert contents(tmp_path) == before


def test_a_directory_holds_one_sweep_and_one_run_at_a_time(tmp_path, caplog):
    refusals = []

    class Second(logging.Handler):
        """Start a second sweep into the same directory while the first one runs."""

        def emit(self, _):
            with pytest.raises(SceneError, match="another run") as refusal:
                compute_into(tmp_path)
            refusals.append(refusal)

    log, second = logging.getLogger("ringwear"), Second(logging.INFO)
    caplog.set_level(logging.INFO, logger="ringwear")
    log.addHandler(second)
    compute_into(tmp_path)
    log.removeHandler(second)
    assert refusals
    with pytest.raises(SceneError, match="--resume"):
        compute_into(tmp_path)
    with pytest.raises(SceneError, match="begun with another sweep file"):
        sweep(BASE, AXES, tmp_path, keep=KEEP[:1], resume=True)
    (tmp_path / "file").touch()
    with pytest.raises(SceneError, match="cannot be written"):
        compute_into(tmp_path / "file" / "out")


def fail_for_three_rings(patch, error):
    """Let scenes of three rings fail, and all scenes that are computed together with them."""
    solve = compute.solved_to_accuracy

    def fail(method, problems, stages):
        if any(len(problem.ring_edges) == 4 for problem in problems):
            raise error
        return solve(method, problems, stages)

    patch.setattr(compute, "solved_to_accuracy", fail)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("error", "status"), [(ValueError("a bad day"), 2), (MemoryError("no room"), 0)], ids=str
)
def test_failed_scenes_end_the_command_with_status_1(command, tmp_path, monkeypatch, error, status):
    """The reason is printed, and other scenes are computed.

    A failed scene is tried again only with --retry-failed; a scene that lacked memory stays
    pending.
    """
    table = {"base": BASE.table(), "keep": KEEP, "axes": AXES}
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(table))
    line, out = "sweep sweep.toml --workers 1 --out out", tmp_path / "out"
    with monkeypatch.context() as patch:
        fail_for_three_rings(patch, error)
        output = command(line, 1).out
    assert f"direct: {type(error).__name__}: {error} (8 scenes)" in output
    assert statuses(out) == [1] * 8 + [status] * 8 + [1] * 8
    results = xarray.open_zarr(out / "sweep.zarr")["steady_rms_slope"].isel(solver=0)
    np.testing.assert_array_equal(results.notnull().all("wear_ratio"), [True, False, True])
    command(f"{line} --resume", 1 if status == 2 else 0)
    command(f"{line} --retry-failed")
    assert statuses(out) == [1] * 24


@pytest.mark.slow
@pytest.mark.parametrize("failing", [False, True])
def test_methods_that_disagree_end_the_command_with_3(command, tmp_path, monkeypatch, failing):
    """If scenes failed, the status is 1 even if others disagree."""
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(LONG | {"axes": AXES}))
    monkeypatch.setattr(compute, "disagreement", lambda *_: 1.5)
    if failing:
        fail_for_three_rings(monkeypatch, ValueError())
    for _ in range(2):
        command("sweep sweep.toml --workers 1 --out . --resume", 1 if failing else 3)


@pytest.mark.parametrize("changed", ["versions", "code"])
def test_a_store_of_other_versions_or_code_is_refused(tmp_path, undisturbed, monkeypatch, changed):
    """Other versions, or another hash of the code, do not continue it."""
    attributes = xarray.open_zarr(undisturbed / "sweep.zarr").attrs
    there = json.loads(attributes["versions"])
    assert (there["ringwear"], there["numpy"]) == (__version__, np.__version__)
    assert attributes["code"] == code()
    other = there | {"ringwear": "0", "numpy": "1.0"}
    shutil.copytree(undisturbed, tmp_path, dirs_exist_ok=True)
    names = {"versions": ("package_versions", other), "code": ("code", "of another edit")}
    name, value = names[changed]
    monkeypatch.setattr(results, name, lambda: value)
    with pytest.raises(
        SceneError, match="begun with another sweep file, other code of ringwear or other libraries"
    ):
        compute_into(tmp_path, resume=True)
    assert contents(tmp_path) == contents(undisturbed)


def test_a_scheduler_that_does_not_answer_is_reported(tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, "TIMEOUT", 1.0)
    with (
        pytest.raises(RingwearError, match="does not answer"),
        blocks.cluster("tcp://127.0.0.1:9") as executor,
    ):
        compute_into(tmp_path, executor=executor)


def test_workers_start_only_if_much_is_left(undisturbed, monkeypatch):
    """A short sweep has no workers."""

    def refuse(*_):
        raise RingwearError("workers are started")

    monkeypatch.setattr(blocks, "_Process", refuse)
    there = compute_into(undisturbed, resume=True).load()
    xarray.testing.assert_identical(sweep(BASE, AXES, keep=KEEP, workers=2), there)
    monkeypatch.setattr(blocks, "LEAST_SECONDS_SAVED", 0.0)
    with pytest.raises(RingwearError, match="are started"):
        sweep(BASE, AXES, keep=KEEP, workers=2)


def begin(directory, *arguments, table=LONG):
    """Start the command in its own process, in a directory."""
    (directory / "sweep.toml").write_text(tomli_w.dumps(table))
    (directory / "counted.py").write_text(CODE)
    return subprocess.Popen(
        [sys.executable, "counted.py", *arguments],
        cwd=directory,
        text=True,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def children(process):
    """Return the processes started by any of its threads, in their order."""
    threads = Path(f"/proc/{process.pid}/task").glob("*/children")
    return sorted(int(number) for thread in threads for number in thread.read_text().split())


def alive(process):
    """Return whether a process runs; one that has ended may still wait for its parent."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the store of the undisturbed command."""
    directory = tmp_path_factory.mktemp("whole")
    assert begin(directory, "--workers", "1").wait() == 0
    return contents(directory / "out")


def finish(directory, whole):
    """Resume a store: it becomes the undisturbed one, and no block is computed twice."""
    process = begin(directory, "--workers", "2", "--resume")
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    assert contents(directory / "out") == whole
    computed = (directory / "out.blocks").read_text().split()
    assert len(set(computed)) == len(computed)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("victim", "number", "workers"),
    [
        ("command", signal.SIGTERM, "2"),
        ("worker", signal.SIGKILL, "2"),
        *nightly(
            ("command", signal.SIGTERM, "1"),
            *product(["command"], [signal.SIGKILL], ["1", "2"]),
            *product(["terminal"], [signal.SIGINT], ["1", "2"]),
        ),
    ],
)
def test_a_sweep_stopped_by_a_signal_is_resumed(tmp_path, whole, victim, number, workers):
    """Ctrl-C reaches all processes of a terminal; other signals reach one process.

    The command ends with one line and can be resumed. It continues if only a worker is killed.
    """
    process = begin(tmp_path, "--workers", workers)
    # two workers, and a process of Python that watches them
    begun = (
        (tmp_path / "out.blocks").exists if victim != "worker" else lambda: children(process)[2:]
    )
    while process.poll() is None and not begun():
        time.sleep(0.05)
    if victim == "terminal":
        os.killpg(process.pid, number)
    else:
        os.kill(process.pid if victim == "command" else children(process)[-1], number)
    _, errors = process.communicate()
    assert "Traceback" not in errors
    if victim == "worker":
        assert process.returncode == 0, errors
    else:
        assert process.returncode == (-number if number == signal.SIGKILL else 1)
        assert 0 < statuses(tmp_path / "out").count(1) < 81
    finish(tmp_path, whole)


# enough scenes for the sweep to be running when it is stopped
VERY_LONG = LONG | {
    "axes": LONG["axes"] | {"punch.wear_ratio": {"geomspace": [0.5, 4.0, 100]}},
}


@pytest.mark.slow
def test_a_stop_while_workers_start_ends_them(tmp_path):
    """One line is printed at any time of the stop, and no worker is left."""
    for delay in (3.0, 5.0):
        process = begin(tmp_path, "--workers", "2", "--resume", table=VERY_LONG)
        time.sleep(delay)
        workers = children(process)
        process.terminate()
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 1
        assert "Traceback" not in errors
        lines = [line for line in errors.splitlines() if not line.startswith("   sweep")]
        assert lines == ["ringwear: stopped; no incomplete files are left"]
        deadline = time.monotonic() + 20
        while any(map(alive, workers)):
            assert time.monotonic() < deadline
            time.sleep(0.05)


WITHOUT_EXTRA = """
import sys
for name in ("dask", "distributed", "zarr"):
    sys.modules[name] = None
from ringwear import SceneError, main, sweep
axes = {"punch.rings": [2, 3]}
dataset = sweep("five_rings", axes, keep=["steady_rms_slope"])
assert dataset["steady_rms_slope"].notnull().all()
assert main(["sweep", "running_in", "--out", "out", "--workers", "1"]) == 2
assert main(["sweep", "running_in", "--out", "out", "--scheduler", "tcp://127.0.0.1:9"]) == 2
try:
    sweep("five_rings", axes, "out", keep=["steady_rms_slope"])
except SceneError as refused:
    print(refused, file=sys.stderr)
"""


@pytest.mark.slow
def test_a_sweep_in_memory_needs_no_extra(script):
    done = script(WITHOUT_EXTRA)
    assert done.returncode == 0, done.stderr
    refusals = [line for line in done.stderr.splitlines() if "ringwear[sweep]" in line]
    assert "zarr" in refusals[0]
    assert "dask and distributed" in refusals[1]
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("linked", [True, False])
def test_files_of_others_are_neither_removed_nor_mixed_with_a_store(command, tmp_path, linked):
    foreign, out = tmp_path / "foreign", tmp_path / "out"
    foreign.mkdir()
    (foreign / "download.partial").write_text("of someone else", "utf-8")
    out.mkdir()
    path = out / "sweep.zarr"
    if linked:
        path.symlink_to(foreign)
    else:
        shutil.copytree(foreign, path)
    printed = command("sweep running_in --out out --resume --workers 1", 2)
    assert "zarr.json is damaged or lost" in printed.err
    assert [file.name for file in path.iterdir()] == ["download.partial"]


def test_leftovers_beside_arrays_of_a_store_are_kept(tmp_path, undisturbed):
    """Only unfinished files of Zarr and of a killed sweep are removed."""
    shutil.copytree(undisturbed, tmp_path, dirs_exist_ok=True)
    store = tmp_path / "sweep.zarr"
    (store / "mine").mkdir()
    theirs = [store / "mine" / "notes.partial", store / "status" / "c" / "0.partial"]
    for file in theirs:
        file.write_text("of someone else", "utf-8")
    hidden = tmp_path / f"{HIDDEN}a"
    hidden.mkdir()
    unfinished = store / "status" / "c" / "0" / f"0.{32 * 'a'}.partial"
    unfinished.write_bytes(b"")
    compute_into(tmp_path, resume=True)
    assert all(file.exists() for file in theirs)
    assert not unfinished.exists()
    assert not hidden.exists()
