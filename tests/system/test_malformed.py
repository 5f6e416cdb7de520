"""What cannot be done is refused in a line that names the key and the remedy, with the right
status; nothing is written.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ringwear.studies.cli import main


def refused(
    arguments: list[str], told: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    """Status 2, one line on standard error that tells all of it, and nothing on standard output."""
    try:
        status = main(arguments)
    except SystemExit as end:
        status = int(end.code or 0)
    assert status == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    # argparse says how the command is used before what is wrong
    (line,) = [line for line in shown.err.splitlines() if line and not re.match(r"usage:| ", line)]
    assert "pydantic" not in line
    assert all(part in line for part in told), line


# {tmp} is an empty directory with a file, a dangling link and a full device in it
COMMANDS: list[tuple[list[str], tuple[str, ...]]] = [
    (["run", "no_such_scene"], ("no_such_scene", "five_rings")),
    (["run", "{tmp}"], ("directory", "five_rings")),
    (["run", "{tmp}/bytes"], ("not a text file", "UTF-8")),
    (["run", "five_rings", "--out", ""], ("--out", "give a directory")),
    (["run", "five_rings", "--out", "{tmp}/file"], ("--out", "give a directory")),
    (["run", "five_rings", "--out", "{tmp}/file/below"], ("--out", "another directory")),
    (["run", "five_rings", "--out", "{tmp}/dangling"], ("--out", "give a directory")),
    (["run", "five_rings", "--out", "/dev/null/nothing"], ("--out", "cannot be written to")),
    (["run", "five_rings", "--memory", "0.1"], ("--memory GIB", "punch.rings")),
    (["run", "five_rings", "--rtol", "small"], ("--rtol", "small")),
    (["run", "five_rings", "--rtol", "nan"], ("rtol", "1e-9 to 0.1")),
    (["run", "five_rings", "--rtol", "-1e-4"], ("--rtol",)),
    (["run", "five_rings", "--methods", ""], ("methods", "mdr")),
    (["run", "five_rings", "--methods", "mdr,fdm"], ("fdm", "mdr")),
    (["run", "five_rings", "--methods", "mdr,mdr"], ("twice",)),
    (["run", "/dev/null"], ("missing keys punch, half_space, load",)),
    (["run", "{tmp}/file/below"], ("below",)),
    (["mesh", "five_rings", "--out", "{tmp}/file/below"], ("--out",)),
    (["run", "five_rings", "--fast"], ("--fast",)),
    (["walk"], ("walk", "run")),
    ([], ("COMMAND",)),
    (["plan"], ("scene",)),
    (["plan", "nothing"], ("nothing", "five_rings")),
    (["mesh", "five_rings", "--out", "{tmp}/file"], ("--out", "give a directory")),
    (["compare", "five_rings"], ("B",)),
    (["compare", "{tmp}", "five_rings", "--out", "{tmp}/new"], ("results.nc", "ringwear run")),
    (["study", "everything"], ("everything", "paper")),
    (["study", "paper", "--fig", "3"], ("--fig", "3")),
    (["study", "march", "--out", ""], ("--out", "give a directory")),
    (
        ["study", "refinement", "--mesh", "{tmp}/none.msh", "--out", "{tmp}/new"],
        ("--mesh", "none.msh"),
    ),
    (
        ["study", "refinement", "--mesh", "{tmp}/file", "--out", "{tmp}/new"],
        ("--mesh", "file", "mesh"),
    ),
    (["study", "refinement", "--mesh", "{tmp}", "--out", "{tmp}/new"], ("--mesh", "directory")),
    (["study", "refinement", "--mesh", "", "--out", "{tmp}/new"], ("--mesh",)),
]


@pytest.mark.parametrize(
    ("arguments", "told"),
    COMMANDS,
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_malformed_commands(
    arguments: list[str],
    told: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    there = tmp_path / "there"
    there.mkdir()
    (there / "file").write_text("mine", "utf-8")
    (there / "bytes").write_bytes(b"\xff\xfe\x80")
    (there / "dangling").symlink_to(there / "nowhere")
    monkeypatch.chdir(tmp_path)
    refused([part.replace("{tmp}", str(there)) for part in arguments], told, capsys)
    assert {entry.name for entry in tmp_path.rglob("*")} == {"there", "file", "bytes", "dangling"}
    assert (there / "file").read_text("utf-8") == "mine"
