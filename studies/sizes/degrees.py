"""Degrees of the pressure, and the number of pressures, by the wanted accuracy.

Constants name what shows them, a test under `tests/` or a study, where there is one.
"""

from dataclasses import replace

import numpy as np

from ...meshes.ground.ground import relative_compliance
from ...meshes.radial import Array
from ...meshes.sizes import convergence
from ..problem.problem import Problem
from ..problem.quantities import COMPARED_MODES
from .ring_edges import FACTOR, edge_sizes

# lowest degree of the pressure: the coarser solution has a degree less, which has to be linear
LOWEST_DEGREE = 2
# part by which a degree may be lower than the estimate of the amplitude asks for, which is above
# the amplitude itself
RELAXED_PART = 0.1
# the most that a degree is lowered by for this reason (physics/test_size_rules.py)
MOST_RELAXED = 0.7
# slowest modes that a history needs to the accuracy asked for, of which no relaxation time is told;
# `degree_of_modes` was measured with so many of them on one ring
MODES_OF_HISTORIES = 3
# degree that three modes on one ring ask for at rtol = 1, measured as told in `degree_of_modes`
DEGREE_OF_THREE_MODES = 2.8
# degrees more for each digit of rtol, measured in the same way
DEGREES_PER_DIGIT = 1.15
# degrees more for each mode more on one ring, measured in the same way
DEGREES_PER_MODE = 1.5
# greatest number of pressures: dense matrices of more take more than half a minute
MOST_PRESSURES = 3500
# coarsest relative accuracy of fields where only energies are wanted: energies err by its square,
# and the coarser solution still has to be like the fine one to show its error
COARSEST_FIELDS = 0.3


def pressure_degree(problem: Problem, ratio: float) -> float:
    """Return the highest degree of the pressure that an accuracy asks for.

    Parameters
    ----------
    problem : with the accuracy of its fields
    ratio : size of an element over that of its neighbour on the far side of an edge, below 1

    Notes
    -----
    An element one element away from a singular point errs by ``A rho^-p`` in the degree p, with the
    amplitude A (`EdgeAmplitude`) and ``ln rho = convergence(ratio)``. Hence

        p = ln(A / rtol) / ln rho

    with the greatest amplitude on the elements in the middle of the rings, a little less by
    `relaxed_degree`, and at least LOWEST_DEGREE. Shown by
    physics/test_orders.py::test_rings_on_quadrilaterals_by_the_degree.
    """
    half, amplitude = problem.merged.widths / 2, problem.edge_amplitude
    edges = np.arange(len(half))
    greatest = max(
        float(amplitude(half, half, edges).max()),
        float(amplitude(half[1:], half[1:], edges[:-1]).max(initial=0.0)),
    )
    degree = relaxed_degree(np.log(greatest / problem.rtol) / convergence(ratio))
    return float(max(degree, LOWEST_DEGREE))


def relaxed_degree(degree: Array | float) -> Array | float:
    """Return degrees that are enough, a little below those that the amplitude asks for.

    Notes
    -----
    ``p - min(RELAXED_PART p, MOST_RELAXED)``, because the estimate of the amplitude is above the
    amplitude itself. Shown by physics/test_size_rules.py.
    """
    return degree - np.minimum(RELAXED_PART * degree, MOST_RELAXED)


