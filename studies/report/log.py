"""Show the log on the terminal."""

import logging
import sys
import time

from ..crosscheck import LOG, STAGES, visible


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
