"""Number of steps of a march in time, counted before it begins."""

import numpy as np

from ....meshes.radial import Array

# Greatest number of steps in time, by whether the punch is in full contact: then a step is only a
# product of matrices, and else a contact problem.
MOST_STEPS = {True: 2_000_000, False: 200_000}


def steps_between(times: Array, step: float) -> Array:
    """Return the number (T,) of equal steps, of at most `step`, from each time to the next.

    The first is the number of steps from 0 to the first time.
    """
    return np.ceil(np.diff(times, prepend=0.0) / step * (1 - 1e-12))


def why_too_many_steps(count: float, remedy: str, max_steps: int = MOST_STEPS[True]) -> str:
    """Return why a march of `count` steps is refused, with the remedy; empty if it is not."""
    return (
        f"{count:.3g} steps are needed to reach the last time, more than {max_steps}: {remedy}"
        if count > max_steps
        else ""
    )
