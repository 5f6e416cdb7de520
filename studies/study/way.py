"""The nouns of every study: a case is what is solved, and a way is how it is solved.

A way has levels, from coarse to fine. A level is a number, such as halvings, a tolerance or a time
step, or a small frozen value. The function that solves a level receives the level itself, so that
nothing is written as text and read back. Adaptive refinement also needs the solution of the level
before.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..crosscheck import Problem, Rings, Scene, Solution

ONE_RING = "one ring"
"""Name of the case of one ring."""
START, LATER, ALL = "start", "later", "all"
"""Values of the column `when`."""
KEYS_OF_STUDIES = ("case", "way", "quantity", "when")
"""Columns of a study that tell its sequences of levels apart."""
Level: TypeAlias = Any
Solve: TypeAlias = Callable[..., Solution]
"""Function (problem, level) -> solution; of a sequential way (problem, level, solution before)."""


class Part(NamedTuple):
    """A quantity at the start, later, or independent of time: one row of the table of a level."""

    quantity: str
    when: str = ALL

    def __str__(self) -> str:
        """Return the name in panels and sentences, such as "pressure, start"."""
        name = self.quantity.replace("_", " ").replace("rms", "RMS")
        return name if self.when == ALL else f"{name}, {self.when}"


class Theory(NamedTuple):
    """Theoretical order of convergence of a quantity.

    Parameters
    ----------
    order : slope of log error over log size; NaN if there is no theory
    floor : relative error; levels with smaller errors are shown but not used to fit the order
    reason : a sentence that explains the order, with its source, or says why there is none
    floor_cause : source of the errors below the floor, such as roundoff
    """

    order: float = np.nan
    floor: float = 0.0
    reason: str = ""
    floor_cause: str = ""


OTHERS = ""
Theories: TypeAlias = dict[Part | str, Theory]
"""Theories of parts, of all quantities at a `when`, and of all others, by `OTHERS`."""


def without_order(reason: str) -> Theories:
    """Return the theory that no quantity has an order, and why."""
    return {OTHERS: Theory(reason=reason)}


@dataclass(frozen=True, eq=False)
class Case:
    """What is solved.

    Parameters
    ----------
    name : name in tables and figures
    scene : scene of the case, to whose results functions of the user are applied; None if the case
        is not the scene of the user, so that they are left out
    problem : problem of the scene. It fixes the radii at which fields are compared, so that all
        solutions of the case are sampled at the same points
    parameter : place on the axis of a parameter that is varied; NaN if none is
    only : names of the quantities that are tabulated; None for all
    """

    name: str
    scene: Scene | None
    problem: Problem
    parameter: float = np.nan
    only: frozenset[str] | None = None

    @classmethod
    def of(
        cls,
        scene: Scene,
        name: str = "scene",
        quantities: frozenset[str] | None = None,
        parameter: float = np.nan,
    ) -> "Case":
        """Return the case of a scene, at the times of the scene and at its start.

        Parameters
        ----------
        scene : the scene
        name : name of the case
        quantities : quantities to compute; None for all that the scene has
        parameter : place of the case on the axis of a parameter

        Raises
        ------
        SceneError
            if the scene has none of the quantities
        """
        if not scene.wear.times or scene.wear.times[0] > 0:
            scene = scene.changed({"wear.times": [0.0, *scene.wear.times]})
        problem = replace(scene.problem, march="modal", step=None, quantities=None)
        if quantities is not None:
            problem = problem.with_quantities(quantities)
        return cls(name, scene, replace(problem, compared_on=problem.face), parameter)

    def with_one_ring(self) -> "Case":
        """Return the case of the same punch with one ring, at its start only.

        Its pressure is singular only at the rim, so that orders are the most regular.
        """
        ends = self.problem.ring_edges[[0, -1]]
        one_ring = replace(
            self.problem,
            rings=Rings.constant(ends, np.ones(1)),
            graded=None,
            times=np.zeros(1),
            steady=False,
            compared_on=None,
        )
        compared = replace(one_ring, compared_on=one_ring.face)
        return Case(ONE_RING, None, compared, only=frozenset({"indentation", "pressure"}))


@dataclass(frozen=True)
class Way:
    """One way to compute a case, from coarse to fine.

    Parameters
    ----------
    name : name in tables and in the legend, such as "P2, graded"
    method : name of the method, which determines the colour: `mdr`, `bem`, `fem`, `naive`, ...
    levels : the levels, from coarse to fine
    solve : function (problem, level) -> solution; that of a sequential way also receives the
        solution of the level before, or None
    refined : what the size is, as the label of an axis; curves share a panel only if it is the same
    size : function of the level that returns the size to which the theory refers; None for
        1 / sqrt(unknowns), which in the plane is proportional to the size of uniform elements
    theory : theoretical orders
    sequential : whether a level starts from the solution of the level before; its seconds then
        include those of all levels before
    promises : whether the level is a tolerance that the solution promises to keep
    largest : greatest size that counts in the observed order, because larger ones are not yet in
        the asymptotic range; 0 if levels are not similar to each other, so that there is no order
    """

    name: str
    method: str
    levels: Sequence[Level]
    solve: Solve
    refined: str
    size: Callable[[Level], float] | None = None
    theory: Theories = field(default_factory=dict)
    sequential: bool = False
    promises: bool = False
    largest: float = np.inf

    def theory_of(self, part: Part) -> Theory:
        """Return the theory of a part: its own, or that of its `when`, or that of all others."""
        theory = self.theory
        return theory.get(part) or theory.get(part.when) or theory.get(OTHERS) or Theory()


def inverse(level: float) -> float:
    """Return the size of a level that is a number of cells."""
    return 1 / level
