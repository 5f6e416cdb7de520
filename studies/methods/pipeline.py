"""The pipeline of every method that yields a compliance, and of every punch.

problem -> compliances (fine, coarser) -> wear -> history -> quantities -> errors
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from weakref import WeakKeyDictionary

import numpy as np

from ...meshes.compliance import Compliance
from ...meshes.contact_cells import fitted_space
from ...meshes.errors import RingwearError
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array
from ..problem.problem import Problem
from ..problem.profile import FLAT, InitialProfile
from ..progress import Stages
from ..sampling.answers import joined
from ..sampling.norms import answer_differences, differences, radial_weight
from ..sizes.defaults import RADIAL_ROUNDOFF, mdr_sizes, smallest_size
from ..sizes.marching import refused_steps, steps_between
from ..sizes.shared import Shared
from ..wear.fitted_press import fit_presses
from ..wear.flat_contact import FittedPress
from ..wear.unilateral import Load
from .base import Discretised, Method, Solution
from .error_factors import error_factor
from .evaluation import Evaluation, FullContact
from .moving_evaluation import MovingContact
from .spaces import first_contact, load_at_start, pressure_spaces


class ComplianceMethod(Method):
    """A method that yields a compliance: contact, wear, quantities and errors are the same for all.

    A method of one's own is a subclass with a `name` and `discretise`; an instance of it can be
    given to `run`.
    """

    @abstractmethod
    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        """Return the compliance that suits a problem, and a coarser one."""

    def refusal(self, problem: Problem) -> str:
        """Return why it cannot solve the problem at all, with the remedy; empty if it can."""
        if problem.march != "modal" and problem.loading.varies:
            return (
                f"wear.march = '{problem.march}' takes steps of one length under one load: with a "
                "load that varies give 'modal'"
            )
        if problem.step and problem.march != "modal":
            steps = float(steps_between(problem.times, problem.step).sum())
            if refused := refused_steps(steps, "give a larger wear.step, or march = 'modal'"):
                return refused
        if problem.indentation is not None and not len(problem.times):
            return (
                "load.indentation has no steady state but that nothing presses any more: give "
                "wear.times"
            )
        if not problem.full_contact and problem.march == "explicit":
            return (
                f"wear.march = 'explicit' does not go with {self.name} on an initial profile, "
                "where contact is an inequality: give 'implicit', or 'modal' for steps that suit "
                "the accuracy"
            )
        return ""

    def solve_all(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Discretise once, for the sharpest of the problems; then wear, sample and estimate each.

        Shaped punches are solved one by one.
        """
        if problems[0].full_contact:
            return solve_in_full_contact(self, problems, stages)
        return [solve_in_moving_contact(self, problem, stages) for problem in problems]

    def solve_again(self, problem: Problem, steady: Solution | None, stages: Stages) -> Solution:
        """Return a problem's solution by finer sizes, with a steady state that is known."""
        if steady is None or problem.full_contact:
            return self.solve(problem, stages)
        return solve_in_moving_contact(self, problem, stages, steady)


class AnySpaceMethod(ComplianceMethod):
    """A method whose compliance can be had on any pressure space."""

    @abstractmethod
    def compliance(self, space: PressureSpace) -> Compliance:
        """Return the compliance on a space."""

    def refusal(self, problem: Problem) -> str:
        """Return why it cannot solve the problem at all, with the remedy; empty if it can.

        Besides what every `ComplianceMethod` refuses, only the radial mesh of a flat punch can be
        sized by the user.
        """
        if not problem.full_contact and problem.mdr.given:
            return (
                "accuracy.mdr sizes the mesh of a flat punch: with an initial profile leave it out"
            )
        return super().refusal(problem)

    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        """Return the compliance on the space that suits a problem, and what makes a coarser one."""
        fine, coarse = pressure_spaces(problem)

        def fitted(edges: tuple[float, ...], infinite: tuple[bool, ...], degree: int) -> Compliance:
            return self.compliance(fitted_space(edges, infinite, degree))

        # of sizes of which each ring edge may have its own, the smallest
        sizes = mdr_sizes(problem).items() if problem.full_contact else ()
        smallest = {name: np.min(size).item() for name, size in sizes if np.size(size)}
        with stages("assembling"):
            compliance = self.compliance(fine)
        return Discretised(
            compliance,
            # within its own space a compliance need not be computed anew
            lambda: (
                compliance.restricted(coarse) if problem.full_contact else self.compliance(coarse)
            ),
            settings=smallest,
            smallest=smallest_size(problem, RADIAL_ROUNDOFF),
            fitted=(partial(fitted, degree=8), partial(fitted, degree=6)),
        )


