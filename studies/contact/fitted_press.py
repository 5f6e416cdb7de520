"""Static contact on a mesh fitted to its edges.

High degrees, graded to where the pressure is singular.

The contact is one or more intervals of the radius. Their edges are fixed, corners of the punch face
at which the pressure is infinite, but for the outermost, which may be free: there the pressure
falls to zero as a root, and the stress intensity vanishes, which the coefficient of the pressure at
the edge measures. With the edges given, all is linear: ``A p = d b - m``. The coefficient at a free
edge gives d, and the load is one equation for the radius.

The half-space has no length of its own: the compliance on a disc of radius c is ``c^3`` times that
of the unit disc under the same intervals, scaled. Of a sphere or a cone one compliance serves every
radius. Layers have a length, and another compliance for each radius. Non-dimensional.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ...mdr import energy
from ...meshes.compliance import Compliance
from ...meshes.contact_cells import fitted_space
from ...meshes.errors import SolverError
from ...meshes.ground.ground import Ground
from ..problem.profile import InitialProfile
from ..wear.flat_contact import FittedPress
from ..wear.unilateral import Interval, Load
from .moments import moments

Intervals = tuple[Interval, ...]
# (edges from 0 to 1 that every pressure space must be broken at, which of them the pressure is
# infinite at, layers in units of the outermost edge, if there are any) -> compliance
CompliancesOn = Callable[[tuple[float, ...], tuple[bool, ...], Ground | None], Compliance]

# of the search for the radius of a free edge: steps, the first over the width of what may hold it,
# and the last over the radius
MOST_SECANTS, FIRST_STEP, RADIUS_TOLERANCE = 60, 1e-3, 1e-7
# kinks of the face that the mesh is fitted to: no nearer to an edge of the contact than this part
# of its width, and no more than this in a part
NEAREST_KINK, MOST_KINKS = 1e-6, 4


def fit_presses(
    profile: InitialProfile,
    load: Load,
    intervals: Intervals,
    compliances: tuple[CompliancesOn, CompliancesOn],
    ground: Ground | None = None,
) -> tuple[FittedPress, FittedPress]:
    """Press an unworn punch on pressures of a higher and of a lower degree.

    Parameters
    ----------
    profile, load : of the punch
    intervals : where it touches, about
    compliances : of the higher degree, and of the lower, which shows what it errs by
    ground : layers, if there are any

    Raises
    ------
    SolverError
        if an edge within the contact is free, or its radius is not found
    """
    if not intervals:
        raise SolverError("nothing touches that cells could feel")
    *_, outermost = edges = [
        free for part in intervals for free in (part.inner_free, part.outer_free)
    ]
    if any(edges[:-1]):
        raise SolverError("it ends where the face is smooth, and not at its outermost edge alone")
    slope = None
    if outermost:
        rough, slope = fit_press(profile, load, intervals, _roughly, ground)
        intervals = rough.intervals
    # in turn, each from where the last found the edge
    coarse, slope = fit_press(profile, load, intervals, compliances[1], ground, slope)
    fine, _ = fit_press(profile, load, coarse.intervals, compliances[0], ground, slope)
    for press in (fine, coarse):
        radii, _, _ = press.space.quadrature
        pressure = press.space.matrix(radii.ravel()) @ press.pressure
        # beyond what polynomials do at edges
        if pressure.min() < -1e-3 * press.force / (np.pi * press.radius**2):
            raise SolverError("the contact has more parts than were found")
    return fine, coarse


def _roughly(
    edges: tuple[float, ...], infinite: tuple[bool, ...], ground: Ground | None
) -> Compliance:
    """Return a compliance that takes no time, by which the edge is sought first."""
    space = fitted_space(edges, infinite, 4, 1e-2 * min(np.diff(edges)))
    return energy.compliance(space, ground)


def fit_press(
    profile: InitialProfile,
    load: Load,
    intervals: Intervals,
    on_edges: CompliancesOn,
    ground: Ground | None = None,
    slope: float | None = None,
) -> tuple[FittedPress, float | None]:
    """Press an unworn punch, and find its outermost edge from a start near it, if that is free.

    Returns by how much the load is missed for how much that edge is, too, and takes it from where
    it is about the same.

    Raises
    ------
    SolverError
        if it is not found: the contact is of another kind than the start
    """
    *inner, last = intervals
    compliance_on, radius = lru_cache(on_edges), last.outer

    def solve(outer: float, load: Load | None) -> FittedPress:
        parts = (*inner, replace(last, outer=float(outer)))
        return _solve(profile, load, parts, compliance_on, ground)

    def miss(outer: float) -> float:
        """Return by how much the load is missed, in a power that is linear of a sphere."""
        press = solve(outer, None)
        if load.force is None:
            return float(np.sqrt(press.indentation / float(load.indentation or 1.0)) - 1)
        return float(np.cbrt(press.force / load.force) - 1)

    if not last.outer_free:
        return solve(radius, load), None
    # The load grows with the radius, but beyond a kink of the face in another way, and short of it
    # there may be none: the secants of one side say nothing of the other.
    low = max([last.inner, *(kink for kink in profile.kinks if kink < radius)])
    high, step, last_miss = 1.0, 0.0, 0.0
    for _ in range(MOST_SECANTS):
        missed = miss(radius)
        if step:
            slope = (missed - last_miss) / step
        elif slope is None:
            nearby = radius - FIRST_STEP * (radius - low)
            slope = (missed - miss(nearby)) / (radius - nearby)
        if missed < 0:
            low = radius
        else:
            # at the kink the load may be too large already
            low, high = (low if low < radius else last.inner), radius
        secant = -missed / slope if slope > 0 else np.inf
        # secants converge faster than linearly: the error is far below the last step
        if abs(secant) <= RADIUS_TOLERANCE * radius:
            # d by the load, of which an edge a little off takes nothing in the first order
            return solve(radius + secant, load), slope
        step = secant if low < radius + secant < high else (low + high) / 2 - radius
        radius, last_miss = radius + step, missed
    raise SolverError("the edge of the contact was not found")


def _solve(
    profile: InitialProfile,
    load: Load | None,
    intervals: Intervals,
    compliance_on: CompliancesOn,
    ground: Ground | None,
) -> FittedPress:
    """Return the press whose contact has these edges.

    If no load is given, its indentation d is the one at which the outermost edge is free.
    """
    last = intervals[-1]
    radius = last.outer
    if not last.inner < radius <= 1:
        raise SolverError("the edges of the contact cross each other or leave the punch")
    infinite = {edge: True for part in intervals for edge in (part.inner, part.outer)}
    infinite |= {0.0: False, radius: not last.outer_free}
    for part in intervals:
        # the pressure goes as x log x at a kink, which ring forces would feel by 2e-4
        near = NEAREST_KINK * (part.outer - part.inner)
        kinks = [kink for kink in profile.kinks if part.inner + near < kink < part.outer - near]
        infinite |= dict.fromkeys(kinks if len(kinks) <= MOST_KINKS else (), False)
    edges = sorted(infinite)
    compliance = compliance_on(
        tuple(edge / radius for edge in edges),
        tuple(infinite[edge] for edge in edges),
        None if ground is None else ground.in_units_of(radius),
    )
    space = compliance.space
    middle = radius * (space.breakpoints[1:] + space.breakpoints[:-1]) / 2
    inside = [(middle > part.inner) & (middle < part.outer) for part in intervals]
    carries = np.setdiff1d(space.dofs[np.any(inside, axis=0)], space.size)
    weights = space.weights[carries] * radius**2
    of_profile = moments(profile, space, radius)[carries] * radius**2
    try:
        factor = cho_factor(compliance.matrix[np.ix_(carries, carries)] * radius**3)
    except np.linalg.LinAlgError as error:
        raise SolverError(
            f"the compliance of the contact is not positive definite: {error}"
        ) from error
    by_weights, by_moments = cho_solve(factor, weights), cho_solve(factor, of_profile)
    if load is None:
        # the last function is the hat at the outermost edge
        indentation = by_moments[-1] / by_weights[-1]
    elif load.force is not None:
        indentation = (load.force + weights @ by_moments) / (weights @ by_weights)
    else:
        indentation = load.indentation or 0.0
    pressure = np.zeros(space.size)
    pressure[carries] = indentation * by_weights - by_moments
    force = float(weights @ pressure[carries])
    return FittedPress(space, pressure, float(indentation), force, intervals)
