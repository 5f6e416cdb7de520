"""Workers of a sweep that are stopped while they start."""

from __future__ import annotations

import time

import pytest
from test_sweep_faults import LONG, alive, begin, children

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
