"""Observed orders of convergence beside those of theory, and what they say about the limit.

A sequence is one quantity on the levels of a family, from coarse to fine. Its observed order is the
slope of ``log error`` over ``log size``: between neighbouring levels, and by least squares over all
levels whose errors lie above the floor where roundoff or another error takes over.

If values follow ``v + c h^p``, three levels give the order p, Richardson's limit v, and Roache's
grid convergence index [1], which is 1.25 times the distance of the finest value from that limit. A
program can state this index as its error without knowing the truth.

[1] Roache: Perspective: a method for uniform reporting of grid refinement studies, J. Fluids Eng.
116 (1994), doi 10.1115/1.2910291.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import stdtrit

from ...meshes.radial import Array
from ..tables import Row
from .levels import Family, Theory

WITHIN = 0.15
"""How far an observed order may be from theory's, by least squares and between the last levels."""
SAFETY_OF_THREE_LEVELS = 1.25
"""Roache's factor of the grid convergence index where three levels have shown the order."""
LOWEST_ORDER, HIGHEST_ORDER = 0.05, 20.0
"""Orders between which Richardson's extrapolation looks for the one that three levels show."""
CONFIDENCE = 0.95
"""Probability of the interval of an observed order, if the scatter of its levels is normal."""


class FieldLevels(Protocol):
    """The fields of the levels of a sequence."""

    @property
    def changes(self) -> Array:
        """(n-1,) norms of the differences between neighbouring levels, relative."""

    def error_of_limit(self, weight: float) -> float:
        """Return the error of the finest field and `weight` times its last change, relative."""


