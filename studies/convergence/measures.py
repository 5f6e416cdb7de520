"""Define the measures of a level, and compute their errors in the norms of the package.

A measure is a quantity of a run (`studies/crosscheck/problem/quantities.py`), at the start or at
later times, or one of three quantities of the discretisation itself. These are the indentation and
the pressure of the flat start, computed in the pressure space of the level, and the stresses on the
axis. (A run computes the flat start with functions that are adapted to its singularity, which would
hide the error at the singular rim.)
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..crosscheck import Array, Problem, Results, differences
from ..crosscheck.problem.face import Face
from ..study.orders import FieldLevels

FLAT_INDENTATION, FLAT_PRESSURE, STRESSES = "flat indentation", "flat pressure", "stresses"
"""Names, in results, of the measures that are not quantities of a run."""
PRESSURE_PART = "d0 by the pressures alone"
"""Column with the error of d0 if the pressures of a level act on the exact half-space (MDR)."""


class Measure(NamedTuple):
    """A column of the table: the error of one quantity.

    Parameters
    ----------
    name : name of the column
    quantity : name of the quantity in results
    when : `start` or `later`; empty if the quantity does not depend on time
    signed : whether the quantity is a single number, so that its error has a sign
    """

    name: str
    quantity: str
    when: str = ""
    signed: bool = False


D0 = Measure("d0", FLAT_INDENTATION, signed=True)
P0 = Measure("pressure at start", FLAT_PRESSURE)
INSIDE = Measure("stresses inside", STRESSES)
"""Measures of the discretisation itself."""
START = (
    Measure("indentation at start", "indentation", "start"),
    Measure("force at start", "normal_force", "start"),
    Measure("pressure at start", "pressure", "start"),
)
"""Measures of the start of a run, used if the start is not flat."""
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
"""Measures at the times after the start."""
TIMELESS = (
    Measure("relaxation time", "relaxation_time", signed=True),
    Measure("steady slope", "steady_rms_slope", signed=True),
    Measure("steady profile", "steady_profile"),
)
"""Measures that do not depend on time."""


def measures_of(problem: Problem, exact: Results) -> tuple[Measure, ...]:
    """Return the measures that a problem has, given its exact results."""
    candidates = [D0, P0]
    at_start, later = rows_at(exact, "start"), rows_at(exact, "later")
    prescribed = {problem.prescribed}
    if "normal_force" in prescribed and len(problem.wear_coefficients) == 1:
        # a single ring carries the prescribed force, which determines its worn volume
        prescribed |= {"ring_force", "ring_worn_volume"}
    if problem.full_contact:
        # the contact radius is that of the punch
        prescribed.add("contact_radius")
    if at_start.any() and FLAT_INDENTATION not in exact:
        candidates += [measure for measure in START if measure.quantity not in prescribed]
    if later.any():
        candidates += [measure for measure in LATER if measure.quantity not in prescribed]
    candidates += TIMELESS
    measures = [measure for measure in candidates if measure.quantity in exact]
    return (*measures, INSIDE) if STRESSES in exact else tuple(measures)


def rows_at(exact: Results, when: str) -> NDArray[np.bool_]:
    """Return a mask (T,) of the times of results that are the loaded start, or later times."""
    times = exact.get("time", np.zeros(0))
    if when == "later":
        return times > 0
    return (times == 0) & (exact["ring_force"].sum(axis=1) > 0) if len(times) else times == 0


def error(measure: Measure, values: Results, exact: Results, face: Face) -> float:
    """Return the relative error of a measure, the greatest over time; NaN if `values` lack it."""
    name = measure.quantity
    if name not in values:
        return np.nan
    if measure.signed:
        value, reference = np.ravel(values[name])[0], np.ravel(exact[name])[0]
        return float(value / reference - 1)
    if name == FLAT_PRESSURE:
        weights = face.weights * face.edge_weights
        squared_error = weights @ (values[name] - exact[name]) ** 2
        return float(np.sqrt(squared_error / (weights @ exact[name] ** 2)))
    if name == STRESSES:
        states = len(exact[name])
        greatest_stress = np.abs(exact[name]).reshape(states, -1).max(axis=1)
        errors = np.abs(values[name] - exact[name]).reshape(states, -1).max(axis=1)
        return float((errors / greatest_stress).max())
    difference = differences({name: values[name]}, exact, face)[name]
    return float((difference[rows_at(exact, measure.when)] if measure.when else difference).max())


@dataclass(frozen=True)
class MeasuredLevels(FieldLevels):
    """Levels of one measure whose error is a norm, from coarse to fine.

    Parameters
    ----------
    measure : measure without a sign
    levels : results of each level
    exact : reference results that the levels are compared with
    face : points and weights of the norms on the face of the punch
    """

    measure: Measure
    levels: tuple[Results, ...]
    exact: Results
    face: Face

    def _norm_of(self, deviation: Callable[[str], Array]) -> float:
        """Return the norm of a deviation, relative to the norm of the exact result."""
        name = self.measure.quantity
        return error(
            self.measure, {name: self.exact[name] + deviation(name)}, self.exact, self.face
        )

    @cached_property
    def changes(self) -> Array:
        """(n-1,) relative norms of the differences between neighbouring levels."""
        pairs = zip(self.levels[:-1], self.levels[1:], strict=True)

        def norm(coarse: Results, fine: Results) -> float:
            return self._norm_of(lambda name: coarse[name] - fine[name])

        return np.array([norm(coarse, fine) for coarse, fine in pairs])

    def error_of_limit(self, weight: float) -> float:
        """Return the relative error of the field ``finest + weight * (finest - second finest)``."""
        coarse, fine = self.levels[-2:]

        def limit(name: str) -> Array:
            return fine[name] + weight * (fine[name] - coarse[name]) - self.exact[name]

        return self._norm_of(limit)
