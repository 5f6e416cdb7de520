"""Polynomial degrees of the pressure, and the number of pressures, as functions of the tolerance.

The comment on a constant names the test under `tests/` or the study that justifies it, if there is
one.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ....meshes.ground.ground import relative_compliance
from ....meshes.radial import Array
from ....meshes.sizes import required_degree
from ..problem.problem import Problem
from ..problem.quantities import COMPARED_MODES
from .ring_edges import QUAD_GRADING, edge_sizes

# Lowest degree of the pressure. The coarser solution used for the error estimate has a degree less,
# and has to be at least linear.
LOWEST_DEGREE = 2
# Share of the degree by which it may be lower than the amplitude estimate requires, because that
# estimate is above the true amplitude.
RELAXATION_RATIO = 0.1
# Upper limit of that reduction, in degrees (physics/test_size_rules.py).
MOST_RELAXED = 0.7
# Number of slowest modes that have to meet the tolerance if relaxation times are not reported. The
# constants of `degree_of_modes` were measured with so many modes on one ring.
MODES_FOR_HISTORY = 3
# Degree that three modes on one ring require at rtol = 1 (extrapolated); `degree_of_modes`
# describes the measurement.
DEGREE_OF_THREE_MODES = 2.8
# Degrees to add per digit of rtol, from the same measurement.
DEGREES_PER_DIGIT = 1.15
# Degrees to add per further mode on one ring, from the same measurement.
DEGREES_PER_MODE = 1.5
# Largest wave number among which the slowest modes are searched, times the thickness of the first
# layer. The relaxation time of waves on a layer that is bonded to a rigid base is greatest at 0 to
# 2.2.
GREATEST_WAVE_NUMBER = 4.0
# Largest number of pressures. Dense matrices of more take more than half a minute.
MOST_PRESSURES = 3500
# Largest tolerance of fields if only energies are wanted. The error of energies is the square of
# that of fields, but the coarser solution must still resemble the fine one, or their difference
# would not show the error.
COARSEST_FIELD_RTOL = 0.3


def pressure_degree(problem: Problem, ratio: float) -> float:
    """Return the highest degree of the pressure that the tolerance requires.

    Parameters
    ----------
    problem : the problem, with the tolerance of its fields
    ratio : size of an element over that of its neighbour farther from the edge, below 1

    Notes
    -----
    It is that of `meshes.sizes.required_degree` with the largest amplitude on the elements in the
    middle of the rings. `relaxed_degree` lowers this a little; the result is at least
    LOWEST_DEGREE. Shown by physics/test_five_rings.py::test_fem_to_nine_digits.
    """
    half_width, amplitude = np.diff(problem.merged.from_axis) / 2, problem.edge_amplitude
    edges = np.arange(len(half_width))
    greatest = max(
        float(amplitude(half_width, half_width, edges).max()),
        float(amplitude(half_width[1:], half_width[1:], edges[:-1]).max(initial=0.0)),
    )
    degree = relaxed_degree(required_degree(greatest / problem.rtol, ratio))
    return float(max(degree, LOWEST_DEGREE))


def relaxed_degree(degree: Array | float) -> Array | float:
    """Return degrees that are a little lower than the amplitude estimate requires, but sufficient.

    Notes
    -----
    ``p - min(RELAXATION_RATIO p, MOST_RELAXED)``: the estimate of the amplitude is above the true
    amplitude. Shown by physics/test_size_rules.py.
    """
    return degree - np.minimum(RELAXATION_RATIO * degree, MOST_RELAXED)


def degree_of_modes(problem: Problem) -> float:
    """Return the degree that the slowest modes require on the ring that has most of them.

    Notes
    -----
    With m of the slowest modes on one ring,

        p = DEGREE_OF_THREE_MODES - DEGREES_PER_DIGIT log10(rtol) + DEGREES_PER_MODE (m - 3).

    Here m is the greatest number of a mode among the slowest ones (`relaxation_times_by_ring`). On
    thin layers the slowest modes may all be on one ring, and they may be shorter than
    `COMPARED_MODES` half-waves on it: then m is `COMPARED_MODES`, and `quads.largest_under_face`
    makes elements narrower.

    Measured errors of three relaxation times: 1e-2, 2e-4, 7e-7, 1e-9 in degrees 4, 6, 8, 10 if all
    three modes are on one ring; 7e-5, 1e-7, 1e-10 in degrees 4, 6, 8 if two of them are; 2e-8 in
    degree 4 if each mode has its own ring. Hence each further mode on a ring requires 1.5 degrees
    more. With eight modes on one ring, the errors of all eight are below 0.02 rtol for rtol from
    1e-2 to 1e-6.
    """
    count = COMPARED_MODES if problem.wants("relaxation_time") else MODES_FOR_HISTORY
    times = relaxation_times_by_ring(problem, count)
    threshold = np.sort(np.concatenate(times))[-count]
    slowest_numbers = [np.flatnonzero(of_ring >= threshold) + 1 for of_ring in times]
    greatest_number = max(numbers.max(initial=0) for numbers in slowest_numbers)
    modes_on_one_ring = min(greatest_number, COMPARED_MODES)
    return float(
        DEGREE_OF_THREE_MODES
        - DEGREES_PER_DIGIT * np.log10(problem.rtol)
        + DEGREES_PER_MODE * (modes_on_one_ring - MODES_FOR_HISTORY)
    )


def relaxation_times_by_ring(problem: Problem, least_count: int) -> list[Array]:
    """Return approximate relaxation times (n,) of the modes of each ring, by their number.

    Parameters
    ----------
    problem : the problem
    least_count : least number n of modes of a ring

    Notes
    -----
    Mode n of a ring of width b has the wave number ``s = n pi / b``. On a homogeneous half-space
    its relaxation time is proportional to ``1 / (k s)`` with the wear coefficient k of the ring. On
    layers it is also multiplied by the relative compliance to waves of that length, so that the
    slowest modes may be much shorter than the ring: their wave numbers are searched up to
    ``GREATEST_WAVE_NUMBER / h`` with the thickness h of the first layer.
    """
    rings, ground = problem.merged, problem.ground
    times = []
    for width, wear in zip(rings.widths, rings.wear_coefficients.mean(axis=0), strict=True):
        greatest = GREATEST_WAVE_NUMBER / ground.first_thickness
        count = max(least_count, int(greatest * width / np.pi))
        numbers = np.arange(1, count + 1)
        times.append(width / wear / numbers * relative_compliance(ground, np.pi * numbers / width))
    return times


def shortest_slow_waves(problem: Problem) -> Array:
    """Return for each ring (N,) the greatest wave number of its slowest modes, if they are short.

    It is 0 on a ring whose slowest modes are its longest ones, for which a sufficient degree
    (`degree_of_modes`) resolves them.
    """
    waves = np.zeros(len(problem.merged.widths))
    for ring, times in enumerate(relaxation_times_by_ring(problem, COMPARED_MODES)):
        greatest = np.argsort(-times, kind="stable")[:COMPARED_MODES].max() + 1
        if greatest > COMPARED_MODES:
            waves[ring] = np.pi * greatest / problem.merged.widths[ring]
    return waves


def pressure_count(problem: Problem, ratio: float) -> float:
    """Return an estimate of the number of pressures on a graded mesh.

    Parameters
    ----------
    problem : the problem, with the tolerance of its fields
    ratio : size ratio of neighbouring elements towards every ring edge and the rim

    Notes
    -----
    It is the sum over all elements of the degrees that the amplitudes on them require; elements are
    as small as `edge_sizes`.
    """
    half_width, sizes, amplitude = (
        np.diff(problem.merged.from_axis) / 2,
        edge_sizes(problem),
        problem.edge_amplitude,
    )
    total, highest = 0.0, pressure_degree(problem, ratio)
    # elements on the inner side of each edge, then on the outer side of each edge but the rim
    for reach, size, edges in (
        (half_width, sizes, np.arange(len(half_width))),
        (half_width[1:], sizes[:-1], np.arange(len(half_width) - 1)),
    ):
        distance = reach[:, None] * ratio ** np.arange(np.ceil(np.log(sizes.min()) / np.log(ratio)))
        edges = np.broadcast_to(edges[:, None], distance.shape)
        wanted = required_degree(amplitude(distance, reach[:, None], edges) / problem.rtol, ratio)
        degrees = np.clip(relaxed_degree(wanted), LOWEST_DEGREE, highest)
        total += float(np.sum(degrees, where=distance > size[:, None]))
    return total


@lru_cache(maxsize=16)
def with_affordable_field_tolerance(problem: Problem, ratio: float) -> Problem:
    """Return the problem with `rtol` replaced by the tolerance that its fields are resolved to.

    Notes
    -----
    - Only energies are wanted: ``min(sqrt(rtol), COARSEST_FIELD_RTOL)``, because the error of
      energies is the square of the error of fields.
    - There are so many rings that more than MOST_PRESSURES pressures would be needed: the tolerance
      is doubled until there are fewer, up to ``sqrt(rtol)``. The cost of dense matrices grows with
      the third power of the number of pressures.

    Shown by system/test_quantities.py::test_energies_alone_take_fewer_unknowns.
    """
    field_rtol = (
        min(problem.rtol**0.5, COARSEST_FIELD_RTOL) if problem.energies_only else problem.rtol
    )
    relaxed = replace(problem, rtol=field_rtol)
    while relaxed.rtol < problem.rtol**0.5 and pressure_count(relaxed, ratio) > MOST_PRESSURES:
        relaxed = replace(relaxed, rtol=min(2 * relaxed.rtol, problem.rtol**0.5))
    return relaxed


def field_accuracy(problem: Problem) -> float:
    """Return the relative tolerance that fields are resolved to on quadrilaterals.

    It is `rtol`, unless only energies are wanted or there are too many rings
    (`with_affordable_field_tolerance`).
    """
    return with_affordable_field_tolerance(problem, QUAD_GRADING).rtol
