"""What studies measure a method by.

Seconds on this machine, and errors against an MDR far finer than any of them.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import xarray

from ..mdr.uniform_grid import UniformGrid
from ..meshes.errors import RingwearError
from ..meshes.radial import Array
from .methods import mdr
from .methods.base import method
from .methods.pipeline import compliance_method
from .methods.quantities import array
from .methods.sampler import Evaluation
from .problem.defaults import grid_step
from .problem.problem import D0, Problem
from .progress import Stages
from .tables import Row
from .wear.full_contact import RunningIn


def exact(problem: Problem) -> xarray.Dataset:
    """What a problem asks for, by the fine MDR, exact in time."""
    space = mdr.radial_space(problem, degree=9, rim_size=1e-8, ring_size=2e-5, grading=0.25)
    results = Evaluation(
        replace(problem, march="modal", step=None), mdr.METHOD.compliance(space)
    ).results
    # at the start it is known in closed form, more accurately than on any mesh
    results.indentation[problem.times == 0] = D0
    return results


def indentation(name: str, problem: Problem) -> Array:
    """The history by a method, without its estimate."""
    if name == "mdr-grid":
        grid = UniformGrid(*problem.merged, problem.mdr.grid)
        return grid.march(problem.times, grid_step(problem, grid.stability_limit()))[2]
    ready = compliance_method(name).discretise(problem, Stages(name))
    wear = RunningIn(ready.compliance, problem.merged.wear_coefficients, problem.earliest)
    return wear.history(problem.times, problem.march, problem.step).indentation


def best(action: Callable[[], object], quick: bool) -> float:
    """Least seconds of five calls, or of one, after a warm-up."""
    action()
    seconds = []
    for _ in range(1 if quick else 5):
        start = time.perf_counter()
        action()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def measured(name: str, problem: Problem, known: Array, quick: bool) -> Row:
    """Seconds, error and own estimate of one setting, or the reason why it failed."""
    try:
        seconds = best(partial(indentation, name, problem), quick)
        solution = method(name).solve(problem, Stages(name))
    except RingwearError as failure:
        return {"remark": str(failure)}
    error = np.abs(array(solution.results, "indentation") / known - 1)
    estimate = solution.errors["indentation"]
    return {
        "unknowns": solution.unknowns,
        "seconds": seconds,
        "error": float(error.max()),
        "estimate": float(estimate.max()),
    }
