"""What a sweep will take, before it does.

Seconds, memory of a worker, bytes of the store; from a sample of its blocks.
"""

from dataclasses import dataclass
from math import ceil, prod

import numpy as np

from ...meshes.errors import SceneError
from ..crosscheck.sizes import beyond_memory, predict_memory
from ..methods.base import method
from ..methods.costs import DISCRETISING, by_terms
from ..methods.estimate import solved_whole
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..problem.shared import Shared, groups
from .axes import Sweep
from .blocks import block_shape, blocks
from .compute import posed
from .layout import layout

# blocks that a plan looks into
SAMPLED = 40
# seconds that a scene takes itself where it has no history: closed forms; else a start, and by the
# square of its pressures (measured; `README.md`)
CLOSED, SCENE, SQUARE = 7e-4, 3e-3, 3e-7
# of the modes of a history, what those of one compliance are; seconds of a scene that shares them:
# a start, by its pressures
ONE, TOGETHER, PRESSURE = 0.4, 1.2e-2, 7e-5
# seconds and bytes to write a block, per variable, and to label a scene
WRITTEN, CHUNK = 1.5e-3, 200
# seconds until a process has loaded what it computes with
START = 1.0


@dataclass(frozen=True)
class Plan:
    """What a sweep will take.

    Parameters
    ----------
    scenes, blocks : of the whole
    seconds : of one process, of which `shared` for discretisations that several scenes share
    memory : GiB of each process
    size : bytes of the store, before compression
    """

    scenes: int
    blocks: int
    seconds: float
    shared: float
    memory: float
    size: float

    def elapsed(self, workers: int) -> float:
        """Return seconds by so many processes, which cannot divide a block."""
        rounds = ceil(self.blocks / workers)
        return START + self.seconds * rounds / self.blocks

    def said(self, workers: int) -> list[str]:
        """In words."""
        seconds = self.elapsed(workers)
        time = f"{seconds / 3600:.3g} h" if seconds > 7200 else f"{seconds:.2g} s"
        return [
            f"{self.scenes} scenes in {self.blocks} blocks: about {time} by {workers} processes, "
            f"{100 * self.shared / self.seconds:.0f} % of it for discretisations that scenes share",
            f"{self.memory:.2g} GiB for each process; a store of at most {self.size / 2**20:.3g} "
            "MiB",
        ]


def planned(sweep: Sweep, memory: float, workers: int) -> Plan:
    """The plan of a sweep.

    Raises
    ------
    SceneError
        if its processes need more memory (GiB) than there is, with the key that causes it
    """
    kept = layout(sweep)
    shape = block_shape(sweep, kept)
    count = prod(ceil(length / step) for length, step in zip(sweep.shape, shape, strict=True))
    wanted = set(np.linspace(0, count - 1, min(count, SAMPLED)).round().astype(int).tolist())
    seconds = shared = most = 0.0
    sampled = 0
    for block in blocks(sweep, shape):
        if block.number not in wanted:
            continue
        part = sweep.part(block.bounds)
        sampled += block.count
        problems: dict[str, list[Problem]] = {}
        scenes: dict[str, list[Scene]] = {}
        for index in np.ndindex(part.shape):
            try:
                scene = part.scene(index)
            except SceneError:
                continue
            for name in scene.methods:
                problems.setdefault(name, []).append(posed(scene, sweep.keep))
                scenes.setdefault(name, []).append(scene)
        for name, of_method in problems.items():
            for numbers in groups(of_method):
                # the sharpest scene of a discretisation, and that of most numbers
                of_group = [scenes[name][number] for number in numbers]
                for scene in (of_group[0], max(of_group, key=_fields)):
                    gib = predict_memory(scene)
                    if refusal := beyond_memory(gib, memory / workers):
                        raise SceneError(refusal)
                    most = max(most, sum(gib.values()))
                once, each = _seconds(name, Shared.of([of_method[number] for number in numbers]))
                shared += once
                seconds += once + each * len(numbers)
    factor = sweep.count / sampled
    values = sum(prod(variable.shape) for variable in kept.variables.values())
    size = sweep.count * (8.0 * values + 12) + CHUNK * count * (len(kept.variables) + 3)
    written = WRITTEN * count * (len(kept.variables) + 3)
    return Plan(sweep.count, count, factor * seconds + written, factor * shared, most, size)


def _fields(scene: Scene) -> int:
    """Return how many numbers a field over time has."""
    return len(scene.problem.times) * len(scene.problem.radii)


def _seconds(name: str, problem: Shared) -> tuple[float, float]:
    """Of what is made once for a group, and of each scene."""
    this = method(name)
    if name == "direct":
        return this.cost(problem).seconds, CLOSED
    if this.own_march:
        return 0.0, this.cost(problem).seconds
    unknowns, pressures = this.counted(problem)
    parts = by_terms(this.kind(problem), unknowns, pressures, problem)
    once, modes = float(parts[:DISCRETISING].sum()), float(parts[DISCRETISING:].sum())
    if whole := solved_whole(problem.members):
        return once + ONE * (len(whole) + 1) * modes, TOGETHER + PRESSURE * pressures
    return once, SCENE + SQUARE * pressures**2 + modes
