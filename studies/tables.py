"""Tables of studies that were stopped: what is finished is kept."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .registry import INTERRUPTED

Row = Mapping[str, Any]


@contextmanager
def keeping_rows(conclusions: list[str]) -> Iterator[None]:
    """Ctrl-C ends the computing, not the study.

    What is finished is still tabulated, drawn and named incomplete.
    """
    try:
        yield
    except KeyboardInterrupt:
        conclusions.append(INTERRUPTED)


def keep_tables(directory: Path) -> None:
    """Remove what may be half there of a study that was stopped between its rows: tables are whole
    after every row.

    Raises
    ------
    KeyboardInterrupt
        if there are no rows either
    """
    tables = set(directory.glob("*.csv"))
    for file in set(directory.iterdir()) - tables:
        file.unlink()
    if not any(len(table.read_text("utf-8").splitlines()) > 1 for table in tables):
        raise KeyboardInterrupt
