"""Check whether results of one program on finer and finer meshes converge to ours.

The results are ordered from coarse to fine. The signed errors are the program's values minus ours.
Differences between two of its results are therefore differences of these errors, and the order,
Richardson's limit and the grid convergence index follow from the errors exactly as they would from
the results (`studies/study/extrapolation.py`). The index is then compared with the true error.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...meshes import Array
from ..crosscheck import FIELDS, UnitNames
from ..study.extrapolation import order_of_errors, orders_between, richardson
from .errors import ErrorAtTime

# least order of errors of a mesh that converge
LEAST_ORDER = 0.5


@dataclass(frozen=True, eq=False)
class Refinement:
    """The errors of one quantity in results from coarse to fine.

    Parameters
    ----------
    quantity : name of the quantity
    time : time at which the finest result is worst, in the units of the scene
    sizes : (n,) sizes of elements or steps
    signed_errors : (n,) relative errors at that time, with their signs
    floor : our own error estimate; smaller errors are not counted
    """

    quantity: str
    time: float
    sizes: Array
    signed_errors: Array
    floor: float

    @property
    def errors(self) -> Array:
        """(n,) absolute values of the relative errors."""
        return np.abs(self.signed_errors)

    @property
    def counted(self) -> NDArray[np.bool_]:
        """(n,) whether an error is above the floor, so that orders use it."""
        return self.errors > self.floor

    @property
    def order(self) -> float:
        """Order by least squares over the errors that are counted; NaN for only one."""
        return order_of_errors(self.sizes[self.counted], self.errors[self.counted]).order

    @property
    def orders(self) -> Array:
        """(n-1,) orders between neighbouring sizes; NaN at an error of zero."""
        return orders_between(self.sizes, np.where(self.errors > 0, self.errors, np.nan))

    @property
    def estimate(self) -> tuple[float, float]:
        """Signed error of Richardson's limit, and the grid convergence index, both relative.

        Both are NaN for fields, for fewer than three results, and if the last three results do not
        converge in one direction.
        """
        if self.quantity in FIELDS:
            return np.nan, np.nan
        return richardson(self.sizes, self.signed_errors)

    @property
    def stalled(self) -> float:
        """First size after which the order is below half of the best one before; NaN if none is."""
        slow = self.orders < 0.5 * np.fmax.accumulate(self.orders)
        slow &= self.counted[1:]
        return float(self.sizes[:-1][slow][0]) if slow.any() else np.nan

    @property
    def converges(self) -> bool:
        """Whether all errors are counted, and decrease with each size, without stalling."""
        falling = bool(self.counted.all() and (np.diff(self.errors) < 0).all())
        return falling and self.order > LEAST_ORDER and not np.isfinite(self.stalled)

    def label(self, names: UnitNames) -> str:
        """Return the quantity and the time in words."""
        quantity = self.quantity.replace("_", " ")
        return f"{quantity} at t = {names.write(self.time, 'time', 3)}"

    def in_words(self, names: UnitNames) -> str:
        """Return a line on the order, the errors and the grid convergence index."""
        limit, index = self.estimate
        orders = ", ".join(order_in_words(order) for order in self.orders)
        line = (
            f"{self.label(names)}: order {order_in_words(self.order)} (between successive "
            f"sizes: {orders}), errors {self.errors[0]:.1e} to {self.errors[-1]:.1e}"
        )
        if not self.counted.all():
            line += f", some below the error estimate of our value ({self.floor:.0e})"
        if np.isfinite(self.stalled):
            line += f", convergence stalls from size {self.stalled:.3g} on"
        if np.isnan(index):
            return line
        judgement = "large enough" if index >= self.errors[-1] else "TOO SMALL"
        return (
            f"{line}; Richardson's limit errs by {abs(limit):.1e}; the grid convergence index of "
            f"{index:.1e} is {judgement} for the true error of {self.errors[-1]:.1e}"
        )


def refinements(
    rows: Sequence[ErrorAtTime], names: Sequence[str], sizes: Sequence[float]
) -> Iterator[Refinement]:
    """Yield the refinement of each quantity that all results have.

    Each is taken at the time at which the finest result is worst.

    Parameters
    ----------
    rows : errors of all results
    names : of the results, from coarse to fine
    sizes : of elements or steps, one for each result
    """
    for quantity in dict.fromkeys(row.quantity for row in rows):
        by_time = [
            {row.time: row for row in rows if (row.solver, row.quantity) == (name, quantity)}
            for name in names
        ]
        if times := set.intersection(*map(set, by_time)):
            time = max(times, key=lambda time: abs(by_time[-1][time].error))
            levels = [errors[time] for errors in by_time]
            signed = np.array([row.error for row in levels])
            floor = max(row.stated for row in levels)
            yield Refinement(quantity, time, np.array(sizes), signed, floor)


def order_in_words(order: float) -> str:
    """Return an order of convergence as text, with at most two decimals."""
    # an order of -0.001 is 0
    return "unknown" if np.isnan(order) else f"{round(order, 2) or 0.0:.2g}"
