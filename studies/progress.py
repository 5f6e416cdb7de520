"""Report progress: the log, and the timed stages of each method."""

import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

LOG = logging.getLogger("ringwear")
STAGES = LOG.getChild("stages")  # stages of single methods, which studies and sweeps do not show


@dataclass
class Stages:
    """Seconds by stage of one method; each stage is logged when it begins and when it ends."""

    name: str
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Time a stage: log when the `with` block begins and ends, and add up its seconds."""
        STAGES.info("%8s  %s ...", self.name, stage)
        start = time.perf_counter()
        yield
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start
        STAGES.info("%8s  %-13s %8.3f s", self.name, stage, self.seconds[stage])


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
        line, now = record.getMessage(), time.monotonic()
        unfinished = line.endswith("...")
        if sys.stderr.isatty():
            print(f"\r\033[K{line}", end="" if unfinished else "\n", file=sys.stderr, flush=True)
        elif not unfinished or now - self._last > 10:
            self._last = now
            print(line, file=sys.stderr, flush=True)
