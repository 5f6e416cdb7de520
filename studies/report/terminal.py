"""Print lines on a terminal, broken between words at its width, and show the log there.

Lines are not broken if the output is no terminal but, for example, a file or a pipe. Control
characters in texts of users, such as names of files, are shown as escape sequences.
"""

import logging
import shutil
import sys
import textwrap
import time
from collections.abc import Iterable

from ..crosscheck import LOG, STAGES, visible


def terminal_width() -> int:
    """Return the width of the terminal in characters; 0 if there is no terminal."""
    return shutil.get_terminal_size((0, 0)).columns


def print_lines(lines: Iterable[str]) -> None:
    """Print lines at once, each broken between words at the width of the terminal."""
    for line in map(visible, lines):
        start = len(line) - len(line.lstrip())
        print(broken(line, "", " " * (start + 2)))
    sys.stdout.flush()


def print_markdown(lines: Iterable[str]) -> None:
    """Print lines of Markdown, which are not broken because rows of tables are single lines."""
    print(*map(visible, lines), sep="\n")


def broken(line: str, indent: str, later_indent: str) -> str:
    """Return a line broken between words at the width of the terminal.

    The first line of the result begins with `indent`, all others with `later_indent`.
    """
    width = terminal_width()
    if not width or len(indent + line) <= width:
        return indent + line
    return textwrap.fill(
        line,
        width,
        initial_indent=indent,
        subsequent_indent=later_indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


def show_progress(of_stages: bool) -> None:
    """Show the log on standard error, with the stages of single methods if `of_stages`."""
    LOG.setLevel(logging.INFO)
    STAGES.setLevel(logging.NOTSET if of_stages else logging.WARNING)
    if not any(isinstance(handler, Terminal) for handler in LOG.handlers):
        LOG.addHandler(Terminal())


class Terminal(logging.Handler):
    """Handler that prints the log on standard error.

    On a terminal, the next line overwrites an unfinished one ("..."). Elsewhere, an unfinished line
    is printed at most every ten seconds.
    """

    _last = float("-inf")

    def emit(self, record: logging.LogRecord) -> None:
        """Write a record to standard error.

        If this is not a terminal, an unfinished line is written only if more than ten seconds have
        passed since the last line.
        """
        line, now = visible(record.getMessage()), time.monotonic()
        unfinished = line.endswith("...")
        if sys.stderr.isatty():
            print(f"\r\033[K{line}", end="" if unfinished else "\n", file=sys.stderr, flush=True)
        elif not unfinished or now - self._last > 10:
            self._last = now
            print(line, file=sys.stderr, flush=True)
