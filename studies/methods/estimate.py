"""What a method's results are worth, by its own account.

The difference to one coarser discretisation, times one factor.

The coarser one differs in everything (a degree, a layer at every singular point, a pole of the far
field; half the cells where edges of the contact move, and larger steps), so that one difference
holds all parts of the error. The factor was chosen on scenes drawn at random, and checked on
others (`tests/physics/test_estimates.py`).
"""

import numpy as np

from ...meshes.radial import Array
from .evaluation import Evaluation
from .quantities import array, differences, radial_weight

# fields that greatest values are taken from
OF_FIELD = {"displacement_max": "displacement", "steady_displacement_max": "steady_profile"}


def estimate_errors(
    fine: Evaluation, coarse: Evaluation
) -> tuple[dict[str, Array], dict[str, float]]:
    """Return the relative error of each quantity in its norm, and parts of that of the indentation.

    Errors over time are those at the times asked for; parts are the greatest over all times, by
    what causes them.
    """
    problem, errors = fine.problem, {}
    missed = differences(coarse.for_estimate, fine.for_estimate, problem.face)
    if "steady_rms_slope" in missed and "steady_profile" in missed:
        missed["steady_rms_slope"] = np.maximum(
            missed["steady_rms_slope"], _square_of_slopes(fine, coarse)
        )
    for name, difference in missed.items():
        error = fine.safety_of(name) * fine.near(name, difference)
        errors[name] = np.maximum(error, fine.least_error(name))
    if problem.full_contact and fine.compliance.space.top <= 2:
        # of low degree, greatest values are known no better than their field: their differences
        # often vanish
        for greatest in OF_FIELD.keys() & errors.keys():
            errors[greatest] = np.maximum(errors[greatest], errors[OF_FIELD[greatest]])
    indentation = fine.safety_of("indentation") * missed.get("indentation", np.zeros(1))
    parts = {"discretisation": float(np.max(indentation, initial=0.0))}
    if problem.indentation is not None:
        # what was given has no error; the force decays, and is judged by the first
        forces = [array(each.for_estimate, "normal_force") for each in (fine, coarse)]
        difference = np.abs(forces[1] - forces[0]).max() / forces[0][0]
        parts = {"force": fine.safety_of("indentation") * float(difference)}
    if problem.march != "modal" and "indentation" in errors:
        at, sampler = np.arange(len(problem.times)), fine.sampler
        steps = differences(
            sampler.history(fine.at(at), on_face=True),
            sampler.history(fine.exact_in_time, on_face=True),
            problem.face,
        )
        errors |= {name: errors[name] + step for name, step in steps.items()}
        parts["time step"] = float(steps["indentation"].max())
    return errors, parts


def _square_of_slopes(fine: Evaluation, coarse: Evaluation) -> Array:
    """Return the mean square of the difference of steady slopes over that of slopes.

    Roots of mean squares may differ by less, where the difference happens to be orthogonal to the
    slope.
    """
    face = fine.problem.face
    weights = face.lengths * radial_weight(face.radii, fine.problem.gradient_average)
    profile = array(fine.for_estimate, "steady_profile")
    slopes, wrong = (
        face.slopes(values)[0] ** 2 @ weights
        for values in (profile, profile - array(coarse.for_estimate, "steady_profile"))
    )
    return np.divide(wrong, slopes, out=np.zeros_like(wrong), where=slopes > 0)
