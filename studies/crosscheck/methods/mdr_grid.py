"""The paper's own algorithm.

It has springs on a uniform grid and explicit steps in time, and gives no steady state.
"""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ....mdr.direct import steady_pressures
from ....mdr.uniform_grid import UniformGrid
from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array
from ..problem.norms import Results
from ..problem.problem import Problem
from ..problem.quantities import differences
from ..problem.refusal import Feature, Refusal
from ..progress import Stages
from ..wear.history import History
from ..wear.step_control import steps_between, why_too_many_steps
from .base import Method, Solution, SystemSize, flat_punches_only
from .error_factors import error_factor
from .sampling.sampler import Sampler

# Time step of the march over the largest stable one (`ringwear study march`).
STABLE_STEP_FRACTION = 0.5


class MdrGrid(Method):
    """MDR on a uniform grid: first order in the grid spacing and in the time step."""

    name = "mdr-grid"
    what = "the paper's own algorithm: MDR on a uniform grid, in explicit steps"
    lacks: ClassVar[dict[str, str]] = {
        "steady state": "the paper's algorithm marches towards it, but never reaches it"
    }
    refused: ClassVar[Mapping[Feature, Refusal]] = {
        "wear along the radius": Refusal(
            "mdr-grid needs wear that is constant on each ring",
            "leave it out of methods, or give steps or many rings in place of "
            "punch.wear_coefficient along the radius",
        ),
        "varying load": Refusal(
            "mdr-grid needs a constant force and sliding speed",
            "leave it out of methods, or give load.normal_force and load.sliding_speed as numbers",
        ),
        **flat_punches_only("mdr-grid"),
    }

    def beyond(self, problem: Problem) -> Refusal | None:
        """Return why problems of this kind are beyond the method; None if it can solve them.

        It solves full flat discs under a constant force and sliding speed, with wear coefficients
        that are constant on rings.
        """
        if problem.inner_radius:
            return Refusal(
                "mdr-grid solves full discs only",
                "with punch.inner_radius leave it out of methods",
            )
        return super().beyond(problem)

    def refusal(self, problem: Problem) -> str:
        """Return why the method cannot solve the problem, with the remedy; empty if it can.

        It needs times, and the number of steps is limited.
        """
        if reason := super().refusal(problem):
            return reason
        if not len(problem.times):
            return (
                "mdr-grid marches in time and gives no steady state: give wear.times, or leave it "
                "out of methods"
            )
        return why_too_many_steps(
            float(steps_between(problem.times, self._step(problem)).sum()),
            "give a larger accuracy.mdr.step, or a coarser accuracy.mdr.grid",
        )

    def remedy(self, problem: Problem) -> str:
        """Return what would make the method more accurate."""
        return f"{self.name} is of first order; give a finer accuracy.mdr.grid"

    def step(self, problem: Problem) -> float:
        """Return the step of the explicit march, from the stability limit for many springs."""
        return _step_within(problem, 4 / np.pi / problem.mdr.grid)

    def system_size(self, problem: Problem) -> SystemSize:
        """Return the number of unknowns: one per spring, and the approach."""
        return SystemSize(problem.mdr.grid + 1, problem.mdr.grid + 1)

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Return the history on the grid.

        Errors are estimated by the difference to a solution with half as many springs and half as
        many steps.
        """
        count, step = problem.mdr.grid, self._step(problem)
        with stages("marching"):
            sampler, history = _march(problem, count, step)
            results, fine = sampler.history(history), sampler.history(history, on_face=True)
            answers = {"worn_volume": sampler.worn_volumes(history[-1:])[0]}
        with stages("estimating"):
            sampler, history = _march(problem, count // 2, 2 * step)
            quantity_differences = differences(
                sampler.history(history, on_face=True), fine, problem.face
            )
            coarser = {"worn_volume": sampler.worn_volumes(history[-1:])[0]}
            # An error of first order doubles on the coarser grid, so that it equals the difference.
            # Slopes and jumps at ring edges converge with order 1/2.
            unresolved = _unresolved_wear(problem, count)
            errors: Results = {
                name: _factor(name) * unresolved * _largest_nearby(difference)
                for name, difference in quantity_differences.items()
            }
            for name, difference in differences(coarser, answers, problem.face).items():
                errors[name] = _factor(name) * unresolved[-1] * difference
        parts = {"grid and step": float(errors["indentation"].max())}
        settings = {"grid": count, "step": step}
        compared = {name: values[problem.compared_rows] for name, values in fine.items()} | answers
        return Solution(results | answers, compared, errors, parts, count + 1, settings)

    def _step(self, problem: Problem) -> float:
        return _step_within(problem, _grid(problem, problem.mdr.grid).stability_limit())


def _step_within(problem: Problem, stability_limit: float) -> float:
    """Return the step of the scene, or else STABLE_STEP_FRACTION of the largest stable step."""
    if problem.mdr.step:
        return problem.mdr.step / problem.units.time
    if problem.step and problem.march == "explicit":
        return problem.step
    return STABLE_STEP_FRACTION * stability_limit


def _grid(problem: Problem, count: int) -> UniformGrid:
    """Return the grid of `count` springs for the rings of a problem, which wear evenly."""
    ring_edges, (wear_coefficients, _) = problem.merged
    return UniformGrid(ring_edges, wear_coefficients, count)


def _march(problem: Problem, count: int, step: float) -> tuple[Sampler, History]:
    """Return the history on a grid, linear between its points, and a sampler for it."""
    grid = _grid(problem, count)
    space = PressureSpace(grid.radii, np.ones(count, dtype=np.int64), np.array([0.0, 1.0]))
    pressure, profile, indentation = grid.march(problem.times, step)
    # k p of the steady state, which is the same on every ring
    rates = grid.wear_coefficients * steady_pressures(grid.ring_edges, grid.wear_coefficients)
    even_wear = rates[0] * problem.times
    history = History.in_full_contact(
        problem.times,
        problem.times,
        pressure,
        profile - np.outer(even_wear, space.uniform),
        indentation - even_wear,
        np.ones(len(problem.times)),
        even_wear,
        space.uniform,
    )
    return Sampler(problem, space), history


def _factor(name: str) -> float:
    """Return the factor on the difference of a quantity to the coarser grid."""
    return error_factor("uniform grid, slope" if name == "rms_slope" else "uniform grid")


def _unresolved_wear(problem: Problem, count: int) -> Array:
    """Return by how much (T,) errors exceed their estimate while wear is finer than the grid.

    Until wear has smoothed the pressure at an edge over a cell, both grids miss the same part of
    it. This part falls with the root of the worn length, which is about ``k t`` on the ring that
    wears most slowly.
    """
    wear = problem.merged.wear_coefficients
    worn_lengths = wear[wear > 0].min() * problem.distances
    unworn = np.ones(len(worn_lengths))
    cells = np.divide(1 / count, worn_lengths, out=unworn, where=worn_lengths > 0)
    return np.sqrt(np.maximum(cells, 1.0))


def _largest_nearby(difference: Array) -> Array:
    """Return the largest of each time and its neighbours, because differences cross zero."""
    return sliding_window_view(np.pad(difference, 1), 3).max(axis=1)


METHOD = MdrGrid()
