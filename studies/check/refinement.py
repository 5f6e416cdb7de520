"""Check whether several results of one program converge, and whether its own estimate is honest.

The results are ordered from coarse to fine. Signed errors are the differences of theirs to ours, so
differences of theirs are differences of errors: the order, Richardson's limit and the grid
convergence index follow from three of them as their program would find them
(`studies/study/orders.py`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..problem.quantities import FIELDS
from ..problem.unit_names import UnitNames
from ..study.levels import Theory
from ..study.orders import Sequence as Levels
from .verdict import Verdict


@dataclass(frozen=True)
class Refinement:
    """One quantity on results from coarse to fine.

    Parameters
    ----------
    sequence : their sizes, and signed errors at a time; what we state of ours is the floor
    time : at which the finest is worst; in the units of the scene
    """

    sequence: Levels
    time: float

    @property
    def estimate(self) -> tuple[float, float]:
        """Signed error of Richardson's limit, and the grid convergence index, both relative.

        Both are NaN for fields, for fewer than three results, and if the last three results do not
        converge in one direction.
        """
        if self.sequence.quantity in FIELDS:
            return np.nan, np.nan
        return self.sequence.richardson

    @property
    def stalled(self) -> float:
        """Size from which on errors fall at less than half the rate before; NaN if they do not."""
        orders = self.sequence.orders
        slow = orders < 0.5 * np.fmax.accumulate(orders)
        slow &= self.sequence.counted[1:]
        return float(self.sequence.sizes[:-1][slow][0]) if slow.any() else np.nan

    def at(self, names: UnitNames) -> str:
        """Return what this is about."""
        quantity = self.sequence.quantity.replace("_", " ")
        return f"{quantity} at t = {names.write(self.time, 'time', 3)}"

    def in_words(self, names: UnitNames) -> str:
        """Return what there is to say, in a line."""
        sequence, (limit, index) = self.sequence, self.estimate
        between = ", ".join(_told(order) for order in sequence.orders)
        line = (
            f"{self.at(names)}: order {_told(sequence.order)} ({between}), errors "
            f"{sequence.errors[0]:.1e} to {sequence.errors[-1]:.1e}"
        )
        if not sequence.counted.all():
            line += f", some below what ours is known to ({sequence.theory.floor:.0e})"
        if np.isfinite(self.stalled):
            line += f", stalls from size {self.stalled:.3g} on"
        if np.isnan(index):
            return line
        honest = "honest" if index >= sequence.errors[-1] else "TOO SMALL"
        return (
            f"{line}; Richardson's limit errs by {abs(limit):.1e}; grid convergence index "
            f"{index:.1e} of an error of {sequence.errors[-1]:.1e}: {honest}"
        )


def refinements(
    rows: Sequence[Verdict], names: Sequence[str], sizes: Sequence[float]
) -> Iterator[Refinement]:
    """Yield each quantity that all results give, at the time at which the finest is worst."""
    for quantity in dict.fromkeys(row.quantity for row in rows):
        errors = [
            {row.time: row for row in rows if (row.solver, row.quantity) == (name, quantity)}
            for name in names
        ]
        if times := set.intersection(*map(set, errors)):
            time = max(times, key=lambda time: abs(errors[-1][time].error))
            at = [of[time] for of in errors]
            theory = Theory(floor=max(row.stated for row in at))
            signed = np.array([row.error for row in at])
            sequence = Levels("theirs", quantity, theory, np.array(sizes), signed)
            yield Refinement(sequence, time)


def _told(order: float) -> str:
    """Return an order in words."""
    return "cannot be told" if np.isnan(order) else f"{order:.2g}"
