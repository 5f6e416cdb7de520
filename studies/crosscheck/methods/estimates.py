"""Error estimates: the difference between a fine and a coarser evaluation, times a factor.

`estimate_errors` takes the differences. `Evaluation.estimate` multiplies each by a factor and
raises it to its floor. The factors and floors are in `error_factors.py`.
"""

import numpy as np

from ....meshes.radial import Array
from ..problem.face import radial_weight
from ..problem.quantities import DESCRIBED, differences
from .error_factors import error_factor
from .evaluation import Evaluation

# Quantities that are the maximum of a field, and that field.
FIELD_OF_MAXIMUM = {"displacement_max": "displacement", "steady_displacement_max": "steady_profile"}


def estimate_errors(
    fine: Evaluation, coarse: Evaluation
) -> tuple[dict[str, Array], dict[str, float]]:
    """Return the relative error of each quantity in its norm, and that of the indentation by cause.

    Parameters
    ----------
    fine, coarse : evaluations of the same problem on the fine and on the coarser discretisation

    Returns
    -------
    errors : dict of arrays
        Errors of quantities that depend on time are those at the requested times.
    parts : dict of float
        Largest error of the indentation over all times, by cause. At a fixed indentation: of the
        normal force, over its first value.
    """
    problem = fine.problem
    coarse_results, fine_results = (
        evaluation.results_for_estimate(fine.estimate_times) for evaluation in (coarse, fine)
    )
    quantity_differences = differences(coarse_results, fine_results, problem.face)
    spaces = fine.compliance.space, coarse.compliance.space
    same_elements = np.array_equal(spaces[0].breakpoints, spaces[1].breakpoints)
    for name in ("rms_slope", "steady_rms_slope") if same_elements else ("steady_rms_slope",):
        if name in quantity_differences:
            square = _mean_square_slope_difference(name, fine, coarse)
            quantity_differences[name] = np.maximum(quantity_differences[name], square)
    errors = {
        name: fine.estimate(name, difference) for name, difference in quantity_differences.items()
    }
    part_of_field = error_factor("part of the field")
    for name in fine.point_values & errors.keys():
        if "displacement" in errors:
            errors[name] = np.maximum(errors[name], part_of_field * errors["displacement"])
    differences_of_answers = differences(coarse.answers, fine.answers, problem.face)
    for name, part in problem.remaining_parts.items():
        if name in differences_of_answers:
            of_coarse, of_fine = (each.times_near(part) for each in (coarse, fine))
            near = np.nanmax(np.abs(of_coarse / of_fine - 1), initial=0.0)
            differences_of_answers[name] = np.maximum(differences_of_answers[name], near)
    for name, difference in differences_of_answers.items():
        errors[name] = fine.estimate(name, difference)
        if (repeated := DESCRIBED[name].at) and repeated[0] in errors:
            quantity, row = repeated
            errors[name] = np.maximum(errors[name], errors[quantity][row])
    if fine.sampler.maxima_from_fields:
        for maximum in FIELD_OF_MAXIMUM.keys() & errors.keys():
            errors[maximum] = np.maximum(errors[maximum], errors[FIELD_OF_MAXIMUM[maximum]])
    if "indentation_steady" in errors:
        errors["indentation_steady"] = errors["steady_displacement_max"]
    indentation = fine.safety * quantity_differences.get("indentation", np.zeros(1))
    parts = {"discretisation": float(np.max(indentation, initial=0.0))}
    if problem.indentation is not None:
        # the indentation is given, and has no error; the force decays, so that its error is
        # relative to the first force
        forces, first = fine_results["normal_force"], float(fine_results["normal_force"][0])
        difference = np.abs(coarse_results["normal_force"] - forces).max()
        difference /= max(first, np.finfo(float).tiny)
        parts = {"force": fine.safety * float(difference)}
    if problem.march != "modal" and "indentation" in errors:
        marched, exact = (
            fine.sampler.history(history, on_face=True)
            for history in (fine.history, fine.exact_in_time)
        )
        steps = differences(marched, exact, problem.face)
        steps |= differences(fine.answers, fine.answers_exact_in_time, problem.face)
        errors |= {name: errors[name] + step for name, step in steps.items()}
        parts["time step"] = float(steps["indentation"].max())
    return errors, parts


def _mean_square_slope_difference(name: str, fine: Evaluation, coarse: Evaluation) -> Array:
    """Return the mean square of the difference of slopes over the mean square of the slopes.

    The difference of two RMS slopes may be smaller than this: if the difference of the slopes
    happens to be orthogonal to the slope, or if both solutions miss the same thin layers. It is
    zero for contact that moves.

    Parameters
    ----------
    name : `rms_slope`, at the times of the estimate, or `steady_rms_slope`
    fine, coarse : evaluations of the same problem on two discretisations
    """
    problem, face, slopes = fine.problem, fine.problem.face, []
    for evaluation in (fine, coarse):
        if (wear := evaluation.wear) is None:
            return np.zeros(1)
        if name == "rms_slope":
            worn = wear.modal(fine.estimate_times).shape
        else:
            worn = wear.steady.displacement[None]
        slopes.append(face.slopes(evaluation.sampler.on_face(worn))[0])
    weights = face.lengths * radial_weight(face.radii, problem.gradient_average, face.inner_radius)
    squared_slope, squared_difference = (
        values**2 @ weights for values in (slopes[0], slopes[0] - slopes[1])
    )
    square = np.divide(
        squared_difference,
        squared_slope,
        out=np.zeros_like(squared_difference),
        where=squared_slope > 0,
    )
    return square if name == "rms_slope" else square[0]
