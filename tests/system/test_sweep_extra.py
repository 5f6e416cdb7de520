"""Sweeps without the extra `sweep`, and stores that are moved, linked or mixed up."""

import shutil
import subprocess
import sys

import pytest
from test_sweep_faults import AXES, BASE, KEEP

from ringwear import SceneError
from ringwear.studies.sweep.axes import Sweep
from ringwear.studies.sweep.compute import compute_block
from ringwear.studies.sweep.results import HIDDEN, Store

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


def plan(**changes):
    table = {"base": BASE.changed(**changes).table(), "axes": AXES, "keep": KEEP}
    return Sweep.of(table)


@pytest.fixture
def store(tmp_path):
    """A finished store of three blocks."""
    folder = tmp_path / "done"
    folder.mkdir()
    finished = Store(plan(), folder, resume=False)
    for number, block in finished.unfinished(False).items():
        finished.write(number, compute_block(block, finished.blank))
    return finished


@pytest.mark.slow
def test_a_sweep_in_memory_needs_no_extra(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_EXTRA], cwd=tmp_path, capture_output=True, text=True
    )
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


def test_leftovers_beside_arrays_of_a_store_are_kept(store):
    """Only unfinished files of Zarr and of a killed sweep are removed."""
    mine = store.path / "mine"
    mine.mkdir()
    theirs = [mine / "notes.partial", store.path / "status" / "c" / "0.partial"]
    for file in theirs:
        file.write_text("of someone else", "utf-8")
    hidden = store.path.with_name(f"{HIDDEN}a")
    hidden.mkdir()
    unfinished = store.path / "status" / "c" / "0" / f"0.{32 * 'a'}.partial"
    unfinished.write_bytes(b"")
    Store(plan(), store.path.parent, resume=True)
    assert all(file.exists() for file in theirs)
    assert not unfinished.exists()
    assert not hidden.exists()
    with pytest.raises(SceneError, match="already exists"):
        Store(plan(), store.path.parent, resume=False)
