"""By how much results of another program err, in our norms and in words."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...meshes.radial import Array
from ..crosscheck.dataset import Result
from ..methods.norms import Results, differences
from ..problem.face import Face
from ..problem.problem import Problem
from ..problem.quantities import FIELDS
from ..problem.unit_names import UnitNames


@dataclass(frozen=True)
class Verdict:
    """The error of one quantity at one time.

    It is in the norm of the quantity, over what we know.

    Parameters
    ----------
    solver, quantity, time : whose, of what, and when, in the units of the scene
    error : relative, in the norm of the quantity; above zero where theirs is too high, but of
        pressures a root mean square
    stated : relative error of ours, by its own estimate
    radius : where a field is worst; NaN of other quantities
    there : signed error at that radius, of pressures over the pressure there
    within : whether it is within what is allowed
    """

    solver: str
    quantity: str
    time: float
    error: float
    stated: float
    radius: float
    there: float
    within: bool


class SampledFace(Face):
    """The face by the radii that somebody gives, which are its breakpoints.

    Each stands for the area from half-way to its neighbours, as in the rule of trapezoids.
    """

    @cached_property
    def radii(self) -> Array:
        return self.breakpoints

    @cached_property
    def areas(self) -> Array:
        middles = (self.radii[1:] + self.radii[:-1]) / 2
        between = np.concatenate([self.radii[:1], middles, self.radii[-1:]])
        return np.pi * np.diff(between**2) if len(middles) else np.ones(1)


def best(result: Result, quantity: str) -> str:
    """Return which of our methods states the least error of a quantity; empty if none gives it."""
    errors = {
        name: solution.greatest_error(quantity)
        for name, solution in result.solutions.items()
        if quantity in solution.errors and quantity in solution.results
    }
    return min(errors, key=errors.__getitem__, default="")


def reference(result: Result, quantity: str) -> tuple[Results, Array]:
    """Return what we say of a problem, by the method that knows a quantity best, and the error (T,)
    that it states of that; a force that is given has none.
    """
    problem, name = result.scene.problem, best(result, quantity)
    if not name and quantity == "normal_force":
        force = problem.loading.at(problem.times).force
        return {quantity: force, "indentation": force}, np.zeros(len(force))
    if not name:
        return {}, np.empty(0)
    return result.solutions[name].results, result.solutions[name].errors[quantity]


def verdicts(result: Result, name: str, limit: float) -> Iterator[Verdict]:
    """Yield the error of every quantity that a program gives, at each of its times."""
    problem, given = result.scene.problem, result.solutions[name].results
    times, radii = (result.coordinates[dim] for dim in ("time", "radius"))
    for quantity, theirs in given.items():
        ours, stated = reference(result, quantity)
        if not ours:
            continue
        gap = theirs - ours[quantity]
        if quantity not in FIELDS:
            errors = differences({quantity: theirs}, ours, problem.face)[quantity]
            signed = np.copysign(errors, gap)
            for row in np.flatnonzero(np.isfinite(gap)):
                error = float(signed[row])
                numbers = float(times[row]), error, float(stated[row]), np.nan, error
                yield Verdict(name, quantity, *numbers, bool(errors[row] <= limit))
            continue
        # pressures jump where wear does, and have no value there
        inner = problem.merged.ring_edges[1:-1] if quantity == "pressure" else np.empty(0)
        off_edges = (np.abs(problem.radii[:, None] - inner) > 1e-9).all(axis=1)
        for row, compared in enumerate(np.isfinite(gap) & off_edges):
            if compared.any():
                error, at = _of_field(problem, quantity, theirs, ours, row, compared)
                there = np.copysign(error, gap[row, at])
                if quantity == "pressure":
                    there = np.divide(gap[row, at], ours[quantity][row, at] or np.nan)
                else:
                    error = there
                numbers = map(float, (times[row], error, stated[row], radii[at], there))
                yield Verdict(name, quantity, *numbers, bool(abs(error) <= limit))


def _of_field(
    problem: Problem, quantity: str, theirs: Array, ours: Results, row: int, compared: Array
) -> tuple[float, int]:
    """Return the error of a field at a time, and the number of the radius where it is worst."""
    rings, standoff = problem.merged, problem.profile.standoff
    face = SampledFace(problem.radii[compared], rings.ring_edges, rings.at, standoff)
    part = slice(row, row + 1)
    against = {key: ours[key][part] for key in ("time", "pressed")}
    against["indentation"] = np.maximum.accumulate(ours["indentation"])[part]
    against[quantity] = ours[quantity][part, compared]
    values = {quantity: theirs[part, compared]}
    (error,) = differences(values, against, face)[quantity]
    gap = np.abs(values[quantity] - against[quantity])[0]
    worst = np.argmax(gap**2 * face.weights if quantity == "pressure" else gap)
    return float(error), int(np.flatnonzero(compared)[worst])


def in_words(rows: Sequence[Verdict], names: UnitNames) -> str:
    """Return a line on one quantity of a program, from its errors at all times."""
    worst = max(rows, key=lambda row: abs(row.error))
    quantity, when = worst.quantity, f"t = {names.write(worst.time, 'time', 3)}"
    said = f"{quantity.replace('_', ' ')}: "
    stated = f"(ours is known to {worst.stated:.0e})" if worst.stated else "(as the scene gives it)"
    if abs(worst.error) <= worst.stated:
        return f"{said}no error to be seen {stated}"
    if quantity in FIELDS:
        local, size = f" r = {names.write(worst.radius, 'length', 3)}", _percent(worst.error)
        said += f"{_sign(worst.error)} by {size} of the indentation {stated}"
        if quantity == "pressure":
            local += f": {_percent(worst.there)} {_sign(worst.there)}"
            said = f"pressure: off by {size} in the root mean square {stated}"
        return f"{said}, worst at {when},{local}"
    said += f"{_percent(worst.error)} {_sign(worst.error)} {stated}"
    spread = np.ptp([row.error for row in rows])
    if len(rows) > 1 and spread <= 0.1 * abs(worst.error):
        return f"{said}, at all times"
    return f"{said}, {'worst ' if len(rows) > 1 else ''}at {when}"


def _percent(error: float) -> str:
    return f"{100 * abs(error):.2g} %"


def _sign(error: float) -> str:
    return "high" if error > 0 else "low"
