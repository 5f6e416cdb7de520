"""Element sizes at ring edges and at the rim, as functions of the tolerance.

The solution is singular there, and the smallest elements of every mesh are there. Lengths are in
punch radii a. The comment on a constant names the test under `tests/` or the study that justifies
it, if there is one.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ....fem.incompressibility import HIGHEST_RATIO
from ....meshes.radial import Array
from ..problem.problem import Problem

# Size of a layer of quadrilaterals over that of the next layer away from the edge. One more degree
# then lowers errors of fields by a factor of 3 and errors of energies by a factor of 9 (`ringwear
# study convergence`).
QUAD_GRADING = 0.25
# Relative error of the squared RMS slope that the elements at an edge may cause, over rtol. That
# error = element size / min(ring width, worn length) (physics/test_size_rules.py).
SLOPE_SHARE = 0.1
# The same at the rim, where the singularity never fades (the same test).
SLOPE_SHARE_AT_RIM = 0.03
# Element size over the worn length at rtol = 1 (extrapolated). The relative error of the mean
# squared pressure is about (size / worn length)^(3/2). On five rings this rule alone has no effect,
# because the other rules require sizes as small as this one.
PRESSURE_SHARE = 0.3
# Element size at the rim, in a, over rtol. The relative error of pressures of the flat start is up
# to 3 times that size, and that of its energy a tenth of it
# (physics/test_trust.py::test_start_pressures_are_those_of_the_closed_form).
START_SHARE = 0.03
# Element size at a hole = size at the rim * this * width of the ring next to the hole, in a: the
# singular pressure is confined to that ring (physics/test_hollow.py).
HOLE_SIZE_PER_RING_WIDTH = 3
# Square of the size of the elements at the axis over the width of the innermost ring, over rtol, if
# the wear coefficient has a slope there (physics/test_graded.py).
CONE_SHARE = 30
# Relative error of the RMS slope by roundoff of finite elements, times the size of the smallest
# elements, in a: slopes of elements of size h have the error FEM_ROUNDOFF / h. Measured on five
# rings with elements of 1e-10 to 1e-24 a. It does not grow with the ratio of the wear coefficients:
# with ratios up to 3e5, the error on two and five rings is below 1e-26 with elements of 1e-20 a at
# ring edges.
FEM_ROUNDOFF = 2e-22
# The same for a nearly incompressible solid, times (1 - 2 nu)^2: the error grows as the inverse of
# that. Measured: 3e-20 at nu = 0.49999 and 9e-23 at 0.4999.
INCOMPRESSIBLE_ROUNDOFF = 2e-29
# The same as FEM_ROUNDOFF for dimensionality reduction and boundary elements, in a, measured in the
# same way.
RADIAL_ROUNDOFF = 5e-27
# rtol over the error that roundoff may cause in the smallest elements.
ROUNDOFF_MARGIN = 3
# Upper limit, in a, of the smallest size that roundoff allows: with larger elements, the
# discretisation error would exceed the roundoff that they avoid.
MAX_ROUNDOFF_SIZE = 1e-12
# First time over the slowest relaxation time below which roundoff of the relaxation modes matters
# too; about the roundoff of a double.
MODE_ROUNDOFF_TIME = 1e-16
# Errors of quantities that depend on thin layers are not promised if (wanted element size /
# smallest element size of a method) is below this. It is two layers of elements: the coarser mesh
# used for the error estimate has one layer less.
ELEMENTS_PER_THIN_LAYER = QUAD_GRADING**-2


def edge_sizes(problem: Problem) -> Array:
    """Return the wanted element size (M,) at every ring edge except the centre; the rim is last.

    Notes
    -----
    Let b be the width of the narrower ring at an edge (or the thickness of the first layer of the
    ground, if that is less). Let l_slow and l_fast be the lengths over which wear has smoothed the
    pressure on the two sides of the edge by the first time after the start. With ``s = min(1,
    l_fast / b)``, the amplitude of the singularity (1 at the rim), the size is the minimum of

        SLOPE_SHARE rtol b,
        SLOPE_SHARE rtol min(l_slow, b) / s,
        PRESSURE_SHARE l_slow (rtol / sqrt(s))^(2/3).

    The first two bound the error of the squared RMS slope: an element of this size contributes the
    share (size / length over which the slope varies) of its integral. The third bounds the error of
    the mean squared pressure, because the pressure varies as the power 3/2 of the distance. At the
    rim, SLOPE_SHARE_AT_RIM replaces SLOPE_SHARE in the second.

    If the wear coefficient has a kink but no step at an edge, pressures of early times vary at most
    as a logarithm of the distance, with the strength of the kink as amplitude. Then the size
    ``min(1, sqrt(rtol) / kink) b`` is sufficient.

    Shown by physics/test_size_rules.py on rings and by
    physics/test_graded.py::test_methods_agree_and_estimates_bound_their_errors on kinks;
    `ringwear study tradeoff` shows the cost of a tolerance.
    """
    rtol, edge_amplitude = problem.rtol, problem.edge_amplitude
    widths = np.minimum(problem.merged.widths_at_edges, problem.ground.first_thickness)
    at_rim = np.arange(len(widths)) == len(widths) - 1
    amplitude = np.where(at_rim, 1.0, np.minimum(1.0, edge_amplitude.worn_length_fast / widths))
    slope_share = np.where(at_rim, SLOPE_SHARE_AT_RIM, SLOPE_SHARE)
    sizes = np.minimum(
        SLOPE_SHARE * rtol * widths,
        slope_share * rtol * np.minimum(edge_amplitude.worn_length_slow, widths) / amplitude,
    )
    pressure_sizes = (
        PRESSURE_SHARE * edge_amplitude.worn_length_slow * (rtol / np.sqrt(amplitude)) ** (2 / 3)
    )
    sizes = np.minimum(sizes, pressure_sizes)
    kink_sizes = np.minimum(rtol**0.5 / np.maximum(problem.merged.kinks, rtol), 1.0) * widths
    return np.where(problem.merged.smooth, np.maximum(sizes, kink_sizes), sizes)


def axis_size(problem: Problem) -> float | None:
    """Return the wanted element size at the axis; None if the solution is smooth there.

    Notes
    -----
    If the wear coefficient k has a slope at the axis, the steady pressure has a conical point, and
    the displacement a term ``r^2 log r``. On the innermost ring, whose width is b, k changes by a
    factor of at most 2. Elements of size h and degree p at the axis then cause a relative error of
    about ``(h / b)^2 / p^4``. Hence the size is ``b sqrt(CONE_SHARE rtol)``. Shown by
    physics/test_graded.py::test_steady_states_of_steep_wear_in_closed_form.
    """
    if not problem.merged.cone_at_axis:
        return None
    return float(problem.merged.widths[0] * np.sqrt(CONE_SHARE * problem.rtol))


def rim_size(problem: Problem, fields: Problem) -> float:
    """Return the wanted size of the elements at the rim.

    Parameters
    ----------
    problem : the problem with the requested tolerance
    fields : the same problem with the tolerance of its fields

    Notes
    -----
    It is the size of `edge_sizes` at the rim, but at most ``START_SHARE rtol``, because the
    pressure of the flat start has an inverse square root singularity at the rim. Shown by
    physics/test_flat_punch.py::test_indentation_on_radial_meshes.
    """
    return float(min(edge_sizes(fields)[-1], START_SHARE * problem.rtol))


def ring_sizes(problem: Problem, fields: Problem) -> Array:
    """Return the wanted sizes (M-1,) at the ring edges between centre and rim.

    Parameters
    ----------
    problem : the problem with the requested tolerance
    fields : the same problem with the tolerance of its fields

    Notes
    -----
    They are those of `edge_sizes`, rounded down to powers of two, because a mesher makes one size
    field per distinct value. At the edge of a hole the pressure of the flat start is infinite as at
    the rim. There the size is at most ``min(1, HOLE_SIZE_PER_RING_WIDTH b)`` times `rim_size`, with
    the width b of the ring next to the hole. Shown by physics/test_hollow.py.
    """
    sizes = edge_sizes(fields)[:-1]
    if problem.inner_radius:
        scale = min(1.0, HOLE_SIZE_PER_RING_WIDTH * float(problem.merged.narrower[0]))
        sizes[0] = min(sizes[0], rim_size(problem, fields) * scale)
    return 2.0 ** np.floor(np.log2(sizes))


def smallest_size(problem: Problem, roundoff: float) -> float:
    """Return the smallest element size at a ring edge for which roundoff costs a third of rtol.

    Parameters
    ----------
    problem : the problem, with its tolerance and its times
    roundoff : constant of the method, `FEM_ROUNDOFF` or `RADIAL_ROUNDOFF`

    Notes
    -----
    Slopes of elements of size h have the error ``roundoff / h``. Hence the size is
    ``ROUNDOFF_MARGIN roundoff / rtol``. If the first time is below ``MODE_ROUNDOFF_TIME``
    relaxation times, the roundoff of the modes matters, which also grows in small elements; the
    size is then MAX_ROUNDOFF_SIZE. Shown by
    physics/test_random_scenes.py::test_numbers_at_extremes_are_right_or_left_out.
    """
    slowest_rate = float(problem.merged.wear_coefficients.min())
    if 0 < problem.earliest * slowest_rate < MODE_ROUNDOFF_TIME:
        return MAX_ROUNDOFF_SIZE
    return min(ROUNDOFF_MARGIN * roundoff / problem.rtol, MAX_ROUNDOFF_SIZE)


def compressibility(problem: Problem) -> float:
    """Return the least 1 - 2 nu of the solid of finite elements, by which roundoff is divided."""
    return 1 - 2 * min(problem.poisson_ratio, HIGHEST_RATIO)


def fem_smallest(problem: Problem) -> float:
    """Return the smallest size of finite elements at a ring edge.

    Notes
    -----
    It is `smallest_size` with the maximum of FEM_ROUNDOFF and ``INCOMPRESSIBLE_ROUNDOFF / (1 - 2
    nu)^2``, because the stiffness against a change of volume multiplies roundoff. Shown by
    physics/test_random_scenes.py::test_numbers_at_extremes_are_right_or_left_out.
    """
    roundoff = max(FEM_ROUNDOFF, INCOMPRESSIBLE_ROUNDOFF / compressibility(problem) ** 2)
    return smallest_size(problem, roundoff)


def missing_layers(problem: Problem, smallest: float) -> Array:
    """Return how many layers of elements (T,) the mesh lacks at each time for the error estimate.

    Parameters
    ----------
    problem : its `estimate_times` are those times
    smallest : smallest element size that the method can use; 0 if there is no limit

    Notes
    -----
    ``ln(wanted / smallest) / ln(QUAD_GRADING)``, but at least 0, with the smallest size `wanted` of
    `edge_sizes` if the history begins at that time.
    """
    layers = np.zeros(len(problem.estimate_times))
    for index, time in enumerate(problem.estimate_times):
        problem_at_time = replace(problem, times=np.array([time]))
        wanted = float(edge_sizes(problem_at_time).min()) if problem_at_time.earliest else np.inf
        layers[index] = (
            max(np.log(wanted / smallest) / np.log(QUAD_GRADING), 0.0) if smallest else 0.0
        )
    return layers


# cached, because the reasons of all compared times need it
@lru_cache(maxsize=16)
def amplified_roundoff(problem: Problem) -> Array:
    """Return the factor (T,) by which thin layers amplify the roundoff of RMS slopes.

    Finite elements of a nearly incompressible solid have a relative roundoff e of displacements
    that is far above that of a double. Next to an edge, wear has smoothed the pressure over a
    length l, and the slope of the worn profile there is proportional to ``1 / sqrt(l)``. Such a
    slope times the roundoff ``e / h`` of slopes, integrated over an element of size h, is in
    proportion to ``e / sqrt(l)`` for every h.

    Returns
    -------
    array
        The maximum over all ring edges of ``s sqrt(b / l)``: the length l on the slower side, at
        most the width b of the narrower ring, and the amplitude s of the singularity, as in
        `edge_sizes`. At times without wear it is 0.
    """
    rings, worn = problem.merged, problem.worn_distances > 0
    slow, fast = (
        np.minimum(1.0, wear * problem.worn_distances[worn, None] / rings.widths_at_edges)
        for wear in rings.wear_at_edges
    )
    fast[:, -1] = 1.0
    root = np.sqrt(np.maximum(slow, np.finfo(float).tiny))
    factors = np.zeros(len(worn))
    factors[worn] = np.where(rings.smooth, 0.0, fast / root).max(axis=1)
    return factors
