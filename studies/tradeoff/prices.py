"""The price of a correct digit in seconds, and the effectivity of error estimates.

The price of a digit is the factor by which one more correct digit multiplies the seconds. It is
fitted by least squares: ``log10 seconds = a + b digits``, with digits = -log10 of the true error,
gives the price ``10^b``, and the interval of b gives the interval of the price.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ..crosscheck import Array
from ..study.orders import CONFIDENCE, slope_interval

LEAST_LEVELS = 3
"""Least number of levels with different errors for a price: two levels have no scatter."""

LEAST_DIGIT_RANGE = 0.5
"""Least range of the errors of all levels, in digits, for a price: a smaller range is no gain."""

UNDETERMINED = "cannot be told"
"""Beginning of the text about a price if it cannot be determined."""

GREATEST_REPORTED_END = 1000
"""Greatest end of an interval that is printed as a number.

If the end is greater, seconds are not related to errors at all.
"""


@dataclass(frozen=True)
class DigitPrice:
    """The factor by which one more correct digit multiplies the seconds.

    Parameters
    ----------
    levels : number of levels with different errors
    digits : range of the errors: log10 of the greatest over the least
    price : by least squares; NaN for fewer than `LEAST_LEVELS` levels
    lower, upper : ends of its `CONFIDENCE` interval; NaN for fewer than `LEAST_LEVELS` levels
    """

    levels: int
    digits: float = 0.0
    price: float = np.nan
    lower: float = np.nan
    upper: float = np.nan

    @property
    def why_not(self) -> str:
        """Reason why the price cannot be determined; empty if it can."""
        if self.levels < LEAST_LEVELS:
            return f"fewer than {LEAST_LEVELS} levels with different errors"
        if self.lower <= 1 <= self.upper:
            ends = f"from {self.lower:.2g} to {self.upper:.2g}"
            if self.upper > GREATEST_REPORTED_END:
                ends = f"to values above {GREATEST_REPORTED_END:g}"
            return f"its interval {ends} contains 1"
        if self.upper < 1:
            return "errors do not fall as seconds grow"
        if self.digits < LEAST_DIGIT_RANGE:
            return f"all errors lie within {self.digits:.2g} digits"
        return ""

    @property
    def in_words(self) -> str:
        """The price with its interval, or the reason why it cannot be determined."""
        if self.why_not:
            return f"{UNDETERMINED}: {self.why_not}"
        return f"{self.price:.3g}, interval {self.lower:.4g} to {self.upper:.4g}"


def fit_digit_price(seconds: Array, errors: Array) -> DigitPrice:
    """Return the price of a digit, fitted to the seconds and the true errors of several levels.

    Parameters
    ----------
    seconds, errors : (n,) of the levels; errors that are zero or not finite are left out
    """
    usable = (errors > 0) & np.isfinite(errors)
    # two tolerances with the same discretisation have the same error: they count as one level
    _, first = np.unique(errors[usable], return_index=True)
    if len(first) < LEAST_LEVELS:
        return DigitPrice(len(first))
    digits = -np.log10(errors[usable][first])
    logarithms = np.log10(seconds[usable][first])
    slope = np.polyfit(digits, logarithms, 1)[0]
    interval = slope_interval(digits, logarithms)
    # if the digits hardly differ, the slope may be so large that its power overflows
    with np.errstate(over="ignore"):
        price, lower, upper = np.power(10.0, [slope, *interval])
    return DigitPrice(len(first), float(np.ptp(digits)), float(price), float(lower), float(upper))


def list_prices(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the price of a digit for each group of quantities and each method.

    Parameters
    ----------
    rows : levels with columns `group`, `method`, `seconds` and `error`
    """
    prices = []
    for (group, name), levels in rows.groupby(["group", "method"], sort=False):
        price = fit_digit_price(*levels[["seconds", "error"]].to_numpy(float).T)
        prices.append(
            {
                "group": group,
                "method": name,
                "levels": price.levels,
                "digits": price.digits,
                "price of a digit": price.price,
                "lower end": price.lower,
                "upper end": price.upper,
                "confidence": CONFIDENCE,
                "in words": price.in_words,
            }
        )
    return pd.DataFrame(prices)


def list_effectivities(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the effectivities of each group and method whose levels have a tolerance.

    The effectivity is the error estimate of the method over its true error.

    Parameters
    ----------
    rows : levels with columns `group`, `method`, `tolerance`, `estimate`, `error`, `effectivity`
    """
    effectivities = []
    with_tolerance = rows.dropna(subset=["tolerance", "effectivity"])
    for (group, name), levels in with_tolerance.groupby(["group", "method"], sort=False):
        missed = levels.error > levels.tolerance
        effectivities.append(
            {
                "group": group,
                "method": name,
                "levels": len(levels),
                "median effectivity": levels.effectivity.median(),
                "least effectivity": levels.effectivity.min(),
                "greatest effectivity": levels.effectivity.max(),
                "levels beyond the tolerance": int(missed.sum()),
                "of these, stated": int((missed & (levels.estimate > levels.tolerance)).sum()),
            }
        )
    return pd.DataFrame(effectivities)


def conclude_prices(prices: pd.DataFrame) -> Iterator[str]:
    """Yield a sentence about the price of a digit for each group of quantities and each method."""
    for row in prices.to_dict("records"):
        words = str(row["in words"])
        group_and_method = f"{row['group']}, {row['method']}"
        if words.startswith(UNDETERMINED):
            yield f"{group_and_method}: the price of a digit {words}."
        else:
            factor, _, interval = words.partition(", ")
            yield (
                f"{group_and_method}: one more digit multiplies the seconds by {factor} "
                f"({interval})."
            )


def conclude_effectivities(effectivities: pd.DataFrame) -> Iterator[str]:
    """Yield the median effectivities, and how often the true error is above the tolerance."""
    if not len(effectivities):
        return
    for group, rows in effectivities.groupby("group", sort=False):
        medians = ", ".join(
            f"{effectivity:.3g} ({name})"
            for name, effectivity in zip(rows.method, rows["median effectivity"], strict=True)
        )
        yield f"{group}: the median ratio of error estimate to true error is {medians}."
    missed, stated, levels = (
        int(effectivities[name].sum())
        for name in ("levels beyond the tolerance", "of these, stated", "levels")
    )
    yield (
        f"The true error is above the tolerance in {missed} of {levels} levels; in {stated} of "
        "these levels the error estimate is above it, too."
    )
