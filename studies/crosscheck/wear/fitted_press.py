"""Solve static contact on a mesh that is fitted to the contact edges. Non-dimensional.

The mesh has high polynomial degrees and is graded towards singularities of the pressure. The
contact is one or more intervals of the radius. Their edges are fixed: they are corners of the punch
face with infinite pressure. Only the outermost edge may be free. There the pressure falls to zero
as a square root, and the stress intensity, which the coefficient of the pressure at the edge
measures, vanishes. If the edges are given, the problem is linear: ``A p = d b - m``. The condition
at the free edge gives d, and the load is one equation for the radius of that edge.

A homogeneous half-space has no intrinsic length: the compliance on a disc of radius c is ``c^3``
times that of the unit disc with scaled intervals. One compliance is therefore enough for all radii
of a sphere or a cone. With layers, each radius needs another compliance.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ....mdr import energy
from ....meshes.compliance import Compliance
from ....meshes.contact_cells import fitted_space
from ....meshes.errors import SolverError
from ....meshes.ground.ground import HALF_SPACE, Ground
from ..problem.profile import InitialProfile, moments, unresolved_height
from .flat_contact import FittedPress
from .unilateral import Interval, Load

Intervals = tuple[Interval, ...]
# function of (edges from 0 to 1 at which every pressure space has breakpoints, size of the elements
# at each but the first, layers in units of the outermost edge) that returns the compliance
CompliancesOn = Callable[[tuple[float, ...], tuple[float, ...], Ground], Compliance]

# secant search for the radius of a free edge: greatest number of steps, length of the first step
# over the width of the bracket, and greatest length of the last step over the radius
MOST_SECANTS, FIRST_STEP, RADIUS_TOLERANCE = 60, 1e-3, 1e-7
# size of the elements, over the radius of the outermost edge, at edges where the pressure is
# infinite, and at edges where it falls to zero; on smaller elements the stiffness loses digits
SIZE_AT_CORNER, SIZE_AT_FREE_EDGE = 1e-10, 2.5e-7
# the mesh is fitted to kinks of the face whose distance from a contact edge, over the width of that
# part of the contact, is at least NEAREST_KINK; to none if there are more than MOST_KINKS
NEAREST_KINK, MOST_KINKS = 1e-6, 60
# Number of layers of elements that all kinks share, and the size of a layer over that of the next
# outer one (`fitted_space`). At a jump of the curvature, the pressure behaves as x log x, and two
# layers make forces right to 1e-8; at a jump of the slope it is infinite as a logarithm, and needs
# all layers down to SIZE_AT_FREE_EDGE, which few kinks get.
LAYERS_AT_KINKS, LAYER_FACTOR = 60, 0.2


def fit_presses(
    profile: InitialProfile,
    load: Load,
    intervals: Intervals,
    compliances: tuple[CompliancesOn, CompliancesOn],
    ground: Ground = HALF_SPACE,
) -> tuple[FittedPress, FittedPress]:
    """Press an unworn punch with pressures of a higher and of a lower polynomial degree.

    Parameters
    ----------
    profile : InitialProfile
        Unworn face.
    load : Load
        Force or indentation.
    intervals : tuple of Interval
        Approximate parts of the contact.
    compliances : tuple of two callables
        Return the compliances of the higher degree, and of the lower one for the error estimate.
    ground : Ground, optional
        Layers, if there are any.

    Raises
    ------
    SolverError
        if an edge other than the outermost is free, if the radius of the free edge is not found, or
        if a pressure is clearly negative
    """
    if not intervals:
        raise SolverError("there is no contact, or it is too small for the cells")
    *_, outermost = edges = [
        free for part in intervals for free in (part.inner_free, part.outer_free)
    ]
    if any(edges[:-1]):
        raise SolverError("the contact has a free edge other than its outermost one")
    slope = None
    if outermost:
        rough, slope = fit_press(profile, load, intervals, _rough_compliance, ground)
        intervals = rough.intervals
    # each search for the edge starts from the result of the previous one; elements at kinks have
    # the lowest degree in both, and only a layer less shows the error there
    coarse, slope = fit_press(
        profile, load, intervals, compliances[1], ground, slope, fewer_layers=1
    )
    fine, _ = fit_press(profile, load, coarse.intervals, compliances[0], ground, slope)
    for press in (fine, coarse):
        radii, _, _ = press.space.quadrature
        pressure = press.space.matrix(radii.ravel()) @ press.pressure
        # polynomials may be slightly negative at edges; this is more
        if pressure.min() < -1e-3 * press.force / (np.pi * press.radius**2):
            raise SolverError("the contact has more parts than were found")
    return fine, coarse


def _rough_compliance(
    edges: tuple[float, ...], sizes: tuple[float, ...], ground: Ground
) -> Compliance:
    """Return a cheap, inaccurate compliance for the first search for the edge."""
    rough = np.maximum(sizes, 1e-2 * min(np.diff(edges)))
    return energy.compliance(fitted_space(edges, rough, 4), ground)


def fit_press(
    profile: InitialProfile,
    load: Load,
    intervals: Intervals,
    on_edges: CompliancesOn,
    ground: Ground = HALF_SPACE,
    slope: float | None = None,
    fewer_layers: int = 0,
) -> tuple[FittedPress, float | None]:
    """Press an unworn punch; if the outermost edge is free, find its radius by secant steps.

    Parameters
    ----------
    profile, load, intervals, ground
        See `fit_presses`; `intervals` contain the first guess of the radius.
    on_edges : callable
        Returns the compliance.
    slope : float, optional
        Derivative of the load error with respect to the radius, from a similar problem.
    fewer_layers : int, optional
        By how much the number of layers at each kink of the face is lower.

    Returns
    -------
    FittedPress
    float or None
        The derivative of the load error; None if no edge is free.

    Raises
    ------
    SolverError
        if the radius is not found, because the contact has other parts than `intervals`
    """
    *inner, last = intervals
    compliance_on, radius = lru_cache(on_edges), last.outer

    def solve(outer: float, load: Load | None) -> FittedPress:
        parts = (*inner, replace(last, outer=float(outer)))
        return _solve(profile, load, parts, compliance_on, ground, fewer_layers)

    def load_error(outer: float) -> float:
        """Return the relative error of the load, in a power that is linear in a sphere's radius."""
        press = solve(outer, None)
        if load.force is None:
            return float(np.sqrt(press.indentation / float(load.indentation or 1.0)) - 1)
        return float(np.cbrt(press.force / load.force) - 1)

    if not last.outer_free:
        return solve(radius, load), None
    # The load increases with the radius, but differently on the two sides of a kink of the face,
    # and inside the kink it may be zero. Secants from one side are therefore useless on the other.
    low = max([last.inner, *(kink for kink in profile.kinks if kink < radius)])
    high, step, last_error = 1.0, 0.0, 0.0
    for _ in range(MOST_SECANTS):
        error = load_error(radius)
        if step:
            slope = (error - last_error) / step
        elif slope is None:
            nearby = radius - FIRST_STEP * (radius - low)
            slope = (error - load_error(nearby)) / (radius - nearby)
        if error < 0:
            low = radius
        else:
            # if the load is too large even at the kink, the edge is inside it
            low, high = (low if low < radius else last.inner), radius
        secant = -error / slope if slope > 0 else np.inf
        # secants converge faster than linearly: the error is far below the last step
        if abs(secant) <= RADIUS_TOLERANCE * radius:
            # d follows from the load, in which the error of the edge is of second order
            return solve(radius + secant, load), slope
        step = secant if low < radius + secant < high else (low + high) / 2 - radius
        radius, last_error = radius + step, error
    raise SolverError("the edge of the contact was not found")


