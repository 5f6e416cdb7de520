"""What the pages for newcomers say is true: their examples run, and give what they promise."""

import re
from pathlib import Path
from textwrap import dedent

import pytest

from ringwear.studies.cli import COMMANDS

ROOT = Path(__file__).parents[2]
FLOORS = ("fem", "mdr", "meshes", "studies")


def test_the_example_of_the_finite_elements(capsys):
    page = (ROOT / "fem" / "README.md").read_text("utf-8")
    exec(dedent(re.search(r"\n(    import numpy.*?)\n\n\[1\]", page, re.DOTALL)[1]), {})
    told = capsys.readouterr().out
    start, again = (float(value) for value in re.findall(r"d0 = (\S+?),?\s", told))
    assert max(abs(start / 0.5 - 1), abs(again / 0.5 - 1)) < 1e-5
    assert "MeshTri" in told
    assert "ElementTriP4" in told


@pytest.mark.parametrize("floor", FLOORS)
def test_what_a_page_points_to_is_there(floor):
    """In the code, or in its sources, each of which is cited."""
    page = (ROOT / floor / "README.md").read_text("utf-8")
    names = re.findall(r"`([A-Za-z_]\w*(?:\.\w+)*)`", page)
    assert len(names) > 10
    files = [file for folder in FLOORS for file in (ROOT / folder).rglob("*.py")]
    code = {word for file in files for word in re.findall(r"\w+", f"{file} {file.read_text()}")}
    # elements of scikit-fem that users may give
    code |= {"ElementTriP1", "ElementTriP4"}
    assert {word for name in names for word in name.split(".")} <= code
    sources = re.findall(r"(?m)^\[(\d)\]", page)
    assert sources
    assert all(page.count(f"[{number}]") >= 2 for number in sources)


def test_the_readme_names_every_command_and_flag():
    text = (ROOT / "README.md").read_text("utf-8")
    assert "--version" in text
    for name, command in COMMANDS.items():
        assert f"ringwear {name}" in text
        for flag in command.arguments:
            assert flag in text or not flag.startswith("--"), flag
