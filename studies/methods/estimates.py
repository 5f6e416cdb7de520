"""Error estimates: the difference of a fine and a coarser evaluation, times a factor.

The factors and floors are in `error_factors.py`; each kind of contact applies them in its own way
(`Evaluation.estimate`).
"""

import numpy as np

from ...meshes.radial import Array
from ..problem.problem import Problem
from ..sampling.norms import answer_differences, differences, radial_weight
from .error_factors import error_factor
from .evaluation import Evaluation

# fields that greatest values are taken from
OF_FIELD = {"displacement_max": "displacement", "steady_displacement_max": "steady_profile"}


def estimate_errors(
    fine: Evaluation, coarse: Evaluation
) -> tuple[dict[str, Array], dict[str, float]]:
    """Return the relative error of each quantity in its norm, and parts of that of the indentation.

    Errors over time are those at the times asked for; parts are the greatest over all times, by
    what causes them.
    """
    problem = fine.problem
    coarser, finer = (each.for_estimate(fine.estimate_times) for each in (coarse, fine))
    missed = differences(coarser, finer, problem.face)
    if "steady_rms_slope" in missed and "steady_profile" in missed:
        missed["steady_rms_slope"] = np.maximum(
            missed["steady_rms_slope"],
            _square_of_slopes(problem, finer["steady_profile"], coarser["steady_profile"]),
        )
    errors = {name: fine.estimate(name, difference) for name, difference in missed.items()}
    part = error_factor("part of the field")
    for name in fine.taken_from_field & errors.keys():
        if "displacement" in errors:
            errors[name] = np.maximum(errors[name], part * errors["displacement"])
    compared = answer_differences(coarse.answers, fine.answers)
    for name, difference in compared.items():
        errors[name] = fine.estimate_answer(name, difference, errors)
    if fine.sampler.by_fields:
        for greatest in OF_FIELD.keys() & errors.keys():
            errors[greatest] = np.maximum(errors[greatest], errors[OF_FIELD[greatest]])
    if "indentation_steady" in errors:
        errors["indentation_steady"] = errors["steady_displacement_max"]
    indentation = fine.safety_of("indentation") * missed.get("indentation", np.zeros(1))
    parts = {"discretisation": float(np.max(indentation, initial=0.0))}
    if problem.indentation is not None:
        # what was given has no error; the force decays, and is judged by the first
        forces, first = finer["normal_force"], float(finer["normal_force"][0])
        difference = np.abs(coarser["normal_force"] - forces).max()
        difference /= max(first, np.finfo(float).tiny)
        parts = {"force": fine.safety_of("indentation") * float(difference)}
    if problem.march != "modal" and "indentation" in errors:
        marched, exact = (
            fine.sampler.history(history, on_face=True)
            for history in (fine.history, fine.exact_in_time)
        )
        steps = differences(marched, exact, problem.face)
        steps |= answer_differences(fine.answers, fine.answers_exact_in_time)
        errors |= {name: errors[name] + step for name, step in steps.items()}
        parts["time step"] = float(steps["indentation"].max())
    return errors, parts


def _square_of_slopes(problem: Problem, profile: Array, coarser: Array) -> Array:
    """Return the mean square of the difference of steady slopes over that of slopes.

    Roots of mean squares may differ by less, where the difference happens to be orthogonal to the
    slope.

    Parameters
    ----------
    profile, coarser : (R,) steady profiles on the face
    """
    face = problem.face
    weights = face.lengths * radial_weight(face.radii, problem.gradient_average, face.inner_radius)
    slopes, wrong = (
        face.slopes(values)[0] ** 2 @ weights for values in (profile, profile - coarser)
    )
    return np.divide(wrong, slopes, out=np.zeros_like(wrong), where=slopes > 0)
