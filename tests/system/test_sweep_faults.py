"""Sweeps that are interrupted, damaged or led astray end with the same bytes as undisturbed ones,
or say why not.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

from ringwear import Scene, sweep
from ringwear.meshes.errors import RingwearError, SceneError, SolverError
from ringwear.studies.cli import main
from ringwear.studies.output.folder import lock_folder
from ringwear.studies.sweep import compute, store
from ringwear.studies.sweep.store import Store
from ringwear.studies.versions import differing, fingerprint

# three blocks of eight scenes
BASE = Scene.load("five_rings").changed(methods=["mdr", "direct"], accuracy__rtol=1e-1)
AXES = {"punch.rings": [2, 3, 4], "punch.wear_ratio": {"geomspace": [0.5, 4.0, 8]}}
NAME = "sweep.zarr"
KEEP = ["steady_displacement_max", "steady_rms_slope"]
FILE = """
keep = ["indentation", "steady_rms_slope"]
[base]
methods = ["mdr", "direct"]
punch = { radius = 1.0, rings = 5, wear_coefficients = [1.0, 10.0] }
half_space = { plane_strain_modulus = 1.0 }
load = { normal_force = 2.0 }
wear = { times = [0.0, 0.1] }
accuracy = { rtol = 1e-2 }
[axes]
"punch.rings" = [2, 3, 4, 5, 6, 7, 8, 9, 10]
"punch.wear_ratio" = { geomspace = [0.5, 4.0, 9] }
"""
# the command, and a line in a file for each block that is in the store
CODE = """
import sys
from pathlib import Path
from ringwear.studies.cli import main
from ringwear.studies.sweep.store import Store
write = Store.write
def counted(self, number, values):
    write(self, number, values)
    with open(sys.argv[2] + ".blocks", "a") as file:
        file.write(f"{number}\\n")
Store.write = counted
if __name__ == "__main__":
    raise SystemExit(main(["sweep", sys.argv[1], "--out", sys.argv[2], *sys.argv[3:]]))
"""


def contents(directory: Path) -> dict[str, bytes]:
    """All files of a store, and its index."""
    files = [*(directory / NAME).rglob("*"), directory / "sweep.index"]
    return {str(file.relative_to(directory)): file.read_bytes() for file in files if file.is_file()}


def swept(directory: Path, **options: object) -> xarray.Dataset:
    return sweep(BASE, AXES, KEEP, out=directory, **options)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("undisturbed")
    swept(directory)
    return directory


def test_memory_and_disk_hold_the_same(undisturbed: Path) -> None:
    xarray.testing.assert_identical(sweep(BASE, AXES, KEEP), swept(undisturbed, resume=True).load())


def test_the_clock_plays_no_part(
    tmp_path: Path, undisturbed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Set back by a year at every look, it changes nothing."""
    now = iter(range(10**9, 0, -31_536_000))
    monkeypatch.setattr(time, "time", lambda: float(next(now, 0)))
    swept(tmp_path)
    assert contents(tmp_path) == contents(undisturbed)


def stopping(monkeypatch: pytest.MonkeyPatch, error: BaseException, at: int) -> None:
    """Writing fails once, after so many arrays of results."""
    write, calls = store.zarr.Array.__setitem__, iter(range(10**9))

    def failing(self: object, region: object, values: object) -> None:
        if region != slice(None) and next(calls) == at:
            raise error
        write(self, region, values)

    monkeypatch.setattr(store.zarr.Array, "__setitem__", failing)


@pytest.mark.parametrize(
    "error", [KeyboardInterrupt(), OSError(28, "No space left on device")], ids=str
)
@pytest.mark.parametrize("at", [0, 8, 13])
def test_stopped_anywhere(
    tmp_path: Path,
    undisturbed: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    at: int,
) -> None:
    with monkeypatch.context() as patch:
        stopping(patch, error, at)
        with pytest.raises((KeyboardInterrupt, OSError)):
            swept(tmp_path)
    assert contents(tmp_path) != contents(undisturbed)
    swept(tmp_path, resume=True)
    assert contents(tmp_path) == contents(undisturbed)


def flipped(content: bytes, _: Path) -> bytes:
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 4]) + content[middle + 1 :]


def truncated(content: bytes, _: Path) -> bytes:
    return content[:-5]


