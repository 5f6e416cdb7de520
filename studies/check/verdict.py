"""Measure the errors of another program's results in our norms, and put them into words."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..methods.base import Solution
from ..problem.quantities import FIELDS
from ..problem.unit_names import UnitNames
from ..progress import LOG
from ..sampling.norms import differences
from ..scene.scene import Scene

Solutions = Mapping[str, Solution]
# relative error from which on it is written as a multiple, not in per cent
MULTIPLES_FROM = 10.0


@dataclass(frozen=True)
class Verdict:
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
    radius : radius at which a field is worst, in the units of the scene; NaN for other quantities
    there : signed error at that radius; of pressures, relative to our pressure there
    """

    solver: str
    quantity: str
    within: bool
    time: float
    error: float
    stated: float
    radius: float
    there: float


def best(solutions: Solutions, quantity: str) -> str:
    """Return the method with the smallest error estimate of a quantity; empty if none has one."""
    errors = {
        name: solution.greatest_error(quantity)
        for name, solution in solutions.items()
        if quantity in solution.errors
    }
    return min(errors, key=errors.__getitem__, default="")


def verdicts(scene: Scene, solutions: Solutions, name: str, limit: float) -> Iterator[Verdict]:
    """Yield the error of every quantity of a program, at each of its times.

    Parameters
    ----------
    solutions : of our methods and of the program
    name : of the program
    limit : relative error that is allowed
    """
    problem, results, times = scene.problem, solutions[name].results, scene.wear.times
    rings = problem.merged
    for quantity in filter(partial(best, solutions), results):
        our_solution = solutions[best(solutions, quantity)]
        is_field, our_values = quantity in FIELDS, our_solution.results[quantity]
        compared = np.isfinite(results[quantity] - our_values)
        if quantity == "pressure":
            # the pressure jumps at ring edges and has no value there
            jumps = np.isclose(problem.radii[:, None], rings.ring_edges[1:-1], 0, 1e-9)
            compared &= ~jumps.any(axis=1)
        if not compared.any():
            LOG.warning("%s: no %s can be compared with ours", name, quantity)
            continue
        columns = compared.any(axis=0) if is_field else np.zeros(1, dtype=int)
        radii = problem.radii[columns]
        face = problem.sampled_face(radii)
        theirs, ours = (
            np.where(compared, values, 0.0)[:, columns]
            if is_field
            else np.where(compared, values, 0.0)
            for values in (results[quantity], our_values)
        )
        reference = our_solution.results | {quantity: ours}
        errors = differences({quantity: theirs}, reference, face)[quantity]
        gaps = (theirs - ours).reshape(len(times), -1)
        # where nothing presses, there is no value to which an error could be relative
        unbounded = (errors == 0) & (np.abs(gaps) > 1e-9 * np.abs(ours).max()).any(axis=1)
        errors = np.where(unbounded, np.inf, errors)
        sizes = np.abs(gaps) * (np.sqrt(face.wear) if quantity == "pressure" else 1.0)
        worst = np.arange(len(times)), sizes.argmax(axis=1)
        local = np.copysign(errors, gaps[worst])
        signed = local
        if quantity == "pressure":
            signed, local = errors, gaps[worst] / np.where(ours[worst], ours[worst], np.nan)
        for row in np.flatnonzero(compared.reshape(len(times), -1).any(axis=1)):
            radius = radii[worst[1][row]] * problem.units.length if is_field else np.nan
            stated = our_solution.errors[quantity][row]
            numbers = map(float, (times[row], signed[row], stated, radius, local[row]))
            yield Verdict(name, quantity, bool(errors[row] <= max(limit, stated)), *numbers)


def in_words(rows: Sequence[Verdict], names: UnitNames) -> str:
    """Return a line on the errors of one quantity of a program, from its verdicts at all times."""
    worst = max(rows, key=lambda row: abs(row.error) - row.stated)
    quantity, time = worst.quantity, f"t = {names.write(worst.time, 'time', 3)}"
    line = f"{quantity.replace('_', ' ')}: "
    estimate = "(our value is given by the scene)"
    if worst.stated:
        estimate = f"(our error estimate: {worst.stated:.0e})"
    if np.isinf(worst.error):
        return f"{line}not zero although nothing presses, at {time}"
    if abs(worst.error) <= worst.stated:
        return f"{line}no error found {estimate}"
    if quantity in FIELDS:
        place, size = f" r = {names.write(worst.radius, 'length', 3)}", _percent(worst.error)
        line += f"{_sign(worst.error)} by {size} of the indentation {estimate}"
        if quantity == "pressure":
            # there is no relative error where our pressure is 0
            if np.isfinite(worst.there):
                place += f": {_percent(worst.there)} {_sign(worst.there)}"
            line = f"pressure: root mean square error of {size} {estimate}"
        return f"{line}, worst at {time},{place}"
    line += f"{_percent(worst.error)} {_sign(worst.error)} {estimate}"
    spread = np.ptp([row.error for row in rows])
    if len(rows) > 1 and spread <= 0.1 * abs(worst.error):
        return f"{line}, at all times"
    return f"{line}, {'worst ' if len(rows) > 1 else ''}at {time}"


def _percent(error: float) -> str:
    """Return an error in per cent, or as a multiple of our value if it is large."""
    if abs(error) >= MULTIPLES_FROM:
        return f"{abs(error):.2g} times"
    per_cent = 100 * abs(error)
    return f"{per_cent:.0f} %" if per_cent >= 10 else f"{per_cent:.2g} %"


def _sign(error: float) -> str:
    return "too high" if error > 0 else "too low"