def _solve(
    profile: InitialProfile,
    load: Load | None,
    intervals: Intervals,
    compliance_on: CompliancesOn,
    ground: Ground,
    fewer_layers: int,
) -> FittedPress:
    """Return the solution of the linear problem in which the contact has the given edges.

    If no load is given, the indentation is the one at which the pressure vanishes at the outermost
    edge.

    Raises
    ------
    SolverError
        if the edges cross or leave the punch, or if the compliance is not positive definite
    """
    last = intervals[-1]
    radius = last.outer
    if not last.inner < radius <= 1:
        raise SolverError("the edges of the contact cross each other or leave the punch")
    corners, kinks = {0.0}, list[float]()
    for part in intervals:
        corners |= {part.inner, part.outer}
        margin = NEAREST_KINK * (part.outer - part.inner)
        kinks += [
            kink for kink in profile.kinks if part.inner + margin < kink < part.outer - margin
        ]
    all_fitted = len(kinks) <= MOST_KINKS
    radii = np.union1d(list(corners), kinks if all_fitted else [])
    sizes = np.full(len(radii) - 1, SIZE_AT_CORNER)
    if kinks and all_fitted:
        widths = np.diff(radii) / radius
        layers = LAYERS_AT_KINKS // len(kinks) - fewer_layers
        at_kinks = np.minimum(widths[:-1], widths[1:]) / 2 * LAYER_FACTOR**layers
        is_kink = np.isin(radii[1:-1], kinks)
        sizes[:-1][is_kink] = np.maximum(at_kinks, SIZE_AT_FREE_EDGE)[is_kink]
    if last.outer_free:
        sizes[-1] = SIZE_AT_FREE_EDGE
    compliance = compliance_on(
        tuple((radii / radius).tolist()), tuple(sizes.tolist()), ground.in_units_of(radius)
    )
    space = compliance.space
    middle = radius * (space.breakpoints[1:] + space.breakpoints[:-1]) / 2
    inside = [(middle > part.inner) & (middle < part.outer) for part in intervals]
    loaded = np.setdiff1d(space.dofs[np.any(inside, axis=0)], space.size)
    weights = space.weights[loaded] * radius**2
    profile_moments = moments(profile, space, radius)[loaded] * radius**2
    try:
        factor = cho_factor(compliance.matrix[np.ix_(loaded, loaded)] * radius**3)
    except np.linalg.LinAlgError as error:
        raise SolverError(
            f"the compliance of the contact is not positive definite: {error}"
        ) from error
    weights_solution = cho_solve(factor, weights)
    moments_solution = cho_solve(factor, profile_moments)
    if load is None:
        # the last basis function is the hat function at the outermost edge
        indentation = moments_solution[-1] / weights_solution[-1]
    elif load.force is not None:
        indentation = (load.force + weights @ moments_solution) / (weights @ weights_solution)
    else:
        indentation = load.indentation or 0.0
    pressure = np.zeros(space.size)
    pressure[loaded] = indentation * weights_solution - moments_solution
    force = float(weights @ pressure[loaded])
    unresolved = 0.0 if all_fitted else unresolved_height(profile, space, indentation, radius)
    return FittedPress(space, pressure, float(indentation), force, intervals, unresolved)
