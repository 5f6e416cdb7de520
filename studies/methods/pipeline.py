"""The pipeline of every method that yields a compliance, and of every punch.

problem -> compliances (fine, coarser) -> wear -> history -> quantities -> errors

A flat punch under a force keeps full contact (`solve_in_full_contact`); any other contact is
marched (`solve_in_moving_contact`). Both evaluate a fine and a coarser compliance alike
(`evaluation.py`, `moving_evaluation.py`), and both state errors by the difference of the two
(`estimate_errors`).
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np

from ...meshes.compliance import Compliance
from ...meshes.contact_cells import fitted_space
from ...meshes.errors import RingwearError, SolverError
from ...meshes.ground.ground import Ground
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array
from ..contact.fitted_press import fit_presses
from ..problem.problem import Problem
from ..problem.profile import FLAT
from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT, ContactRegime, Regime
from ..progress import Stages
from ..sampling.answers import joined
from ..sizes.defaults import RADIAL_ROUNDOFF, smallest_size
from ..sizes.layers import narrow_enough
from ..sizes.marching import refused_steps, steps_between
from ..sizes.shared import covering
from ..wear.flat_contact import FittedPress
from ..wear.unilateral import Interval
from .base import Discretised, Method, Solution, SystemSize
from .error_factors import error_factor
from .estimates import estimate_errors
from .evaluation import Evaluation, FullContact
from .moving_evaluation import MovingContact
from .spaces import choose_spaces, first_contact, load_at_start, pressure_spaces

# dense matrices of the size of the compliance that are in memory at once
DENSE_MATRICES = 14.0
# tension, over rtol and the greatest pressure, that may be an error of full contact on layers
MOST_TENSION = 10.0


class ComplianceMethod(Method):
    """A method that yields a compliance: contact, wear, quantities and errors are the same for all.

    A method of one's own is a subclass with a `name` and `discretise`; an instance of it can be
    given to `run`.
    """

    # it takes every regime, as far as march and times go with it
    refused: ClassVar[Mapping[Regime, str]] = {}

    @abstractmethod
    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        """Return the compliance that suits a problem, and a coarser one."""

    def sizes_of_flat_punches(self, problem: Problem) -> str:
        """Return what to leave out if the user has given sizes that only a flat punch can have.

        Empty if the user has given none.
        """
        return ""

    def refusal(self, problem: Problem) -> str:
        """Return why it cannot solve the problem at all, with the remedy; empty if it can."""
        if refused := super().refusal(problem):
            return refused
        if not problem.full_contact and (leave_out := self.sizes_of_flat_punches(problem)):
            return leave_out
        if problem.march not in problem.load_regime.marches:
            return (
                f"wear.march = '{problem.march}' takes steps of one length under one load: with a "
                "load that varies give 'modal'"
            )
        if problem.step and problem.march != "modal":
            steps = float(steps_between(problem.times, problem.step).sum())
            remedy, most = "give a larger wear.step, or march = 'modal'", problem.contact.most_steps
            if refused := refused_steps(steps, remedy, most):
                return refused
        if not len(problem.times) and (refused := problem.load_regime.refused_without_times):
            return refused
        if problem.march not in problem.contact.marches:
            return (
                f"wear.march = '{problem.march}' does not go with {self.name} on an initial "
                "profile, where contact is an inequality: give 'implicit', or 'modal' for steps "
                "that suit the accuracy"
            )
        return ""

    def system_size(self, problem: Problem) -> SystemSize:
        """Return how many pressures there will be on the space that suits a problem."""
        size = pressure_spaces(problem)[0].size
        return SystemSize(size, size)

    def numbers_in_memory(self, problem: Problem, pressures: int) -> float:
        """Return about how many numbers its dense matrices have."""
        return DENSE_MATRICES * float(pressures) ** 2

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Discretise, wear, sample, and estimate errors."""
        return PIPELINES[problem.contact](self, [problem], stages)[0]

    def solve_alike(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Discretise once, for the smallest sizes that any needs; then wear, sample, estimate each.

        Shaped punches are solved one by one.
        """
        return PIPELINES[problems[0].contact](self, problems, stages)

    def solve_again(
        self, problem: Problem, before: Solution, allowed: float, stages: Stages
    ) -> Solution:
        """Return a problem's solution by finer sizes.

        Of a shaped punch, a steady state whose errors are allowed, and a start fitted to the edges
        of the contact, are kept: neither depends on the cells of the history.
        """
        if problem.full_contact:
            return self.solve(problem, stages)
        return solve_in_moving_contact(self, problem, stages, before, allowed)


class AnySpaceMethod(ComplianceMethod):
    """A method whose compliance can be had on any pressure space."""

    @abstractmethod
    def compliance(self, space: PressureSpace, ground: Ground | None = None) -> Compliance:
        """Return the compliance on a space, of layered ground if there are layers."""

    def sizes_of_flat_punches(self, problem: Problem) -> str:
        """Return what to leave out if the user has given sizes of the radial mesh."""
        leave_out = (
            "accuracy.mdr sizes the mesh of a flat punch: with an initial profile leave it out"
        )
        return leave_out if problem.mdr.given_by_user else ""

    def sizes_given(self, problem: Problem) -> bool:
        """Return whether the user has given the sizes of the radial mesh."""
        return problem.mdr.given_by_user

    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        """Return the compliance on the space that suits a problem, and what makes a coarser one."""
        spaces, ground = choose_spaces(problem), problem.ground

        def fitted(
            edges: tuple[float, ...],
            infinite: tuple[bool, ...],
            scaled_ground: Ground | None,
            degree: int,
        ) -> Compliance:
            space = fitted_space(edges, infinite, degree)
            return self.compliance(narrow_enough(space, scaled_ground), scaled_ground)

        def coarser() -> Compliance:
            if spaces.nested:
                return compliance.restricted(spaces.coarse)
            return self.compliance(spaces.coarse, ground)

        with stages("assembling"):
            compliance = self.compliance(spaces.fine, ground)
        return Discretised(
            compliance,
            coarser,
            settings=spaces.smallest_sizes,
            smallest=smallest_size(problem, RADIAL_ROUNDOFF),
            fitted=(partial(fitted, degree=8), partial(fitted, degree=6)),
        )


def solve_in_full_contact(
    method: ComplianceMethod, problems: Sequence[Problem], stages: Stages
) -> list[Solution]:
    """Solve flat punches on the same rings: their histories are exact in time."""
    several = len(problems) > 1
    made = method.discretise(covering(problems) if several else problems[0], stages)
    with stages("estimating"):
        compliances = made.compliance, made.coarser()
    with stages("marching" if len(problems[0].times) else "steady state"):
        return [_in_full_contact(method, problem, made, compliances) for problem in problems]


def _in_full_contact(
    method: ComplianceMethod,
    problem: Problem,
    made: Discretised,
    compliances: tuple[Compliance, Compliance],
) -> Solution:
    fine, coarse = (FullContact(problem, each, made.safety, made.smallest) for each in compliances)
    refuse_tension(fine)
    return _solution(method.remedy(problem), made, fine, coarse)


def refuse_tension(evaluation: FullContact) -> None:
    """Raise where full contact on layers would take tension in the course of wear.

    On a homogeneous half-space pressures that are positive at the start stay so; a layer that bends
    or bulges may part from the punch later.

    Raises
    ------
    SolverError
        that names the remedy
    """
    problem = evaluation.problem
    if problem.ground is None or not problem.earliest:
        return
    later = problem.checked[problem.distances[problem.checked] > 0]
    history = evaluation.history[later]
    pressure = (evaluation.compliance.space.matrix(problem.face.radii) @ history.pressure.T).T
    allowed = MOST_TENSION * problem.rtol * np.abs(pressure).max(axis=1)
    if (parted := np.flatnonzero(pressure.min(axis=1) < -allowed)).size:
        time = float(problem.times[later][parted[0]]) * problem.units.time
        raise SolverError(
            f"half_space.layers part from the punch by t = {time:.3g}, though they do not at the "
            "start, which is not solved: end wear.times before, or leave them out"
        )


def solve_in_moving_contact(
    method: ComplianceMethod,
    problem: Problem,
    stages: Stages,
    before: Solution | None = None,
    allowed: float = 0.0,
) -> Solution:
    """Solve a punch whose contact opens, closes and spreads; its steady state is the flat one's.

    Parameters
    ----------
    method : that yields the compliances
    problem : with the accuracy that sizes follow
    stages : tells of the progress
    before : a solution by coarser sizes, of which the start and an accurate steady state are kept
    allowed : the error that a steady state may have to be kept
    """
    steady = steady_part(method, problem, stages, before, allowed)
    if steady and not len(problem.times):
        return steady
    with stages("locating"):
        intervals, _ = first_contact(problem)
    made = method.discretise(problem, stages)
    with stages("pressing"):
        presses, notes = fitted_starts(problem, intervals, made, before)
    start, coarse_start = presses or (None, None)
    with stages("marching"):
        fine = MovingContact(problem, made.compliance, start)
    with stages("estimating"):
        watched = replace(problem, times=fine.estimate_times)
        coarse = MovingContact(
            watched, made.coarser(), coarse_start, error_factor("steps of the coarser march")
        )
        solution = _solution(method.remedy(problem), made, fine, coarse)
    solution = replace(
        _without_infinite_peak(solution, problem.rtol),
        settings=fine.settings,
        notes=(*made.notes, *notes, *fine.notes()),
        march=fine.marched,
        presses=presses,
    )
    if steady and np.isnan(fine.marched.time_of_full_contact):
        note = (
            "the steady state is that of all of the face in contact, which the history does not "
            "reach"
        )
        solution = replace(solution, notes=(*solution.notes, note))
    return _beside(solution, steady) if steady else solution


def solve_each_in_moving_contact(
    method: ComplianceMethod, problems: Sequence[Problem], stages: Stages
) -> list[Solution]:
    """Solve shaped punches one by one, each on a discretisation of its own."""
    return [solve_in_moving_contact(method, problem, stages) for problem in problems]


Pipeline = Callable[[ComplianceMethod, Sequence[Problem], Stages], list[Solution]]
"""What solves problems of one contact regime, by any method that yields a compliance."""
PIPELINES: dict[ContactRegime, Pipeline] = {
    FULL_CONTACT: solve_in_full_contact,
    MOVING_CONTACT: solve_each_in_moving_contact,
}


def steady_part(
    method: ComplianceMethod,
    problem: Problem,
    stages: Stages,
    before: Solution | None,
    allowed: float,
) -> Solution | None:
    """Return the steady state of a shaped punch, which is that of the flat one, if it is wanted.

    That of a solution before is kept if its errors are allowed.
    """
    if not problem.steady:
        return None
    if before and (kept := before.steady_part) and kept.greatest_of_all_errors <= allowed:
        return kept
    flat = replace(problem, profile=FLAT, times=problem.times[:0], compared_on=problem.face)
    return method.solve(replace(flat, loading=problem.loading.final), stages)


def fitted_starts(
    problem: Problem,
    intervals: tuple[Interval, ...],
    made: Discretised,
    before: Solution | None = None,
) -> tuple[tuple[FittedPress, ...], tuple[str, ...]]:
    """Return the start fitted to the edges of the contact, and a coarser one, with notes.

    Both are those of a solution before, if there is one, because they do not depend on cells. There
    are none where nothing presses at the time 0, or where the fit fails, which a note tells.

    Parameters
    ----------
    intervals : where contact begins, on cells
    """
    if not made.fitted or problem.times[0] > 0 or not problem.loading.forces[0]:
        return (), ()
    if before and before.presses:
        return before.presses, ()
    try:
        load, ground = load_at_start(problem), problem.ground
        return fit_presses(problem.profile, load, intervals, made.fitted, ground), ()
    except RingwearError as error:
        note = (
            "the start is as accurate as the march, not fitted to the edges of the contact: "
            f"{error}"
        )
        return (), (note,)


def _solution(remedy: str, made: Discretised, fine: Evaluation, coarse: Evaluation) -> Solution:
    errors, parts = estimate_errors(fine, coarse)
    return Solution(
        fine.results,
        fine.checked,
        errors,
        parts,
        made.unknowns or made.compliance.space.size,
        made.settings,
        made.notes,
        fine.wear,
        made.half_space,
        smallest=made.smallest,
        answers=fine.answers,
        remedy=remedy,
        limited_by_degree=made.limited_by_degree,
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
