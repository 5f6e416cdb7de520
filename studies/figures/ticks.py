"""Ticks with few and short labels: round numbers of up to three digits, and powers of ten."""

import numpy as np
from matplotlib.ticker import Locator

from ...meshes import Array

# number of digits of a label
DIGITS = 3
# range of numbers that are printed without a power of ten
SMALLEST, LARGEST = 1e-3, 1e5
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class RoundTicks(Locator):
    """Ticks at multiples of 1, 2 or 5 times a power of ten.

    Parameters
    ----------
    most : greatest number of intervals between ticks
    """

    def __init__(self, most: int) -> None:
        self.most = most

    def __call__(self) -> list[float]:
        """Return the ticks in the view of the axis."""
        return self.tick_values(*self.axis.get_view_interval()) if self.axis else []

    def tick_values(self, vmin: float, vmax: float) -> list[float]:
        """Return the ticks between two ends of an axis."""
        low, high = sorted((vmin, vmax))
        return round_ticks(low, high, self.most).tolist()


class Decades(Locator):
    """Ticks at powers of ten, and at 2 and 5 times these if there is only one.

    Parameters
    ----------
    most : greatest number of ticks
    """

    def __init__(self, most: int) -> None:
        self.most = most

    def __call__(self) -> list[float]:
        """Return the ticks in the view of the axis."""
        return self.tick_values(*self.axis.get_view_interval()) if self.axis else []

    def tick_values(self, vmin: float, vmax: float) -> list[float]:
        """Return the ticks between two ends of an axis."""
        low, high = sorted((vmin, vmax))
        return decades(low, high, self.most).tolist() if low > 0 else []


def round_ticks(low: float, high: float, most: int) -> Array:
    """Return ticks from `low` to `high` that differ in their first three digits.

    There are up to `most` intervals between them, or more if there would be less than two ticks.
    """
    if not high > low:
        return np.array([low])
    rough = (high - low) / most
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough * (1 - 1e-9))
    smallest = smallest_step(low, high)
    step = max(step, smallest)
    first, last = np.ceil(low / step - 1e-6), np.floor(high / step + 1e-6)
    if last <= first and step > smallest:
        return round_ticks(low, high, most + 1)
    # 0, not -0
    return np.arange(first, last + 1) * step + 0.0


def smallest_step(low: float, high: float) -> float:
    """Return one unit of the third digit of the larger of two numbers; 0 if both are 0."""
    largest = max(abs(low), abs(high))
    return float(10.0 ** (np.floor(np.log10(largest) + 1e-9) + 1 - DIGITS)) if largest else 0.0


def decades(low: float, high: float, most: int) -> Array:
    """Return powers of ten from `low` to `high`; if fewer than two, also 2 and 5 times these."""
    first, last = np.ceil(np.log10(low) - 1e-9), np.floor(np.log10(high) + 1e-9)
    if last > first:
        step = max(1.0, np.ceil((last - first + 1) / most))
        return 10.0 ** np.arange(first, last + 1, step)
    parts = np.outer(10.0 ** np.arange(first - 1, last + 1), [1, 2, 5]).ravel()
    return parts[(parts >= low * (1 - 1e-9)) & (parts <= high * (1 + 1e-9))]


MANTISSAS = (
    *((1,), (1, 2, 5), (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9)),
    *(tuple(np.arange(1, 10, 0.1)), tuple(np.arange(1, 10, 0.01))),
)
"""Sets of mantissas of ticks; the first set that yields at least two ticks is used."""


def spread(low: float, high: float, most: int = 5) -> Array:
    """Return 2 to `most` round numbers on a logarithmic axis, powers of ten if two fit."""
    tens = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    for mantissas in MANTISSAS:
        values = np.outer(tens, mantissas).ravel()
        values = values[(low <= values) & (values <= high)]
        if len(values) > 1:
            break
    return values[:: -(-len(values) // most) or 1]


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
    """Return 0.01 as 10⁻², and 0.02 as 2·10⁻²."""
    exponent = int(np.floor(np.log10(value) + 1e-9))
    mantissa = float(f"{value / 10.0**exponent:.{DIGITS}g}")
    return _ten_to(exponent) if mantissa == 1 else f"{mantissa:g}·{_ten_to(exponent)}"


def _ten_to(exponent: int) -> str:
    return "10" + str(exponent).translate(SUPERSCRIPTS)
