"""Sizes of elements beside ring edges and at the rim, by the wanted accuracy.

Fields are singular there, so the smallest elements of every mesh are. Lengths are in punch radii.
Constants name what shows them, a test under `tests/` or a study, where there is one.
"""

import numpy as np

from ...meshes.radial import Array
from ..problem.problem import Problem

# size of a layer of quadrilaterals over that of the layer outside it: a degree more then lowers
# errors of fields three times and those of energies nine times (`ringwear study convergence`)
FACTOR = 0.25
# share of rtol that the squared RMS slope may lose in the elements at an edge: it loses as much as
# these elements are of what wear has smoothed, or of the ring
# (physics/test_size_rules.py)
SLOPE_SHARE = 0.1
# the same at the rim, where the singularity never fades (the same test)
SLOPE_SHARE_AT_RIM = 0.03
# size over the worn length, where rtol is 1: the mean square of the pressure loses the power 3/2 of
# the size over the worn length. Five rings do not feel it alone, because the other rules ask for
# sizes as small there
PRESSURE_SHARE = 0.3
# size at the rim over rtol. Pressures of the flat start err by up to three times that size, and its
# energy by a tenth of it: that is stated of them (`methods/error_factors.py`)
START_SHARE = 0.03
# sizes at a hole are to those at the rim as this many widths of the ring beside it to the radius,
# for the singular pressure is confined to the ring (physics/test_hollow.py)
WIDTHS_OF_RINGS_AT_HOLES = 3
# relative error of the RMS slope by the roundoff of finite elements, times the size of the smallest
# ones, in a: slopes of elements of size h err by roundoff / h. Measured by five rings on elements
# of 1e-10 to 1e-24 a. It does not grow with the ratio of the wear coefficients: with ratios up to
# 3e5, two and five rings lose less than 1e-26 on elements of 1e-20 a beside ring edges
FEM_ROUNDOFF = 2e-22
# the same for an incompressible solid, times (1 - 2 nu)^2, with which it grows: 3e-20 was measured
# at 0.49999, which 1/2 is modelled as, and 9e-23 at 0.4999
INCOMPRESSIBLE_ROUNDOFF = 2e-29
# greatest Poisson's ratio that is modelled
GREATEST_MODELLED_RATIO = 0.49999
# the same of dimensionality reduction and boundary elements, in a, measured in the same way
RADIAL_ROUNDOFF = 5e-27
# times by which the error of roundoff in the smallest elements is kept below rtol
MARGIN_OF_ROUNDOFF = 3
# greatest size that this roundoff may ask for, in a: larger elements would lose more than it takes
GREATEST_OF_SMALLEST = 1e-12
# first time over the slowest relaxation time below which roundoff of the modes is felt, too
# about the roundoff of a double
EARLIEST_OF_MODES = 1e-16
# a quantity is felt in layers that a mesh has, or its coarser one lacks, if they are thinner than
# this many times its smallest elements: two layers of them
THIN = FACTOR**-2


def edge_sizes(problem: Problem) -> Array:
    """Return the wanted sizes (N,) at every ring edge but the centre, the rim last.

    Notes
    -----
    With the relative accuracy ``rtol``, the width b of the narrower ring beside an edge, or the
    thickness of the first layer if that is less, and the lengths l_slow and l_fast over which wear
    has smoothed the pressure on its two sides by the first time after the start, the size is the
    least of three:

        SLOPE_SHARE rtol b,
        SLOPE_SHARE rtol min(l_slow, b) / s,
        PRESSURE_SHARE l_slow (rtol / sqrt(s))^(2/3),      s = min(1, l_fast / b).

    The first two keep the squared RMS slope: an element of this size holds as large a share of its
    integral as it is of the length over which the slope varies. The third keeps the mean square of
    the pressure, which varies by the power 3/2 of the distance. The amplitude s is that of the
    singularity, and 1 at the rim. Where the wear coefficient has a kink and no step, pressures of
    early times are a logarithm of the distance at most, with the amplitude of the kink, so that
    ``sqrt(rtol) / kink`` of the ring is enough.

    Shown by physics/test_size_rules.py on rings and by
    physics/test_graded.py::test_methods_agree_and_errors_stated_are_above_the_true_ones on kinks;
    `ringwear study tradeoff` shows what the accuracy costs.
    """
    rtol, narrower, worn = problem.rtol, problem.merged.narrower, problem.edge_amplitude
    narrower = np.append(narrower, problem.merged.widths[-1])
    if problem.ground is not None:
        narrower = np.minimum(narrower, problem.ground.first_thickness)
    at_rim = np.arange(len(narrower)) == len(narrower) - 1
    amplitude = np.where(at_rim, 1.0, np.minimum(1.0, worn.worn_length_fast / narrower))
    slope_share = np.where(at_rim, SLOPE_SHARE_AT_RIM, SLOPE_SHARE)
    sizes = np.minimum(
        SLOPE_SHARE * rtol * narrower,
        slope_share * rtol * np.minimum(worn.worn_length_slow, narrower) / amplitude,
    )
    of_pressure = PRESSURE_SHARE * worn.worn_length_slow * (rtol / np.sqrt(amplitude)) ** (2 / 3)
    sizes = np.minimum(sizes, of_pressure)
    continuous = np.minimum(rtol**0.5 / np.maximum(problem.merged.kinks, rtol), 1.0) * narrower
    return np.asarray(np.where(problem.merged.smooth, np.maximum(sizes, continuous), sizes))


