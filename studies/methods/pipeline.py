"""The pipeline of every method that yields a compliance, and of every punch.

problem -> compliances (fine, coarser) -> wear -> history -> quantities -> errors
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace

import xarray

from ...meshes.compliance import Compliance
from ...meshes.errors import RingwearError
from ..problem.marching import refused_steps, steps_between
from ..problem.problem import Problem
from ..problem.profile import FLAT
from ..problem.shared import Shared
from ..progress import Stages
from ..wear.fitted_press import FittedPress, fit_presses
from .base import Discretised, Method, Solution, method
from .estimate import estimate_errors
from .evaluation import Evaluation, FullContact, MovingContact
from .spaces import first_contact, load_of
from .together import Together, worn_together


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
        if problem.step and problem.march != "modal":
            steps = float(steps_between(problem.times, problem.step).sum())
            if refused := refused_steps(steps, "give a larger wear.step, or march = 'modal'"):
                return refused
        if problem.full_contact:
            return ""
        if problem.march == "explicit":
            return (
                f"wear.march = 'explicit' does not go with {self.name} on an initial profile or a "
                "fixed indentation, where contact is an inequality: give 'implicit', or 'modal' "
                "for steps that suit the accuracy"
            )
        if problem.indentation is not None and not len(problem.times):
            return (
                "load.indentation has no steady state but that nothing presses any more: give "
                "wear.times"
            )
        return ""

    def solve_all(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Discretise once, for the sharpest of the problems; then wear, sample and estimate each.

        Shaped punches are solved one by one.
        """
        if problems[0].full_contact:
            return solve_in_full_contact(self, problems, stages)
        return [solve_in_moving_contact(self, problem, stages) for problem in problems]


def solve_in_full_contact(
    method: ComplianceMethod, problems: Sequence[Problem], stages: Stages
) -> list[Solution]:
    """Solve flat punches on the same rings: their histories are exact in time."""
    several = len(problems) > 1
    made = method.discretise(Shared.of(problems) if several else problems[0], stages)
    with stages("estimating"):
        compliances = made.compliance, made.coarser()
    with stages("marching" if len(problems[0].times) else "steady state"):
        together = worn_together(problems, *compliances) if several else None
        return [_in_full_contact(made, problem, compliances, together) for problem in problems]


def _in_full_contact(
    made: Discretised,
    problem: Problem,
    compliances: tuple[Compliance, Compliance],
    together: Together | None,
) -> Solution:
    """Solve one flat punch, by modes that it shares with others if these lose next to nothing."""
    if together:
        fine, coarse = (
            FullContact(problem, compliance, made.safety, modes)
            for compliance, modes in zip(compliances, together.modes, strict=True)
        )
        lost = together.lost(fine.wear, problem)
        if together.negligible(lost, problem.rtol):
            return _solution(made, fine, coarse).less_certain(lost, "shared modes")
    fine, coarse = (FullContact(problem, compliance, made.safety) for compliance in compliances)
    return _solution(made, fine, coarse)


def solve_in_moving_contact(method: ComplianceMethod, problem: Problem, stages: Stages) -> Solution:
    """Solve a punch whose contact opens, closes and spreads; its steady state is the flat one's."""
    steady = None
    if problem.steady and problem.indentation is None:
        flat = replace(problem, profile=FLAT, times=problem.times[:0], compared_on=problem.face)
        steady = method.solve(flat, stages)
        if not len(problem.times):
            return steady
    with stages("locating"):
        intervals, _ = first_contact(problem)
    made = method.discretise(problem, stages)
    presses: tuple[FittedPress | None, FittedPress | None] = (None, None)
    notes = list(made.notes)
    if problem.times[0] == 0 and made.fitted:
        with stages("pressing"):
            load = load_of(problem)
            try:
                presses = fit_presses(problem.profile, load, intervals, made.fitted)
            except RingwearError as error:
                notes.append(
                    "the start is as accurate as the march, not fitted to the edges of the "
                    f"contact: {error}"
                )
    with stages("marching"):
        fine = MovingContact(problem, made.compliance, presses[0])
        _ = fine.results
    with stages("estimating"):
        coarse = MovingContact(problem, made.coarser(), presses[1], looser=4.0)
        solution = _solution(made, fine, coarse)
    solution = replace(
        solution,
        settings=fine.settings,
        notes=(*notes, *fine.notes()),
    )
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
    )


def _beside(history: Solution, steady: Solution) -> Solution:
    """Return a history beside the steady state of the flat punch."""
    results, checked = (
        xarray.merge([ours, theirs.drop_vars("time", errors="ignore")])
        for ours, theirs in (
            (history.results, steady.results),
            (history.checked, steady.checked),
        )
    )
    return replace(
        history,
        results=results,
        checked=checked,
        errors=history.errors | steady.errors,
        notes=(*history.notes, *steady.notes),
        settings={
            **history.settings,
            "steady_state": {**steady.settings, "unknowns": steady.unknowns},
        },
    )


def compliance_method(name: str) -> ComplianceMethod:
    """Return the method of that name, which must yield a compliance."""
    named = method(name)
    assert isinstance(named, ComplianceMethod)
    return named