def solve_in_full_contact(
    method: ComplianceMethod, problems: Sequence[Problem], stages: Stages
) -> list[Solution]:
    """Solve flat punches on the same rings: their histories are exact in time."""
    several = len(problems) > 1
    made = method.discretise(Shared.of(problems) if several else problems[0], stages)
    with stages("estimating"):
        compliances = made.compliance, made.coarser()
    with stages("marching" if len(problems[0].times) else "steady state"):
        return [
            _solution(
                made,
                *(FullContact(problem, each, made.safety, made.smallest) for each in compliances),
            )
            for problem in problems
        ]


# starts of shaped punches that are fitted to the edges of the contact, by the face, as long as that
# is in use; by method, load and Poisson's ratio
_STARTS: WeakKeyDictionary[
    InitialProfile, dict[tuple[Method, Load, float], tuple[FittedPress, FittedPress]]
] = WeakKeyDictionary()


def solve_in_moving_contact(
    method: ComplianceMethod, problem: Problem, stages: Stages, steady: Solution | None = None
) -> Solution:
    """Solve a punch whose contact opens, closes and spreads; its steady state is the flat one's."""
    if problem.steady and steady is None:
        flat = replace(problem, profile=FLAT, times=problem.times[:0], compared_on=problem.face)
        steady = method.solve(replace(flat, loading=problem.loading.held_last), stages)
        if not len(problem.times):
            return steady
    with stages("locating"):
        intervals, _ = first_contact(problem)
    made = method.discretise(problem, stages)
    presses: tuple[FittedPress | None, FittedPress | None] = (None, None)
    notes = list(made.notes)
    if problem.times[0] == 0 and problem.loading.forces[0] and made.fitted:
        with stages("pressing"):
            load = load_at_start(problem)
            # the start does not depend on cells: a refinement has the one found before
            found = _STARTS.setdefault(problem.profile, {})
            key = method, load, problem.poisson_ratio
            try:
                if key not in found:
                    found[key] = fit_presses(problem.profile, load, intervals, made.fitted)
                presses = found[key]
            except RingwearError as error:
                notes.append(
                    "the start is as accurate as the march, not fitted to the edges of the "
                    f"contact: {error}"
                )
    with stages("marching"):
        fine = MovingContact(problem, made.compliance, presses[0])
        _ = fine.results
    with stages("estimating"):
        watched = replace(problem, times=fine.march.times)
        coarse = MovingContact(watched, made.coarser(), presses[1], step_tolerance_factor=4.0)
        solution = _without_infinite_peak(_solution(made, fine, coarse), problem.rtol)
    solution = replace(
        solution,
        settings=fine.settings,
        notes=(*notes, *fine.notes()),
        march=fine.march,
        presses=tuple(press for press in presses if press is not None),
    )
    if steady and np.isnan(fine.march.time_of_full_contact):
        note = (
            "the steady state is that of all of the face in contact, which the history does not "
            "reach"
        )
        solution = replace(solution, notes=(*solution.notes, note))
    return _beside(solution, steady) if steady else solution


