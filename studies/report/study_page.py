"""Write the page of a study: conclusions, figures and tables."""

from collections.abc import Iterable
from pathlib import Path

from ..crosscheck import Scene


def write_study(
    title: str, purpose: str, scene: Scene, conclusions: Iterable[str], path: Path
) -> None:
    """Write the page of a study or a fit, with the figures and tables in the same folder."""
    import pandas as pd  # imported here: runs need neither

    from .template import write_page

    tables = {
        _plain(file): pd.read_csv(file, dtype=str, keep_default_na=False, nrows=200).map(_short)
        for file in sorted(path.parent.glob("*.csv"))
    }
    rows = {name: table.to_dict("records") for name, table in tables.items()}
    # conclusions that are table rows are left out, because the page shows the tables
    sentences = [line for line in conclusions if not line.startswith("|")]
    context = {"title": title, "purpose": purpose, "conclusions": sentences, "tables": rows}
    captions = {file.name: _plain(file) for file in sorted(path.parent.glob("*.png"))}
    write_page(path, "study.html.j2", scene, captions, **context)


def _plain(file: Path) -> str:
    return file.stem.replace("_", " ")


def _short(cell: str) -> str:
    """Return a number with four digits, and any other text as it is."""
    try:
        return f"{float(cell):.4g}" if "." in cell or "e" in cell else cell
    except ValueError:
        return cell