def rim_size(problem: Problem, fields: Problem) -> float:
    """Return the wanted size of the elements at the rim.

    Parameters
    ----------
    problem : with the accuracy asked for
    fields : the same with the accuracy of its fields

    Notes
    -----
    It is the size of `edge_sizes` there, and at most ``START_SHARE rtol``: the pressure of the flat
    start is infinite at the rim as a root. Shown by
    physics/test_flat_punch.py::test_indentation_on_radial_meshes.
    """
    return float(min(edge_sizes(fields)[-1], START_SHARE * problem.rtol))


def ring_sizes(problem: Problem, fields: Problem) -> Array:
    """Return the wanted sizes (N-1,) at the ring edges between centre and rim.

    Parameters
    ----------
    problem : with the accuracy asked for
    fields : the same with the accuracy of its fields

    Notes
    -----
    They are those of `edge_sizes`, rounded down to powers of two, because a mesher makes a size
    field of each distinct value. At the edge of a hole, pressures of the flat start are infinite as
    at the rim, so that the size is at most ``min(1, WIDTHS_OF_RINGS_AT_HOLES b)`` times `rim_size`,
    with the width b of the ring beside the hole. Shown by physics/test_hollow.py.
    """
    sizes = edge_sizes(fields)[:-1]
    if problem.merged.hollow:
        scale = min(1.0, WIDTHS_OF_RINGS_AT_HOLES * float(problem.merged.narrower[0]))
        sizes[0] = min(sizes[0], rim_size(problem, fields) * scale)
    return np.asarray(2.0 ** np.floor(np.log2(sizes)))


def smallest_size(problem: Problem, roundoff: float) -> float:
    """Return the least size of elements beside a ring edge, so that roundoff costs a third of rtol.

    Parameters
    ----------
    problem : with its accuracy and its times
    roundoff : of the method, `FEM_ROUNDOFF` or `RADIAL_ROUNDOFF`

    Notes
    -----
    Slopes of elements of size h err by ``roundoff / h``, so that the size is ``MARGIN_OF_ROUNDOFF
    roundoff / rtol``. Before ``EARLIEST_OF_MODES`` relaxation times, roundoff of the modes is felt,
    which grows in small elements, too. Shown by
    physics/test_promise.py::test_layers_thinner_than_the_roundoff_of_radii_are_resolved.
    """
    slowest = float(problem.merged.ends.min())
    if 0 < problem.earliest * slowest < EARLIEST_OF_MODES:
        return GREATEST_OF_SMALLEST
    return min(MARGIN_OF_ROUNDOFF * roundoff / problem.rtol, GREATEST_OF_SMALLEST)


def fem_smallest(problem: Problem) -> float:
    """Return the least size of finite elements beside a ring edge.

    Notes
    -----
    It is `smallest_size` with the greater of FEM_ROUNDOFF and ``INCOMPRESSIBLE_ROUNDOFF / (1 - 2
    nu)^2``, because the stiffness against a change of volume multiplies roundoff. Shown by
    physics/test_promise.py::test_finite_elements_resolve_layers_of_slow_rings.
    """
    compressibility = 1 - 2 * min(problem.poisson_ratio, GREATEST_MODELLED_RATIO)
    roundoff = max(FEM_ROUNDOFF, INCOMPRESSIBLE_ROUNDOFF / compressibility**2)
    return smallest_size(problem, roundoff)
