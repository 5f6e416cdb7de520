"""Refuse histories in which full contact would need tension."""

from collections.abc import Callable

import numpy as np

from ....meshes.errors import SolverError
from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Indices
from ..problem.problem import Problem
from .history import History

# Tension, over (rtol * largest pressure), that may be a mere discretisation error on layers.
MOST_TENSION = 10.0


def refuse_tension(
    problem: Problem, space: PressureSpace, history_at: Callable[[Indices], History]
) -> None:
    """Raise if full contact takes tension during wear, which is not modelled.

    On a homogeneous half-space, pressures that are positive at the start stay positive under a
    force that never falls. A layer that bends or bulges may lose contact with the punch later, and
    so may any punch while the force falls, if the prediction that it does not is wrong.

    Parameters
    ----------
    problem : a flat punch
    space : the space of the pressures
    history_at : returns the history at some of the times of the problem, given by their indices

    Raises
    ------
    SolverError
        with the time and the remedy
    """
    later = problem.compared_rows[problem.distances[problem.compared_rows] > 0]
    pressure = (space.matrix(problem.face.radii) @ history_at(later).pressure.T).T
    allowed_tension = MOST_TENSION * problem.rtol * np.abs(pressure).max(axis=1)
    if (lost_contact := np.flatnonzero(pressure.min(axis=1) < -allowed_tension)).size:
        time = float(problem.times[later][lost_contact[0]]) * problem.units.time
        if not problem.ground.layered:
            raise SolverError(
                f"the pressure becomes negative by t = {time:.3g}, while the force falls, although "
                "a small solution predicted full contact: end wear.times before that"
            )
        raise SolverError(
            f"half_space.layers lose contact with the punch by t = {time:.3g}, though not at the "
            "start, and this is not modelled: end wear.times before that, or leave them out"
        )
