"""Tell whether the pressures of another program are a sawtooth of too long a wear step."""

from typing import TYPE_CHECKING

import numpy as np

from ..crosscheck import Scene
from ..estimate.diagnose import CONSISTENT, EXPLAINS, Diagnosis
from ..wear_step.elements import ELEMENTS
from ..wear_step.sawtooth import Sawtooth, find
from .other_program import OtherProgram

if TYPE_CHECKING:
    from .errors import ErrorAtTime

TOO_LONG = "wear step too long"
"""Name of the mistake."""


def sawtooth_of(scene: Scene, program: OtherProgram, element: str | None) -> Sawtooth | None:
    """Return the sawtooth in the last rows of a program, and the step that its mesh allows.

    Parameters
    ----------
    scene : the scene, at the times and radii of all programs
    program : its results
    element : element of the program, if it is known
    """
    table = program.pressures(scene)
    if table is None:
        return None
    problem, (times, radii, pressures) = scene.problem, table
    area = np.pi * (1 - problem.inner_radius**2)
    mean = float(problem.loading.at(times[-1:]).force[0]) / area
    found = find(times, pressures, mean)
    if found is None or problem.loading.varies or not problem.full_contact:
        return found
    # it loads scikit-fem, which tables without a sawtooth do not need
    from ..wear_step.models import limit_of_models

    limit, model = limit_of_models(problem, times, radii, pressures, element)
    return Sawtooth(found.size, found.number, found.step, limit, model)


def diagnosis_of(
    scene: Scene, program: OtherProgram, found: Sawtooth, rows: "list[ErrorAtTime]", within: float
) -> Diagnosis:
    """Return the mistake of too long a wear step, in words.

    Parameters
    ----------
    scene, program : as in `sawtooth_of`
    found : the sawtooth
    rows : errors of the program
    within : allowed relative error
    """
    names, units = scene.unit_names, scene.problem.units
    table = program.pressures(scene)
    assert table is not None
    radius = names.write(float(table[1][found.number]) * units.length, "length", 3)
    histories = [abs(row.error) for row in rows if not np.isfinite(row.radius)]
    remaining = max(histories, default=0.0)
    right = "indentation and force are right, but the pressures are not: " if histories else ""
    if remaining > within:
        right = ""
    step = names.write(found.step * units.time, "time", 3)
    allowed = ""
    if np.isfinite(found.limit):
        limit = names.write(found.limit * units.time, "time", 2)
        allowed = f", at most about {limit} for {found.element} with nodes at these radii"
    text = (
        f"{right}at r = {radius} the pressure jumps up and down from row to row, by "
        f"{100 * found.size:.2g} % of the mean pressure, as if the wear step of {step} were longer "
        f"than the mesh allows{allowed}"
    )
    element = f" --element {found.element}" if found.element in ELEMENTS else ""
    return Diagnosis(
        TOO_LONG,
        found.limit * units.time,
        np.nan,
        np.nan,
        1.0,
        EXPLAINS if histories and remaining <= within else CONSISTENT,
        text,
        remaining,
        "",
        "update the wear in half the step, or less: the sawtooth decays; ringwear plan SCENE "
        f"--mesh FILE{element} gives the longest stable step of your mesh",
        program.name,
    )
