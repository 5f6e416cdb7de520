"""Count the steps of a march before it begins, and choose their lengths from a tolerance.

The error of a step of second order is proportional to the third power of its length. Lengths are
powers of sqrt(2), so that successive steps often share a matrix and its factor. A step ends at
every knot of the load.
"""

from typing import NamedTuple

import numpy as np

from ....meshes.radial import Array
from ..problem.norms import LEAST_SLOPE

# greatest number of steps, each of which is a contact problem, and of steps in full contact, which
# are only products of matrices
MOST_STEPS, MOST_LINEAR_STEPS = 200_000, 2_000_000
# length of the first step over the distance in which a punch wears by its indentation, or over the
# total sliding distance if that is shorter
FIRST_STEP = 1e-5
# length of the next step over that which would just meet the tolerance
SAFETY = 0.8
# greatest ratio of successive step lengths
MOST_GROWTH = 2.0
# lower bound on the error over the tolerance, from which the next length is computed
LEAST_RELATIVE_ERROR = 1e-12


def steps_between(times: Array, step: float) -> Array:
    """Return the number (T,) of equal steps, of at most `step`, from each time to the next.

    The first is the number of steps from 0 to the first time.
    """
    return np.ceil(np.diff(times, prepend=0.0) / step * (1 - 1e-12))


def why_too_many_steps(count: float, remedy: str, max_steps: int = MOST_LINEAR_STEPS) -> str:
    """Return why a march of `count` steps is refused, with the remedy; empty if it is not."""
    return (
        f"{count:.3g} steps are needed to reach the last time, more than {max_steps}: {remedy}"
        if count > max_steps
        else ""
    )


class StepError(NamedTuple):
    """The error that a step adds to the worn depth, as root mean squares.

    Parameters
    ----------
    depth : error of the worn depth, over the face
    slope : error of the slope of the worn depth, along the radius
    slope_after : slope of the face after the step, along the radius
    """

    depth: float
    slope: float = 0.0
    slope_after: float = 0.0


class StepControl:
    """Choose step lengths whose errors meet a tolerance, from the error of the last step.

    Parameters
    ----------
    tolerance : float
        Error of the worn depth that a step may add, over the greatest indentation so far.
    distance : float
        Sliding distance of which the first step is a small part.
    slope_tolerance : float
        Error of the slope of the worn face that a step may add, over that slope.
    length : float
        Factor on the lengths of all steps, whatever limits them. The tolerances are those of steps
        without it.
    """

    def __init__(
        self,
        tolerance: float,
        distance: float,
        slope_tolerance: float = np.inf,
        length: float = 1.0,
    ) -> None:
        # the error of a step is proportional to the third power of its length
        self.tolerances = np.array([tolerance, slope_tolerance]) * length**3
        self.greatest_errors = np.zeros(2)
        self.step = _round_down(length * FIRST_STEP * distance) if distance else 1.0
        self.most_growth = MOST_GROWTH**length
        self.greatest_indentation = float(np.finfo(float).tiny)
        self.taken = self.rejected = 0

    def next_towards(self, remaining: float) -> float:
        """Return the next step: all of the remaining distance to a time, or at most half of it."""
        if self.step >= remaining * (1 - 1e-9):
            return remaining
        return min(self.step, remaining / 2)

    def accepts(self, dt: float, error: StepError, indentation: float) -> bool:
        """Judge a step by its error, count it, and choose the length of the next one."""
        self.greatest_indentation = max(self.greatest_indentation, abs(indentation))
        slope = max(error.slope_after, LEAST_SLOPE * self.greatest_indentation)
        errors = np.array([error.depth / self.greatest_indentation, error.slope / slope])
        relative = float((errors / self.tolerances).max())
        next_step = _round_down(
            dt * min(self.most_growth, SAFETY * max(relative, LEAST_RELATIVE_ERROR) ** (-1 / 3))
        )
        if relative > 1:
            self.rejected, self.step = self.rejected + 1, next_step
            return False
        self.taken, self.greatest_errors = self.taken + 1, np.maximum(self.greatest_errors, errors)
        # if a knot of the load cut this step short, keep the longer length planned before
        self.step = max(self.step, next_step) if dt < self.step else next_step
        return True


def _round_down(step: float) -> float:
    """Return the greatest power of sqrt(2) that does not exceed a step."""
    return float(2.0 ** (np.floor(2 * np.log2(step)) / 2))
