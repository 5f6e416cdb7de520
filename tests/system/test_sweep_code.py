"""The hash of the code that a sweep stores is that of the code that has computed it.

Copies of the package are edited, and loaded in processes of their own.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ringwear.studies.crosscheck.versions import code

ROOT = Path(__file__).parents[2]
# loads ringwear from another folder
FINDER = """
import sys
from importlib.util import spec_from_file_location
from pathlib import Path
FOLDERS = {"ringwear": "studies/api"}
FOLDERS |= {f"ringwear.{name}": name for name in ("meshes", "mdr", "fem", "studies")}
class Copy:
    @staticmethod
    def find_spec(name, path=None, target=None):
        if name in FOLDERS:
            folder = Path.cwd() / FOLDERS[name]
            return spec_from_file_location(
                name, folder / "__init__.py", submodule_search_locations=[str(folder)]
            )
sys.meta_path.insert(0, Copy)
from ringwear.studies.crosscheck.versions import code
file = Path("mdr/direct.py")
"""
STEPS = {
    "load": "from ringwear.mdr import direct",
    "hash": "code()",
    "edit": "file.write_text(file.read_text('utf-8').replace('return 1 /', 'return 1.1 /'))",
}


@pytest.mark.parametrize(
    ("steps", "same"),
    [("load hash edit", True), ("hash edit load", False), ("load edit hash", False)],
)
def test_the_hash_is_that_of_the_loaded_code(tmp_path, steps, same):
    """If a file is edited before it is hashed, it is not known which version was loaded."""
    for name in ("meshes", "mdr", "fem", "studies"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, tmp_path / name, ignore=ignored)
    script = "\n".join([FINDER, *map(STEPS.get, steps.split()), "print(code())"])
    call = [sys.executable, "-c", script]
    done = subprocess.run(call, cwd=tmp_path, text=True, capture_output=True)
    assert (done.stdout == f"{code()}\n") == same, done.stderr
    assert done.returncode == 0
