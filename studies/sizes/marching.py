"""Steps of a march in time, counted before any is made."""

import numpy as np

from ...meshes.radial import Array
from ..problem.regimes import FULL_CONTACT


def steps_between(times: Array, step: float) -> Array:
    """Count the equal steps (T,) of at most `step` up to each time from the one before."""
    return np.asarray(np.ceil(np.diff(times, prepend=0.0) / step * (1 - 1e-12)))


def refused_steps(count: float, remedy: str, most: int = FULL_CONTACT.most_steps) -> str:
    """Return why so many steps will not be made, with the remedy; empty if they will."""
    return (
        f"{count:.3g} steps are needed to the last time, more than {most}: {remedy}"
        if count > most
        else ""
    )
