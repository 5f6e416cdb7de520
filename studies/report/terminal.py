"""Lines on a terminal: broken between words where it ends, and never cut.

Where there is no terminal, as in files and pipes, lines stay whole.
"""

import shutil
import textwrap
from collections.abc import Iterable


def terminal_width() -> int:
    """Return the characters that a line of the terminal has; 0 if there is no terminal."""
    return shutil.get_terminal_size((0, 0)).columns


def print_lines(lines: Iterable[str]) -> None:
    """Print lines, each broken between words where the terminal ends."""
    for line in lines:
        start = len(line) - len(line.lstrip())
        print(broken(line, "", " " * (start + 2)))


def broken(line: str, indent: str, then: str) -> str:
    """Return a line broken between words where the terminal ends, with indents."""
    width = terminal_width()
    if not width or len(indent + line) <= width:
        return indent + line
    return textwrap.fill(
        line,
        width,
        initial_indent=indent,
        subsequent_indent=then,
        break_long_words=False,
        break_on_hyphens=False,
    )
