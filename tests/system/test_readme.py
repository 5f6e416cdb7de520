"""What the pages for newcomers say is true: their examples run, and give what they promise."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from ringwear.studies.cli import COMMANDS

ROOT = Path(__file__).parents[2]
FLOORS = ("fem", "mdr", "meshes", "studies")


def test_the_example_of_the_finite_elements() -> None:
    page = (ROOT / "fem" / "README.md").read_text("utf-8")
    code = re.search(r"\n(    import numpy.*?)\n\n\[1\]", page, re.DOTALL)
    assert code is not None
    done = subprocess.run(
        [sys.executable, "-c", re.sub(r"(?m)^    ", "", code[1])],
        capture_output=True,
        text=True,
        cwd=ROOT,
    )
    assert done.returncode == 0, done.stderr
    values = [float(value) for value in re.findall(r"d0 = (\S+?),?\s", done.stdout)]
    assert len(values) == 2
    assert all(abs(value / 0.5 - 1) < 1e-5 for value in values)
    assert "MeshTri" in done.stdout
    assert "ElementTriP4" in done.stdout


def words_of_code() -> set[str]:
    """Files and words of the code."""
    files = [file for folder in FLOORS for file in (ROOT / folder).rglob("*.py")]
    words = {word for file in files for word in re.findall(r"\w+", file.read_text("utf-8"))}
    return words | {file.stem for file in files}


@pytest.mark.parametrize("floor", FLOORS)
def test_what_a_page_points_to_is_there(floor: str) -> None:
    text = (ROOT / floor / "README.md").read_text("utf-8")
    pointed = re.findall(r"`([A-Za-z_]\w*(?:\.\w+)*)`", text)
    assert len(pointed) > 10
    # elements of scikit-fem that users may give
    theirs = {"ElementTriP1", "ElementTriP4"}
    missing = {word for name in pointed for word in name.split(".")} - words_of_code() - theirs
    assert missing <= {"py"}


@pytest.mark.parametrize("floor", FLOORS)
def test_every_source_of_a_page_is_cited(floor: str) -> None:
    text = (ROOT / floor / "README.md").read_text("utf-8")
    numbers = re.findall(r"(?m)^\[(\d)\]", text)
    assert numbers
    assert all(text.count(f"[{number}]") >= 2 for number in numbers)


def test_the_readme_names_every_command_and_flag() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    assert "--version" in text
    for name, command in COMMANDS.items():
        assert f"ringwear {name}" in text
        for flag in command.arguments:
            assert flag in text or not flag.startswith("--"), flag
