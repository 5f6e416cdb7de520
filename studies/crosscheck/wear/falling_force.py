"""Predict whether a flat punch keeps full contact while its force falls.

A fall of the force acts as a flat punch that pulls. Its tension is greatest at the rim and on rings
that wear fast. The face stays in contact if the pressure of the punch exceeds this tension
everywhere. Relaxation modes give the pressures at any time, so that a small solution by
dimensionality reduction shows this before the problem is solved. The solution itself is checked for
tension afterwards.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ....mdr import energy
from ....meshes.errors import SolverError
from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array, Indices
from ..problem.face import Rings
from ..problem.loading import Loading
from ..problem.problem import Problem
from .full_contact import RunningIn
from .history import History

# Least pressure with which contact counts as kept, over the steady pressure under the greatest
# force. Where that pressure was below 0.1 in 60 random scenes, its error in the small solution was
# at most 0.003 (physics/test_falling_force.py::
# test_the_prediction_agrees_with_the_independent_solution).
MARGIN = 0.02
# Degree of the small solution, size ratio of its elements, and size of its smallest element over
# the length that the slower ring at an edge wears during the shortest segment of the load.
DEGREE, GRADING, SMALLEST = 5, 0.2, 1e-2
# Greatest number of its unknowns. With more, the solution would take seconds.
MOST_UNKNOWNS = 1500
# Times in each segment of the load at which pressures are computed, over its duration. If there are
# many segments, fewer are used, so that there are about MOST_TIMES.
FRACTIONS = np.concatenate([np.geomspace(1e-3, 0.1, 6), np.linspace(0.15, 1.0, 18)])
MOST_TIMES = 4000
# times after the last knot, over the time from there to the last requested one
LATER_FRACTIONS = np.geomspace(1e-4, 1.0, 16)


def with_prediction(problem: Problem) -> Problem:
    """Return a problem whose force falls, with the prediction whether contact is kept.

    This is predicted only for histories of flat punches on a homogeneous half-space.
    """
    if not (problem.profile.flat and len(problem.times) and not problem.ground.layered):
        return problem
    rings = (problem.graded or problem.rings).merged()
    kept = keeps_contact(rings, problem.loading, float(problem.times[-1]))
    return replace(problem, keeps_contact=kept)


def keeps_contact(rings: Rings, loading: Loading, last_time: float) -> bool:
    """Return whether all pressures of a flat punch stay positive, with a margin.

    Parameters
    ----------
    rings : rings of the punch, on a homogeneous half-space
    loading : force and sliding speed over time
    last_time : end of the history
    """
    # by value, because the objects of equal problems differ
    return _keeps_contact(
        _as_tuples(rings.ring_edges),
        _as_tuples(rings.wear_coefficients),
        _as_tuples(np.array([loading.times, loading.forces, loading.speeds])),
        last_time,
    )


def _as_tuples(array: Array) -> Any:
    return tuple(map(_as_tuples, array)) if array.ndim else array.item()


@lru_cache(maxsize=256)
def _keeps_contact(edges: tuple, wear: tuple, knots: tuple, last_time: float) -> bool:
    rings, loading = Rings(np.array(edges), np.array(wear)), Loading(*map(np.array, knots))
    slid, during = loading.segments.slid, loading.times[:-1] < last_time
    decreases = (np.diff(loading.forces) < 0) & (np.cumsum(slid) > 0) & during
    if (decreases & (slid == 0)).any():
        # without sliding, the tension at the rim is infinite
        return False
    shortest = float(np.min(slid[during & (slid > 0)], initial=float(slid.sum())))
    space = _space(rings, SMALLEST * shortest)
    if space.size > MOST_UNKNOWNS:
        return False
    running_in = RunningIn(energy.compliance(space), rings.wear_coefficients, loading=loading)
    history = running_in.modal(_times(loading, last_time))
    at_points = space.on_elements(np.array([-1.0, 0.0, 1.0]))
    least = at_points @ (MARGIN * running_in.steady.pressure)
    return bool((at_points @ history.pressure.T >= least[:, None]).all())


def _times(loading: Loading, last_time: float) -> Array:
    """Return times of sliding at which pressures are computed, up to the last one."""
    starts, durations = loading.times[:-1, None], np.diff(loading.times)[:, None]
    stride = max(len(starts) * len(FRACTIONS) // MOST_TIMES, 1)
    # from the end, where the tension of a fall is greatest
    fractions = FRACTIONS[::-stride]
    after = loading.times[-1] + max(last_time - loading.times[-1], 0.0) * LATER_FRACTIONS
    times = np.unique(np.append(starts + durations * fractions, after))
    times = times[times <= last_time]
    return times[loading.at(times).distance > 0]


def _space(rings: Rings, length: float) -> PressureSpace:
    """Return a graded space whose smallest elements are the length times wear coefficients."""
    slower, _ = rings.wear_at_edges
    sizes = np.minimum(np.maximum(slower * length, 1e-13), 0.1 * rings.widths_at_edges)
    return PressureSpace.graded(rings.ring_edges, sizes, GRADING, DEGREE)


# Tension, over (rtol * largest pressure), that may be a mere discretisation error on layers.
MOST_TENSION = 10.0


def refuse_tension(
    problem: Problem, space: PressureSpace, history_at: Callable[[Indices], History]
) -> None:
    """Raise if full contact takes tension during wear, which is not modelled.

    On a homogeneous half-space, pressures that are positive at the start stay positive under a
    force that never falls. A layer that bends or bulges may lose contact with the punch later, and
    so may any punch while the force falls, if the prediction that it does not is wrong.

    Parameters
    ----------
    problem : a flat punch
    space : the space of the pressures
    history_at : returns the history at some of the times of the problem, given by their indices

    Raises
    ------
    SolverError
        with the time and the remedy
    """
    later = problem.compared_rows[problem.distances[problem.compared_rows] > 0]
    pressure = (space.matrix(problem.face.radii) @ history_at(later).pressure.T).T
    allowed_tension = MOST_TENSION * problem.rtol * np.abs(pressure).max(axis=1)
    if (lost_contact := np.flatnonzero(pressure.min(axis=1) < -allowed_tension)).size:
        time = float(problem.times[later][lost_contact[0]]) * problem.units.time
        if not problem.ground.layered:
            raise SolverError(
                f"the pressure becomes negative by t = {time:.3g}, while the force falls, although "
                "a small solution predicted full contact: end wear.times before that"
            )
        raise SolverError(
            f"half_space.layers lose contact with the punch by t = {time:.3g}, though not at the "
            "start, and this is not modelled: end wear.times before that, or leave them out"
        )
