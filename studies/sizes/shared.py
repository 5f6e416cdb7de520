"""Problems on the same ring edges and half-space.

One discretisation serves every wear, load and time.

A compliance knows nothing of wear, only its sizes do: those beside each edge follow the length that
wear has blunted there by the earliest time. What all of several problems need is the least of them
on the slower side, the greatest on the faster.
"""

from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np

from ...meshes.sizes import EdgeAmplitude
from ..problem.loading import Loading
from ..problem.problem import Problem


def covering(problems: Sequence[Problem]) -> Problem:
    """Return a problem to discretise for several: its sizes are as small as any of them needs.

    It is the first of them, with the least accuracy, the sliding distances and the amplitudes at
    ring edges of all. At each edge these take the least length over which wear has smoothed the
    pressure on the slower side, and the greatest ratio of the lengths on both sides.

    Parameters
    ----------
    problems : with the same `merged.ring_edges`
    """
    amplitudes = [problem.edge_amplitude for problem in problems]
    distances = np.unique(np.concatenate([problem.distances for problem in problems]))
    first, rtol = problems[0], min(problem.rtol for problem in problems)
    # at constant force and speed, times are sliding distances
    several = replace(first, rtol=rtol, times=distances, loading=Loading())
    amplitude = EdgeAmplitude(
        rtol,
        np.min([each.worn_length_slow for each in amplitudes], axis=0),
        np.max([each.ratio for each in amplitudes], axis=0),
        float(distances[-1]) / several.earliest if several.earliest else 1.0,
        np.max([problem.merged.kinks for problem in problems], axis=0),
        amplitudes[0].narrower_width,
    )
    return replace(several, shared_amplitude=amplitude)


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
