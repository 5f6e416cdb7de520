"""Draw the figures of a run and write its page (report.html)."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..crosscheck.result.outcome import Outcome
from ..crosscheck.result.output.files import draw
from ..crosscheck.result.output.one_file import make
from ..crosscheck.result.output.signals import STOPPED
from ..crosscheck.result.words import Account
from .template import write_page

if TYPE_CHECKING:
    from ..figures.style import Picture


def show(
    result: Outcome, account: Account, pictures: Sequence["Picture"], directory: Path, page: bool
) -> list[str]:
    """Draw the pictures of a run, and its page if `page`; return the failures, with reasons."""
    failures = draw(result, pictures, directory)
    if page:
        write = partial(write_report, result, account, pictures)
        failures += make(directory / "report.html", write)
    if STOPPED.is_set():
        # a library may have caught the KeyboardInterrupt as an error of its own
        raise KeyboardInterrupt
    return failures


def write_report(
    result: Outcome, account: Account, pictures: Sequence["Picture"], path: Path
) -> None:
    """Write the page of a run, with those of the pictures whose files are in the same folder."""
    from .slides import slides  # imported here: it loads matplotlib, which other runs do not need

    missing = []
    if result.has_inside and not any(map(len, result.inside.parts)):
        missing.append(
            "stress.png is not drawn: nothing presses at the times of the fields inside the "
            "half-space. Give output.field_times at which the force is not 0."
        )
    captions = {
        picture.file: picture.caption
        for picture in pictures
        if (path.parent / picture.file).exists()
    }
    first = [file for file in account.first_figures(pictures) if file in captions]
    context = {
        "account": account,
        "title": account.title,
        "missing": missing,
        "first_figures": first,
        "other_figures": [file for file in captions if file not in first],
    }
    write_page(path, account.template, result.scene, captions, slides=slides(result), **context)
