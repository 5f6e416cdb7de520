"""Problems on the same ring edges and half-space.

One discretisation serves every wear, load and time.

A compliance knows nothing of wear, only its sizes do: those beside each edge follow the length that
wear has blunted there by the earliest time. What all of several problems need is the least of them
on the slower side, the greatest on the faster.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from ...meshes.sizes import EdgeAmplitude
from ..problem.problem import Problem


@dataclass(frozen=True, eq=False)
class Shared(Problem):
    """The first of several problems, to be discretised as sharply as the sharpest needs it.

    Parameters
    ----------
    members : the problems, with the same `merged.ring_edges`
    """

    members: tuple[Problem, ...] = ()

    @classmethod
    def of(cls, members: Sequence[Problem]) -> Self:
        """Return the problem that stands for several, with the smallest of their tolerances."""
        first = {field.name: getattr(members[0], field.name) for field in fields(Problem)}
        rtol = min(member.rtol for member in members)
        return cls(**first | {"rtol": rtol}, members=tuple(members))

    @property
    def edge_amplitude(self) -> EdgeAmplitude:
        """Estimate of the amplitude of high degrees at ring edges that covers all members.

        At each edge it takes the least length over which wear has smoothed the pressure on the
        slower side, and the greatest ratio of the lengths on both sides.
        """
        amplitudes = [member.edge_amplitude for member in self.members]
        worn_length_slow = np.min([lengths.worn_length_slow for lengths in amplitudes], axis=0)
        ratio = np.max([lengths.ratio for lengths in amplitudes], axis=0)
        latest = max(
            lengths.time_ratio * member.earliest
            for lengths, member in zip(amplitudes, self.members, strict=True)
        )
        span = latest / self.earliest if self.earliest else 1.0
        kinks = np.max([member.merged.kinks for member in self.members], axis=0)
        return EdgeAmplitude(
            self.rtol, worn_length_slow, ratio, span, kinks, amplitudes[0].narrower_width
        )

    @property
    def earliest(self) -> float:
        """The first sliding distance after the start in any of the problems; 0 without any."""
        return min((each.earliest for each in self.members if each.earliest), default=0.0)


def discretised_alike(problem: Problem) -> Hashable:
    """Return what a discretisation depends on, but for the amplitudes at edges."""
    sizes = problem.fem.model_dump_json(), problem.mdr.model_dump_json()
    numbers = problem.poisson_ratio, problem.ground, problem.rtol, problem.gradient_average
    kinds = bool(len(problem.times)), problem.contact
    rings = problem.merged
    edges = rings.ring_edges.tobytes(), rings.smooth.tobytes(), rings.hollow
    return *edges, *numbers, *kinds, *sizes


def groups(problems: Sequence[Problem]) -> list[list[int]]:
    """Return the numbers of the problems in groups that share a discretisation.

    Each group begins with the problem in which wear has smoothed the pressure at a ring edge over
    the shortest length: it needs the smallest elements.
    """
    # greatest ratio of the lengths that wear has blunted in problems that share a discretisation:
    # pressures that the sharper needs cost the others their third power
    widest = 100.0
    sharpest = [float(problem.edge_amplitude.worn_length_slow.min()) for problem in problems]
    parts, latest = list[list[int]](), dict[Hashable, list[int]]()
    for number in np.argsort(sharpest, kind="stable").tolist():
        kind = discretised_alike(problems[number])
        if kind not in latest or sharpest[number] > widest * sharpest[latest[kind][0]]:
            latest[kind] = []
            parts.append(latest[kind])
        latest[kind].append(number)
    return parts