def degree_of_modes(problem: Problem) -> float:
    """Return the degree that the slowest modes ask for on the ring that has most of them.

    Notes
    -----
    With m of the slowest modes on one ring,

        p = DEGREE_OF_THREE_MODES - DEGREES_PER_DIGIT log10(rtol) + DEGREES_PER_MODE (m - 3).

    Relaxation times of a ring are about its width b over its wear coefficient, times 1, 1/2, 1/3,
    ..., and on layers times the compliance of waves of that length: that tells which modes are
    slowest. On thin layers these may all be on one ring. Measured: three relaxation times err by
    1e-2, 2e-4, 7e-7, 1e-9 in degrees 4, 6, 8, 10 if all are of one ring, by 7e-5, 1e-7, 1e-10 in
    degrees 4, 6, 8 if two are, by 2e-8 in degree 4 if each has one. So another mode on a ring asks
    for 1.5 degrees more; with eight of them on one ring all eight err by less than .02 rtol, from
    1e-2 to 1e-6.
    """
    slowest = problem.merged.widths / problem.merged.ends.mean(axis=0)
    count = COMPARED_MODES if problem.wants("relaxation_time") else MODES_OF_HISTORIES
    number = np.arange(1, count + 1)
    times = slowest[:, None] / number
    if problem.ground is not None:
        # the half wave number n on a ring has the wave number n pi / b
        waves = np.pi * number / problem.merged.widths[:, None]
        compliance = relative_compliance(problem.ground, waves.ravel())
        times = times * compliance.reshape(times.shape)
    most = (times >= np.sort(times, axis=None)[-count]).sum(axis=1).max()
    return float(
        DEGREE_OF_THREE_MODES
        - DEGREES_PER_DIGIT * np.log10(problem.rtol)
        + DEGREES_PER_MODE * (most - MODES_OF_HISTORIES)
    )


def pressure_count(problem: Problem, ratio: float) -> float:
    """Return an estimate of how many pressures a graded mesh takes.

    Parameters
    ----------
    problem : with the accuracy of its fields
    ratio : by which elements shrink towards every ring edge and the rim

    Notes
    -----
    It is the sum of the degrees on all elements. Elements at the distance x from an edge have the
    degree ``ln(A(x) / rtol) / ln rho`` of `pressure_degree`, down to the sizes of `edge_sizes`.
    """
    half, sizes, amplitude = problem.merged.widths / 2, edge_sizes(problem), problem.edge_amplitude
    total, most = 0.0, pressure_degree(problem, ratio)
    # on the inner side of each edge, and on the outer side of all but the rim
    for reach, size, edges in (
        (half, sizes, np.arange(len(half))),
        (half[1:], sizes[:-1], np.arange(len(half) - 1)),
    ):
        distance = reach[:, None] * ratio ** np.arange(np.ceil(np.log(sizes.min()) / np.log(ratio)))
        edges = np.broadcast_to(edges[:, None], distance.shape)
        digits = np.log(amplitude(distance, reach[:, None], edges) / problem.rtol)
        degrees = np.clip(relaxed_degree(digits / convergence(ratio)), LOWEST_DEGREE, most)
        total += float(np.sum(degrees, where=distance > size[:, None]))
    return total


def with_affordable_field_tolerance(problem: Problem, ratio: float) -> Problem:
    """Return the problem with the tolerance that its fields can have.

    Notes
    -----
    Energies err by the square of the error of fields. If only energies are wanted, fields are
    resolved to ``min(sqrt(rtol), COARSEST_FIELDS)``. With so many rings that there would be more
    than MOST_PRESSURES pressures, the tolerance is doubled until there are not, up to
    ``sqrt(rtol)``; dense matrices cost the third power of the pressures. Shown by
    physics/test_promise.py::test_an_indentation_alone_reaches_a_fine_accuracy.
    """
    fields = min(problem.rtol**0.5, COARSEST_FIELDS) if problem.energies_only else problem.rtol
    fewer = replace(problem, rtol=fields)
    while fewer.rtol < problem.rtol**0.5 and pressure_count(fewer, ratio) > MOST_PRESSURES:
        fewer = replace(fewer, rtol=min(2 * fewer.rtol, problem.rtol**0.5))
    return fewer


def field_accuracy(problem: Problem) -> float:
    """Return the relative accuracy that fields are resolved to.

    It is the one asked for, unless only energies are wanted or there are too many rings
    (`with_affordable_field_tolerance`).
    """
    return with_affordable_field_tolerance(problem, FACTOR).rtol
