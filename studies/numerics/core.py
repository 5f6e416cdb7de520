"""What the studies of the numerics take from the methods and the march.

All access to both goes through this file. Non-dimensional.
"""

from dataclasses import replace

import numpy as np
import xarray

from ...mdr import energy
from ...mdr.uniform_grid import UniformGrid
from ...meshes.compliance import Compliance
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array
from ..methods.base import Solution, method
from ..methods.evaluation import FullContact
from ..methods.pipeline import compliance_method
from ..methods.spaces import radial_space
from ..problem.defaults import grid_step
from ..problem.problem import D0, Problem
from ..progress import Stages
from ..wear.full_contact import RunningIn


def prepare(name: str, problem: Problem) -> Compliance:
    """Return the compliance that a method has for a problem, on its own pressure space."""
    return compliance_method(name).discretise(problem, Stages(name)).compliance


def run_in(problem: Problem, compliance: Compliance) -> RunningIn:
    """Wear the flat punch of a problem on a compliance."""
    return RunningIn(compliance, problem.merged.wear_coefficients, problem.earliest)


def solve(name: str, problem: Problem) -> Solution:
    """Solve a problem by a method, at the sizes that it chooses at once, and estimate errors."""
    return method(name).solve(problem, Stages(name))


def indentation(name: str, problem: Problem) -> Array:
    """Return the indentation (T,) by a method, and nothing else."""
    if name == "mdr-grid":
        grid = UniformGrid(*problem.merged, problem.mdr.grid)
        return grid.march(problem.times, grid_step(problem, grid.stability_limit()))[2]
    running_in = run_in(problem, prepare(name, problem))
    return running_in.history(problem.times, problem.march, problem.step).indentation


def exact_indentation(problem: Problem) -> Array:
    """Return the indentation (T,) by an MDR far finer than what is studied, exact in time."""
    space = graded_space(problem, degree=9, rim_size=1e-8, ring_size=2e-5, grading=0.25)
    values = run_in(problem, energy.compliance(space)).modal(problem.times).indentation
    # the start is known in closed form, more accurately than on any mesh
    return np.where(problem.times == 0, D0, values)


def graded_space(problem: Problem, **sizes: float) -> PressureSpace:
    """Return a pressure space graded to ring edges and rim (see `radial_space`)."""
    return radial_space(problem, **sizes)  # type: ignore[arg-type]


def evaluate(problem: Problem, compliance: Compliance) -> xarray.Dataset:
    """Return all that a problem asks for, steady state included, exact in time on a compliance."""
    modal = replace(problem, march="modal", step=None, steady=True, gradient_average="line")
    return FullContact(modal, compliance).results
