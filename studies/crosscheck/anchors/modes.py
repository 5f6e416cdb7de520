"""Check the relaxation modes that a history is a sum of."""

import numpy as np

from ..wear.full_contact import RunningIn
from .anchor import Row, Rows
from .reported import ROUNDOFF_TOLERANCE, Reported

# number of random combinations of the modes that are tried, and the seed of their coefficients
COMBINATIONS, SEED = 3, 0
# Part of the slowest relaxation time down to which the compliance is tried: the energy of a faster
# mode is a difference that may lose more digits than the tolerance allows.
FASTEST_TRIED = 1e-5


def check_modes_of_history(report: Reported) -> Rows:
    """Compare random sums of modes with the matrices whose eigenvectors the modes are.

    The pressures p of the modes are orthonormal with the weight k, and their energies with the
    compliance A are the relaxation times T::

        p = sum_i x_i p_i,    int k p^2 dA = sum_i x_i^2,    p . A p = sum_i x_i^2 T_i
    """
    running_in = _running_in(report)
    if running_in is None:
        return
    modes, space = running_in.modes, running_in.compliance.space
    random = np.random.default_rng(SEED)
    coefficients = random.standard_normal((COMBINATIONS, len(modes.relaxation)))
    pressures = running_in.pressures_of_modes(coefficients)
    weighted = (space.mass(report.problem.merged.wear_coefficients) @ pressures.T).T
    value, reference = (pressures * weighted).sum(axis=1), (coefficients**2).sum(axis=1)
    yield Row("modes are orthonormal with the weight k", value, reference, ROUNDOFF_TOLERANCE)
    tried = modes.relaxation >= FASTEST_TRIED * modes.relaxation[0]
    # each mode has the same part of the energy
    scaled = np.where(tried, coefficients / np.sqrt(modes.relaxation), 0.0)
    images = running_in.pressures_of_modes(scaled) @ running_in.compliance.factor.T
    value, reference = (images**2).sum(axis=1), (scaled**2 * modes.relaxation).sum(axis=1)
    yield Row("modes reproduce the compliance", value, reference, ROUNDOFF_TOLERANCE)


def _running_in(report: Reported) -> RunningIn | None:
    """Return the running-in by modes that a history contains; None if it contains none."""
    solution = report.solution
    if report.full_contact:
        return solution.wear if report.has_slid.any() else None
    return solution.evolution.running_in if solution.evolution else None
