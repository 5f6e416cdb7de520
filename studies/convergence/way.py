"""A way to refine the discretisation of a scene. The study makes one family of levels from it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..crosscheck import Discretised, Problem, Stages
from ..study.levels import Theory


@dataclass(frozen=True)
class Way:
    """One way to refine the discretisation of a scene, from coarse to fine.

    Parameters
    ----------
    name : name of its family in the table
    label : label of its curves; all ways with the same elements have the same label
    group : group of ways that are drawn in one figure
    method : method that discretises: `mdr`, `bem` or `fem`
    sizes : size of each level, by the setting of the level
    discretise : function of (setting, stages) that returns the discretisation of a level
    theory : function that returns the theoretical order of a measure by its name
    xlabel : label of the size in figures
    work : function that returns the expected seconds of the level of a setting
    problem_at : function that returns the problem to solve for a setting; None if all levels solve
        the same problem
    error_parts : further columns of the table, each with a part of an error
    """

    name: str
    label: str
    group: str
    method: str
    sizes: Mapping[Any, float]
    discretise: Callable[[Any, Stages], Discretised]
    theory: Callable[[str], Theory]
    xlabel: str
    work: Callable[[Any], float] = lambda _: 1.0
    problem_at: Callable[[Any], Problem] | None = None
    error_parts: tuple[str, ...] = ()
