"""All blocks of a store are computed by one version of the code.

Copies of the package are altered, and run in processes of their own.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import tomli_w
from test_sweep_cluster import cluster as cluster
from test_sweep_faults import contents, statuses

from ringwear import Scene

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
            folder = str(Path(%r) / FOLDERS[name])
            return spec_from_file_location(
                name, f"{folder}/__init__.py", submodule_search_locations=[folder]
            )
sys.meta_path.insert(0, Copy)
"""
STEADY = "mdr/direct.py", "return 1 / (wear_coefficients", "return 1.1 / (wear_coefficients"
SWEEP = {
    "base": Scene.load("five_rings").changed(methods=["direct"]).table(),
    "keep": ["steady_wear_rate"],
    "axes": {"punch.rings": [2, 3], "punch.wear_ratio": {"geomspace": [0.5, 4.0, 8]}},
}


def copy_package(folder):
    """Copy ringwear, and return the code by which a process loads the copy."""
    for name in ("meshes", "mdr", "fem", "studies"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    return FINDER % str(folder)


def alter(folder, file, before, after):
    path = folder / file
    text = path.read_text("utf-8")
    assert before in text
    path.write_text(text.replace(before, after), "utf-8")


def run_with(finder, directory, *arguments):
    """Run the command with the copy of the package."""
    code = f"{finder}\nfrom ringwear import main\nif __name__ == '__main__':\n"
    code += f"    sys.exit(main(['sweep', 'sweep.toml', '--out', 'out', *{arguments!r}]))"
    (directory / "run.py").write_text(code)
    command = [sys.executable, "run.py"]
    return subprocess.run(command, cwd=directory, text=True, capture_output=True)


@pytest.mark.slow
def test_a_resume_with_altered_code_is_refused(tmp_path):
    """The altered code has the same version, but gives other numbers; none of them is stored."""
    finder = copy_package(tmp_path / "copy")
    (tmp_path / "sweep.toml").write_text(tomli_w.dumps(SWEEP))
    assert run_with(finder, tmp_path, "--workers", "1").returncode == 0
    status = tmp_path / "out" / "sweep.zarr" / "status" / "c" / "0" / "0"
    status.unlink()
    before = contents(tmp_path / "out")
    alter(tmp_path / "copy", *STEADY)
    refused = run_with(finder, tmp_path, "--workers", "1", "--resume")
    assert refused.returncode == 2
    (line,) = refused.stderr.splitlines()
    assert "begun with another sweep file, other code of ringwear or other libraries" in line
    assert contents(tmp_path / "out") == before
    # the original code continues
    alter(tmp_path / "copy", STEADY[0], STEADY[2], STEADY[1])
    assert run_with(finder, tmp_path, "--workers", "1", "--resume").returncode == 0
    assert statuses(tmp_path / "out") == [1] * 16


@pytest.mark.parametrize("imported", [True, False])
def test_the_hash_is_that_of_the_loaded_code(tmp_path, imported):
    """An edit after a file is loaded does not change the hash; an edit before does."""
    finder = copy_package(tmp_path / "copy")
    code = f"""{finder}
import ringwear
from ringwear.studies.crosscheck.versions import code
if {imported}:
    from ringwear.mdr import direct
before = code()
path = Path({str(tmp_path / "copy")!r}) / "mdr" / "direct.py"
path.write_text(path.read_text("utf-8").replace("return 1 / (wear", "return 1.1 / (wear"))
from ringwear.mdr import direct
print(before == code())
"""
    process = subprocess.run([sys.executable, "-c", code], text=True, capture_output=True)
    assert process.stdout == f"{imported}\n", process.stderr


@pytest.mark.slow
def test_code_edited_between_loading_and_hashing_has_a_hash_of_its_own(tmp_path):
    """The process has loaded a file, and hashes it only after the file was edited."""
    finder = copy_package(tmp_path / "copy")
    code = f"""{finder}
import ringwear
from ringwear.mdr import direct
path = Path({str(tmp_path / "copy")!r}) / "mdr" / "direct.py"
if len(sys.argv) > 1:
    path.write_text(path.read_text("utf-8"))
from ringwear.studies.crosscheck.versions import code
print(code())
"""
    call = [sys.executable, "-c", code]
    plain, edited, again = (
        subprocess.run([*call, *more], text=True, capture_output=True, check=True).stdout
        for more in ([], ["edit"], [])
    )
    assert plain == again != edited
