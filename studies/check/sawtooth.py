"""Tell whether the pressures of another program are a sawtooth of too long a wear step.

An update that is too long for a mesh makes the pressure of a node jump up and down from row to row.
Where negative pressures are set to zero, the jumps saturate between zero and about twice the right
pressure, and the indentation remains right. The tables have consecutive updates.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from ...meshes import Array
from ..estimate.compared import Comparison
from ..estimate.diagnosis import EXPLAINS, REDUCES, Diagnosis
from ..study.own import ELEMENTS
from .other_program import ROWS

if TYPE_CHECKING:
    from .errors import ErrorAtTime

TOO_LONG = "wear step too long"
"""Name of the mistake."""
SMALL, STEADY_RATIO = 0.02, 0.97
"""Least size of jumps over the mean pressure, and least ratio of successive jumps: small ones must
not decay. Noise has the ratio 2/3."""
LARGE, LASTING_RATIO, LASTING_GROWTH = 0.1, 0.7, 0.85
"""The same for jumps that may be irregular but must last, and least size of the later ones over the
earlier ones."""
LAST_ROWS = 40
"""Number of the last rows in which a sawtooth is sought, and to which models are compared."""
FEWEST_RADII = 3
"""Least number of radii of a table."""


class Sawtooth(NamedTuple):
    """Pressures that jump up and down from update to update.

    Parameters
    ----------
    size : of the jumps at the worst radius, over the mean pressure
    number : number of that radius
    step : mean step between the rows
    """

    size: float
    number: int
    step: float


def find(times: Array, pressures: Array, mean: float) -> Sawtooth | None:
    """Return the last sawtooth in a table; None without one.

    Far beyond the limit pressures are irregular, and some rows show it, but others do not.

    Parameters
    ----------
    times : (T,) increasing
    pressures : (T, R) pressures of nodes, from inside to outside
    mean : mean pressure
    """
    if pressures.shape[1] < FEWEST_RADII:
        return None
    ends = range(len(times), ROWS - 1, -ROWS // 2)
    windows = (slice(end - ROWS, end) for end in ends)
    found = (_in_rows(times[rows], pressures[rows], mean) for rows in windows)
    return next(filter(None, found), None)


def _in_rows(times: Array, pressures: Array, mean: float) -> Sawtooth | None:
    """Return the sawtooth in some rows; None if there is none."""
    # half the distances (T - 2, R) from lines through the rows before and after
    shares = ((times[1:-1] - times[:-2]) / (times[2:] - times[:-2]))[:, None]
    bent = (pressures[1:-1] - (1 - shares) * pressures[:-2] - shares * pressures[2:]) / 2
    alternates = (bent[1:] * bent[:-1] < 0).all(axis=0)
    sizes = np.where(alternates, np.median(np.abs(bent), axis=0), 0.0) / mean
    number = int(sizes.argmax())
    near = bent[:, max(0, number - 1) : number + 2]
    squares, half = (near**2).sum(axis=1), len(near) // 2
    if not squares[:-1].sum() > 0 or not squares[:half].sum() > 0:
        return None
    ratio = -(near[1:] * near[:-1]).sum() / squares[:-1].sum()
    growth = np.sqrt(squares[-half:].sum() / squares[:half].sum())
    size = float(sizes[number])
    steady = size > SMALL and ratio > STEADY_RATIO
    lasting = size > LARGE and ratio > LASTING_RATIO and growth > LASTING_GROWTH
    if not (steady or lasting):
        return None
    return Sawtooth(size, number, float(np.diff(times).mean()))


def mistake_of_steps(
    comparison: Comparison,
    rows: "list[ErrorAtTime]",
    within: float,
    element: str | None,
) -> list[Diagnosis]:
    """Return the mistake of too long a wear step, if the last rows of a program have a sawtooth.

    Parameters
    ----------
    comparison : results of the program and ours
    rows : errors of the program
    within : allowed relative error
    element : element of the program, if it is known
    """
    if not (given := comparison.pressures):
        return []
    scene, (times, radii, pressures) = comparison.scene, given
    problem, names = scene.problem, scene.unit_names
    area = np.pi * (1 - problem.inner_radius**2)
    mean = float(problem.loading.at(times[-1:]).force[0]) / area
    # without rows and radii that have no values
    table = pd.DataFrame(pressures, times, radii).dropna(how="all").dropna(axis="columns")
    table = table.tail(LAST_ROWS)
    times, radii, pressures = (np.asarray(each) for each in (table.index, table.columns, table))
    if (found := find(times, pressures, mean)) is None:
        return []
    limit, model, allowed = np.nan, "", ""
    if problem.full_contact and not problem.loading.varies:
        # it loads scikit-fem, which tables without a sawtooth do not need
        from ..wear_step.models import limit_of_models

        limit, model = limit_of_models(problem, times, radii, pressures, element)
    if np.isfinite(limit):
        longest = names.write(limit * problem.units.time, "time", 2)
        allowed = f", at most about {longest} for {model} with nodes at these radii"
    radius = names.write(float(radii[found.number]) * problem.units.length, "length", 3)
    histories = [abs(row.error) for row in rows if not np.isfinite(row.radius)]
    remaining = max(histories, default=0.0)
    explains = bool(histories) and remaining <= within
    right = "indentation and force are right, but the pressures are not: " if explains else ""
    step = names.write(found.step * problem.units.time, "time", 3)
    text = (
        f"{right}at r = {radius} the pressure jumps up and down from row to row, by "
        f"{100 * found.size:.2g} % of the mean pressure, as if the wear step of {step} were longer "
        f"than the mesh allows{allowed}"
    )
    option = f" --element {model}" if model in ELEMENTS else ""
    diagnosis = Diagnosis(
        TOO_LONG,
        limit * problem.units.time,
        EXPLAINS if explains else REDUCES,
        text,
        max((abs(row.error) for row in rows if np.isfinite(row.error)), default=remaining),
        remaining,
        "update the wear in half the step, or less: the sawtooth decays; ringwear plan SCENE "
        f"--mesh FILE{option} gives the longest stable step of your mesh",
    )
    return [diagnosis]
