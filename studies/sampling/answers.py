"""The numbers of the answer: scalars, and numbers per ring, that summarise a run. Non-dimensional.

They are computed from each evaluation of a compliance, so that the difference of a fine and a
coarse evaluation estimates their error. Numbers that do not exist for a scene are left out; parts
that a method does not compute are NaN.

A displacement sensor on the holder of the punch shows its approach d(t), which becomes a straight
line once the punch has run in. Running-in times are defined by the part of ``d(t) - w t`` that is
still to come, with the steady wear rate w. It is a sum of decaying exponentials with positive
coefficients.
"""

import numpy as np

from ...meshes.radial import Array, ring_of
from ..contact.marched import Marched
from ..problem.problem import Problem
from ..problem.quantities import ANSWER, STATES
from ..wear.flat_contact import FittedPress
from ..wear.full_contact import RunningIn
from ..wear.history import History
from .norms import Results
from .sampler import Sampler

# Times of running-in are located on the logarithm of (part that is left / part wanted); this is the
# smallest value of that ratio.
SMALLEST_RATIO = 1e-3


def empty_answers(problem: Problem) -> Results:
    """Return arrays of NaN for all numbers of the answer."""
    sizes = {"state": len(STATES), "ring": len(problem.wear_coefficients)}
    return {
        name: np.full([sizes[dim] for dim in quantity.dims], np.nan)
        for name, quantity in ANSWER.items()
    }


def flat_answers(
    problem: Problem, wear: RunningIn, steady: Results, ends: History | None
) -> Results:
    """Return the answer of a flat punch in full contact.

    Parameters
    ----------
    problem : the problem
    wear : the running-in on a compliance
    steady : the steady quantities on the face, those that are wanted
    ends : the history at the first and at the last of the times, if there are any
    """
    values = empty_answers(problem)
    if ends is not None:
        flat, edges = wear.flat, problem.ring_edges
        values["pressure_min"][0], values["pressure_max"][0] = flat.extremes_on(edges)
        forces = flat.ring_forces(edges)
        values["force_share"][0] = forces / forces.sum()
        values["indentation_start"][...] = flat.indentation + problem.profile.standoff
        values["running_in_time"][...] = wear.relaxation_times[0]
        for name, remaining_part in problem.load_regime.remaining_fractions.items():
            values[name][...] = wear.time_until(remaining_part)
        sampler = Sampler(problem, wear.compliance.space)
        values["worn_volume"] = sampler.worn_volumes(ends)[-1]
        add_forces(values, problem, sampler.ring_forces(ends).sum(axis=1))
    add_steady_values(values, problem, steady)
    return without_missing(values)


def moving_answers(
    problem: Problem,
    march: Marched,
    start: FittedPress | None,
    ends: History,
) -> Results:
    """Return the answer of a punch whose contact opens, closes or spreads.

    Parameters
    ----------
    problem : the problem
    march : the march through the times
    start : the initial contact, if it is fitted to the edges of the contact
    ends : the history at the first and at the last of the times
    """
    values = empty_answers(problem)
    sampler = Sampler(problem, march.space)
    forces = sampler.ring_forces(ends)
    if not problem.reason_not_steady:
        values["running_in_time"][...] = march.face.slowest_time
    values["worn_volume"] = sampler.worn_volumes(ends)[-1]
    add_forces(values, problem, forces.sum(axis=1))
    if not problem.loading.varies:
        values["time_to_full_contact"][...] = march.time_of_full_contact
        for name, remaining_part in problem.load_regime.remaining_fractions.items():
            values[name][...] = _time_of_march(march, remaining_part)
        if problem.times[0] == 0:
            values["indentation_start"][...] = ends.indentation[0] + problem.profile.standoff
            total = forces[0].sum()
            values["force_share"][0] = forces[0] / total if total > 0 else np.nan
    if start is not None:
        values["contact_radius_start"][...] = start.radius
        values["pressure_peak_start"][...] = _peak(start)
    return without_missing(values)


def steady_answers(problem: Problem, steady: Results) -> Results:
    """Return the answer of a method that computes only steady quantities on the face."""
    values = empty_answers(problem)
    add_steady_values(values, problem, steady)
    return without_missing(values)


