"""The page of a run or of a study.

One file that opens from disk, without a network, and prints on A4.
"""

import base64
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ..crosscheck.dataset import Result
from ..output.files import draw, make
from ..output.signals import STOPPED
from ..problem.scene import Scene
from ..versions import versions
from .words import Account

if TYPE_CHECKING:
    from ..figures.style import Picture


def show(
    result: Result, account: Account, pictures: Sequence["Picture"], directory: Path, page: bool
) -> list[str]:
    """Draw pictures of a run, and if wanted a page with them; return what could not be made."""
    failures = draw(result, pictures, directory)
    if page:
        write = partial(write_report, result, account, pictures)
        failures += make(directory / "report.html", write)
    if STOPPED.is_set():
        # a library has taken the exception for a failure of its own
        raise KeyboardInterrupt
    return failures


def write_report(
    result: Result, account: Account, pictures: Iterable["Picture"], path: Path
) -> None:
    """Write the page of a run with those of the pictures that stand beside it."""
    from .slides import slides  # which loads matplotlib, and a run without figures needs none

    about = {"account": account, "title": account.title}
    captions = {picture.file: picture.caption for picture in pictures}
    _write(path, "run.html.j2", result.scene, captions, slides=slides(result), **about)


def write_study(
    name: str, purpose: str, scene: Scene, conclusions: Iterable[str], path: Path
) -> None:
    """Write the page of a study; its figures and tables are those that stand beside it."""
    import pandas as pd  # runs do without

    tables = {
        _plain(file): pd.read_csv(file, dtype=str, keep_default_na=False, nrows=200).map(_short)
        for file in sorted(path.parent.glob("*.csv"))
    }
    rows = {name: table.to_dict("records") for name, table in tables.items()}
    # tables stand below
    told = [line for line in conclusions if not line.startswith("|")]
    about = {"title": f"Study: {name}", "purpose": purpose, "conclusions": told, "tables": rows}
    captions = {file.name: _plain(file) for file in sorted(path.parent.glob("*.png"))}
    _write(path, "study.html.j2", scene, captions, **about)


def _write(path: Path, template: str, scene: Scene, captions: dict[str, str], **about: Any) -> None:
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    pictures = [
        (base64.b64encode(file.read_bytes()).decode(), caption)
        for name, caption in captions.items()
        if (file := path.parent / name).exists()
    ]
    page = environment.get_template(template).render(
        pictures=pictures, scene=scene.to_toml(), versions=versions(), **about
    )
    path.write_text(page, "utf-8")


def _plain(file: Path) -> str:
    return file.stem.replace("_", " ")


def _short(cell: str) -> str:
    """Return a number with four digits, and any other text as it is."""
    try:
        return f"{float(cell):.4g}" if "." in cell or "e" in cell else cell
    except ValueError:
        return cell
