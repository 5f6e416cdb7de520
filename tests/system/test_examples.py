"""The examples of the README run as they stand, and show what they say."""

import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "studies" / "examples"


def shown(name, where):
    """What an example prints, run in a directory of its own."""
    file = EXAMPLES / f"{name}.py"
    assert len(file.read_text("utf-8").splitlines()) <= 30
    done = subprocess.run([sys.executable, str(file)], cwd=where, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_a_convergence_study(tmp_path):
    rows = re.findall(
        r"rtol (\S+): indentation (\S+), steady slope (\S+)", shown("convergence", tmp_path)
    )
    assert len(rows) == 4
    for rtol, *errors in rows:
        assert max(map(float, errors)) < float(rtol)
    assert (tmp_path / "convergence.png").exists()


@pytest.mark.slow
def test_fem_against_mdr(tmp_path):
    told = shown("fem_against_mdr", tmp_path)
    assert told.startswith("The methods agree")
    assert (tmp_path / "fem_against_mdr.png").exists()


def test_a_mesh_of_ones_own(tmp_path):
    errors = [float(value) for value in re.findall(r"E\*\) (\S+)", shown("own_mesh", tmp_path))]
    # of order one in the size at the rim, which halves each time
    ratios = [one / other for one, other in pairwise(errors)]
    assert all(1.7 < ratio < 2.3 for ratio in ratios)
