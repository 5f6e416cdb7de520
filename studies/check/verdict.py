"""By how much results of another program err, in our norms and in words."""

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
# errors from which on they are told as multiples, not in per cent
MANY = 10.0


@dataclass(frozen=True)
class Verdict:
    """The error of one quantity at one time.

    It is in the norm of the quantity, over what we know.

    Parameters
    ----------
    solver, quantity : whose, and of what
    within : whether it is within what is allowed, or within what ours is known to
    time : when, in the units of the scene
    error : relative, in the norm of the quantity; above zero where theirs is too high, but of
        pressures a root mean square
    stated : relative error of ours, by its own estimate
    radius : where a field is worst; NaN of other quantities
    there : signed error at that radius, of pressures over the pressure there
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
    """Return which method states the least error of a quantity; empty if none does."""
    errors = {
        name: solution.greatest_error(quantity)
        for name, solution in solutions.items()
        if quantity in solution.errors
    }
    return min(errors, key=errors.__getitem__, default="")


def verdicts(scene: Scene, solutions: Solutions, name: str, limit: float) -> Iterator[Verdict]:
    """Yield the error of every quantity that a program gives, at each of its times."""
    problem, given, times = scene.problem, solutions[name].results, scene.wear.times
    rings = problem.merged
    for quantity in filter(partial(best, solutions), given):
        ours = solutions[best(solutions, quantity)]
        field, exact = quantity in FIELDS, ours.results[quantity]
        compared = np.isfinite(given[quantity] - exact)
        if quantity == "pressure":
            # it jumps at ring edges, and has no value there
            jumps = np.isclose(problem.radii[:, None], rings.ring_edges[1:-1], 0, 1e-9)
            compared &= ~jumps.any(axis=1)
        if not compared.any():
            LOG.warning("%s: no %s where there is one of ours", name, quantity)
            continue
        at = compared.any(axis=0) if field else np.zeros(1, dtype=int)
        radii = problem.radii[at]
        face = problem.sampled_face(radii)
        theirs, right = (
            np.where(compared, values, 0.0)[:, at] if field else np.where(compared, values, 0.0)
            for values in (given[quantity], exact)
        )
        errors = differences({quantity: theirs}, ours.results | {quantity: right}, face)[quantity]
        gaps = (theirs - right).reshape(len(times), -1)
        # where nothing presses there is nothing that errors could be relative to
        wrong = (errors == 0) & (np.abs(gaps) > 1e-9 * np.abs(right).max()).any(axis=1)
        errors = np.where(wrong, np.inf, errors)
        sizes = np.abs(gaps) * (np.sqrt(face.wear) if quantity == "pressure" else 1.0)
        worst = np.arange(len(times)), sizes.argmax(axis=1)
        local = np.copysign(errors, gaps[worst])
        signed = local
        if quantity == "pressure":
            signed, local = errors, gaps[worst] / np.where(right[worst], right[worst], np.nan)
        for row in np.flatnonzero(compared.reshape(len(times), -1).any(axis=1)):
            place = radii[worst[1][row]] * problem.units.length if field else np.nan
            stated = ours.errors[quantity][row]
            numbers = map(float, (times[row], signed[row], stated, place, local[row]))
            yield Verdict(name, quantity, bool(errors[row] <= max(limit, stated)), *numbers)


def in_words(rows: Sequence[Verdict], names: UnitNames) -> str:
    """Return a line on one quantity of a program, from its errors at all times."""
    worst = max(rows, key=lambda row: abs(row.error) - row.stated)
    quantity, when = worst.quantity, f"t = {names.write(worst.time, 'time', 3)}"
    said = f"{quantity.replace('_', ' ')}: "
    stated = f"(ours is known to {worst.stated:.0e})" if worst.stated else "(as the scene gives it)"
    if np.isinf(worst.error):
        return f"{said}not zero where nothing presses, at {when}"
    if abs(worst.error) <= worst.stated:
        return f"{said}no error to be seen {stated}"
    if quantity in FIELDS:
        local, size = f" r = {names.write(worst.radius, 'length', 3)}", _percent(worst.error)
        said += f"{_sign(worst.error)} by {size} of the indentation {stated}"
        if quantity == "pressure":
            # where ours is 0 there is nothing to be relative to
            if np.isfinite(worst.there):
                local += f": {_percent(worst.there)} {_sign(worst.there)}"
            said = f"pressure: off by {size} in the root mean square {stated}"
        return f"{said}, worst at {when},{local}"
    said += f"{_percent(worst.error)} {_sign(worst.error)} {stated}"
    spread = np.ptp([row.error for row in rows])
    if len(rows) > 1 and spread <= 0.1 * abs(worst.error):
        return f"{said}, at all times"
    return f"{said}, {'worst ' if len(rows) > 1 else ''}at {when}"


def _percent(error: float) -> str:
    """Return an error in per cent, or as a multiple of the right value, if it is that large."""
    if abs(error) >= MANY:
        return f"{abs(error):.2g} times"
    per_cent = 100 * abs(error)
    return f"{per_cent:.0f} %" if per_cent >= 10 else f"{per_cent:.2g} %"


def _sign(error: float) -> str:
    return "high" if error > 0 else "low"
