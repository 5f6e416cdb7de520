"""What a march on an initial profile is made of; its seconds depend on where contact goes."""

import numpy as np

from ....meshes.pressure_space import PressureSpace
from ...problem.defaults import cells_of
from ...problem.problem import Problem
from ..base import Cost

# cells beside those that are known beforehand, where contact begins on a narrow part of the face
MORE = 1.3
# triangles: unknowns for each pressure, and those that there are besides
UNKNOWNS, MORE_UNKNOWNS = 80, 8000


def described(problem: Problem) -> str:
    """The space of the march."""
    space = _space(problem)
    return (
        f"linear pressures on {len(space.degrees)} cells and more where contact begins, and a "
        "press fitted to its edges"
    )


def counted(problem: Problem, elements: bool) -> tuple[int, int]:
    """Unknowns, and pressures among them."""
    pressures = int(MORE * _space(problem).size)
    return (UNKNOWNS * pressures + MORE_UNKNOWNS if elements else pressures), pressures


def cost(problem: Problem, elements: bool) -> Cost:
    """Of the march and its estimate; its seconds and its error are known by the run only."""
    return Cost(*counted(problem, elements), np.nan, np.nan)


def _space(problem: Problem) -> PressureSpace:
    return cells_of(problem).space()
