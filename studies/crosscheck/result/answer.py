"""The answer of a run: the numbers that describe the punch, by each method."""

import numpy as np

from ....meshes.radial import Array
from ..methods.base import Solution
from ..methods.sampling.answers import empty_answer
from ..problem.problem import Problem
from ..problem.quantities import ANSWER

# quantities that are reported together with the answer
ALSO = ("steady_wear_rate", "steady_rms_slope")


class Answers(dict[str, dict[str, Array]]):
    """The numbers of the answer, by method; an unknown key is answered with a known one."""

    def __missing__(self, key: object) -> dict[str, Array]:
        """Raise a KeyError that says what to write instead."""
        first = next(iter(self), "mdr")
        number = key if key in self.get(first, {}) else "time_to_90"
        raise KeyError(
            f"no method {key!r} in these answers: write answers[{first!r}][{number!r}]; the "
            f"methods are {', '.join(self)}"
        )


def answer(problem: Problem, solution: Solution) -> dict[str, Array]:
    """Return the values of `ANSWER` by one method, non-dimensional.

    A number is NaN if the method does not compute it or the scene does not have it.
    """
    return {
        name: solution.answers.get(name, empty_answer(problem, quantity))
        for name, quantity in ANSWER.items()
    }


def answer_errors(problem: Problem, solution: Solution) -> dict[str, Array]:
    """Return the error estimate of each number that `answer` returns, NaN if there is none.

    The error is relative, in the norm of the number; this norm is taken over all rings.
    """
    values = answer(problem, solution)
    return {
        name: solution.errors.get(name, _unknown_error(name, value))
        for name, value in values.items()
    }


def _unknown_error(name: str, value: Array) -> Array:
    """Return NaN in the shape of the error of a number."""
    return np.full(value.shape[:-1] if "ring" in ANSWER[name].dims else value.shape, np.nan)
