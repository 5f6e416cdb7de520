"""The page of a run or of a study.

One file that opens from disk, without a network, and prints on A4.
"""

import base64
import csv
from collections.abc import Iterable
from importlib.resources import files
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from jinja2 import Environment, StrictUndefined, select_autoescape

from ..crosscheck.dataset import Result, versions
from ..crosscheck.scope import left_out, modelled
from ..problem.scene import Scene
from . import words
from .slides import slides

# what each figure shows, in the order of the page
CAPTIONS = {
    "profiles_and_pressures.png": (
        "Worn profiles less their least wear, and contact pressures, at some of the times."
    ),
    "history.png": (
        "Running-in: greatest displacement and RMS slope over time, and by how much the methods "
        "differ."
    ),
    "contact.png": (
        "Edges of the contact over time, its inside shaded, and what each ring carries and has "
        "worn off."
    ),
    "steady_state.png": "The steady state: limiting profile and pressure.",
    "operator_difference.png": "The methods compared for every pressure at once: long waves, of "
    "which the answer is "
    "made, are at the right; waves shorter than the elements, at the left, are beyond either "
    "method.",
    "stress.png": "Von Mises stress in the half-space.",
    "mesh.png": "The mesh of the half-space.",
}
MOST_ROWS = 200


class Picture(NamedTuple):
    """A figure within the page."""

    source: str
    caption: str


def write_report(result: Result, directory: Path, path: Path) -> None:
    """Write the page of a run; its figures are those in the directory."""
    pictures = [
        _picture(directory / name, caption)
        for name, caption in CAPTIONS.items()
        if (directory / name).exists()
    ]
    _write(
        path,
        "run.html.j2",
        title=result.scene.title or "Untitled scene",
        sentences=words.sentences(result),
        defaults=words.defaults_taken(result),
        answers=words.answer_lines(result),
        answered_by=words.answered_by(result),
        rings=words.ring_rows(result, most=256),
        verdict=result.verdict if result.agreement else "one method",
        verdict_line=words.verdict(result),
        methods=words.method_rows(result),
        agreement=words.agreement_rows(result),
        anchors=words.anchor_rows(result),
        remarks=words.remarks(result),
        slides=slides(result),
        pictures=pictures,
        modelled=modelled(result.scene),
        left_out=left_out(result.scene),
        scene=result.scene.to_toml(),
        versions=versions(),
    )


def write_study(
    study: tuple[str, str], scene: Scene, conclusions: Iterable[str], directory: Path, path: Path
) -> None:
    """Write the page of a study, by its name and purpose.

    Its figures and tables are those in the directory.
    """
    name, purpose = study
    pictures = [
        _picture(file, file.stem.replace("_", " ")) for file in sorted(directory.glob("*.png"))
    ]
    tables = {file.stem.replace("_", " "): _table(file) for file in sorted(directory.glob("*.csv"))}
    # tables stand below
    kept = [line for line in conclusions if not line.startswith("|")]
    known: dict[str, Any] = {
        "pictures": pictures,
        "tables": tables,
        "scene": scene.to_toml(),
        "versions": versions(),
    }
    _write(
        path, "study.html.j2", title=f"Study: {name}", purpose=purpose, conclusions=kept, **known
    )


def _write(path: Path, template: str, **known: Any) -> None:
    folder = files("ringwear.studies") / "report"

    def load(name: str) -> str:
        return (folder / name).read_text("utf-8")

    environment = Environment(
        autoescape=select_autoescape(default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    # the script and the style are ours, and are not to be escaped
    page = environment.from_string(load("page.html.j2"))
    known |= {"style": load("page.css"), "script": load("slides.js"), "layout": page}
    path.write_text(environment.from_string(load(template)).render(**known), "utf-8")


def _picture(file: Path, caption: str) -> Picture:
    return Picture(f"data:image/png;base64,{base64.b64encode(file.read_bytes()).decode()}", caption)


def _table(file: Path) -> words.Rows:
    with file.open(newline="", encoding="utf-8") as text:
        lines = list(islice(csv.reader(text), MOST_ROWS + 1))
    return words.Rows(tuple(lines[0]), [tuple(_cell(cell) for cell in line) for line in lines[1:]])


def _cell(text: str) -> str:
    """Numbers to four digits."""
    try:
        return f"{float(text):.4g}" if "." in text or "e" in text else text
    except ValueError:
        return text