@dataclass(frozen=True)
class Sequence:
    """One quantity on the levels of a family that were solved.

    Parameters
    ----------
    name : of the family
    quantity : what was computed
    theory : what is expected of it
    sizes, signed : (n,) of the levels; errors relative and signed
    fields : what the levels are where the errors are norms, which have no sign
    """

    name: str
    quantity: str
    theory: Theory
    sizes: Array
    signed: Array
    fields: FieldLevels | None = None

    @property
    def errors(self) -> Array:
        """(n,) relative errors without their signs."""
        return np.abs(self.signed)

    @property
    def counted(self) -> NDArray[np.bool_]:
        """(n,) whether a level counts for the order."""
        return self.errors > self.theory.floor

    @property
    def order(self) -> float:
        """Observed order by least squares over the levels that count; NaN of fewer than two."""
        return self._fit(slice(None))

    @property
    def last_order(self) -> float:
        """Observed order between the last two levels that count."""
        return self._fit(slice(-2, None))

    @property
    def interval(self) -> tuple[float, float]:
        """Interval of the order by the scatter about the fit, of `CONFIDENCE`; NaN of two levels.

        It is Student's, with two degrees of freedom less than there are levels.
        """
        sizes, errors = self._logarithms(slice(None))
        return slope_interval(sizes, errors)

    def _logarithms(self, part: slice) -> tuple[Array, Array]:
        sizes, errors = (np.log(values[self.counted][part]) for values in (self.sizes, self.errors))
        return sizes, errors

    def _fit(self, part: slice) -> float:
        sizes, errors = self._logarithms(part)
        return float(np.polyfit(sizes, errors, 1)[0]) if len(sizes) > 1 else np.nan

    @property
    def orders(self) -> Array:
        """(n-1,) observed orders between neighbouring levels; NaN at an error of zero."""
        errors = np.where(self.errors > 0, self.errors, np.nan)
        return np.diff(np.log(errors)) / np.diff(np.log(self.sizes))

    @property
    def richardson(self) -> tuple[float, float]:
        """Signed error of Richardson's limit, and the grid convergence index, both relative.

        Both are NaN for fewer than three levels, and if the last three levels do not converge in
        one direction. Where errors are norms of fields, the order follows from norms of the
        differences of levels, and the limit is a field, whose error is a norm again.
        """
        nothing = np.nan, np.nan
        if len(self.sizes) < 3 or not np.isfinite(self.signed[-3:]).all():
            return nothing
        sizes, errors = self.sizes[-3:], self.signed[-3:]
        before, last = errors[:-1] - errors[1:] if self.fields is None else self.fields.changes[-2:]

        def misfit(order: float) -> float:
            powers = sizes**order
            return float((powers[0] - powers[1]) * last - (powers[1] - powers[2]) * before)

        if misfit(LOWEST_ORDER) * misfit(HIGHEST_ORDER) >= 0:
            return nothing
        order = brentq(misfit, LOWEST_ORDER, HIGHEST_ORDER)
        weight = 1 / ((sizes[1] / sizes[2]) ** order - 1)
        if self.fields is not None:
            index = SAFETY_OF_THREE_LEVELS * weight * last
            return self.fields.error_of_limit(weight), float(index)
        left = weight * last
        index = SAFETY_OF_THREE_LEVELS * abs(left) / (1 + errors[2])
        return float(errors[2] - left), float(index)

    @property
    def verdict(self) -> str:
        """Whether observed orders are those of theory."""
        if np.isnan(self.theory.order):
            return ""
        if np.isnan(self.order):
            return "too few levels above the floor"
        off = np.array([self.order, self.last_order]) - self.theory.order
        return "yes" if (np.abs(off) <= WITHIN).all() else "no"

    @property
    def label(self) -> str:
        """What was computed, with the observed order, that of theory and the verdict."""
        label = f"{self.name}, {self.quantity}: {self.order:.2f}"
        if not self.verdict:
            return label
        return f"{label} (theory {self.theory.order:.3g}: {self.verdict})"

    def summary(self) -> Row:
        """Return a row of the table of orders."""
        lowest, highest = self.interval
        limit, index = self.richardson
        return {
            "refined": self.name,
            "quantity": self.quantity,
            "levels": f"{self.counted.sum()} of {len(self.sizes)}",
            "expected order": self.theory.order,
            "least squares": self.order,
            "lower end": lowest,
            "upper end": highest,
            "last levels": self.last_order,
            f"within {WITHIN}": self.verdict,
            "finest error": f"{self.errors[-1]:.1e}",
            "error of Richardson's limit": limit,
            "grid convergence index": index,
            "floor": self.theory.floor,
            "cause of the floor": self.theory.floor_cause,
            "theory": self.theory.reason,
        }


def slope_interval(x: Array, y: Array) -> tuple[float, float]:
    """Return the interval of the slope of a line fitted by least squares, of `CONFIDENCE`.

    It is Student's, with two degrees of freedom less than there are points; NaN of fewer than
    three points.

    Parameters
    ----------
    x, y : (n,) points
    """
    if len(x) < 3:
        return np.nan, np.nan
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    half = stdtrit(len(x) - 2, (1 + CONFIDENCE) / 2) * np.sqrt(covariance[0, 0])
    return float(slope - half), float(slope + half)


def sequences_of(families: Iterable[Family], rows: pd.DataFrame) -> list[Sequence]:
    """Return a sequence for each quantity of a family that has a theory, if rows tell of it."""
    sequences = []
    for family in families:
        solved = rows[rows.family == family.name]
        for quantity, theory in family.theory.items():
            levels = solved[["size", quantity]].dropna().to_numpy(float)
            if len(levels):
                sequences.append(Sequence(family.name, quantity, theory, *levels.T))
    return sequences


def conclude(sequences: Iterable[Sequence]) -> list[str]:
    """Return how observed orders agree with theory, and then a line for each sequence."""
    sequences = list(sequences)
    verdicts = [sequence.verdict for sequence in sequences if sequence.verdict]
    return [
        f"{verdicts.count('yes')} of {len(verdicts)} orders that theory tells are within {WITHIN} "
        "of it, fitted and between the last levels.",
        *(f"{sequence.label}, finest error {sequence.errors[-1]:.1e}" for sequence in sequences),
    ]
