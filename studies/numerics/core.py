"""What studies measure on a compliance, and what is exact. Non-dimensional."""

from dataclasses import replace

import numpy as np

from ...mdr import energy
from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..methods.evaluation import FullContact
from ..methods.norms import Results
from ..methods.spaces import radial_space
from ..problem.problem import D0, Problem


def exact_indentation(problem: Problem) -> Array:
    """Return the indentation (T,) by an MDR far finer than what is studied, exact in time."""
    space = radial_space(problem, degree=9, rim_size=1e-8, ring_size=2e-5, grading=0.25)
    alone = replace(problem, quantities=frozenset(["indentation"]))
    values = evaluate(alone, energy.compliance(space))["indentation"]
    # the start is known in closed form, more accurately than on any mesh
    return np.where(problem.times == 0, D0, values)


def evaluate(problem: Problem, compliance: Compliance) -> Results:
    """Return all that a problem asks for, steady state included, exact in time on a compliance."""
    modal = replace(problem, march="modal", step=None, steady=True, gradient_average="line")
    return FullContact(modal, compliance).results