def _solution(made: Discretised, fine: Evaluation, coarse: Evaluation) -> Solution:
    errors, parts = estimate_errors(fine, coarse)
    unknowns = made.unknowns or made.compliance.space.size
    return Solution(
        fine.results,
        fine.checked,
        errors,
        parts,
        unknowns,
        made.settings,
        made.notes,
        fine.wear,
        made.half_space,
        smallest=made.smallest,
        answers=fine.answers,
        evaluate=type(fine),
    )


def _without_infinite_peak(solution: Solution, rtol: float) -> Solution:
    """Return a solution without the peak of the pressure where a coarser press has another.

    At a kink of the face the pressure is infinite, which no number of polynomials shows.
    """
    name = "pressure_peak_start"
    if name not in solution.answers or solution.errors.get(name, np.inf) <= rtol:
        return solution
    answers = {key: value for key, value in solution.answers.items() if key != name}
    errors = {key: error for key, error in solution.errors.items() if key != name}
    return replace(solution, answers=answers, errors=errors)


# fields that greatest values are taken from
OF_FIELD = {"displacement_max": "displacement", "steady_displacement_max": "steady_profile"}


# numbers of a flat punch that are values of the displacement at one place, whose differences cross
# zero now and then: their errors are at least this part of that of the field
TAKEN_FROM_FIELD = {"displacement_centre", "displacement_max"}


def estimate_errors(
    fine: Evaluation, coarse: Evaluation
) -> tuple[dict[str, Array], dict[str, float]]:
    """Return the relative error of each quantity in its norm, and parts of that of the indentation.

    Errors over time are those at the times asked for; parts are the greatest over all times, by
    what causes them.
    """
    problem = fine.problem
    missed = differences(coarse.for_estimate, fine.for_estimate, problem.face)
    if "steady_rms_slope" in missed and "steady_profile" in missed:
        missed["steady_rms_slope"] = np.maximum(
            missed["steady_rms_slope"], _square_of_slopes(fine, coarse)
        )
    errors = {name: fine.estimate(name, difference) for name, difference in missed.items()}
    part = error_factor("part of the field")
    for name in TAKEN_FROM_FIELD & errors.keys():
        if problem.full_contact and "displacement" in errors:
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
        forces = [each.for_estimate["normal_force"] for each in (fine, coarse)]
        difference = np.abs(forces[1] - forces[0]).max() / max(forces[0][0], np.finfo(float).tiny)
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


def _square_of_slopes(fine: Evaluation, coarse: Evaluation) -> Array:
    """Return the mean square of the difference of steady slopes over that of slopes.

    Roots of mean squares may differ by less, where the difference happens to be orthogonal to the
    slope.
    """
    face = fine.problem.face
    of_face = fine.problem.gradient_average, face.inner_radius
    weights = face.lengths * radial_weight(face.radii, *of_face)
    profile = fine.for_estimate["steady_profile"]
    slopes, wrong = (
        face.slopes(values)[0] ** 2 @ weights
        for values in (profile, profile - coarse.for_estimate["steady_profile"])
    )
    return np.divide(wrong, slopes, out=np.zeros_like(wrong), where=slopes > 0)


def _beside(history: Solution, steady: Solution) -> Solution:
    """Return a history beside the steady state of the flat punch."""
    return replace(
        history,
        steady_part=steady,
        results=steady.results | history.results,
        checked=steady.checked | history.checked,
        errors=history.errors | steady.errors | _join_errors(history, steady),
        answers=joined(history.answers, steady.answers),
        notes=(*history.notes, *steady.notes),
        settings={
            **history.settings,
            "steady_state": {**steady.settings, "unknowns": steady.unknowns},
        },
    )


def _join_errors(history: Solution, steady: Solution) -> dict[str, Array]:
    """Return errors of the numbers of the answer of which two solutions give a part each."""
    shared = history.answers.keys() & steady.answers.keys()
    stated = history.errors, steady.errors
    return {
        name: np.where(np.isnan(stated[0][name]), stated[1][name], stated[0][name])
        for name in shared
        if all(name in errors for errors in stated)
    }
