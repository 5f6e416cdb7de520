"""Named stages of a run: timed for the summary, and shown while they last."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

Report = Callable[[str], None]


def silent(_: str) -> None:
    """Report nothing."""


@dataclass
class Stages:
    """Seconds by stage of one method.

    Parameters
    ----------
    name : the method, for messages
    report : called with a line when a stage begins and when it ends
    """

    name: str
    report: Report = silent
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        self.report(f"{self.name:>7}  {stage} ...")
        start = time.perf_counter()
        yield
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start
        self.report(f"{self.name:>7}  {stage:<13} {self.seconds[stage]:8.3f} s")
