"""The common pipeline of all methods that compute a compliance.

- discretise, finely and coarsely: `ComplianceMethod.discretise`, with sizes from
  `studies/crosscheck/sizes/`
- wear and sample on both compliances: `evaluation.py`, `moving_evaluation.py`
- estimate errors by the difference of both, times factors: `estimates.py`, `error_factors.py`

A flat punch stays in full contact (`solve_in_full_contact`), unless the force falls too fast. Any
other contact is marched in time (`solve_in_moving_contact`).
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np

from ....meshes.compliance import Compliance
from ....meshes.contact_cells import fitted_space
from ....meshes.errors import RingwearError
from ....meshes.ground.ground import HALF_SPACE, Ground
from ....meshes.pressure_space import PressureSpace
from ..problem.norms import Results
from ..problem.problem import Problem
from ..problem.profile import FLAT
from ..problem.quantities import ANSWER, COMPARED_MODES
from ..problem.refusal import Feature, Refusal
from ..progress import Stages
from ..sizes.layers import narrowed_for_layers
from ..sizes.ring_edges import RADIAL_ROUNDOFF, smallest_size
from ..sizes.shared import covering
from ..wear.falling_force import refuse_tension
from ..wear.first_contact import covers_face, first_contact, load_at_start
from ..wear.fitted_press import fit_presses
from ..wear.flat_contact import FittedPress
from ..wear.step_control import (
    MOST_LINEAR_STEPS,
    MOST_STEPS,
    steps_between,
    why_too_many_steps,
)
from ..wear.unilateral import Interval
from .base import Discretised, Method, Solution, SystemSize
from .error_factors import error_factor
from .estimates import estimate_errors
from .evaluation import Evaluation, FullContact
from .moving_evaluation import MovingContact
from .spaces import choose_spaces

# Largest error estimate of a relaxation time that is reported. Above it, estimates are not reliable
# (physics/test_late_times.py::test_reported_relaxation_times_are_as_accurate_as_stated).
LARGEST_MODE_ERROR = 0.02
# Increase of the width of elements on layers per distance from the edges of a fitted start
# (physics/test_thin_layers.py::test_a_ball_on_a_thin_coat_against_an_independent_equation).
GROWTH_AT_START = 0.5


class ComplianceMethod(Method):
    """A method that computes a compliance; the rest of the pipeline is common to all such methods.

    A user's own method is a subclass with a `name` and `discretise`; an instance of it can be
    passed to `run`.
    """

    # No feature is refused as such; `refusal` checks the march and the times.
    refused: ClassVar[Mapping[Feature, Refusal]] = {}

    @abstractmethod
    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        """Return the compliance on a discretisation that suits the problem, and a coarser one."""

    def sizes_of_flat_punches(self, problem: Problem) -> str:
        """Return which sizes of the scene only a flat punch can have; empty if there are none."""
        return ""

    def refusal(self, problem: Problem) -> str:
        """Return why the method cannot solve the problem, with the remedy; empty if it can."""
        if reason := super().refusal(problem):
            return reason
        if not problem.full_contact and (reason := self.sizes_of_flat_punches(problem)):
            return reason
        if problem.march != "modal" and problem.loading.varies:
            return (
                f"wear.march = '{problem.march}' takes equal steps under a constant load: with a "
                "load that varies give 'modal'"
            )
        steps, remedy = 0.0, ""
        if problem.step and problem.march != "modal":
            steps = float(steps_between(problem.times, problem.step).sum())
            remedy = "give a larger wear.step, or march = 'modal'"
        elif not problem.full_contact:
            steps = problem.least_steps
            remedy = (
                "a contact problem is solved at each of wear.times, and a step ends at each time "
                "of the load: give fewer"
            )
        most = MOST_LINEAR_STEPS if problem.full_contact else MOST_STEPS
        if reason := why_too_many_steps(steps, remedy, most):
            return reason
        if not len(problem.times) and problem.indentation is not None:
            return (
                "with load.indentation the pressure vanishes in the steady state, so that there is "
                "nothing to compute without a history: give wear.times"
            )
        if problem.march == "explicit" and not problem.full_contact:
            return (
                f"wear.march = '{problem.march}' is not possible for {self.name} with an initial "
                "profile, where contact is an inequality: give 'implicit', or 'modal' for steps "
                "that suit the accuracy"
            )
        return ""

    def system_size(self, problem: Problem) -> SystemSize:
        """Return the number of pressures on the space that suits the problem."""
        size = choose_spaces(problem).fine.size
        return SystemSize(size, size)

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Return the solution: discretise, wear, sample, and estimate errors."""
        return self.solve_alike([problem], stages)[0]

    def solve_alike(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Return the solutions of several problems on one discretisation, if they are flat punches.

        The discretisation has the smallest sizes that any of the problems needs. Shaped punches are
        solved one by one.
        """
        if problems[0].full_contact:
            return solve_in_full_contact(self, problems, stages)
        return [solve_in_moving_contact(self, problem, stages) for problem in problems]

    def solve_again(
        self, problem: Problem, earlier: Solution, allowed_error: float, stages: Stages
    ) -> Solution:
        """Return the solution of a problem with finer sizes than those of an earlier solution.

        For a shaped punch, two parts of the earlier solution do not depend on the cells of the
        history, and are reused: the start that is fitted to the edges of the contact, and the
        steady state if its errors are within `allowed_error`.
        """
        if problem.full_contact:
            return self.solve(problem, stages)
        return solve_in_moving_contact(self, problem, stages, earlier, allowed_error)


class AnySpaceMethod(ComplianceMethod):
    """A method that can compute a compliance on any pressure space."""

    @abstractmethod
    def compliance(self, space: PressureSpace, ground: Ground = HALF_SPACE) -> Compliance:
        """Return the compliance of the ground on a space."""

    def sizes_of_flat_punches(self, problem: Problem) -> str:
        """Return which sizes of the radial mesh to leave out; empty if the scene sets none."""
        message = (
            "accuracy.mdr sizes the mesh of a flat punch: with an initial profile leave it out"
        )
        return message if problem.mdr.given_by_user else ""

    def sizes_given(self, problem: Problem) -> bool:
        """Return whether the scene sets the sizes of the radial mesh."""
        return problem.mdr.given_by_user

    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        """Return the compliance on the space that suits the problem, and a coarser one."""
        spaces, ground = choose_spaces(problem), problem.ground

        def fitted(
            edges: tuple[float, ...],
            sizes: tuple[float, ...],
            scaled_ground: Ground,
            degree: int,
        ) -> Compliance:
            space = fitted_space(edges, sizes, degree)
            narrow = narrowed_for_layers(space, scaled_ground, GROWTH_AT_START)
            return self.compliance(narrow, scaled_ground)

        def coarser() -> Compliance:
            if spaces.nested:
                return compliance.restricted(spaces.coarse)
            return self.compliance(spaces.coarse, ground)

        with stages("assembling"):
            compliance = self.compliance(spaces.fine, ground)
        return Discretised(
            compliance,
            coarser,
            settings=spaces.sizes,
            smallest=smallest_size(problem, RADIAL_ROUNDOFF),
            fitted=(partial(fitted, degree=8), partial(fitted, degree=6)),
        )


def solve_in_full_contact(
    method: ComplianceMethod, problems: Sequence[Problem], stages: Stages
) -> list[Solution]:
    """Solve flat punches on the same rings; their histories are exact in time."""
    is_batch = len(problems) > 1
    discretisation = method.discretise(covering(problems) if is_batch else problems[0], stages)
    with stages("estimating"):
        compliances = discretisation.compliance, discretisation.coarser()
    with stages("marching" if len(problems[0].times) else "steady state"):
        return [_solve_one(problem, discretisation, compliances) for problem in problems]


def _solve_one(
    problem: Problem,
    discretisation: Discretised,
    compliances: tuple[Compliance, Compliance],
) -> Solution:
    fine, coarse = (
        FullContact(
            problem,
            compliance,
            discretisation.safety,
            discretisation.smallest,
            discretisation.slope_roundoff,
            discretisation.least_error,
        )
        for compliance in compliances
    )
    may_need_tension = problem.ground.layered or problem.keeps_contact
    if may_need_tension and problem.earliest:
        refuse_tension(problem, fine.compliance.space, fine.history_at)
    return _solution(discretisation, fine, coarse)


def solve_in_moving_contact(
    method: ComplianceMethod,
    problem: Problem,
    stages: Stages,
    earlier: Solution | None = None,
    allowed_error: float = 0.0,
) -> Solution:
    """Solve a punch whose contact moves, and the steady state of the flat punch.

    Parameters
    ----------
    method : the method that computes the compliances
    problem : the problem, with the tolerance from which sizes are chosen
    stages : reports the progress
    earlier : a solution with coarser sizes; its fitted start is reused, and its steady state if
        that is accurate enough
    allowed_error : largest error of a steady state that is reused
    """
    begun_steady = begin_steady_part(method, problem, stages, earlier, allowed_error)
    if not len(problem.times) and (alone := begun_steady()):
        return alone
    with stages("locating"):
        intervals, _ = first_contact(problem)
    discretisation = method.discretise(problem, stages)
    with stages("pressing"):
        presses, notes = fitted_starts(problem, intervals, discretisation, earlier)
    start, coarse_start = presses or (None, None)
    # fields are compared at the same radii, which otherwise depend on the first time
    on_face, in_layers = replace(problem, compared_on=problem.face), covers_face(intervals)
    length = error_factor("steps of the coarser march")

    with stages("estimating"):
        compliance = discretisation.coarser()
    march = partial(MovingContact, on_face, compliance, coarse_start, length, in_layers)
    evolution = stages.begin(lambda _: march().evolution, "estimating")
    with stages("marching"):
        fine = MovingContact(problem, discretisation.compliance, start, in_layers=in_layers)
    with stages("estimating"):
        coarse = march(evolution())
        solution = _solution(discretisation, fine, coarse)
    steady = begun_steady()
    solution = replace(
        _without_infinite_peak(solution, problem.rtol),
        settings=fine.settings,
        notes=(*discretisation.notes, *notes, *fine.notes()),
        evolution=fine.evolution,
        presses=presses,
    )
    if steady and np.isnan(fine.evolution.time_of_full_contact):
        note = "the steady state is that of full contact, which the history does not reach"
        solution = replace(solution, notes=(*solution.notes, note))
    return _join_steady_part(solution, steady) if steady else solution


def begin_steady_part(
    method: ComplianceMethod,
    problem: Problem,
    stages: Stages,
    earlier: Solution | None,
    allowed_error: float,
) -> Callable[[], Solution | None]:
    """Begin the steady state of a shaped punch, which is that of the flat one, if it is wanted.

    Return a function that returns it. The steady state of an earlier solution is reused if its
    errors are within `allowed_error`.
    """
    if not problem.steady:
        return lambda: None
    if earlier and (reused := earlier.steady_part) and reused.max_error <= allowed_error:
        return lambda: reused
    flat = replace(problem, profile=FLAT, times=problem.times[:0], compared_on=problem.face)
    return stages.begin(partial(method.solve, replace(flat, loading=problem.loading.final)))


def fitted_starts(
    problem: Problem,
    intervals: tuple[Interval, ...],
    discretisation: Discretised,
    earlier: Solution | None = None,
) -> tuple[tuple[FittedPress, ...], tuple[str, ...]]:
    """Return the initial contact on spaces fitted to its edges, fine and coarser, and notes.

    The starts of an earlier solution are reused, because they do not depend on cells. The starts
    are empty if nothing presses at the time 0, or if the fit fails; a note reports that failure.

    Parameters
    ----------
    intervals : intervals of first contact, located on cells
    """
    if not discretisation.fitted or problem.times[0] > 0 or not problem.loading.forces[0]:
        return (), ()
    if earlier and earlier.presses:
        return earlier.presses, ()
    try:
        load, ground = load_at_start(problem), problem.ground
        return fit_presses(problem.profile, load, intervals, discretisation.fitted, ground), ()
    except RingwearError as error:
        note = f"the start cannot be fitted, and is only as accurate as the march: {error}"
        return (), (note,)


def _solution(discretisation: Discretised, fine: Evaluation, coarse: Evaluation) -> Solution:
    errors, parts = estimate_errors(fine, coarse)
    # the first part is that of the discretisation; others are those of steps in time
    error_by_sizes = next(iter(parts.values()))
    return Solution(
        _without_unresolved_modes(fine.results, errors) | fine.answers,
        fine.compared | fine.answers,
        errors,
        parts,
        discretisation.unknowns or discretisation.compliance.space.size,
        discretisation.settings,
        discretisation.notes,
        fine.wear,
        discretisation.half_space,
        smallest=discretisation.smallest,
        slope_roundoff=discretisation.slope_roundoff,
        limited_by_degree=discretisation.limited_by_degree,
        error_by_sizes=error_by_sizes,
    )


def _without_unresolved_modes(results: Results, errors: Results) -> Results:
    """Return results without the relaxation times that the discretisation does not resolve.

    They begin with the first one whose error estimate exceeds `LARGEST_MODE_ERROR`, or that has no
    estimate. The slowest ones, which are compared with other methods, always remain.
    """
    name = "relaxation_time"
    if name not in results:
        return results
    resolved = np.append(errors[name] <= LARGEST_MODE_ERROR, False)
    count = max(COMPARED_MODES, int(np.argmin(resolved)))
    return results | {name: results[name][:count]}


def _without_infinite_peak(solution: Solution, rtol: float) -> Solution:
    """Return a solution without the peak of the initial pressure if its error exceeds `rtol`.

    At a kink of the face the pressure is infinite, which no polynomial can represent.
    """
    name = "pressure_peak_start"
    if name not in solution.results or solution.errors.get(name, np.inf) <= rtol:
        return solution
    results, compared, errors = (
        {key: value for key, value in values.items() if key != name}
        for values in (solution.results, solution.compared, solution.errors)
    )
    return replace(solution, results=results, compared=compared, errors=errors)


def _join_steady_part(history: Solution, steady: Solution) -> Solution:
    """Return one solution that has the history and the steady state of the flat punch."""
    return replace(
        history,
        steady_part=steady,
        results=_joined(history.results, steady.results),
        compared=_joined(history.compared, steady.compared),
        errors=_joined(history.errors, steady.errors),
        notes=(*history.notes, *steady.notes),
        settings={
            **history.settings,
            "steady_state": {**steady.settings, "unknowns": steady.unknowns},
        },
    )


def _joined(history: Results, steady: Results) -> Results:
    """Return the values of a history and of a steady state.

    The steady state gives its own quantities, and completes numbers of the answer that are NaN in
    part, such as the values at the start and in the steady state.
    """
    shared = (history.keys() & steady.keys()).intersection(ANSWER)
    parts = {
        name: np.where(np.isnan(history[name]), steady[name], history[name]) for name in shared
    }
    return steady | history | parts
