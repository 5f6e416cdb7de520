"""The tolerances of a work-precision diagram, by the kind of contact, and what a level costs.

A flat punch takes milliseconds at any tolerance. A contact that moves is marched with dense
matrices on cells, so that it has fewer tolerances, and its seconds grow faster with them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT

EXPECTED_SECONDS = {"mdr": 0.05, "bem": 0.05, "fem": 0.2, "mdr-grid": 0.3, "naive": 0.3}
"""Seconds of a run of a flat punch at the coarsest level."""
EXPECTED_PRICE = 1.4
"""Factor by which one more digit asked for multiplies the expected seconds."""
EXPECTED_SHAPED = {1e-1: 1.0, 1e-2: 1.0, 3e-3: 2.5, 1e-3: 6.0}
"""Seconds of a run of a shaped punch by MDR, by its tolerance; finite elements take twice."""


@dataclass(frozen=True, eq=False)
class Tolerances:
    """What is asked for in a diagram, and what that costs.

    Parameters
    ----------
    in_full, quick : tolerances that methods are asked for
    reference, quick_reference : accuracy of the solutions that errors are measured by
    seconds : expected seconds of a run, by the method and the tolerance, NaN if sizes or steps are
        set
    knows_others : whether the naive finite elements, Euler's marches and the paper's grid can
        solve such a contact
    """

    in_full: tuple[float, ...]
    quick: tuple[float, ...]
    reference: float
    quick_reference: float
    seconds: Callable[[str, float], float]
    knows_others: bool

    def asked(self, quick: bool) -> tuple[float, ...]:
        """Return the tolerances that methods are asked for."""
        return self.quick if quick else self.in_full

    def of_reference(self, quick: bool) -> float:
        """Return the accuracy of the solutions that errors are measured by."""
        return self.quick_reference if quick else self.reference


def _seconds_of_flat(name: str, tolerance: float) -> float:
    digits = 0.0 if np.isnan(tolerance) else -np.log10(tolerance) - 1
    return float(EXPECTED_SECONDS.get(name, 0.1) * EXPECTED_PRICE**digits)


def _seconds_of_shaped(name: str, tolerance: float) -> float:
    shaped = EXPECTED_SHAPED.get(tolerance, 1.0)
    return 2 * shaped if name == "fem" else shaped


TOLERANCES = {
    FULL_CONTACT: Tolerances(
        in_full=tuple(10.0**-digits for digits in range(1, 9)),
        quick=tuple(10.0**-digits for digits in range(1, 4)),
        reference=1e-9,
        quick_reference=1e-6,
        seconds=_seconds_of_flat,
        knows_others=True,
    ),
    # the first tolerance is refined to a tenth of itself, and sizes end where cells are too many
    MOVING_CONTACT: Tolerances(
        in_full=(1e-1, 1e-2, 3e-3, 1e-3),
        quick=(1e-1, 1e-2),
        reference=1e-5,
        quick_reference=1e-4,
        seconds=_seconds_of_shaped,
        knows_others=False,
    ),
}
