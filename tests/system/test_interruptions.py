"""An interruption ends a command with one line, also while its modules are loaded."""

import subprocess
import sys

import pytest
from groups import nightly

# a process that is interrupted at the moment at which a module is about to be loaded
INTERRUPTED_IMPORT = """
import signal, sys

class Interruption:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[1]:
            sys.meta_path.remove(self)
            signal.raise_signal(signal.SIGINT)

# where the tests themselves run in the background, the shell has told them to ignore it
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Interruption())
from ringwear import main
sys.exit(main(["run", "flat_punch", "--rtol", "1e-2", "--out", sys.argv[2]]))
"""
MODULES = [
    "numpy",
    *nightly("pydantic", "argparse", "scipy.linalg", "skfem", "netCDF4", "matplotlib"),
    *nightly("ringwear.studies.crosscheck.scene.scene", "ringwear.studies.report.page"),
]


@pytest.mark.parametrize("module", MODULES)
def test_an_interruption_while_modules_are_loaded_is_one_line(module, tmp_path):
    call = [sys.executable, "-c", INTERRUPTED_IMPORT, module, str(tmp_path / "out")]
    done = subprocess.run(call, text=True, capture_output=True, timeout=120)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "ringwear: stopped; no incomplete files are left"
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


LATER = """
import signal, sys
from ringwear import main
from ringwear.studies.crosscheck.result import run

def fail(scene, **_):
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise ImportError("a library could not be loaded")

signal.signal(signal.SIGINT, signal.default_int_handler)
run.run = fail
sys.exit(main(["run", "flat_punch", "--out", sys.argv[1]]))
"""


@pytest.mark.slow
def test_an_interruption_that_a_library_turns_into_an_error_is_one_line(tmp_path):
    call = [sys.executable, "-c", LATER, str(tmp_path / "out")]
    done = subprocess.run(call, text=True, capture_output=True, timeout=120)
    assert done.returncode == 1
    assert done.stderr == "ringwear: stopped; no incomplete files are left\n"
    assert not (tmp_path / "out").exists()
