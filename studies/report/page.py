"""Draw the figures of a run and write its page (report.html)."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..crosscheck import INSIDE, LOG, STOPPED, Account, Result, copies, make

if TYPE_CHECKING:
    from ..figures.catalogue import Picture


def show(
    result: Result, account: Account, pictures: Sequence["Picture"], directory: Path, page: bool
) -> list[str]:
    """Draw the pictures of a run, and its page if `page`; return the failures, with reasons."""
    failures = _draw(result, pictures, directory)
    if page:
        write = partial(write_report, result, account, pictures)
        failures += make(directory / "report.html", write)
    if STOPPED.is_set():
        # a library may have caught the KeyboardInterrupt as an error of its own
        raise KeyboardInterrupt
    return failures


def _draw(result: Result, pictures: Sequence["Picture"], directory: Path) -> list[str]:
    """Draw the pictures that a result has data for; return the failures, with reasons.

    Fields inside the half-space are written, too. They take as long as the contact problem, and are
    therefore left out without pictures unless the scene asks for them (`output.field_times`). A
    copy of this process draws half of the other pictures.
    """
    from ..crosscheck import write_half_space

    def draw(drawn: Iterable["Picture"]) -> list[str]:
        failures = []
        for picture in drawn:
            if picture.drawn_for(result):
                LOG.info("  output  drawing %s ...", picture.file)
                failures += make(directory / picture.file, partial(picture.write, result))
        return failures

    scene = result.scene
    series = bool(scene.output.field_times)
    others = [picture for picture in pictures if not picture.of_inside]
    with copies() as apart:
        half = len(others) // 2 + 1
        (drawn,) = apart(partial(draw, others[:half]))
        failures = draw(others[half:])
        if result.has_inside and (pictures or series):
            failures += make(
                directory / INSIDE,
                lambda path: write_half_space(result.inside(), scene, path, series),
            )
            failures += draw(picture for picture in pictures if picture.of_inside)
        return failures + drawn()


def write_report(
    result: Result, account: Account, pictures: Sequence["Picture"], path: Path
) -> None:
    """Write the page of a run, with those of the pictures whose files are in the same folder."""
    # imported here: they load matplotlib and jinja2, which runs without a page do not need
    from .slides import slides
    from .template import write_page

    missing = []
    if result.has_inside and not any(map(len, result.inside().parts)):
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