def add_steady_values(values: Results, problem: Problem, steady: Results) -> None:
    """Add the numbers of the steady state to the answer.

    Pressures of the start may be infinite, and have no closed form if the face is shaped. Then the
    steady pressures are the only pressures in the answer.
    """
    if "steady_displacement_max" in steady:
        values["indentation_steady"] = steady["steady_displacement_max"]
    if "steady_pressure" in steady:
        face, pressure = problem.face, steady["steady_pressure"]
        values["pressure_min"][1], values["pressure_max"][1] = _steady_extremes(problem, steady)
        final = problem.loading.forces[-1]
        values["force_share"][1] = face.ring_sums(face.areas * pressure) / final


def _steady_extremes(problem: Problem, steady: Results) -> tuple[Array, Array]:
    """Return the smallest and the largest steady pressure (N,) on each ring of the scene."""
    face, pressure = problem.face, steady["steady_pressure"]
    first = np.flatnonzero(np.diff(face.ring, prepend=-1))
    least, greatest = (extreme.reduceat(pressure, first) for extreme in (np.minimum, np.maximum))
    if problem.graded is not None:
        # k p is constant over the face, and k is linear between the edges of the modelled rings:
        # the extremes are at these edges, where the face has no radii
        rate = np.sum(face.weights * pressure) / np.sum(face.areas)
        rings = problem.graded
        middles = (rings.ring_edges[1:] + rings.ring_edges[:-1]) / 2
        at_ends = rate / rings.wear_coefficients
        ring = ring_of(problem.ring_edges, middles)
        for index in range(len(least)):
            least[index] = at_ends[:, ring == index].min()
            greatest[index] = at_ends[:, ring == index].max()
    return least, greatest


def add_forces(values: Results, problem: Problem, forces: Array) -> None:
    """Add the forces that the load does not prescribe to the answer.

    The force at the start is known only if the start is one of the times.

    Parameters
    ----------
    values : the answer
    problem : the problem
    forces : (2,) at the first and at the last of the times
    """
    for name, index in problem.load_regime.reported_forces.items():
        if name != "force_start" or problem.times[0] == 0:
            values[name][...] = forces[index]


def without_missing(values: Results) -> Results:
    """Return the answer without numbers that are NaN in all their parts."""
    return {name: value for name, value in values.items() if not np.isnan(value).all()}


def merged_answers(history: Results, steady: Results) -> Results:
    """Return the answer of a history, completed by that of the steady state.

    A part that only one of them has is taken from that one.
    """
    shared = history.keys() & steady.keys()
    parts = {
        name: np.where(np.isnan(history[name]), steady[name], history[name]) for name in shared
    }
    return {name: value for name, value in (steady | history | parts).items() if name in ANSWER}


def _time_of_march(march: Marched, wanted_part: float) -> float:
    """Return the time after which at most a given part of the running-in is left.

    It is NaN if that time is after the march.
    """
    from scipy.interpolate import PchipInterpolator  # few runs need it

    times, remaining = march.remainder()
    if np.isfinite(march.time_of_full_contact):
        # after full contact, the part that is left decays at least as fast as the slowest mode
        later = times[-1] + march.face.slowest_time * np.geomspace(1e-3, 20, 400)
        remaining = np.append(remaining, march.remainder_in_full_contact(later))
        times = np.append(times, later)
    elif march.face.load.force is not None:
        # before full contact, it may cross zero more than once
        return float("nan")
    remaining = np.abs(remaining) / np.abs(remaining).max()
    last = np.flatnonzero(remaining > wanted_part)[-1]
    if last + 1 == len(times):
        return float("nan")
    # the logarithm is nearly linear in time between steps
    window = slice(max(last - 2, 0), last + 4)
    logarithm = np.log(np.maximum(remaining[window], wanted_part * SMALLEST_RATIO) / wanted_part)
    return float(PchipInterpolator(times[window], logarithm).roots(extrapolate=False)[-1])


def _peak(press: FittedPress) -> float:
    """Return the largest pressure of an initial contact; NaN if a corner makes it infinite."""
    corners = [
        not interval.outer_free or (interval.inner > 0 and not interval.inner_free)
        for interval in press.intervals
    ]
    if any(corners):
        return float("nan")
    radii = press.radius * np.sin(np.linspace(0, np.pi / 2, 2001))
    return float(press.pressure_at(radii).max())
