"""What a digit costs, and by how much methods overstate their errors.

The price of a digit is the factor by which one more correct digit multiplies the seconds. It is
fitted by least squares: ``log10 seconds = a + b digits``, with digits = -log10 of the true error,
gives the price ``10^b``, and the interval of b gives that of the price.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ...meshes.radial import Array
from ..study.orders import CONFIDENCE, slope_interval

LEAST_LEVELS = 3
"""Levels of different errors that a price of a digit needs: two have no scatter."""

LEAST_DIGITS = 0.5
"""Digits between the errors of all levels that a price needs: less is no gain to be paid for."""


HOPELESS = 1000
"""Greatest end of an interval that is told; seconds beyond do not follow the errors at all."""


@dataclass(frozen=True)
class DigitPrice:
    """The factor by which one more correct digit multiplies the seconds.

    Parameters
    ----------
    levels : of different errors
    digits : between the greatest and the least error
    price : by least squares; NaN of fewer than `LEAST_LEVELS` levels
    lower, upper : ends of its interval, of `CONFIDENCE`; NaN of fewer than `LEAST_LEVELS` levels
    """

    levels: int
    digits: float = 0.0
    price: float = np.nan
    lower: float = np.nan
    upper: float = np.nan

    @property
    def why_not(self) -> str:
        """Why the price cannot be told; empty if it can."""
        if self.levels < LEAST_LEVELS:
            return f"fewer than {LEAST_LEVELS} levels of different errors"
        if self.lower <= 1 <= self.upper:
            ends = f"from {self.lower:.2g} to {self.upper:.2g}"
            if self.upper > HOPELESS:
                ends = f"beyond {HOPELESS:g}"
            return f"the interval reaches {ends}, and contains 1"
        if self.upper < 1:
            return "errors do not fall as seconds grow"
        if self.digits < LEAST_DIGITS:
            return f"all errors lie within {self.digits:.2g} digits"
        return ""

    @property
    def in_words(self) -> str:
        """The price with its interval, or why it cannot be told."""
        if self.why_not:
            return f"cannot be told: {self.why_not}"
        return f"{self.price:.3g}, interval {self.lower:.4g} to {self.upper:.4g}"


def fit_digit_price(seconds: Array, errors: Array) -> DigitPrice:
    """Return the price of a digit by the seconds and the true errors of some levels.

    Parameters
    ----------
    seconds, errors : (n,) of the levels; errors that are zero or not finite are left out
    """
    counted = (errors > 0) & np.isfinite(errors)
    # a tolerance that changes nothing repeats a level, and says nothing about digits
    _, first = np.unique(errors[counted], return_index=True)
    if len(first) < LEAST_LEVELS:
        return DigitPrice(len(first))
    digits = -np.log10(errors[counted][first])
    logarithms = np.log10(seconds[counted][first])
    slope = np.polyfit(digits, logarithms, 1)[0]
    interval = slope_interval(digits, logarithms)
    # slopes over digits that hardly differ are without bound
    with np.errstate(over="ignore"):
        price, lower, upper = np.power(10.0, [slope, *interval])
    return DigitPrice(len(first), float(np.ptp(digits)), float(price), float(lower), float(upper))


def list_prices(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the price of a digit for each group of quantities and each method.

    Parameters
    ----------
    rows : levels with columns `group`, `method`, `seconds` and `error`
    """
    found = []
    for (group, name), levels in rows.groupby(["group", "method"], sort=False):
        price = fit_digit_price(*levels[["seconds", "error"]].to_numpy(float).T)
        found.append(
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
    return pd.DataFrame(found)


def list_effectivities(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the effectivities of each group and method that is asked for a tolerance.

    The effectivity is the error that the method states over its true error.

    Parameters
    ----------
    rows : levels with columns `group`, `method`, `tolerance`, `estimate`, `error`, `effectivity`
    """
    found = []
    asked = rows.dropna(subset=["tolerance", "effectivity"])
    for (group, name), levels in asked.groupby(["group", "method"], sort=False):
        missed = levels.error > levels.tolerance
        found.append(
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
    return pd.DataFrame(found)


def conclude_prices(prices: pd.DataFrame) -> Iterator[str]:
    """Yield a sentence about the price of a digit for each group of quantities and each method."""
    for row in prices.to_dict("records"):
        words = str(row["in words"])
        who = f"{row['group']}, {row['method']}"
        if words.startswith("cannot be told"):
            yield f"{who}: what one more digit costs {words}."
        else:
            factor, _, interval = words.partition(", ")
            yield f"{who}: one more digit multiplies the seconds by {factor} ({interval})."


def conclude_effectivities(effectivities: pd.DataFrame) -> Iterator[str]:
    """Yield how stated errors compare with true ones, and how often a tolerance is missed."""
    if not len(effectivities):
        return
    for group, rows in effectivities.groupby("group", sort=False):
        medians = ", ".join(
            f"{of:.3g} ({name})"
            for name, of in zip(rows.method, rows["median effectivity"], strict=True)
        )
        yield f"{group}: the stated error over the true one is {medians} in the median."
    missed, stated, levels = (
        int(effectivities[name].sum())
        for name in ("levels beyond the tolerance", "of these, stated", "levels")
    )
    yield (
        f"In {missed} of {levels} levels the true error is above the tolerance asked for; in "
        f"{stated} of these the method states so."
    )
