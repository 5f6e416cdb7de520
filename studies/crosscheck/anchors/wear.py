"""Check the wear of a flat punch: volumes and power."""

from itertools import pairwise

import numpy as np

from ....meshes.radial import Array, unit_gauss
from ..methods.sampling.sampler import Sampler
from .anchor import Row, Rows
from .reported import (
    HEIGHT_ROUNDOFF,
    REFERENCE_ERROR_FACTOR,
    ROUNDOFF_TOLERANCE,
    Reported,
)

# Gauss points in each interval of the time quadrature, whose intervals double in length after a
# change of the load, and the greatest number of doublings: a sum of decaying exponentials is
# integrated with a relative error of 1e-9
POINTS_PER_DOUBLING, MOST_DOUBLINGS = 6, 40
# tolerance of the volume of each ring against the integral of its force, over rtol and the stated
# errors: Galerkin's form of Archard's law holds on each ring to roundoff
RING_VOLUME_TOLERANCE = 0.1


def check_wear(report: Reported) -> Rows:
    """Compare the wear of the whole face with the work of the force."""
    work, face, rows = report.work, report.face, report.has_slid
    even_wear = report.steady_wear_rate * work[rows]
    exact = max(ROUNDOFF_TOLERANCE, report.graded * report.rtol)
    yield Row("even wear, w F v0 t", report.even_wear[rows], even_wear, exact)
    indentation = report.take("indentation")
    worn, quadrature_error = report.integrate(report.take("profile"), 1 / report.wear)
    # the error of the profile is relative to the indentation
    quadrature_error += report.tolerance("profile") * indentation * (face.areas / report.wear).sum()
    tolerance = np.maximum(quadrature_error[rows] / work[rows], report.rtol)
    yield Row("worn volume over k, F v0 t", worn[rows], work[rows], tolerance)
    worn = report.take("worn_volume") / report.problem.wear_coefficients
    if np.isfinite(worn).all() and not report.graded:
        name = "worn volume of the answer over k, F v0 t"
        exact = max(ROUNDOFF_TOLERANCE, float(report.tolerance("worn_volume")))
        # heights are differences f = d - u; dividing by a small k magnifies their roundoff
        roundoff = HEIGHT_ROUNDOFF * indentation[-1] * (face.areas / report.wear).sum()
        yield Row(name, worn.sum(), work[-1], exact + roundoff / work[-1])


def check_power(report: Reported) -> Rows:
    """Compare the rate of the indentation with the power of wear, ``F d'(2t) = int k p^2 dA``.

    The compliance and the wear law are symmetric; therefore the rate at the time 2t follows from
    the square of the pressure at the time t.
    """
    running_in, times, step = report.solution.wear, report.times, 0.005
    stated_errors = report.tolerance("pressure")
    # skip times without pressure: at a fixed indentation pressure and power decay to zero
    rows = report.has_slid & np.isfinite(stated_errors) & (report.take("pressure") ** 2).any(axis=1)
    marched = report.problem.march != "modal" or report.problem.loading.varies
    if running_in is None or marched or not rows.any() or not report.times_are_those_solved:
        return
    # d'(2t) by central differences of fourth order; 2e-14 below is the roundoff of d
    doubled_times = 2 * times[rows]
    nearby = running_in.modal(np.outer(doubled_times, 1 + step * np.array([-2, -1, 1, 2])).ravel())
    depths = (
        -report.flat.indentation * nearby.force if report.fixed_indentation else nearby.indentation
    )
    steady = 0.0 if report.fixed_indentation else report.steady_wear_rate
    rates = depths.reshape(-1, 4) @ [1, -8, 8, -1] / (12 * step * doubled_times)
    # power of the transient part of the pressure; its product with the steady part integrates to 0
    pressure = report.take("pressure")[rows] - steady / report.wear
    transient_power, quadrature_error = report.integrate(pressure**2, report.wear)
    power = transient_power + steady
    tolerance = report.rtol + 2 * stated_errors[rows] * np.sqrt(transient_power / power)
    tolerance += (quadrature_error + 2e-14 / step / doubled_times) / power
    yield Row("power, F d'(2t) = int k p^2 dA", rates, power, tolerance)


def check_ring_volumes(report: Reported) -> Rows:
    """Compare each ring's wear between two times with its force, ``V_j = k_j int F_j ds``."""
    running_in, problem, face = report.solution.wear, report.problem, report.face
    times = report.times[report.has_slid]
    coefficients = report.reading.coefficients
    if running_in is None or coefficients is None or problem.march != "modal" or len(times) < 2:
        return
    if not report.times_are_those_solved:
        return
    sampler = Sampler(problem, running_in.compliance.space)
    force_integrals = []
    for start, end in pairwise(times):
        quadrature_times, weights = _quadrature(report, start, end)
        force_integrals.append(weights @ sampler.ring_forces(running_in.modal(quadrature_times)))
    profile, depth = (
        report.take("profile")[report.has_slid],
        report.take("indentation")[report.has_slid],
    )
    volumes = face.ring_sums(face.areas * profile)
    quadrature_error = REFERENCE_ERROR_FACTOR * face.integral_error(profile * face.areas)
    scale = volumes[1:].sum(axis=1)
    stated_error = report.errors("profile", "ring_force").max(axis=0)[report.has_slid]
    stated_error = (stated_error[1:] + stated_error[:-1]) * report.area * (depth[1:] + depth[:-1])
    tolerance = (
        RING_VOLUME_TOLERANCE * (report.rtol + stated_error / scale)
        + (quadrature_error[1:] + quadrature_error[:-1]) / scale
    )
    yield Row(
        "worn volume of each ring, V_j = k_j int F_j ds",
        np.diff(volumes, axis=0),
        np.array(force_integrals) * coefficients / report.units.wear_coefficient,
        tolerance[:, None],
        scale[:, None],
    )


def _quadrature(report: Reported, start: float, end: float) -> tuple[Array, Array]:
    """Return quadrature times, and weights for integrals over the sliding distance.

    Fast modes start again at each knot of the load, after which its slope has changed. The
    intervals of the quadrature therefore double in length from each knot on.

    Parameters
    ----------
    start, end : ends of the integral, non-dimensional times
    """
    numbers, unit = report.reading, report.units.time
    knots = numbers.knots / unit
    cuts = np.unique([start, end, *knots[(knots > start) & (knots < end)]])
    times_of_grid = [cuts]
    for first, last in pairwise(cuts):
        knot = knots[knots <= first][-1]
        shortest = max(first - knot, (last - knot) * 2.0**-MOST_DOUBLINGS)
        count = max(1, int(np.ceil(np.log2((last - knot) / shortest))))
        times_of_grid.append(knot + np.geomspace(shortest, last - knot, count + 1)[1:-1])
    grid = np.unique(np.concatenate(times_of_grid))
    nodes, gauss_weights = unit_gauss(POINTS_PER_DOUBLING)
    lengths = np.diff(grid)[:, None]
    times = (grid[:-1, None] + lengths * nodes).ravel()
    return times, (lengths * gauss_weights).ravel() * numbers.speed.at(times * unit)
