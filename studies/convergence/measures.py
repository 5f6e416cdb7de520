"""What is measured of a level, and by how much it errs, in the norms of the package.

A measure is a quantity of a run (`studies/problem/quantities.py`) at the start or later, or one of
three that are taken from the discretisation itself: the indentation and the pressure of the flat
start by the pressures of its own space (a run seeks the start among functions that suit it better,
which would hide the singular rim), and the stresses on the axis.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...meshes.radial import Array
from ..problem.face import Face
from ..problem.problem import Problem
from ..sampling.norms import Results, differences
from ..study.orders import FieldLevels

FLAT_INDENTATION, FLAT_PRESSURE, STRESSES = "flat indentation", "flat pressure", "stresses"
"""Measures that no run has, by their names among results."""
PRESSURE_PART = "d0 by the pressures alone"
"""Column of the error that the pressures of a level make on the exact half-space."""


class Measure(NamedTuple):
    """A column of the table: the error of one quantity.

    Parameters
    ----------
    name : of the column
    quantity : by its name among results
    when : `start`, `later`, or nothing where it has no time
    signed : whether it is one number, whose error has a sign
    """

    name: str
    quantity: str
    when: str = ""
    signed: bool = False


D0 = Measure("d0", FLAT_INDENTATION, signed=True)
P0 = Measure("pressure at start", FLAT_PRESSURE)
INSIDE = Measure("stresses inside", STRESSES)
START = (
    Measure("indentation at start", "indentation", "start"),
    Measure("force at start", "normal_force", "start"),
    Measure("pressure at start", "pressure", "start"),
)
LATER = (
    Measure("d(t)", "indentation", "later"),
    Measure("normal force", "normal_force", "later"),
    Measure("pressure", "pressure", "later"),
    Measure("profile", "profile", "later"),
    Measure("ring forces", "ring_force", "later"),
    Measure("RMS slope", "rms_slope", "later"),
    Measure("contact radius", "contact_radius", "later"),
    Measure("worn volume", "ring_worn_volume", "later"),
)
TIMELESS = (
    Measure("relaxation time", "relaxation_time", signed=True),
    Measure("steady slope", "steady_rms_slope", signed=True),
    Measure("steady profile", "steady_profile"),
)


def measures_of(problem: Problem, exact: Results) -> tuple[Measure, ...]:
    """Return what can be measured of a problem, given its exact results."""
    found = [D0, P0]
    at_start, later = rows_at(exact, "start"), rows_at(exact, "later")
    given = {problem.load_regime.given}
    if "normal_force" in given and len(problem.wear_coefficients) == 1:
        # one ring carries the force that is given, and loses the volume that goes with it
        given |= {"ring_force", "ring_worn_volume"}
    if at_start.any() and FLAT_INDENTATION not in exact:
        found += [measure for measure in START if measure.quantity not in given]
    if later.any():
        found += [measure for measure in LATER if measure.quantity not in given]
    found += TIMELESS
    chosen = [measure for measure in found if measure.quantity in exact]
    return (*chosen, INSIDE) if STRESSES in exact else tuple(chosen)


def rows_at(exact: Results, when: str) -> NDArray[np.bool_]:
    """Return which of the times of results (T,) are the start, or later."""
    times = exact.get("time", np.zeros(0))
    if when == "later":
        return times > 0
    return (times == 0) & (exact["ring_force"].sum(axis=1) > 0) if len(times) else times == 0


def error(measure: Measure, values: Results, exact: Results, face: Face) -> float:
    """Return the relative error of a measure, greatest over time; NaN if values lack it."""
    name = measure.quantity
    if name not in values:
        return np.nan
    if measure.signed:
        value, reference = np.ravel(values[name])[0], np.ravel(exact[name])[0]
        return float(value / reference - 1)
    if name == FLAT_PRESSURE:
        weights = face.weights * face.edge_weights
        wrong = weights @ (values[name] - exact[name]) ** 2
        return float(np.sqrt(wrong / (weights @ exact[name] ** 2)))
    if name == STRESSES:
        states = len(exact[name])
        greatest = np.abs(exact[name]).reshape(states, -1).max(axis=1)
        wrong = np.abs(values[name] - exact[name]).reshape(states, -1).max(axis=1)
        return float((wrong / greatest).max())
    difference = differences({name: values[name]}, exact, face)[name]
    return float((difference[rows_at(exact, measure.when)] if measure.when else difference).max())


@dataclass(frozen=True)
class MeasuredLevels(FieldLevels):
    """The levels of one measure that has no sign, from coarse to fine.

    Parameters
    ----------
    measure : a norm
    levels : results of each level
    exact, face : what they are compared with, and where
    """

    measure: Measure
    levels: tuple[Results, ...]
    exact: Results
    face: Face

    def _norm_of(self, wrong: Callable[[str], Array]) -> float:
        """Return the norm of a difference to the exact result, relative to this."""
        name = self.measure.quantity
        return error(self.measure, {name: self.exact[name] + wrong(name)}, self.exact, self.face)

    @cached_property
    def changes(self) -> Array:
        """(n-1,) norms of the differences between neighbouring levels, relative."""
        pairs = zip(self.levels[:-1], self.levels[1:], strict=True)

        def norm(coarse: Results, fine: Results) -> float:
            return self._norm_of(lambda name: coarse[name] - fine[name])

        return np.array([norm(coarse, fine) for coarse, fine in pairs])

    def error_of_limit(self, weight: float) -> float:
        """Return the error of the finest field and `weight` times its last change, relative."""
        coarse, fine = self.levels[-2:]

        def limit(name: str) -> Array:
            return fine[name] + weight * (fine[name] - coarse[name]) - self.exact[name]

        return self._norm_of(limit)
