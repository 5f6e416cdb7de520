"""The tolerances of a work-precision diagram for each kind of contact, and the expected seconds.

A flat punch takes milliseconds at any tolerance. Moving contact is marched with dense matrices on
cells: it has fewer tolerances, because its seconds grow faster with them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

EXPECTED_SECONDS = {"mdr": 0.05, "bem": 0.05, "fem": 0.2, "mdr-grid": 0.3, "naive": 0.3}
"""Seconds of a run of a flat punch at the coarsest level, by method."""
EXPECTED_PRICE = 1.4
"""Factor by which one more digit of the tolerance multiplies the expected seconds."""
EXPECTED_SECONDS_SHAPED = {1e-1: 1.0, 1e-2: 1.0, 3e-3: 2.5, 1e-3: 6.0}
"""Seconds of a run of a shaped punch by MDR, by tolerance; finite elements take twice as long."""


@dataclass(frozen=True, eq=False)
class Tolerances:
    """The tolerances of a diagram, and the expected seconds of its levels.

    Parameters
    ----------
    full, quick : tolerances of the levels, of the full and of the quick study
    reference, quick_reference : tolerance of the references that errors are measured against
    seconds : function (method, tolerance) -> expected seconds of a run; the tolerance is NaN if the
        level sets sizes or steps instead
    with_full_contact_methods : whether the methods for full contact apply: the naive finite
        elements, Euler's marches and the paper's grid
    """

    full: tuple[float, ...]
    quick: tuple[float, ...]
    reference: float
    quick_reference: float
    seconds: Callable[[str, float], float]
    with_full_contact_methods: bool

    def asked(self, quick: bool) -> tuple[float, ...]:
        """Return the tolerances of the levels."""
        return self.quick if quick else self.full

    def of_reference(self, quick: bool) -> float:
        """Return the tolerance of the references that errors are measured against."""
        return self.quick_reference if quick else self.reference


def _seconds_of_flat(name: str, tolerance: float) -> float:
    """Return the expected seconds of a run of a flat punch."""
    digits = 0.0 if np.isnan(tolerance) else -np.log10(tolerance) - 1
    return float(EXPECTED_SECONDS.get(name, 0.1) * EXPECTED_PRICE**digits)


def _seconds_of_shaped(name: str, tolerance: float) -> float:
    """Return the expected seconds of a run of a shaped punch."""
    seconds = EXPECTED_SECONDS_SHAPED.get(tolerance, 1.0)
    return 2 * seconds if name == "fem" else seconds


# by whether the punch is in full contact
TOLERANCES = {
    True: Tolerances(
        full=tuple(10.0**-digits for digits in range(1, 9)),
        quick=tuple(10.0**-digits for digits in range(1, 4)),
        reference=1e-9,
        quick_reference=1e-6,
        seconds=_seconds_of_flat,
        with_full_contact_methods=True,
    ),
    # a run at 1e-1 is refined to a tenth of that at most; sizes follow rtol up to a greatest
    # number of cells
    False: Tolerances(
        full=(1e-1, 1e-2, 3e-3, 1e-3),
        quick=(1e-1, 1e-2),
        reference=1e-5,
        quick_reference=1e-4,
        seconds=_seconds_of_shaped,
        with_full_contact_methods=False,
    ),
}