def swapped(_: bytes, file: Path) -> bytes:
    """Another block's shard, whole in itself."""
    return Path(str(file).replace("/c/2/", "/c/1/")).read_bytes()


def emptied(*_: object) -> bytes:
    return b""


@pytest.mark.parametrize("damage", [flipped, truncated, swapped, emptied, None])
@pytest.mark.parametrize("what", ["steady_rms_slope", "disagreement", "index"])
def test_damage_is_found_and_mended(
    tmp_path: Path,
    undisturbed: Path,
    monkeypatch: pytest.MonkeyPatch,
    what: str,
    damage: Callable[[bytes, Path], bytes] | None,
) -> None:
    """Only the block that is damaged is computed again; all, if it is the index."""
    shutil.copytree(undisturbed, tmp_path, dirs_exist_ok=True)
    shards = sorted((tmp_path / NAME / what / "c" / "2").rglob("?"))
    file = shards[-1] if shards else tmp_path / "sweep.index"
    if damage is None:
        file.unlink()
    else:
        file.write_bytes(damage(file.read_bytes(), file))
    written, write = list[int](), Store.write

    def counted(self: Store, number: int, values: Any) -> None:
        written.append(number)
        write(self, number, values)

    monkeypatch.setattr(Store, "write", counted)
    swept(tmp_path, resume=True)
    assert contents(tmp_path) == contents(undisturbed)
    if what != "index":
        assert written == [2]


@pytest.mark.parametrize("file", ["zarr.json", "status/zarr.json", "rings/c/0"])
def test_damaged_metadata_are_made_again(tmp_path: Path, undisturbed: Path, file: str) -> None:
    swept(tmp_path)
    path = tmp_path / NAME / file
    path.write_bytes(path.read_bytes()[:-5])
    swept(tmp_path, resume=True)
    assert contents(tmp_path) == contents(undisturbed)


def test_one_sweep_to_a_directory(tmp_path: Path) -> None:
    with lock_folder(tmp_path), pytest.raises(SceneError, match="another run"):
        swept(tmp_path)
    swept(tmp_path)
    with pytest.raises(SceneError, match="--resume"):
        swept(tmp_path)
    with pytest.raises(SceneError, match="another sweep"):
        sweep(BASE, AXES, KEEP[:1], out=tmp_path, resume=True)


def test_a_directory_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(SceneError, match="cannot be written"):
        swept(tmp_path / "file" / "out")


def statuses(directory: Path) -> list[int]:
    return xarray.open_zarr(directory / NAME)["status"].values.ravel().tolist()


