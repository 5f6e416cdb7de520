"""Texts of users are one line everywhere, and names of files choose no folder outside `results`.

A title with an end of line would put commands into decks of other programs, and escape sequences
would reach the terminal.
"""

import re
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import tomli_w
from groups import nightly_but

from ringwear import Scene, SceneError, check, deck, method, run, study

FLAT = Scene.load("flat_punch").changed(methods=["mdr"], accuracy__rtol=1e-2)
CONTROLS = [
    "\n*INCLUDE, INPUT=secret",
    "\r\n*CLOAD",
    "\x1b[2J",
    "\x00",
    "\x85x",
    "\u2028x",
    "\u202ex",
]


@pytest.mark.parametrize("key", ["title", "units"])
@pytest.mark.parametrize("end", CONTROLS)
def test_a_title_and_units_are_one_line(key, end, command, tmp_path):
    table = {key: f"SI{end}"} | FLAT.table()
    table[key] = f"SI{end}"
    (tmp_path / "mine.toml").write_text(tomli_w.dumps(table), "utf-8")
    for line in ("run mine.toml", "deck mine.toml --for calculix", "plan mine.toml"):
        printed = command(line, 2)
        assert printed.out == ""
        (line,) = printed.err.split("\n")[:-1]
        assert f"{key}: " in line
        assert "give one line of text" in line
        assert line.isprintable()
    assert [file.name for file in tmp_path.iterdir()] == ["mine.toml"]
    with pytest.raises(SceneError, match="one line of text"):
        FLAT.changed({key: f"SI{end}"})


@pytest.mark.parametrize("title", ["Hertz’ Kugel, ø 5 µm ³ — “neu”", "a\u00a0b", "👩\u200d🔬", ""])
def test_any_printed_language_is_a_title(title):
    assert FLAT.changed(title=title).title == title


@pytest.mark.parametrize("program", ["calculix", "abaqus"])
@pytest.mark.parametrize("title", ["*INCLUDE, INPUT=secret", "** times: 1, 2", "  *CLOAD"])
def test_no_title_is_a_keyword_or_a_comment_of_a_deck(program, title, tmp_path):
    """The lines of a deck with such a title are those of the deck with another title, but one."""
    for name, given in (("plain", "Plain"), ("odd", title)):
        deck(FLAT.changed(title=given), program, tmp_path / name, "Q1", size=0.5)
    decks = [path.name for path in (tmp_path / "plain").glob("*.inp")]
    assert decks
    for name in decks:
        plain, odd = ((tmp_path / each / name).read_text().split("\n") for each in ("plain", "odd"))
        changed = [(a, b) for a, b in zip(plain, odd, strict=True) if a != b]
        ((line, odd_line),) = changed
        assert line.replace("Plain", title) == odd_line
        assert not odd_line.lstrip().startswith("*")


def test_names_of_programs_methods_and_quantities_are_one_line():
    table = pd.DataFrame({"time": [0.0], "indentation": [0.97]})
    with pytest.raises(SceneError, match="name of a method or a program: 'a"):
        check(FLAT, {"a\nb": table})

    class Own(type(method("mdr"))):
        name = "own\x1b[31m"

    with pytest.raises(SceneError, match="name of a method or a program: 'own"):
        run(FLAT, methods=[Own()])
    with pytest.raises(SceneError, match="name of a quantity: 'p"):
        study("convergence", quantities={"p\\\\\n": lambda _: 1.0}, quick=True)


@pytest.mark.slow
def test_names_of_files_and_columns_are_shown_with_escape_sequences(command, tmp_path):
    escape = "\x1b[31m"
    name, heading = f"scene{escape}.toml", f"odd{escape}"
    (tmp_path / name).write_text(FLAT.changed(methods=["direct"]).to_toml(), "utf-8")
    printed = [command(f"run '{name}' --no-figures"), command(f"run 'absent{escape}'", 2)]
    pd.DataFrame({"time": [0.0], "indentation": [1.0], heading: [1.0]}).to_csv("their.csv")
    printed.append(command("check flat_punch their.csv"))
    errors = "".join(each.err for each in printed)
    assert r"absent\x1b[31m" in errors
    assert r"odd\x1b[31m" in errors
    assert escape not in errors + "".join(each.out for each in printed)


NAMES = ["...toml", "..toml", ".toml", "....toml", "..x.toml", "x..toml", "...", ".. .toml"]


RUN = "run {} --no-figures"
OTHERS = ["mesh {}", "deck {} --for abaqus", "sweep {} --workers 1"]


@pytest.mark.parametrize(
    ("line", "name"),
    nightly_but(
        [(RUN, "...toml")], [*product([RUN], NAMES), *product(OTHERS, ["...toml", "..x.toml"])]
    ),
)
def test_no_name_of_a_file_leads_outside_of_results(line, name, command, tmp_path, monkeypatch):
    home = tmp_path / "above" / "home"
    home.mkdir(parents=True)
    monkeypatch.chdir(home)
    scene = FLAT.changed(methods=["direct"])
    text = scene.to_toml()
    if line.startswith("sweep"):
        sweep = {"base": scene.table(), "axes": {"punch.radius": [1.0, 2.0]}}
        text = tomli_w.dumps(sweep)
    (home / name).write_text(text, "utf-8")
    command(line.format(f"'{name}'"))
    written = [path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file()]
    inside = Path("above/home/results")
    others = [path for path in written if inside not in path.parents]
    assert others == [Path("above/home") / name]
    # every result is in a folder of its own that is not hidden
    (folder,) = (home / "results").iterdir()
    assert folder.is_dir()
    assert re.fullmatch(r"[^.].*[^.]|[^.]", folder.name)


def test_control_characters_of_a_file_are_no_lines_of_a_page(command, tmp_path):
    """The name of a checked file stands in figures, tables and the page."""
    times = np.array([0.0, 1.0])
    pd.DataFrame({"time": times, "indentation": 1.0 + 0 * times}).to_csv("a\nb.csv", index=False)
    (line,) = command("check flat_punch 'a\nb.csv'", 2).err.split("\n")[:-1]
    assert r"'a\nb.csv' has the control character '\n'" in line
    assert not (tmp_path / "results").exists()
