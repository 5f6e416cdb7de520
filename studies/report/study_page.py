"""Write the page of a study: conclusions, figures and tables."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from ..crosscheck import Scene

if TYPE_CHECKING:
    from pandas import DataFrame

MOST_ROWS = 200
"""Greatest number of rows of a table on the page."""


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
    from .template import write_page

    rows = [(name, table[:MOST_ROWS].map(as_text).to_dict("records")) for name, table in tables]
    context = {"title": title, "purpose": purpose, "conclusions": conclusions, "tables": rows}
    captions = {
        file.name: file.stem.replace("_", " ") for file in sorted(path.parent.glob("*.png"))
    }
    write_page(path, "study.html.j2", scene, captions, **context)


def as_text(cell: object) -> str:
    """Return a number with four digits, "" for NaN or None, and any other text in one line."""
    if isinstance(cell, float):
        return "" if cell != cell else f"{cell:.4g}"
    return "" if cell is None else str(cell).replace("\n", " ")
