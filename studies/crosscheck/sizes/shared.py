"""One discretisation for several problems on the same ring edges and half-space.

Wear, load and times do not enter a compliance. They only enter the element sizes: these follow the
length over which wear has smoothed the pressure at each ring edge by the first time. A
discretisation that is fine enough for all problems takes, at each edge, the shortest of these
lengths on the slower side and the longest on the faster side.
"""

from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np

from ....meshes.sizes import EdgeAmplitude
from ..problem.loading import Loading
from ..problem.problem import Problem


def covering(problems: Sequence[Problem]) -> Problem:
    """Return a problem whose discretisation is fine enough for all of several problems.

    It is the first problem, with the smallest tolerance of all, the sliding distances of all, and
    amplitudes at ring edges that bound those of all: at each edge the shortest length over which
    wear has smoothed the pressure on the slower side, the largest ratio of the lengths on the two
    sides, and the steepest wear coefficient.

    Parameters
    ----------
    problems : problems with the same `merged.ring_edges`
    """
    amplitudes = [problem.edge_amplitude for problem in problems]
    distances = np.unique(np.concatenate([problem.distances for problem in problems]))
    first, rtol = problems[0], min(problem.rtol for problem in problems)
    # at constant force and speed, times are sliding distances
    combined = replace(first, rtol=rtol, times=distances, loading=Loading())
    gradients = [edge.wear_gradients for edge in amplitudes if edge.wear_gradients is not None]
    amplitude = EdgeAmplitude(
        rtol,
        np.min([edge.worn_length_slow for edge in amplitudes], axis=0),
        np.max([edge.ratio for edge in amplitudes], axis=0),
        max(edge.time_ratio for edge in amplitudes),
        np.max([problem.merged.kinks for problem in problems], axis=0),
        amplitudes[0].narrower_width,
        np.max(gradients, axis=0) if gradients else None,
    )
    return replace(combined, shared_amplitude=amplitude)


def discretisation_key(problem: Problem) -> Hashable:
    """Return a key that is equal for problems with the same discretisation.

    It leaves out the amplitudes at ring edges, which may differ.
    """
    sizes = problem.fem.model_dump_json(), problem.mdr.model_dump_json()
    numbers = problem.ground, problem.rtol, problem.gradient_average
    kinds = bool(len(problem.times)), problem.full_contact
    rings = problem.merged
    edges = rings.ring_edges.tobytes(), rings.smooth.tobytes()
    return *edges, rings.cone_at_axis, *numbers, *kinds, *sizes


def groups(problems: Sequence[Problem]) -> list[list[int]]:
    """Return the indices of the problems in groups that share a discretisation.

    The first problem of each group is the one in which wear has smoothed the pressure at a ring
    edge over the shortest length. It needs the smallest elements.
    """
    # Largest ratio of the shortest worn lengths within a group. More pressures than a problem needs
    # cost it their third power.
    max_length_ratio = 100.0
    worn_lengths = [float(problem.edge_amplitude.worn_length_slow.min()) for problem in problems]
    all_groups, open_groups = list[list[int]](), dict[Hashable, list[int]]()
    for index in np.argsort(worn_lengths, kind="stable").tolist():
        kind = discretisation_key(problems[index])
        if (
            kind not in open_groups
            or worn_lengths[index] > max_length_ratio * worn_lengths[open_groups[kind][0]]
        ):
            open_groups[kind] = []
            all_groups.append(open_groups[kind])
        open_groups[kind].append(index)
    return all_groups
