"""Report progress: the log, and the timed stages of each method."""

import logging
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
