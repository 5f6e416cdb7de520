"""The paper's own algorithm beside the others.

Springs on a uniform grid, explicit steps in time, no steady state.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray
from scipy.integrate import cumulative_trapezoid

from ...mdr.uniform_grid import UniformGrid
from ...meshes.radial import Array
from ..problem.defaults import grid_step
from ..problem.marching import refused_steps, steps_between
from ..problem.problem import Problem
from ..progress import Stages
from .base import Method, Solution
from .quantities import differences, labelled, radial_weight

# with half the springs and twice the step, what is of first order doubles; slopes and jumps at ring
# edges are of half that
OF_FIRST_ORDER = 2.5


class MdrGrid(Method):
    """First order in the grid and in the step."""

    name = "mdr-grid"
    what = "the paper's own algorithm: MDR on a uniform grid, in explicit steps"
    own_march = True
    lacks: ClassVar[dict[str, str]] = {
        "steady state": "the paper's algorithm marches towards it, and never arrives"
    }

    def refusal(self, problem: Problem) -> str:
        if not problem.full_contact:
            return (
                "mdr-grid uses the rule of springs, q = d - g, which holds only while contact is "
                "one disc, and an initial "
                "profile or a fixed indentation may break that: leave it out of methods"
            )
        if not len(problem.times):
            return (
                "mdr-grid marches in time and knows no steady state: give wear.times, or leave it "
                "out of methods"
            )
        return refused_steps(
            self._steps(problem), "give a larger accuracy.mdr.step, or a coarser accuracy.mdr.grid"
        )

    def _steps(self, problem: Problem) -> float:
        return float(steps_between(problem.times, self._step(problem)).sum())

    def solve_all(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        return [self._marched_and_estimated(problem, stages) for problem in problems]

    def _marched_and_estimated(self, problem: Problem, stages: Stages) -> Solution:
        count, step = problem.mdr.grid, self._step(problem)
        with stages("marching"):
            marched = _marched(problem, count, step)
            results = _sampled(problem, marched, problem.radii)
            fine = _sampled(problem, marched, problem.face.radii)
        with stages("estimating"):
            coarse = _sampled(problem, _marched(problem, count // 2, 2 * step), problem.face.radii)
            found = differences(coarse, fine, problem.face)
            errors = {name: OF_FIRST_ORDER * _near(one) for name, one in found.items()}
        parts = {"grid and step": float(errors["indentation"].max())}
        settings = {"grid": count, "step": step}
        return Solution(
            results, fine.isel(time=problem.checked), errors, parts, count + 1, settings
        )

    def _step(self, problem: Problem) -> float:
        return grid_step(problem, UniformGrid(*problem.merged, problem.mdr.grid).stability_limit())


@dataclass(frozen=True, eq=False)
class Marched:
    """The grid, and pressures and profiles (T, n+1) and indentations (T,) at the times
    asked for.
    """

    grid: UniformGrid
    pressure: Array
    profile: Array
    indentation: Array


def _marched(problem: Problem, count: int, step: float) -> Marched:
    grid = UniformGrid(*problem.merged, count)
    return Marched(grid, *grid.march(problem.times, step))


def _sampled(problem: Problem, marched: Marched, radii: Array) -> xarray.Dataset:
    own, pressure, profile = marched.grid.radii, marched.pressure, marched.profile

    def at(values: Array, radii: Array) -> Array:
        return np.array([np.interp(radii, own, row) for row in values])

    squared = radial_weight(own, problem.gradient_average) * np.gradient(profile, own, axis=1) ** 2
    within = cumulative_trapezoid(2 * np.pi * own * pressure, own, axis=1, initial=0.0)
    indentation, worn = marched.indentation, at(profile, radii)
    values = {
        "pressure": at(pressure, radii),
        "profile": worn,
        "displacement": indentation[:, None] - worn,
        "indentation": indentation,
        "displacement_centre": indentation - profile[:, 0],
        "displacement_max": indentation - profile.min(axis=1),
        "rms_slope": np.sqrt(np.trapezoid(squared, own, axis=1)),
        "ring_force": np.diff(at(within, problem.ring_edges), axis=1),
    }
    return labelled(values, radii, problem.times)


def _near(difference: Array) -> Array:
    """The greatest of each time and its neighbours: differences cross zero now and then."""
    padded = np.concatenate([difference[:1], difference, difference[-1:]])
    return np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])


METHOD = MdrGrid()
