"""Write HTML pages as single files that need no network and can be printed on A4."""

import base64
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..crosscheck import Scene, package_versions
from ..tables.writing import json_text

if TYPE_CHECKING:
    from pandas import DataFrame

MOST_ROWS = 200
"""Greatest number of rows of a table on the page of a study."""


class Shown(NamedTuple):
    """A figure on a page: the image, in base 64, and its caption."""

    image: str
    caption: str


def write_page(
    path: Path, template: str, scene: Scene, captions: dict[str, str], **context: Any
) -> None:
    """Write a page from a template, with the captioned figures that are in the same folder.

    The template gets them as `pictures`, by the names of their files.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # only pages need it

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.policies["json.dumps_function"] = json_text
    pictures = {
        name: Shown(base64.b64encode(file.read_bytes()).decode(), caption)
        for name, caption in captions.items()
        if (file := path.parent / name).exists()
    }
    page = environment.get_template(template).render(
        pictures=pictures, scene=scene.to_toml(), versions=package_versions(), **context
    )
    path.write_text(page, "utf-8")


def write_study(
    title: str,
    purpose: str,
    scene: Scene,
    conclusions: Iterable[str],
    tables: "Iterable[tuple[str, DataFrame]]",
    path: Path,
) -> None:
    """Write the page of a study or a fit, with the figures in the same folder.

    Parameters
    ----------
    title, purpose, scene, conclusions : what is at the top, and the scene at the end
    tables : captions, which may be empty, and tables
    path : file to write
    """
    rows = [(name, table[:MOST_ROWS].map(as_text).to_dict("records")) for name, table in tables]
    # conclusions that are table rows are left out, because the page shows the tables
    sentences = [line for line in conclusions if not line.startswith("|")]
    context = {"title": title, "purpose": purpose, "conclusions": sentences, "tables": rows}
    captions = {
        file.name: file.stem.replace("_", " ") for file in sorted(path.parent.glob("*.png"))
    }
    write_page(path, "study.html.j2", scene, captions, **context)


def as_text(cell: object) -> str:
    """Return a number with four digits, "" for NaN or None, and any other text in one line."""
    if isinstance(cell, float):
        return "" if cell != cell else f"{cell:.4g}"
    return "" if cell is None else str(cell).replace("\n", " ")
