"""A punch in full contact at any time, by its relaxation modes."""

from collections.abc import Mapping

from ...meshes.radial import Array
from ..methods.base import Solution
from ..methods.sampler import Sampler
from ..problem.problem import Problem
from ..problem.quantities import QUANTITIES
from ..wear.full_contact import RunningIn


def modal_method(solutions: Mapping[str, Solution]) -> tuple[str, RunningIn] | None:
    """Return the first method whose modes give the state at any time, and its running-in."""
    for name, solution in solutions.items():
        if solution.wear is not None:
            return name, solution.wear
    return None


def sample_modes(problem: Problem, wear: RunningIn, times: Array) -> dict[str, Array]:
    """Return the quantities at non-dimensional times, and of the steady state if that is wanted, in
    the units of the scene, with times and radii.
    """
    sampler, units = Sampler(problem, wear.compliance.space), problem.units
    results = sampler.history(wear.modal(times))
    if problem.steady:
        results |= sampler.steady(wear.steady)
    sampled = {
        name: results[name] * getattr(units, quantity.unit)
        for name, quantity in QUANTITIES.items()
        if name in results
    }
    return sampled | {"time": times * units.time, "radius": problem.radii * units.length}
