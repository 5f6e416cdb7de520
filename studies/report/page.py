"""The page of a run, with its figures."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..outcome.outcome import Outcome
from ..output.files import draw
from ..output.one_file import make
from ..output.signals import STOPPED
from .template import write_page
from .words import Account

if TYPE_CHECKING:
    from ..figures.style import Picture


def show(
    result: Outcome, account: Account, pictures: Sequence["Picture"], directory: Path, page: bool
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
    result: Outcome, account: Account, pictures: Iterable["Picture"], path: Path
) -> None:
    """Write the page of a run with those of the pictures that stand beside it."""
    from .slides import slides  # which loads matplotlib, and a run without figures needs none

    about = {"account": account, "title": account.title}
    captions = {picture.file: picture.caption for picture in pictures}
    write_page(path, "run.html.j2", result.scene, captions, slides=slides(result), **about)
