"""Workers of a sweep that are stopped while they start, or that lack memory."""

from __future__ import annotations

import time

import pytest
import tomli_w
import xarray
from test_sweep_faults import BASE, LONG, alive, begin, children, contents, statuses

from ringwear import main

pytestmark = pytest.mark.slow


# enough scenes for the sweep to be running when it is stopped
VERY_LONG = LONG | {
    "axes": LONG["axes"] | {"punch.wear_ratio": {"geomspace": [0.5, 4.0, 100]}},
}


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


# a small scene, and one that needs 0.55 GiB
LARGE = {
    "base": BASE.changed(methods=["mdr"], accuracy__rtol=1e-2, wear__times=[]).table(),
    "keep": ["steady_rms_slope"],
    "axes": {"punch.rings": [2, 100]},
}


def test_memory_that_no_worker_can_start_with_is_refused(tmp_path, capsys):
    """Workers that are ended for their memory while they start would be started again for ever."""
    command = ["sweep", "running_in", "--out", str(tmp_path / "out"), "--memory", "0.0001"]
    assert main(command) == 2
    assert "libraries" in capsys.readouterr().err


def test_scenes_that_lack_memory_stay_pending(tmp_path, capsys):
    """Other scenes are computed, the reason is stored, and more memory computes these scenes."""
    file, out = tmp_path / "sweep.toml", tmp_path / "out"
    file.write_text(tomli_w.dumps(LARGE))
    command = ["sweep", str(file), "--out", str(out), "--workers", "2"]
    for more in ([], ["--resume"]):
        assert main([*command, "--memory", "0.42", *more]) == 1
        streams = capsys.readouterr()
        assert "1 scenes finished, 0 failed, 1 left" in streams.out
        assert "it seems to need more than 0.42 GiB" in streams.out
        assert len([line for line in streams.err.splitlines() if "left out" in line]) == 1
        assert statuses(out) == [1, 0]
        stored = xarray.open_zarr(out / "sweep.zarr")
        assert "GiB" in str(stored["reason"].values[1])
        assert stored["steady_rms_slope"].notnull().all("solver").values.tolist() == [1, 0]
    assert main([*command, "--memory", "6", "--resume"]) == 0
    assert statuses(out) == [1, 1]
    assert main([*command, "--out", str(tmp_path / "whole"), "--memory", "6"]) == 0
    assert contents(out) == contents(tmp_path / "whole")
