"""Report progress: the log, and the timed stages of each method."""

import logging
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from typing import TypeVar

from .copies import Apart, here

LOG = logging.getLogger("ringwear")
STAGES = LOG.getChild("stages")  # stages of single methods, which studies and sweeps do not show

Value = TypeVar("Value")


@dataclass
class Stages:
    """Seconds by stage of one method; each stage is logged when it begins and when it ends.

    A stage may be done apart, in a copy of this process (`copies.py`).
    """

    name: str
    seconds: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    apart: Apart = here
    waited: float = 0.0

    @contextmanager
    def __call__(self, stage: str, level: int = logging.INFO) -> Iterator[None]:
        """Time a stage: log when the `with` block begins and ends, and add up its seconds."""
        STAGES.log(level, "%8s  %s ...", self.name, stage)
        start = time.perf_counter() - self.waited
        yield
        self.seconds[stage] += time.perf_counter() - self.waited - start
        STAGES.log(level, "%8s  %-13s %8.3f s", self.name, stage, self.seconds[stage])

    def begin(self, work: Callable[["Stages"], Value], part_of: str = "") -> Callable[[], Value]:
        """Begin a work apart, which gets its own stages; return a function that waits for it.

        The function adds the seconds of the stages of the work, in place of those of waiting. The
        work may be `part_of` a stage, which is then not logged.
        """

        def timed() -> tuple[Value, dict[str, float]]:
            stages = Stages(self.name, apart=self.apart)
            with stages(part_of, logging.DEBUG) if part_of else nullcontext():
                value = work(stages)
            return value, stages.seconds

        (done,) = self.apart(timed)

        def result() -> Value:
            start = time.perf_counter()
            value, seconds = done()
            self.waited += time.perf_counter() - start
            for stage, added in seconds.items():
                self.seconds[stage] += added
            return value

        return result
