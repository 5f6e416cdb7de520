"""The page of a run or of a study.

One file that opens from disk, without a network, and prints on A4.
"""

import base64
import csv
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined

from ..crosscheck.dataset import Result
from ..figures.style import Picture
from ..problem.scene import Scene
from ..versions import versions
from .slides import slides
from .words import Account, Rows


def write_report(result: Result, account: Account, pictures: Iterable[Picture], path: Path) -> None:
    """Write the page of a run with those of the pictures that stand beside it."""
    shown = [(picture.file, picture.caption) for picture in pictures]
    rings = account.rings.shortened(256)
    about = vars(account) | {"rings": rings, "slides": slides(result)}
    _write(path, "run.html.j2", result.scene, shown, **about)


def write_study(
    name: str, purpose: str, scene: Scene, conclusions: Iterable[str], path: Path
) -> None:
    """Write the page of a study; its figures and tables are those that stand beside it."""
    directory = path.parent
    shown = [(file.name, _plain(file)) for file in sorted(directory.glob("*.png"))]
    tables = {_plain(file): _table(file) for file in sorted(directory.glob("*.csv"))}
    # tables stand below
    told = [line for line in conclusions if not line.startswith("|")]
    about = {"title": f"Study: {name}", "purpose": purpose, "conclusions": told, "tables": tables}
    _write(path, "study.html.j2", scene, shown, **about)


def _write(
    path: Path, template: str, scene: Scene, shown: list[tuple[str, str]], **about: Any
) -> None:
    def load(name: str) -> str:
        return (files("ringwear.studies") / "report" / name).read_text("utf-8")

    environment = Environment(
        loader=FunctionLoader(load),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    pictures = [
        (base64.b64encode(file.read_bytes()).decode(), caption)
        for name, caption in shown
        if (file := path.parent / name).exists()
    ]
    page = environment.get_template(template).render(
        pictures=pictures,
        scene=scene.to_toml(),
        versions=versions(),
        style=load("page.css"),
        script=load("slides.js"),
        **about,
    )
    path.write_text(page, "utf-8")


def _plain(file: Path) -> str:
    return file.stem.replace("_", " ")


def _table(file: Path) -> Rows:
    with file.open(newline="", encoding="utf-8") as text:
        head, *lines = csv.reader(text)
    return Rows(tuple(head), [tuple(map(_short, line)) for line in lines[:200]])


def _short(cell: str) -> str:
    """Return a number with four digits, and any other text as it is."""
    try:
        return f"{float(cell):.4g}" if "." in cell or "e" in cell else cell
    except ValueError:
        return cell
