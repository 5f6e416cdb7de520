"""Continue a study that was stopped: find its rows, and refuse those of another study."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...meshes import SceneError
from ..crosscheck import LOG, computed_with
from ..tables.writing import json_text
from .record import Record

HIDDEN = ".writing"
"""Folder in which a study that was killed has left its rows."""


def rows_before(out: Path, name: str, setup: Mapping[str, Any]) -> str:
    """Return the rows that a stopped study has left in its folder; empty if there are none.

    Parameters
    ----------
    out : output folder
    name : name of the study
    setup : scene and options, which have to be the same

    Raises
    ------
    SceneError
        if the rows are those of another scene, of other options, or of another version
    """
    for folder in (out / HIDDEN, out):
        rows, described = folder / f"{name}.csv", folder / f"{name}.json"
        if not (rows.is_file() and described.is_file()):
            continue
        before, now = json.loads(described.read_text("utf-8")), _described(setup)
        differing = [key for key in now if before.get(key) != now[key]]
        if differing:
            raise SceneError(
                f"--resume: {rows} was written with another {' and '.join(differing)}: leave out "
                "--resume, or give another --out"
            )
        text = rows.read_text("utf-8")
        count = max(text.count("\n") - 1, 0)
        LOG.info("   resuming: %d rows of %s are kept", count, rows)
        return text
    LOG.info("   nothing to resume in %s: the study starts anew", out)
    return ""


def as_before(folder: Path, name: str, setup: Mapping[str, Any], text: str) -> Record:
    """Return the record of a study in a folder, with the rows of a stopped one.

    A file beside the table describes the study, so that it can be resumed.
    """
    described = json_text(_described(setup), indent=1)
    (folder / f"{name}.json").write_text(described + "\n", "utf-8")
    file = folder / f"{name}.csv"
    return Record.resumed(text, file) if text else Record(file)


def _described(setup: Mapping[str, Any]) -> dict[str, Any]:
    """Return what determines the rows of a study, as JSON stores it."""
    described = {**setup, "version": computed_with()}
    return dict(json.loads(json_text(described, default=str)))
