"""Print lines on a terminal, broken between words at its width.

Lines are not broken if the output is no terminal but, for example, a file or a pipe. Control
characters in texts of users, such as names of files, are shown as escape sequences.
"""

import shutil
import sys
import textwrap
from collections.abc import Iterable

from ..crosscheck import visible


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
