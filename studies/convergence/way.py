"""A way to refine the discretisation of a scene, which becomes a family of the study."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..methods.base import Discretised
from ..problem.problem import Problem
from ..progress import Stages
from ..study.levels import Theory


@dataclass(frozen=True)
class Way:
    """One way to refine the discretisation of a scene, from coarse to fine.

    Parameters
    ----------
    name : of its family in the table
    label : of its curves, shared by all ways with the same elements
    group : of ways that are drawn together
    method : whose discretisation it is: `mdr`, `bem` or `fem`
    sizes : settings of the levels, each with its size
    discretise : (setting, stages) -> what is worn
    theory : name of a measure -> what is expected of its errors
    xlabel : what the size is called
    work : setting -> seconds that its level is expected to take
    problem_at : setting -> the problem that is solved; by default the same at all levels
    parts : columns of the table that tell parts of an error
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
    parts: tuple[str, ...] = ()
