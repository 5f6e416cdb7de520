"""Measure the errors of another program's results in our norms, and put them into words."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from ..crosscheck import FIELDS, LOG, QUANTITIES, Results, Scene, Solution

if TYPE_CHECKING:
    from ..figures.scale import Scale

Solutions = Mapping[str, Solution]
# relative error from which on it is written as a multiple, not in per cent
MULTIPLES_FROM = 10.0


@dataclass(frozen=True)
class ErrorAtTime:
    """The error of one quantity of a program at one time.

    It is measured in the norm of the quantity, relative to our value.

    Parameters
    ----------
    solver, quantity : name of the program, and name of the quantity
    within : whether the error is within the allowed error or our own error estimate
    time : in the units of the scene
    error : relative, in the norm of the quantity; positive where the program's value is too high,
        but always positive for pressures, for which it is a root mean square
    stated : relative error estimate of our value
    radius : radius at which the difference of a field is largest, in the units of the scene; NaN
        for other quantities
    there : signed error at that radius; of pressures, relative to our pressure there
    largest : largest difference at one radius, relative to the same as `error`; of pressures, to
        the root mean square of our pressure
    """

    solver: str
    quantity: str
    within: bool
    time: float
    error: float
    stated: float
    radius: float
    there: float
    largest: float


def best(solutions: Solutions, quantity: str) -> str:
    """Return the method with the smallest error estimate of a quantity; empty if none has one."""
    errors = {
        name: solution.greatest_error(quantity)
        for name, solution in solutions.items()
        if quantity in solution.errors
    }
    return min(errors, key=errors.__getitem__, default="")


def errors_at_times(
    scene: Scene,
    solutions: Solutions,
    theirs: tuple[str, Results],
    limit: float,
    reference: str = "",
) -> Iterator[ErrorAtTime]:
    """Yield the error of every quantity of a program, at each of its times.

    Parameters
    ----------
    solutions : of our methods
    theirs : name and results of the program
    limit : relative error that is allowed
    reference : our method that fields are compared with, as in the figure of the difference; if
        empty, and for all other quantities, the method with the smallest error estimate
    """
    name, results = theirs
    problem, times = scene.problem, scene.wear.times
    rings = problem.merged
    for quantity in filter(partial(best, solutions), results):
        is_field = quantity in FIELDS
        method = reference if is_field and reference else best(solutions, quantity)
        our_solution = solutions[method]
        our_values = our_solution.results[quantity]
        compared = np.isfinite(results[quantity] - our_values)
        if quantity == "pressure":
            # the pressure jumps at ring edges and has no value there
            jumps = np.isclose(problem.radii[:, None], rings.from_axis[1:-1], 0, 1e-9)
            compared &= ~jumps.any(axis=1)
        if not compared.any():
            LOG.warning("%s: no %s can be compared with ours", name, quantity)
            continue
        columns = compared.any(axis=0) if is_field else np.zeros(1, dtype=int)
        radii = problem.radii[columns]
        face = problem.sampled_face(radii)
        values_of_theirs, ours = (
            np.where(compared, values, 0.0)[:, columns]
            if is_field
            else np.where(compared, values, 0.0)
            for values in (results[quantity], our_values)
        )
        reference_values = our_solution.results | {quantity: ours}
        values, norm = {quantity: values_of_theirs}, QUANTITIES[quantity].norm
        errors = QUANTITIES[quantity].difference(values, reference_values, face)
        signed_gaps = (values_of_theirs - ours).reshape(len(times), -1)
        # where nothing presses, there is no value to which an error could be relative
        gaps = np.abs(signed_gaps)
        is_gap = gaps > 1e-9 * np.abs(ours).max()
        errors = np.where((errors == 0) & is_gap.any(axis=1), np.inf, errors)
        if quantity == "pressure":
            gaps = norm.gaps(quantity, values, reference_values, face)
        worst = np.arange(len(times)), gaps.argmax(axis=1)
        local = np.copysign(errors, signed_gaps[worst])
        signed, largest = local, errors
        if quantity == "pressure":
            scale = norm.size(quantity, reference_values, face)[:, 0]
            infinite = np.where(gaps[worst] > 0, np.inf, 0.0)
            sizes = np.divide(gaps[worst], scale, out=infinite, where=scale > 0)
            signed = errors
            local = signed_gaps[worst] / np.where(ours[worst], ours[worst], np.nan)
            largest = np.where(np.isinf(errors), np.inf, sizes)
        for row in np.flatnonzero(compared.reshape(len(times), -1).any(axis=1)):
            radius = radii[worst[1][row]] * problem.units.length if is_field else np.nan
            stated = our_solution.errors[quantity][row]
            numbers = times[row], signed[row], stated, radius, local[row], largest[row]
            within = bool(errors[row] <= max(limit, stated))
            yield ErrorAtTime(name, quantity, within, *map(float, numbers))


@dataclass(frozen=True)
class QuantityError:
    """The errors of one quantity of a program, over all times, as texts.

    Parameters
    ----------
    rows : the errors of the quantity, at each of its times
    scale : writes times and radii as the figures do
    """

    rows: Sequence[ErrorAtTime]
    scale: "Scale"

    @property
    def quantity(self) -> str:
        """The name of the quantity in words."""
        return self.rows[0].quantity.replace("_", " ")

    @property
    def within(self) -> bool:
        """Whether the error is within the allowed error at all times."""
        return all(row.within for row in self.rows)

    @property
    def worst(self) -> ErrorAtTime:
        """The error at the time at which it exceeds our error estimate most."""
        return max(self.rows, key=lambda row: abs(row.error) - row.stated)

    @property
    def excess(self) -> float:
        """The greatest error beyond our own error estimate."""
        return abs(self.worst.error) - self.worst.stated

    @property
    def largest(self) -> ErrorAtTime:
        """The error at the time at which the difference at one radius is largest."""
        significant = [row for row in self.rows if abs(row.error) > row.stated]
        return max(significant or self.rows, key=lambda row: row.largest)

    @property
    def found(self) -> bool:
        """Whether the error is larger than our error estimate at some time."""
        return self.excess > 0

    @property
    def error(self) -> str:
        """The greatest error, and its norm."""
        row = self.worst
        if not self.found:
            return "no error found"
        if np.isinf(row.error):
            return "not zero although nothing presses"
        if row.quantity == "pressure":
            return f"root mean square error of {_percent(row.error)}"
        if row.quantity in FIELDS:
            return f"{_sign(row.error)} by {_percent(row.error)} of the indentation"
        return f"{_percent(row.error)} {_sign(row.error)}"

    @property
    def place(self) -> str:
        """When, and at which radius, the error is largest; empty if there is none."""
        row, errors = self.worst, [row.error for row in self.rows]
        if not self.found:
            return ""
        when = self.scale.when(row.time)
        if row.quantity in FIELDS and row.quantity != "pressure" and np.isfinite(row.error):
            return f"{when}, {self.scale.where(row.radius)}"
        # a norm over the face has no radius
        constant = row.quantity not in FIELDS and np.isclose(errors, row.error, 0.1, 0.0).all()
        return "all times" if constant and len(errors) > 1 else when

    @property
    def at_one_radius(self) -> str:
        """The largest difference of pressures at one radius; empty for other quantities."""
        row = self.largest
        if row.quantity != "pressure" or not self.found or np.isinf(self.worst.error):
            return ""
        text = f"{self.scale.when(row.time)}, {self.scale.where(row.radius)}: "
        # there is no relative error where our pressure is 0
        if np.isfinite(row.there):
            text += f"{_percent(row.there)} {_sign(row.there)}, "
        return f"{text}{_percent(row.largest)} of the root mean square pressure"

    @property
    def estimate(self) -> str:
        """Our own error estimate at the time of the greatest error."""
        if not self.worst.stated:
            return "our value is given by the scene"
        return f"our error estimate: {self.worst.stated:.0e}"

    def __str__(self) -> str:
        """Return all of this in one line."""
        line = f"{self.quantity}: {self.error} ({self.estimate})"
        if self.place == "all times":
            line += ", at all times"
        elif self.place:
            line += f", {'largest ' if len(self.rows) > 1 else ''}at {self.place}"
        if self.at_one_radius:
            line += f"; at one radius largest at {self.at_one_radius}"
        return line


def quantity_errors(rows: Iterable[ErrorAtTime], scale: "Scale") -> list[QuantityError]:
    """Return the errors of each quantity of one program, from those at each time."""
    groups = groupby(rows, lambda row: row.quantity)
    return [QuantityError(tuple(group), scale) for _, group in groups]


def _percent(error: float) -> str:
    """Return an error in per cent, or as a multiple of our value if it is large."""
    if abs(error) >= MULTIPLES_FROM:
        return f"{abs(error):.2g} times"
    per_cent = 100 * abs(error)
    return f"{per_cent:.0f} %" if per_cent >= 10 else f"{per_cent:.2g} %"


def _sign(error: float) -> str:
    return "too high" if error > 0 else "too low"
