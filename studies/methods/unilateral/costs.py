"""What a march on an initial profile will take, without making any of it: a guess, for where contact goes is not known."""

import numpy as np

from ringwear.meshes.pressure_space import PressureSpace
from ringwear.studies.methods.base import Cost
from ringwear.studies.methods.costs import steps
from ringwear.studies.problem.defaults import cells_of
from ringwear.studies.problem.problem import Problem

# contact problems of a march whose steps suit the accuracy, and seconds of one over the square of its pressures; measured on
# spheres and recessed rings
STAGES, PER_STAGE = 900, 8e-9
# cells beside those that are known beforehand, where contact begins on a narrow part of the face
MORE = 1.3
# triangles: unknowns for each pressure, and their seconds; quadrilaterals fitted to contact edges take the rest
UNKNOWNS, MORE_UNKNOWNS, PER_UNKNOWN, FITTED = 80, 8000, 2e-5, 0.5


def described(problem: Problem) -> str:
    """The space of the march."""
    space = _space(problem)
    return f"linear pressures on {len(space.degrees)} cells and more where contact begins, and a press fitted to its edges"


def counted(problem: Problem, elements: bool) -> tuple[int, int]:
    """Unknowns, and pressures among them."""
    pressures = int(MORE * _space(problem).size)
    return (UNKNOWNS * pressures + MORE_UNKNOWNS if elements else pressures), pressures


def cost(problem: Problem, elements: bool) -> Cost:
    """Of the march and its estimate; its error is known by the run only."""
    unknowns, pressures = counted(problem, elements)
    solved = STAGES + 2 * steps(problem)
    seconds = 0.3 + solved * PER_STAGE * pressures**2 + (FITTED + PER_UNKNOWN * unknowns if elements else 0.0)
    return Cost(unknowns, pressures, seconds, np.nan)


def _space(problem: Problem) -> PressureSpace:
    return cells_of(problem).space()
