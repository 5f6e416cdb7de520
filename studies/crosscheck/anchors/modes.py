"""Check the relaxation modes that a history is a sum of, and their times."""

import numpy as np

from ....mdr import energy, ring_kernel
from ..wear.time_scale import COARSE, FINE, slowest_relaxation_times
from .anchor import Row, Rows
from .reported import REFERENCE_ERROR_FACTOR, ROUNDOFF_TOLERANCE, Reported

# number of relaxation times that are compared: the independent small problem resolves that many
COMPARED_TIMES = 8
# the small problem is solved on two meshes; a relaxation time is not compared if the relative
# difference of the two is larger than this
LARGEST_MESH_DIFFERENCE = 0.01
# number of random combinations of the modes that are tried, and the seed of their coefficients
COMBINATIONS, SEED = 3, 0
# Part of the slowest relaxation time down to which the compliance is tried: the energy of a faster
# mode is a difference that may lose more digits than the tolerance allows.
FASTEST_TRIED = 1e-5


def check_relaxation_times(report: Reported) -> Rows:
    """Compare relaxation times with those of a small problem that is solved independently.

    A shaped punch has only the slowest time, that of the full face.
    """
    name = "relaxation_time" if report.has("relaxation_time") else "running_in_time"
    times = np.atleast_1d(report.take(name))
    # use another theory than the method does, the same for most of them
    half_space = energy.compliance if report.name == "bem" else ring_kernel.compliance
    rings, ground = report.problem.merged, report.reading.ground
    coarse, fine = (
        slowest_relaxation_times(rings, report.fixed_indentation, sizes, half_space, ground)
        for sizes in (COARSE, FINE)
    )
    stated_errors = np.atleast_1d(report.errors(name)[0])
    reported = int(np.isfinite(times).sum())
    count = min(len(coarse), len(fine), len(stated_errors), reported, COMPARED_TIMES)
    if count:
        mesh_difference = np.abs(coarse[:count] / fine[:count] - 1)
        allowed = (
            np.fmax(stated_errors[:count], report.rtol) + REFERENCE_ERROR_FACTOR * mesh_difference
        )
        # the slowest time is always compared, the others only if the small problem resolves them
        tolerance = np.where(mesh_difference <= LARGEST_MESH_DIFFERENCE, allowed, np.inf)
        tolerance[0] = allowed[0]
        label = "relaxation times, by an independent small problem"
        yield Row(label, times[:count], fine[:count], tolerance)
    if report.has("running_in_time"):
        value = report.take("running_in_time")
        yield Row("running-in time of the answer", value, times[0], ROUNDOFF_TOLERANCE)


def check_modes_of_history(report: Reported) -> Rows:
    """Compare random sums of modes with the matrices whose eigenvectors the modes are.

    The pressures p of the modes are orthonormal with the weight k, and their energies with the
    compliance A are the relaxation times T::

        p = sum_i x_i p_i,    int k p^2 dA = sum_i x_i^2,    p . A p = sum_i x_i^2 T_i
    """
    running_in = report.solution.wear
    if running_in is None or not report.has_slid.any():
        return
    yield Row(
        "modes add up to the flat start", running_in.resolved_fraction, 1.0, ROUNDOFF_TOLERANCE
    )
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
