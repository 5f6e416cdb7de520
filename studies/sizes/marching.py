"""Number of steps of a march in time, counted before it begins."""

import numpy as np

from ...meshes.radial import Array
from ..problem.loading import Loading
from ..problem.problem import Problem
from ..problem.regimes import FULL_CONTACT


def step_ends(times: Array, loading: Loading) -> Array:
    """Return the times (E,) at which a step of a march always ends.

    They are the requested times and the knots of the load until the last of these.
    """
    return np.union1d(times, loading.times[loading.times < times[-1]])


def least_steps(problem: Problem) -> int:
    """Return the number of steps that a march of a contact that moves needs at least.

    Once all of the face is in contact, relaxation modes take the place of steps if the load is
    constant.
    """
    if not len(problem.times):
        return 0
    ends = step_ends(problem.times, problem.loading)
    if problem.loading.varies or problem.indentation is not None:
        return len(ends)
    return int(np.count_nonzero(ends < problem.time_to_wear_flat))


def steps_between(times: Array, step: float) -> Array:
    """Return the number (T,) of equal steps, of at most `step`, from each time to the next.

    The first is the number of steps from 0 to the first time.
    """
    return np.asarray(np.ceil(np.diff(times, prepend=0.0) / step * (1 - 1e-12)))


def why_too_many_steps(count: float, remedy: str, max_steps: int = FULL_CONTACT.most_steps) -> str:
    """Return why a march of `count` steps is refused, with the remedy; empty if it is not."""
    return (
        f"{count:.3g} steps are needed to reach the last time, more than {max_steps}: {remedy}"
        if count > max_steps
        else ""
    )
