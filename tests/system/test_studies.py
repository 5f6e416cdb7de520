"""Tables that any study writes row by row, and that Ctrl-C keeps."""

import csv
import logging
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest
from groups import nightly, nightly_but

from ringwear import Scene, SceneError, main, study

LOG = logging.getLogger("ringwear")
INTERRUPTED = "INTERRUPTED"


def names_of_studies():
    """Return the names of all studies that solve levels, from the message about a wrong one."""
    with pytest.raises(SceneError) as refusal:
        study("absent")
    names = str(refusal.value).partition("give one of ")[2].split(", ")
    assert "march" in names
    return sorted({*names} - {"paper", "operators"})


def levels(path):
    """Return the levels in a table that are solved, each once, in their order."""
    rows = csv.DictReader(path.read_text("utf-8").splitlines())
    return list(dict.fromkeys((row["case"], row["way"], row["level"]) for row in rows))


@contextmanager
def interrupted_at(line):
    """Press Ctrl-C as the n-th line is logged."""

    class Stop(logging.Handler):
        left = line

        def emit(self, record):
            self.left -= "level" in record.getMessage()
            if self.left == 0:
                raise KeyboardInterrupt

    handler = Stop()
    LOG.addHandler(handler)
    try:
        yield
    finally:
        LOG.removeHandler(handler)


@pytest.mark.parametrize("line", [1, *nightly(2)])
@pytest.mark.parametrize("name", nightly_but(["march", "extremes"], names_of_studies()))
def test_a_study_stopped_early_keeps_its_tables(name, line, command, tmp_path):
    with interrupted_at(line):
        printed = command(f"study {name} five_rings --quick --out .", 1).out
    assert INTERRUPTED in printed
    assert len(levels(tmp_path / f"{name}.csv")) == line - 1
    assert INTERRUPTED in (tmp_path / "report.html").read_text("utf-8")


@pytest.mark.parametrize(("rows", "left"), [("a\n", []), ("a\n1\n", ["march.csv"])])
def test_ctrl_c_leaves_tables_with_rows_and_nothing_else(
    rows, left, command, tmp_path, monkeypatch
):
    def march(_, *, quick, record):
        assert quick
        record.file.write_text(rows, "utf-8")
        record.file.with_name("march.png").write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr("ringwear.studies.march.march", march)
    command("study march --quick --out .", 1)
    assert [file.name for file in tmp_path.glob("[!.]*")] == left


def test_ctrl_c_while_the_page_is_written_keeps_all_other_files(command, tmp_path, monkeypatch):
    write_text = Path.write_text

    def half_write(path, text, *arguments):
        write_text(path, text[: len(text) // 2], *arguments)
        if path.name == "report.html":
            raise KeyboardInterrupt
        return write_text(path, text, *arguments)

    monkeypatch.setattr(Path, "write_text", half_write)
    assert INTERRUPTED in command("study march --quick --out .", 1).out
    names = {file.name for file in tmp_path.iterdir()}
    assert {"march.csv", "orders.csv", "march.png"} <= names
    assert "report.html" not in names


@pytest.mark.nightly
def test_a_study_that_is_killed_is_resumed(tmp_path, capsys):
    """The rows of a process that was killed are kept, and the others are added to them."""
    out = tmp_path / "out"
    arguments = ["study", "refinement", "flat_punch", "--quick", "--out", str(out)]
    code = f"from ringwear import main; main({arguments})"
    hidden = out / ".writing" / "refinement.csv"
    with subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.DEVNULL) as study:
        while study.poll() is None and not (hidden.exists() and len(levels(hidden)) > 4):
            time.sleep(0.01)
        study.kill()
    before = hidden.read_text("utf-8").splitlines()
    assert main([*arguments, "--resume"]) == 0
    after = (out / "refinement.csv").read_text("utf-8").splitlines()
    assert after[: len(before)] == before
    assert len(after) > len(before)
    # another scene is refused
    assert main(["study", "refinement", *arguments[3:], "--resume"]) == 2
    assert "was written with another scene" in capsys.readouterr().err
    assert (out / "refinement.csv").read_text("utf-8").splitlines() == after


def test_tables_of_two_studies_of_one_scene_join():
    scene = Scene.load("flat_punch").changed(wear__times=[0.0, 0.1], accuracy__rtol=1e-3)
    extremes = study("extremes", scene, quick=True, vary={"punch.radius": [1.0]}, methods=["mdr"])
    convergence = study("convergence", scene, quick=True, methods=["mdr"])
    joined = pd.merge(extremes.table, convergence.table, on=["quantity", "when", "method"])
    parts = set(zip(joined["quantity"], joined["when"], strict=True))
    assert {("indentation", "start"), ("pressure", "later"), ("steady_profile", "all")} <= parts
