"""The answer of a run, as it is reported: what a user asked of the punch, by each method."""

import numpy as np

from ...meshes.radial import Array
from ..methods.base import Solution
from ..problem.problem import Problem
from ..problem.quantities import ANSWER
from ..sampling.answers import empty_answers

# quantities that are given with the answer
ALSO = ("steady_wear_rate", "steady_rms_slope")


def answer(problem: Problem, solution: Solution) -> dict[str, Array]:
    """Return the values of `ANSWER` by one method, non-dimensional.

    They are NaN where the method does not give them, or the scene does not ask for them. Those that
    not every run has are left out then.
    """
    return {
        name: solution.answers.get(name, nothing)
        for name, nothing in empty_answers(problem).items()
        if name in solution.answers or ANSWER[name].always
    }


def answer_errors(problem: Problem, solution: Solution) -> dict[str, Array]:
    """Return the error of each number that `answer` returns, NaN where none is stated.

    An error is relative, in the norm of the number, which is taken over all rings.
    """
    values = answer(problem, solution)
    return {
        name: solution.errors.get(name, _nothing_stated(name, value))
        for name, value in values.items()
    }


def _nothing_stated(name: str, value: Array) -> Array:
    """Return NaN in the shape of an error."""
    return np.full(value.shape[:-1] if "ring" in ANSWER[name].dims else value.shape, np.nan)
