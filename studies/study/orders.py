"""Fit observed orders of convergence, compare them with theory, and extrapolate to the limit.

A sequence is one quantity on the levels of a family, from coarse to fine. Its observed order is the
slope of ``log error`` over ``log size``, computed between neighbouring levels and by least squares
over all levels with errors above a floor. Below the floor, roundoff or another error dominates.

If values follow ``v + c h^p``, three levels determine the order p, Richardson's limit v, and
Roache's grid convergence index [1], which is 1.25 times the distance of the finest value from that
limit. A program can report this index as its error estimate without knowing the exact value.

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

from ..crosscheck import Array
from ..tables import Row
from .levels import Family, Theory

ORDER_TOLERANCE = 0.15
"""Greatest difference between observed and theoretical order that counts as agreement.

The order by least squares and the order between the last two levels both have to satisfy it.
"""
INDEX_SAFETY_FACTOR = 1.25
"""Safety factor of the grid convergence index if three levels determine the order (Roache [1])."""
LOWEST_ORDER, HIGHEST_ORDER = 0.05, 20.0
"""Bounds of the search for the order in Richardson's extrapolation from three levels."""
CONFIDENCE = 0.95
"""Confidence level of the interval of an observed order, for normally distributed scatter."""


class FieldLevels(Protocol):
    """Fields on the levels of a sequence, for quantities whose error is a norm."""

    @property
    def changes(self) -> Array:
        """(n-1,) relative norms of the differences between neighbouring levels."""

    def error_of_limit(self, weight: float) -> float:
        """Return the relative error of the field ``finest + weight * (finest - second finest)``."""


@dataclass(frozen=True)
class Sequence:
    """One quantity on the solved levels of a family.

    Parameters
    ----------
    name : name of the family
    quantity : name of the quantity
    theory : theoretical order of the quantity
    sizes : (n,) sizes of the levels
    signed_errors : (n,) relative errors with their signs
    fields : fields on the levels, if the errors are norms, which have no sign
    """

    name: str
    quantity: str
    theory: Theory
    sizes: Array
    signed_errors: Array
    fields: FieldLevels | None = None

    @property
    def errors(self) -> Array:
        """(n,) absolute values of the relative errors."""
        return np.abs(self.signed_errors)

    @property
    def counted(self) -> NDArray[np.bool_]:
        """(n,) whether the error of a level is above the floor, so that the fit uses it."""
        return self.errors > self.theory.floor

    @property
    def order(self) -> float:
        """Observed order by least squares over the levels above the floor; NaN for only one."""
        return self._fit(slice(None))

    @property
    def last_order(self) -> float:
        """Observed order between the last two levels above the floor."""
        return self._fit(slice(-2, None))

    @property
    def interval(self) -> tuple[float, float]:
        """Confidence interval of the fitted order at the level `CONFIDENCE`.

        It follows from the scatter about the fit, by Student's distribution with n - 2 degrees of
        freedom for n levels. Both ends are NaN for fewer than three levels.
        """
        sizes, errors = self._logarithms(slice(None))
        return slope_interval(sizes, errors)

    def _logarithms(self, levels: slice) -> tuple[Array, Array]:
        sizes, errors = (
            np.log(values[self.counted][levels]) for values in (self.sizes, self.errors)
        )
        return sizes, errors

    def _fit(self, levels: slice) -> float:
        sizes, errors = self._logarithms(levels)
        return float(np.polyfit(sizes, errors, 1)[0]) if len(sizes) > 1 else np.nan

    @property
    def orders(self) -> Array:
        """(n-1,) observed orders between neighbouring levels; NaN at an error of zero."""
        errors = np.where(self.errors > 0, self.errors, np.nan)
        return np.diff(np.log(errors)) / np.diff(np.log(self.sizes))

    @property
    def richardson(self) -> tuple[float, float]:
        """Signed error of Richardson's limit, and the grid convergence index, both relative.

        Both are NaN for fewer than three levels, and if the last three levels do not converge
        monotonically. If errors are norms of fields, the order is computed from the norms of the
        differences between levels. The limit is then a field, and its error is a norm, too.
        """
        undetermined = np.nan, np.nan
        if len(self.sizes) < 3 or not np.isfinite(self.signed_errors[-3:]).all():
            return undetermined
        sizes, errors = self.sizes[-3:], self.signed_errors[-3:]
        previous, last = (
            errors[:-1] - errors[1:] if self.fields is None else self.fields.changes[-2:]
        )

        def misfit(order: float) -> float:
            powers = sizes**order
            return float((powers[0] - powers[1]) * last - (powers[1] - powers[2]) * previous)

        if misfit(LOWEST_ORDER) * misfit(HIGHEST_ORDER) >= 0:
            return undetermined
        order = brentq(misfit, LOWEST_ORDER, HIGHEST_ORDER)
        weight = 1 / ((sizes[1] / sizes[2]) ** order - 1)
        if self.fields is not None:
            index = INDEX_SAFETY_FACTOR * weight * last
            return self.fields.error_of_limit(weight), float(index)
        distance_to_limit = weight * last
        index = INDEX_SAFETY_FACTOR * abs(distance_to_limit) / (1 + errors[2])
        return float(errors[2] - distance_to_limit), float(index)

    @property
    def verdict(self) -> str:
        """Whether the observed orders agree with theory: `yes`, `no`, or why this is undecided.

        It is empty if there is no theory.
        """
        if np.isnan(self.theory.order):
            return ""
        if np.isnan(self.order):
            return "too few levels above the floor"
        deviations = np.array([self.order, self.last_order]) - self.theory.order
        return "yes" if (np.abs(deviations) <= ORDER_TOLERANCE).all() else "no"

    @property
    def label(self) -> str:
        """Label of the curve: family, quantity, observed order, theoretical order and verdict."""
        label = f"{self.name}, {self.quantity}: {self.order:.2f}"
        if not self.verdict:
            return label
        return f"{label} (theory {self.theory.order:.3g}: {self.verdict})"

    def summary(self) -> Row:
        """Return the row of this sequence in the table of orders."""
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
            f"within {ORDER_TOLERANCE}": self.verdict,
            "finest error": f"{self.errors[-1]:.1e}",
            "error of Richardson's limit": limit,
            "grid convergence index": index,
            "floor": self.theory.floor,
            "cause of the floor": self.theory.floor_cause,
            "theory": self.theory.reason,
        }


