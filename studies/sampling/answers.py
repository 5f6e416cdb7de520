"""The numbers of the answer: what a user wants to know of a punch. Non-dimensional.

Each evaluation of a compliance gives them, so that the difference of a fine and a coarse one tells
by how much they err. Numbers that a scene does not have are left out; parts that a method does not
give are NaN.

A displacement sensor on the holder of the punch shows its approach d(t), which rises in a straight
line once the punch has run in. Times of running-in are taken from what ``d(t) - w t`` has still to
rise, a sum of decaying exponentials with positive coefficients.
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

# part of the worn way below which a time is found by the logarithm of what is left
FLOOR_OF_LOGARITHM = 1e-3


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
    """Return the answer of a flat punch whose whole face carries.

    Parameters
    ----------
    problem : what is asked for
    wear : the running-in on a compliance
    steady : its steady quantities on the face, those that are wanted
    ends : its history at the first and at the last of the times, if there are any
    """
    values = empty_answers(problem)
    if ends is not None:
        flat, edges = wear.flat, problem.ring_edges
        values["pressure_min"][0], values["pressure_max"][0] = flat.extremes_on(edges)
        forces = flat.ring_forces(edges)
        values["force_share"][0] = forces / forces.sum()
        values["indentation_start"][...] = flat.indentation + problem.profile.standoff
        values["running_in_time"][...] = wear.relaxation_times[0]
        for name, left in problem.load_regime.remaining_fractions.items():
            values[name][...] = wear.time_until(left)
        sampler = Sampler(problem, wear.compliance.space)
        values["worn_volume"] = sampler.worn_volumes(ends)[-1]
        put_forces(values, problem, sampler.ring_forces(ends).sum(axis=1))
    put_steady(values, problem, steady)
    return present(values)


def moving_answers(
    problem: Problem,
    march: Marched,
    start: FittedPress | None,
    ends: History,
) -> Results:
    """Return the answer of a punch whose contact opens, closes or spreads.

    Parameters
    ----------
    problem : what is asked for
    march : the march through the times
    start : the press at the start, if it is fitted to the edges of the contact
    ends : the history at the first and at the last of the times
    """
    values = empty_answers(problem)
    sampler = Sampler(problem, march.space)
    forces = sampler.ring_forces(ends)
    if not problem.reason_not_steady:
        values["running_in_time"][...] = march.face.slowest_time
    values["worn_volume"] = sampler.worn_volumes(ends)[-1]
    put_forces(values, problem, forces.sum(axis=1))
    if not problem.loading.varies:
        values["time_to_full_contact"][...] = march.time_of_full_contact
        for name, left in problem.load_regime.remaining_fractions.items():
            values[name][...] = _time_of_march(march, left)
        if problem.times[0] == 0:
            values["indentation_start"][...] = ends.indentation[0] + problem.profile.standoff
            whole = forces[0].sum()
            values["force_share"][0] = forces[0] / whole if whole > 0 else np.nan
    if start is not None:
        values["contact_radius_start"][...] = start.radius
        values["pressure_peak_start"][...] = _peak(start)
    return present(values)


def steady_answers(problem: Problem, steady: Results) -> Results:
    """Return the answer of a method that gives nothing but steady quantities on the face."""
    values = empty_answers(problem)
    put_steady(values, problem, steady)
    return present(values)


def put_steady(values: Results, problem: Problem, steady: Results) -> None:
    """Put what the answer tells of the steady state into the answer.

    Pressures may be infinite at the start, and have no closed form where the face is shaped: then
    this is all that the answer tells of them.
    """
    if "steady_displacement_max" in steady:
        values["indentation_steady"] = steady["steady_displacement_max"]
    if "steady_pressure" in steady:
        face, pressure = problem.face, steady["steady_pressure"]
        values["pressure_min"][1], values["pressure_max"][1] = _steady_extremes(problem, steady)
        held_last = problem.loading.forces[-1]
        values["force_share"][1] = face.ring_sums(face.areas * pressure) / held_last


def _steady_extremes(problem: Problem, steady: Results) -> tuple[Array, Array]:
    """Return the least and the greatest steady pressure on each ring of the scene."""
    face, pressure = problem.face, steady["steady_pressure"]
    first = np.flatnonzero(np.diff(face.ring, prepend=-1))
    least, greatest = (extreme.reduceat(pressure, first) for extreme in (np.minimum, np.maximum))
    if problem.graded is not None:
        # k p is one constant, and k is linear between the edges of the rings that are modelled: the
        # extremes are at these, where the face has no radii
        rate = np.sum(face.weights * pressure) / np.sum(face.areas)
        rings = problem.graded
        middles = (rings.ring_edges[1:] + rings.ring_edges[:-1]) / 2
        at_ends = rate / rings.ends
        ring = ring_of(problem.ring_edges, middles)
        for number in range(len(least)):
            least[number] = at_ends[:, ring == number].min()
            greatest[number] = at_ends[:, ring == number].max()
    return least, greatest


def put_forces(values: Results, problem: Problem, forces: Array) -> None:
    """Put the forces that the load does not give into the answer.

    The force of the start is known only if the start is among the times.

    Parameters
    ----------
    forces : (2,) at the first and at the last of the times
    """
    for name, place in problem.load_regime.reported_forces.items():
        if name != "force_start" or problem.times[0] == 0:
            values[name][...] = forces[place]


def present(values: Results) -> Results:
    """Return those numbers of which at least a part is given."""
    return {name: value for name, value in values.items() if not np.isnan(value).all()}


def joined(history: Results, steady: Results) -> Results:
    """Return the answer of a history beside that of the steady state, each where it is given."""
    both = history.keys() & steady.keys()
    parts = {name: np.where(np.isnan(history[name]), steady[name], history[name]) for name in both}
    return {name: value for name, value in (steady | history | parts).items() if name in ANSWER}


def _time_of_march(march: Marched, part: float) -> float:
    """Return the time from which no more than a part is left; NaN if that is after the march."""
    from scipy.interpolate import PchipInterpolator  # few runs need it

    times, left = march.remainder()
    if np.isfinite(march.time_of_full_contact):
        # what is left decays, at least as fast as the slowest mode
        later = times[-1] + march.face.slowest_time * np.geomspace(1e-3, 20, 400)
        left = np.append(left, march.remainder_in_full_contact(later))
        times = np.append(times, later)
    elif march.face.load.force is not None:
        # it may cross zero, and come back
        return float("nan")
    left = np.abs(left) / np.abs(left).max()
    more = np.flatnonzero(left > part)[-1]
    if more + 1 == len(times):
        return float("nan")
    # its logarithm falls in nearly straight lines
    near = slice(max(more - 2, 0), more + 4)
    near_left = np.log(np.maximum(left[near], part * FLOOR_OF_LOGARITHM) / part)
    return float(PchipInterpolator(times[near], near_left).roots(extrapolate=False)[-1])


def _peak(press: FittedPress) -> float:
    """Return the greatest pressure of a press; NaN where a corner makes it infinite."""
    corners = [
        not part.outer_free or (part.inner > 0 and not part.inner_free) for part in press.intervals
    ]
    if any(corners):
        return float("nan")
    radii = press.radius * np.sin(np.linspace(0, np.pi / 2, 2001))
    return float(press.pressure_at(radii).max())