@pytest.mark.parametrize(
    "error", [MemoryError("no room"), OSError(24, "Too many open files")], ids=str
)
def test_what_the_machine_lacked_is_tried_again(
    tmp_path: Path, undisturbed: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    """It is no failure of the scene, which stays pending; its neighbours are there."""
    solve = compute.solved_to_accuracy

    def starved(method: Any, problems: Any, stages: Any) -> Any:
        if any(np.isclose(problem.wear_coefficients.min(), 0.5) for problem in problems):
            raise error
        return solve(method, problems, stages)

    with monkeypatch.context() as patch:
        patch.setattr(compute, "solved_to_accuracy", starved)
        swept(tmp_path)
    dataset = xarray.open_zarr(tmp_path / NAME).load()
    pending = np.isclose(AXES["punch.wear_ratio"]["geomspace"][0], dataset["wear_ratio"])
    np.testing.assert_array_equal(dataset["status"], np.where(pending, 0, 1) * np.ones((3, 1)))
    assert str(error) in str(dataset["reason"].values[0, 0])
    assert np.isfinite(dataset["steady_rms_slope"].values[:, ~pending]).all()
    swept(tmp_path, resume=True)
    assert contents(tmp_path) == contents(undisturbed)


def test_the_command_ends_with_what_became_of_the_scenes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """1 where scenes failed, whose reason is said, or are left.

    Failed ones are tried again only if asked for.
    """
    (tmp_path / "sweep.toml").write_text(
        FILE.replace("9, 10]", "9]").replace("[2, 3, 4, 5, 6, 7, 8, ", "[2, 3, ")
    )
    command = ["sweep", str(tmp_path / "sweep.toml"), "--workers", "1", "--out"]
    whole, out = tmp_path / "whole", tmp_path / "out"
    assert main([*command, str(whole)]) == 0
    solve, tried = compute.solved_to_accuracy, list[int]()

    def failing(method: Any, problems: Any, stages: Any) -> Any:
        tried.append(len(problems))
        if len(problems[0].rings.ring_edges) == 3:
            raise failure
        return solve(method, problems, stages)

    for failure, status, word in (
        (ValueError("a bad day"), 2, "failed"),
        (MemoryError("full"), 0, "left"),
    ):
        shutil.rmtree(out, ignore_errors=True)
        monkeypatch.setattr(compute, "solved_to_accuracy", failing)
        assert main([*command, str(out)]) == 1
        assert statuses(out) == [status] * 9 + [1] * 18
        said = capsys.readouterr().out
        assert f"{word}: mdr: {type(failure).__name__}: {failure} (9 scenes)" in said
        tried.clear()
        assert main([*command, str(out), "--resume"]) == 1
        # a failure is final, and what the machine lacked is not
        assert bool(tried) == (status == 0)
        monkeypatch.setattr(compute, "solved_to_accuracy", solve)
        assert main([*command, str(out), "--resume", "--retry-failed"]) == 0
        assert contents(out) == contents(whole)
        capsys.readouterr()
    assert main([*command, str(out), "--retry-failed"]) == 2
    assert "give --resume" in capsys.readouterr().err


def test_methods_that_disagree_end_the_command_with_3(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sweep.toml").write_text(FILE)
    command = [
        "sweep",
        str(tmp_path / "sweep.toml"),
        "--workers",
        "1",
        "--out",
        str(tmp_path / "out"),
        "--resume",
    ]
    worst, solve = compute.worst, compute.solved_to_accuracy
    monkeypatch.setattr(compute, "worst", lambda *given: worst(*given)._replace(disagreement=1.5))
    assert main(command) == 3
    assert main(command) == 3

    def failing(method: Any, problems: Any, stages: Any) -> Any:
        if len(problems[0].rings.ring_edges) == 3:
            raise ValueError
        return solve(method, problems, stages)

    # a scene that failed comes before scenes that disagree
    monkeypatch.setattr(compute, "solved_to_accuracy", failing)
    shutil.rmtree(tmp_path / "out")
    assert main(command) == 1


def test_one_code_computes_a_store(
    tmp_path: Path, undisturbed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What another code, or other versions, have computed is not stored.

    And no other goes on with a store.
    """
    other = json.dumps(json.loads(fingerprint()) | {"code": "0", "numpy": "1.0"})
    for foreign in (other, ""):
        with monkeypatch.context() as patch:
            patch.setattr(compute, "FINGERPRINT", foreign)
            with pytest.raises(
                SolverError, match=r"has another .*numpy.*code than this process"
            ) as raised:
                swept(tmp_path / f"of {foreign[:9]}")
        assert "\n" not in str(raised.value)
        assert statuses(tmp_path / f"of {foreign[:9]}") == [0] * 24
    assert xarray.open_zarr(undisturbed / NAME).attrs["versions"] == fingerprint()
    shutil.copytree(undisturbed, tmp_path, dirs_exist_ok=True)
    monkeypatch.setattr(store, "fingerprint", lambda: other)
    with pytest.raises(SceneError, match=r"begun with another versions: install the ringwear"):
        swept(tmp_path, resume=True)
    assert contents(tmp_path) == contents(undisturbed)


def test_code_and_tables_have_a_fingerprint(tmp_path: Path) -> None:
    """That of a checkout is that of an installed copy, until one number in it changes."""
    tree = installed_copy(tmp_path)
    assert fingerprint_of(tree) == fingerprint()
    for name in (
        "studies/wear/flat_contact.py",
        "studies/scenes/five_rings.toml",
        "mdr/transforms.py",
    ):
        file = tree / "ringwear" / name
        text = file.read_text("utf-8")
        file.write_text(text + "\n", "utf-8")
        assert differing(fingerprint_of(tree)) == "code", name
        file.write_text(text, "utf-8")
    assert fingerprint_of(tree) == fingerprint()


def installed_copy(directory: Path) -> Path:
    """A directory to put on the path, with ringwear in it as pip installs it."""
    root, tree = Path(__file__).parents[2], directory / "tree"
    quiet = shutil.ignore_patterns("__pycache__", "api")
    for part in ("meshes", "mdr", "fem", "studies"):
        shutil.copytree(root / part, tree / "ringwear" / part, ignore=quiet)
    shutil.copy(root / "studies/api/__init__.py", tree / "ringwear")
    return tree


def fingerprint_of(tree: Path) -> str:
    code = (
        "from ringwear.studies import "
        "versions\nprint(versions.__file__)\nprint(versions.fingerprint())"
    )
    found = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": str(tree)},
    )
    where, known = found.stdout.splitlines()
    assert Path(where).is_relative_to(tree)
    return known


@pytest.mark.slow
def test_processes_give_the_same(tmp_path: Path, undisturbed: Path) -> None:
    swept(tmp_path, workers=2)
    assert contents(tmp_path) == contents(undisturbed)


def test_a_scheduler_that_does_not_answer(tmp_path: Path) -> None:
    with pytest.raises(RingwearError, match="does not answer"):
        swept(tmp_path, scheduler="tcp://127.0.0.1:9")


def begun(tmp_path: Path, out: Path, *arguments: str) -> subprocess.Popen[str]:
    """The command, in a process of its own."""
    (tmp_path / "sweep.toml").write_text(FILE)
    (tmp_path / "counted.py").write_text(CODE)
    command = [
        sys.executable,
        str(tmp_path / "counted.py"),
        str(tmp_path / "sweep.toml"),
        str(out),
        *arguments,
    ]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, text=True, stdout=pipe, stderr=pipe, start_new_session=True)


def children(process: subprocess.Popen[str]) -> list[int]:
    listed = subprocess.run(
        ["ps", "--ppid", str(process.pid), "-o", "pid="],
        capture_output=True,
        text=True,
        check=False,
    )
    return [int(one) for one in listed.stdout.split()]


def alive(process: int) -> bool:
    """Whether a process runs; one that has ended may wait for its parent to look."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def until_written(out: Path, process: subprocess.Popen[str]) -> None:
    """Wait until a block is in the store."""
    while process.poll() is None and not Path(f"{out}.blocks").exists():
        time.sleep(0.05)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The store of the undisturbed command."""
    directory = tmp_path_factory.mktemp("whole")
    assert begun(directory, directory / "out", "--workers", "1").wait() == 0
    return contents(directory / "out")


@pytest.mark.slow
def test_killed_again_and_again(tmp_path: Path, whole: dict[str, bytes]) -> None:
    """At random moments; no finished block is computed twice, and workers end with the command."""
    generator = random.Random(4)
    for trial in range(3):
        out = tmp_path / f"killed{trial}"
        for _ in range(4):
            process = begun(tmp_path, out, "--workers", "2", "--resume")
            time.sleep(generator.uniform(0.2, 12.0))
            workers = children(process)
            process.kill()
            process.wait()
            deadline = time.monotonic() + 20
            while any(map(alive, workers)):
                assert time.monotonic() < deadline
                time.sleep(0.05)
        process = begun(tmp_path, out, "--workers", "2", "--resume")
        _, errors = process.communicate()
        assert process.returncode == 0, errors
        assert contents(out) == whole
        computed = Path(f"{out}.blocks").read_text().split()
        assert len(set(computed)) == len(computed)


@pytest.mark.slow
def test_a_worker_process_that_dies(tmp_path: Path, whole: dict[str, bytes]) -> None:
    """Its block is computed by another; the store does not show it."""
    process = begun(tmp_path, tmp_path / "out", "--workers", "2")
    until_written(tmp_path / "out", process)
    os.kill(children(process)[-1], signal.SIGKILL)
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    assert contents(tmp_path / "out") == whole


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_stop_leaves_a_store_to_go_on_with(
    tmp_path: Path, whole: dict[str, bytes], number: int, workers: str
) -> None:
    """Ctrl-C reaches all processes of a terminal, SIGTERM one; both end in a line."""
    out = tmp_path / "out"
    process = begun(tmp_path, out, "--workers", workers)
    until_written(out, process)
    (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
    _, errors = process.communicate()
    assert process.returncode == 1
    assert "Traceback" not in errors
    assert 0 < statuses(out).count(1) < 81
    assert begun(tmp_path, out, "--resume").wait() == 0
    assert contents(out) == whole
