"""How long the steps of a march are.

Steps suit a tolerance: the error of a step of second order grows as its third power. They go by
powers of the root of two, so that neighbouring ones share a matrix and its factor. A step ends on
every time asked for.
"""

import numpy as np

# part of the distance that is slid in the first step
FIRST = 1e-6
# of the step that would just meet the tolerance, the part that is taken next
CAUTION = 0.8
# how much longer a step may be than the one before it
GROWTH = 4.0
# the least error over the tolerance that a longer step is sought by
LEAST = 1e-12


class StepControl:
    """Choose steps whose errors suit a tolerance, by the error of the step before.

    Parameters
    ----------
    tolerance : error of the worn depth that a step may add, over the greatest indentation so far
    distance : that is slid in all
    """

    def __init__(self, tolerance: float, distance: float) -> None:
        self.tolerance = tolerance
        self.step = _quantised(FIRST * distance) if distance else 1.0
        self.deepest = float(np.finfo(float).tiny)
        self.taken = self.rejected = 0

    def next_towards(self, left: float) -> float:
        """Return a step that ends on a time asked for or leaves at least half of the way to it."""
        if self.step >= left * (1 - 1e-9):
            return left
        return min(self.step, left / 2)

    def accepts(self, dt: float, error: float, indentation: float) -> bool:
        """Judge a step by its error, count it, and choose the length of the next one."""
        self.deepest = max(self.deepest, abs(indentation))
        relative = error / (self.tolerance * self.deepest)
        longer = _quantised(dt * min(GROWTH, CAUTION * max(relative, LEAST) ** (-1 / 3)))
        if relative > 1:
            self.rejected, self.step = self.rejected + 1, longer
            return False
        self.taken += 1
        # a step cut short by an output time says nothing against the longer ones
        self.step = max(self.step, longer) if dt < self.step else longer
        return True


def _quantised(step: float) -> float:
    """Return the power of the root of two at or below a step."""
    return float(2.0 ** (np.floor(2 * np.log2(step)) / 2))
