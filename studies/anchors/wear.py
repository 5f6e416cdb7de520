"""Check the wear of a flat punch: volumes, reciprocity and power."""

from itertools import pairwise

import numpy as np

from ...meshes.radial import Array, unit_gauss
from ..sampling.sampler import Sampler
from .anchor import Row, Rows
from .reported import DOUBT, EXACT, Reported

# Gauss points in each doubling of the distance since a load began to change: a sum of decaying
# exponentials is integrated to 1e-9 of itself
POINTS_A_DOUBLING, MOST_DOUBLINGS = 6, 40
# part of the indentation that roundoff takes from heights, a few units of the last digit
HEIGHTS_LOST = 1e-15
# part of the accuracy asked for that each ring's volume may be off the integral of its force:
# Galerkin's form of Archard's law holds on each ring to roundoff
OF_RING_VOLUMES = 0.1


def check_wear(report: Reported) -> Rows:
    """Compare what has worn over the whole face, by volume and by reciprocity."""
    work, face, later = report.work, report.face, report.later
    profile, depth = report.take("profile"), report.take("indentation")
    force = report.take("normal_force") if report.fixed else report.forces
    if not report.fixed:
        worn, doubt = report.integrate(profile, 1 / report.wear)
        # the profile is promised relative to the indentation
        doubt += report.tolerance("profile") * depth * (face.areas / report.wear).sum()
        tolerance = np.maximum(doubt[later] / work[later], report.rtol)
        yield Row("worn volume over k, F v0 t", worn[later], work[later], tolerance)
        worn = report.take("worn_volume") / report.problem.wear_coefficients
        if np.isfinite(worn).all() and not report.graded:
            name = "worn volume of the answer over k, F v0 t"
            exact = max(EXACT, float(report.tolerance("worn_volume")))
            # heights are differences f = d - u, whose roundoff counts most where wear is slow
            lost = HEIGHTS_LOST * depth[-1] * (face.areas / report.wear).sum()
            yield Row(name, worn.sum(), work[-1], exact + lost / work[-1])
    tolerance = report.tolerance("indentation", "profile")
    lost, doubt = report.integrate(profile, report.flat.pressure_at(face.radii))
    name = "reciprocity with the flat punch"
    yield Row(name, report.flat.indentation * force + lost, depth, tolerance + doubt / depth)
    if report.graded:
        return
    tolerance = report.tolerance("indentation", "profile", "pressure")
    lost, _ = report.integrate(profile, report.steady_wear_rate / report.wear)
    moved, doubt = report.integrate(report.take("pressure"), report.steady_displacement(face.radii))
    name = "reciprocity with the steady state"
    yield Row(name, moved + lost, depth, tolerance + doubt / depth)


def check_power(report: Reported) -> Rows:
    """Compare the rate of the indentation with the power that wear takes, ``F d'(2t) = int k p^2``.

    The compliance and the law of wear are symmetric, so that the rate at twice the time is the
    square of the pressure at the time.
    """
    wear, times, step = report.solution.wear, report.times, 0.005
    stated = report.tolerance("pressure")
    # at a fixed indentation the pressure vanishes in the end, and with it the power
    some = report.later & np.isfinite(stated) & (report.take("pressure") ** 2).any(axis=1)
    marched = report.problem.march != "modal" or report.problem.loading.varies
    if wear is None or marched or not some.any() or not report.times_are_those_solved:
        return
    # d'(2t) by differences of fourth order, with the roundoff of d over short times
    twice = 2 * times[some]
    near = wear.modal(np.outer(twice, 1 + step * np.array([-2, -1, 1, 2])).ravel())
    depths = -report.flat.indentation * near.force if report.fixed else near.indentation
    steady = 0.0 if report.fixed else report.steady_wear_rate
    rates = depths.reshape(-1, 4) @ [1, -8, 8, -1] / (12 * step * twice)
    # of what is not yet steady; its product with what is steady integrates to 0
    pressure = report.take("pressure")[some] - steady / report.wear
    spent, doubt = report.integrate(pressure**2, report.wear)
    power = spent + steady
    tolerance = report.rtol + 2 * stated[some] * np.sqrt(spent / power)
    tolerance += (doubt + 2e-14 / step / twice) / power
    yield Row("power, F d'(2t) = int k p^2 dA", rates, power, tolerance)


def check_ring_volumes(report: Reported) -> Rows:
    """Compare what each ring wears from time to time with its force, ``V_j = k_j int F_j ds``."""
    wear, problem, face = report.solution.wear, report.problem, report.face
    times = report.times[report.later]
    coefficients = report.reading.coefficients
    if wear is None or coefficients is None or problem.march != "modal" or len(times) < 2:
        return
    if not report.times_are_those_solved:
        return
    sampler = Sampler(problem, wear.compliance.space)
    passed = []
    for start, end in pairwise(times):
        at, weights = _quadrature(report, start, end)
        passed.append(weights @ sampler.ring_forces(wear.modal(at)))
    profile, depth = report.take("profile")[report.later], report.take("indentation")[report.later]
    volumes = face.ring_sums(face.areas * profile)
    doubt = DOUBT * face.integral_error(profile * face.areas)
    scale = volumes[1:].sum(axis=1)
    stated = report.errors("profile", "ring_force").max(axis=0)[report.later]
    stated = (stated[1:] + stated[:-1]) * report.area * (depth[1:] + depth[:-1])
    tolerance = OF_RING_VOLUMES * (report.rtol + stated / scale) + (doubt[1:] + doubt[:-1]) / scale
    yield Row(
        "each ring wears by its force, V_j = k_j int F_j ds",
        np.diff(volumes, axis=0),
        np.array(passed) * coefficients / report.units.wear_coefficient,
        tolerance[:, None],
        scale[:, None],
    )


def _quadrature(report: Reported, start: float, end: float) -> tuple[Array, Array]:
    """Return times, and weights of the sliding distance, that integrate from a time to another.

    Where the load begins to change, fast modes begin anew: intervals double from each such knot.
    """
    reading, unit = report.reading, report.units.time
    knots = reading.knots / unit
    cuts = np.unique([start, end, *knots[(knots > start) & (knots < end)]])
    places = [cuts]
    for first, last in pairwise(cuts):
        began = knots[knots <= first][-1]
        shortest = max(first - began, (last - began) * 2.0**-MOST_DOUBLINGS)
        count = max(1, int(np.ceil(np.log2((last - began) / shortest))))
        places.append(began + np.geomspace(shortest, last - began, count + 1)[1:-1])
    grid = np.unique(np.concatenate(places))
    node, weight = unit_gauss(POINTS_A_DOUBLING)
    lengths = np.diff(grid)[:, None]
    times = (grid[:-1, None] + lengths * node).ravel()
    return times, (lengths * weight).ravel() * reading.speed.at(times * unit)
