"""Ticks with few and short labels: round numbers of up to three digits, and powers of ten."""

from collections.abc import Sequence
from math import isclose

import numpy as np
from matplotlib.ticker import LogLocator, MaxNLocator

# number of digits of a label
DIGITS = 3
# range of numbers that are printed without a power of ten
SMALLEST, LARGEST = 1e-3, 1e5
# steps between ticks of linear axes, times powers of ten
STEPS = [1, 2, 5, 10]
# greatest number of round numbers on a logarithmic axis with fewer than two powers of ten
MOST_ROUND = 4
# ticks closer to 0 than this, over the span of the axis, are 0
ROUNDOFF = 1e-9
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Decades(LogLocator):
    """Ticks at powers of ten, or at a few round numbers if fewer than two powers are in view."""

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        """Return the ticks between two ends of an axis, and maybe some beyond them."""
        ticks = super().tick_values(vmin, vmax)
        if sum(vmin <= tick <= vmax for tick in ticks) > 1:
            return ticks
        low, high = np.floor(np.log10([vmin, vmax]))
        rounded = np.outer(10.0 ** np.arange(low, high + 1), [1, 2, 5]).ravel()
        shown = [tick for tick in rounded.tolist() if vmin <= tick <= vmax]
        if len(shown) > 1:
            return shown[:: -(-len(shown) // MOST_ROUND)]
        return MaxNLocator(MOST_ROUND, steps=STEPS).tick_values(vmin, vmax)


def tick_label(value: float, span: float) -> str:
    """Return the label of a tick of a linear axis; empty if it would have more than three digits.

    Ticks without a label lie between others with one. Locators miss 0 by roundoff of the `span` of
    the axis.
    """
    if abs(value) < ROUNDOFF * span:
        return "0"
    return short_number(value) if isclose(value, float(f"{value:.{DIGITS}g}"), rel_tol=1e-6) else ""


def short_number(value: float) -> str:
    """Return a number of up to three digits as text: 0.25, 12000, 2·10⁻⁵."""
    rounded = float(f"{value:.{DIGITS}g}") + 0.0
    if not rounded or SMALLEST <= abs(rounded) < LARGEST:
        return f"{rounded:g}".replace("-", "−")
    mantissa, _, exponent = f"{rounded:e}".partition("e")
    return f"{float(mantissa):g}·{_ten_to(int(exponent))}".replace("-", "−")


def one_digit(value: float) -> str:
    """Return a number with one digit as text: 0.02, 2·10⁻⁵, 10⁻⁵."""
    return short_number(float(f"{value:.1g}")).removeprefix("1·")


def power_of_ten(value: float) -> str:
    """Return 0.01 as 10⁻², 0.02 as 2·10⁻², and 2 as 2."""
    exponent = int(np.floor(np.log10(value) + 1e-9))
    mantissa = float(f"{value / 10.0**exponent:.{DIGITS}g}")
    if mantissa == 1:
        return _ten_to(exponent)
    return f"{mantissa:g}·{_ten_to(exponent)}" if exponent else f"{mantissa:g}"


def _ten_to(exponent: int) -> str:
    return "10" + str(exponent).translate(SUPERSCRIPTS)
