"""Pressure spaces that suit a problem, and coarser ones for the error estimate.

A flat punch has singular pressures at ring edges and at the rim at early times; its space has
geometric layers of high degree. If edges of the contact move, pressures jump at places that are not
known beforehand; the space then has linear pressures on cells.
"""

from collections.abc import Mapping
from typing import NamedTuple

from ....meshes.pressure_space import PressureSpace
from ..problem.problem import Problem
from ..sizes.radial import radial_sizes
from ..wear.first_contact import contact_cells


class PressureSpaces(NamedTuple):
    """The pressure space that suits a problem, and one that is coarser in every respect.

    Parameters
    ----------
    fine, coarse : the spaces
    nested : whether the coarse space is a subspace of the fine one; its compliance is then a
        restriction and need not be computed anew
    sizes : the sizes from which the fine space was made, for the summary; empty for cells
    """

    fine: PressureSpace
    coarse: PressureSpace
    nested: bool
    sizes: Mapping[str, float]


def choose_spaces(problem: Problem) -> PressureSpaces:
    """Return the pressure spaces that suit the contact of a problem."""
    if not problem.full_contact:
        fine, coarse = contact_cells(problem)
        return PressureSpaces(fine.space(), coarse.space(), False, {})
    sizes = radial_sizes(problem)
    space = sizes.space(problem)
    return PressureSpaces(space, space.coarser(), True, sizes.summary)


def pressure_spaces(problem: Problem) -> tuple[PressureSpace, PressureSpace]:
    """Return the pressure space that suits a problem, and one that is coarser in every respect."""
    spaces = choose_spaces(problem)
    return spaces.fine, spaces.coarse
