"""Impossible commands are refused: a line names key and remedy, and nothing is written."""

import re
import shlex

import pytest

from ringwear import main

# commands, and what the message must name; there is a folder with a file and a dangling link in it
COMMANDS = [
    ("run no_such_scene", "no_such_scene five_rings"),
    ("run there", "directory five_rings"),
    ("run there/bytes", "text UTF-8"),
    ("run /dev/null", "missing keys punch half_space load"),
    ("run five_rings --out ''", "--out directory"),
    ("run five_rings --out there/file", "--out directory"),
    ("run five_rings --out there/file/below", "--out another directory"),
    ("run five_rings --out there/dangling", "--out directory"),
    ("run five_rings --out /dev/null/nothing", "--out written"),
    ("run five_rings --rtol small", "--rtol small"),
    ("run five_rings --rtol nan", "rtol 1e-9 0.1"),
    ("run five_rings --methods ''", "methods mdr"),
    ("run five_rings --methods mdr,fdm", "fdm mdr"),
    ("run five_rings --fast", "--fast"),
    ("walk", "walk run"),
    ("", "COMMAND"),
    ("plan", "scene"),
    ("mesh five_rings --out there/file", "--out directory"),
    ("compare five_rings", "B"),
    ("compare there five_rings --out new", "summary.json ringwear run"),
    ("study everything", "everything paper"),
    ("study refinement --mesh none.msh --out new", "--mesh none.msh"),
    ("study refinement --mesh there/file --out new", "--mesh file"),
    ("study refinement --mesh there --out new", "--mesh directory"),
    ("study refinement --mesh '' --out new", "--mesh"),
    ("run five_rings --memory 0.1", "--memory punch.rings"),
]


@pytest.mark.parametrize(("command", "words"), COMMANDS)
def test_a_malformed_command_is_refused(command, words, tmp_path, monkeypatch, capsys):
    """The status is 2, one line on standard error has all words, and standard output is empty."""
    there = tmp_path / "there"
    there.mkdir()
    (there / "file").write_text("mine", "utf-8")
    (there / "bytes").write_bytes(b"\xff\xfe\x80")
    (there / "dangling").symlink_to(there / "nowhere")
    monkeypatch.chdir(tmp_path)
    try:
        status = main(shlex.split(command))
    except SystemExit as end:
        status = end.code
    assert status == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    # argparse prints the usage before the error
    (line,) = [line for line in shown.err.splitlines() if line and not re.match(r"usage:| ", line)]
    assert "pydantic" not in line
    assert all(word in line for word in words.split()), line
    assert {entry.name for entry in tmp_path.rglob("*")} == {"there", "file", "bytes", "dangling"}
    assert (there / "file").read_text("utf-8") == "mine"
