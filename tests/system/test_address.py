"""One command writes the address of the repository; releases are refused without it."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ADDRESS = "https://github.com/someone/ringwear"


@pytest.fixture
def copied(tmp_path):
    """Return a function that runs the command in a copy of the files that it changes."""
    for name in ("README.md", "CITATION.cff", "pyproject.toml", ".ci/address.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    # once the address of the repository is known, it is in these files
    project = tmp_path / "pyproject.toml"
    text = re.sub(r"\[project\.urls\]\n(?:[^\[\n]*\n)*", "", project.read_text("utf-8"))
    project.write_text(text, "utf-8")

    def run(*arguments):
        command = [sys.executable, tmp_path / ".ci" / "address.py", *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    return run


def test_the_address_is_written_everywhere(copied, tmp_path):
    done = copied("--check", "v0.1.0")
    assert done.returncode == 1
    assert "the address of the repository is not known" in done.stderr
    for address in ("github.com/someone/ringwear", "https://example.org/x", ""):
        assert "give the address as" in copied(address).stderr
    for _ in range(2):  # a second time changes nothing
        assert copied(ADDRESS).returncode == 0
        texts = {
            file.name: file.read_text("utf-8") for file in tmp_path.iterdir() if file.is_file()
        }
        project = tomllib.loads(texts["pyproject.toml"])["project"]
        assert project["urls"]["Repository"] == ADDRESS
        assert project["urls"]["Documentation"] == "https://someone.github.io/ringwear/"
        assert project["scripts"]["ringwear"] == "ringwear.studies.cli:main"
        assert texts["CITATION.cff"].count(f"repository-code: {ADDRESS}\n") == 1
        assert f"]({ADDRESS}/raw/main/.github/five_rings.png)" in texts["README.md"]
        assert f"]({ADDRESS}/blob/main/studies/reference.md)" in texts["README.md"]
        assert "](studies/" not in texts["README.md"]
    assert copied("--check", "v0.1.0").returncode == 0
    assert "the tag is v0.2.0" in copied("--check", "v0.2.0").stderr
