"""What computing will cost, before it is done.

Seconds on one thread and GiB, by counts and by measured rates.

The counts are of unknowns, pressures, times, steps and rings; the rates are a small table in the
package, `costs.json`, which `python -m ringwear.studies.benchmark.rates` measures again. What
memory is needed for has the name of its scene key.
"""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from ...meshes.radial import Array
from ..problem.marching import steps_between
from ..problem.problem import Problem
from ..wear.modes import LARGE

# the first of the terms are of the discretisation, whatever is then asked of it; the last of times,
# on any compliance alike
DISCRETISING, OF_TIMES = 5, 2
# finest accuracy of the scenes that the rates were measured on (`studies/benchmark/rates.py`)
FINEST_MEASURED = 1e-7


@dataclass(frozen=True)
class Cost:
    """Predicted cost of one method: unknowns, pressures among them, and seconds on one thread.

    `seconds` are nan where contact opens, closes and spreads. `error` is what its own estimate of
    the indentation will be about; nan where that is not known, because the user gave the sizes or
    nobody has measured it.
    """

    unknowns: int
    pressures: int
    seconds: float
    error: float


@dataclass(frozen=True)
class Expected:
    """What a whole run will take.

    Parameters
    ----------
    by_method : cost of each method
    check, numbers, figures : seconds for comparing methods as operators; for loading, answer and
        files; for figures and page
    memory : GiB by what needs them
    """

    by_method: dict[str, Cost]
    check: float
    numbers: float
    figures: float
    memory: dict[str, float]

    @property
    def seconds(self) -> float:
        methods = sum(cost.seconds for cost in self.by_method.values())
        return methods + self.check + self.numbers + self.figures

    @property
    def gib(self) -> float:
        return sum(self.memory.values())


@cache
def rates() -> dict[str, Any]:
    """The table of measured rates."""
    return json.loads((files("ringwear.studies") / "costs.json").read_text("utf-8"))


def terms(unknowns: int, pressures: int, problem: Problem) -> Array:
    """What the seconds of a method that yields a compliance are made of.

    A start; the mesh and its matrix, its factor; dense algebra; modes, all of them or those of a
    Krylov space; the history at the times of the estimate and at those asked for.
    """
    square, cube = float(pressures) ** 2, float(pressures) ** 3
    count = len(problem.times)
    history = float(count > 0)
    small = history * float(pressures <= LARGE)
    return np.array(
        [
            1.0,
            unknowns,
            unknowns**1.5,
            square,
            cube,
            history * square,
            small * cube,
            (history - small) * LARGE * square,
            count * square,
            float(count) * len(problem.radii),
        ]
    )


def march_terms(pressures: int, problem: Problem) -> Array:
    """Of steps in time on any compliance: what is factorised at each time, or once, and the
    steps.
    """
    square, cube = float(pressures) ** 2, float(pressures) ** 3
    factors = len(problem.times) if problem.march == "implicit" else 1
    return np.array([factors * cube, steps(problem) * square, steps(problem)])


def steps(problem: Problem) -> float:
    """Of a march in time; none by modes."""
    return (
        float(steps_between(problem.times, problem.step).sum())
        if problem.march != "modal" and problem.step
        else 0.0
    )


def by_terms(kind: str, unknowns: int, pressures: int, problem: Problem) -> Array:
    """Seconds by the terms; nan where no rates were measured."""
    known = rates().get(kind)
    parts = np.array(known["seconds"] if known else np.nan) * terms(unknowns, pressures, problem)
    if steps(problem):
        parts = np.append(
            parts, rates()[problem.march]["seconds"] @ march_terms(pressures, problem)
        )
    return parts


def by_rates(kind: str, unknowns: int, pressures: int, problem: Problem) -> Cost:
    """Cost by the rates measured for a kind of method.

    Seconds and error are nan where there are none.
    """
    known = rates().get(kind)
    if known is None:
        return Cost(unknowns, pressures, np.nan, np.nan)
    error = float(10 ** np.polyval(known["error"], np.log10(problem.rtol)))
    return Cost(
        unknowns, pressures, float(by_terms(kind, unknowns, pressures, problem).sum()), error
    )


def direct_terms(rings: int) -> Array:
    """Of closed forms: a start, each ring, every two of them."""
    return np.array([1.0, rings, float(rings) ** 2])


def check_terms(pressures: int, problem: Problem) -> Array:
    """Of the comparison of two compliances on so many pressures."""
    history = float(len(problem.times) > 0)
    return np.array(
        [1.0, float(pressures) ** 2, float(pressures) ** 3, history * float(pressures) ** 3]
    )


def number_terms(problem: Problem, costs: dict[str, Cost]) -> Array:
    """Of loading, the answer and files of numbers: a start, fields over time, rings."""
    fields = float(len(problem.times)) * len(problem.radii) * len(costs)
    return np.array([1.0, fields, len(problem.wear_coefficients)])


def figure_terms(problem: Problem, costs: dict[str, Cost]) -> Array:
    """Of figures and page.

    A start, fields, rings that are shaded, and what is inside the half-space.
    """
    inside = costs["fem"].unknowns if "fem" in costs and problem.full_contact else 0
    return np.array([*number_terms(problem, costs), float(inside > 0), inside, inside**1.5])


def memory_terms(problem: Problem, costs: dict[str, Cost]) -> dict[str, Array]:
    """What memory is made of, by the scene key behind it.

    Dense matrices, the factor, fields over time, closed forms.
    """
    compliances = [cost for cost in costs.values() if cost.unknowns]
    dense = sum(float(cost.pressures) ** 2 for cost in compliances)
    factor = sum(cost.unknowns * np.log2(max(cost.unknowns, 2)) for cost in compliances)
    fields = float(len(problem.times)) * len(problem.radii) * len(costs)
    rings = float(len(problem.merged.wear_coefficients)) ** 2 if "direct" in costs else 0.0
    return {
        "libraries": np.array([1.0, 0, 0, 0, 0]),
        "punch.rings and accuracy.rtol": np.array([0, dense, factor, 0, 0]),
        "wear.times and output.radii": np.array([0, 0, 0, fields, 0]),
        "punch.rings": np.array([0, 0, 0, 0, rings]),
    }
