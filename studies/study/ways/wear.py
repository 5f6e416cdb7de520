"""Compute the wear of a case on one compliance that a way prescribes."""

import numpy as np

from ....fem import HalfSpace
from ....meshes import Compliance
from ...crosscheck import FullContact, MovingContact, Problem, Results, Solution, press_flat

STEP_LENGTH = 0.6
"""Factor on the lengths of time steps in moving contact, so that cells dominate the error."""


def wear_on(
    problem: Problem, compliance: Compliance, half_space: HalfSpace | None = None
) -> Solution:
    """Return the solution of a case on a compliance; it has no error estimates.

    Full contact is exact in time. Other contact is marched on the cells of the compliance.

    Parameters
    ----------
    problem : problem of the case
    compliance : compliance on a pressure space
    half_space : finite-element half-space from which it is condensed, if there is one
    """
    size = half_space.unknowns if half_space else compliance.space.size
    if not problem.full_contact:
        moving = MovingContact(problem, compliance, step_length=STEP_LENGTH)
        return Solution(
            moving.results | moving.answers,
            moving.compared | moving.answers,
            {},
            {},
            size,
            half_space=half_space,
            evolution=moving.evolution,
        )
    full = FullContact(problem, compliance)
    return Solution(
        full.results | full.answers,
        full.compared | full.answers | start_in_space(problem, compliance, full.compared),
        {},
        {},
        size,
        wear=full.wear,
        half_space=half_space,
    )


def start_in_space(problem: Problem, compliance: Compliance, compared: Results) -> Results:
    """Return the start of a flat punch in the pressure space itself, in place of the fitted one.

    A run computes the start in functions that have its singularity, so that its error would not
    show the elements at the rim.

    Returns
    -------
    results : (T, ...) indentation or force, and pressure; only t = 0 differs from `compared`
    """
    times = compared.get("time", np.zeros(0))
    if not len(times) or times[0] > 0 or not problem.loading.forces[0]:
        return {}
    pressed = press_flat(compliance, problem.indentation)
    force = 1.0 if problem.indentation is not None else float(problem.loading.forces[0])
    starts = {
        "indentation": force * pressed.indentation,
        "normal_force": pressed.force,
        "pressure": force * (compliance.space.matrix(problem.face.radii) @ pressed.pressure),
    }
    names = starts.keys() & compared.keys() - {problem.prescribed}
    return {
        name: np.concatenate([np.asarray(starts[name])[None], compared[name][1:]]) for name in names
    }