def slope_interval(x: Array, y: Array) -> tuple[float, float]:
    """Return the confidence interval of the slope of a least-squares line, at level `CONFIDENCE`.

    It uses Student's distribution with n - 2 degrees of freedom. Both ends are NaN for fewer than
    three points.

    Parameters
    ----------
    x, y : (n,) coordinates of the points
    """
    if len(x) < 3:
        return np.nan, np.nan
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    half_width = stdtrit(len(x) - 2, (1 + CONFIDENCE) / 2) * np.sqrt(covariance[0, 0])
    return float(slope - half_width), float(slope + half_width)


def sequences_of(families: Iterable[Family], rows: pd.DataFrame) -> list[Sequence]:
    """Return one sequence for each quantity with a theory in each family, if rows have values."""
    sequences = []
    for family in families:
        family_rows = rows[rows.family == family.name]
        for quantity, theory in family.theory.items():
            levels = family_rows[["size", quantity]].dropna().to_numpy(float)
            if len(levels):
                sequences.append(Sequence(family.name, quantity, theory, *levels.T))
    return sequences


def conclude(sequences: Iterable[Sequence]) -> list[str]:
    """Return a sentence on how many orders agree with theory, and one line for each sequence."""
    sequences = list(sequences)
    verdicts = [sequence.verdict for sequence in sequences if sequence.verdict]
    return [
        f"{verdicts.count('yes')} of {len(verdicts)} orders with a theory are within "
        f"{ORDER_TOLERANCE} of it, by least squares and between the last levels.",
        *(f"{sequence.label}, finest error {sequence.errors[-1]:.1e}" for sequence in sequences),
    ]
