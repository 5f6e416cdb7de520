"""The paper's own algorithm beside the others: springs on a uniform grid, explicit steps in time, no steady state."""

from typing import Any, ClassVar

import numpy as np
from scipy.integrate import cumulative_trapezoid

from ringwear.mdr.uniform_grid import UniformGrid
from ringwear.meshes.radial import Array
from ringwear.studies.methods.base import Cost, Method, Solution
from ringwear.studies.methods.estimate import GRID, over_neighbours
from ringwear.studies.methods.quantities import array, labelled, relative_difference, with_errors
from ringwear.studies.methods.sampler import radial_weight
from ringwear.studies.problem.defaults import grid_step
from ringwear.studies.problem.problem import Problem
from ringwear.studies.progress import Stages


class MdrGrid(Method):
    """First order in the grid and in the step."""

    name = "mdr-grid"
    what = "the paper's own algorithm: MDR on a uniform grid, in explicit steps"
    look: ClassVar[dict[str, Any]] = {"color": "#8e6c00", "linestyle": (0, (5, 1, 1, 1)), "marker": "v", "markersize": 3}
    own_march = True
    lacks: ClassVar[dict[str, str]] = {"steady state": "the paper's algorithm marches towards it, and never arrives"}

    def described(self, problem: Problem) -> str:
        return f"grid of {problem.mdr.grid} springs, steps of {self._step(problem) * problem.units.time:.3g}"

    def counted(self, problem: Problem) -> tuple[int, int]:
        return problem.mdr.grid + 1, problem.mdr.grid + 1

    def cost(self, problem: Problem) -> Cost:
        # two products with full matrices a step, and half as many steps again for the estimate
        points, steps = problem.mdr.grid + 1, float(problem.times.max(initial=0.0)) / self._step(problem)
        return Cost(points, points, 1e-5 * steps + 1e-9 * steps * points**2, 0.1 + 1e-7 * points**2, np.nan)

    def refusal(self, problem: Problem) -> str:
        if not len(problem.times):
            return "mdr-grid marches in time and knows no steady state: give wear.times, or leave it out of methods"
        return ""

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        count, step = problem.mdr.grid, self._step(problem)
        with stages("marching"):
            results = labelled(_marched(problem, count, step))
        with stages("estimating"):
            coarser = _marched(problem, count // 2, 2 * step)
            differences = {name: relative_difference(name, value, array(results, name)) for name, value in coarser.items()}
            errors = {name: GRID.of(name) * over_neighbours(name, one) for name, one in differences.items()}
        parts = {"grid and step": float(errors["indentation"].max())}
        return Solution(with_errors(results, errors), parts, count + 1, {"grid": count, "step": step})

    def _step(self, problem: Problem) -> float:
        return grid_step(problem, UniformGrid(*problem.merged, problem.mdr.grid).stability_limit())


def _marched(problem: Problem, count: int, step: float) -> dict[str, Array]:
    grid = UniformGrid(*problem.merged, count)
    pressure, profile, indentation = grid.march(problem.times, step)

    def sampled(values: Array, radii: Array) -> Array:
        return np.array([np.interp(radii, grid.radii, row) for row in values])

    squared = radial_weight(grid.radii, problem.gradient_average) * np.gradient(profile, grid.radii, axis=1) ** 2
    within = cumulative_trapezoid(2 * np.pi * grid.radii * pressure, grid.radii, axis=1, initial=0.0)
    worn = sampled(profile, problem.radii)
    return {
        "pressure": sampled(pressure, problem.radii),
        "profile": worn,
        "displacement": indentation[:, None] - worn,
        "indentation": indentation,
        "displacement_centre": indentation - profile[:, 0],
        "displacement_max": indentation - profile.min(axis=1),
        "rms_slope": np.sqrt(np.trapezoid(squared, grid.radii, axis=1)),
        "ring_force": np.diff(sampled(within, problem.ring_edges), axis=1),
    }


METHOD = MdrGrid()
