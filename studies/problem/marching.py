"""Steps of a march in time, counted before any is made."""

from collections.abc import Callable

import numpy as np

from ...meshes.radial import Array

# state -> state after a step
Advance = Callable[[Array], Array]
MOST_STEPS = 2_000_000


def steps_between(times: Array, step: float) -> Array:
    """(T,) equal steps of at most `step` up to each time from the one before."""
    return np.asarray(np.ceil(np.diff(times, prepend=0.0) / step * (1 - 1e-12)))


def refused_steps(count: float, remedy: str) -> str:
    """Why so many steps will not be made, with the remedy; empty if they will."""
    return (
        f"{count:.3g} steps are needed to the last time, more than {MOST_STEPS}: {remedy}"
        if count > MOST_STEPS
        else ""
    )


def take_steps(
    times: Array, step: float, advance_by: Callable[[float], Advance], wearing: int, state: Array
) -> tuple[Array, Array]:
    """Return states (T, n), and what has worn by each, of a march in equal steps.

    Parameters
    ----------
    times, step : output times, and the longest step between them
    advance_by : length of a step -> how a state goes on in it
    wearing : which state of a step wears: the one before it (0), or after it (1)
    state : (n,) at the start

    """
    steps = steps_between(times, step)
    worn, now = np.zeros_like(state), 0.0
    states, profiles = [], []
    for time, count in zip(times, steps, strict=True):
        if count:
            dt = (time - now) / count
            advance, now = advance_by(dt), time
            for _ in range(int(count)):
                pair = state, advance(state)
                worn, state = worn + dt * pair[wearing], pair[1]
        states.append(state)
        profiles.append(worn)
    return np.array(states), np.array(profiles)
