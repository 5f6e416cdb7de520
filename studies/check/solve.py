"""Solve the many problems of a diagnosis by MDR, without error estimates where that is possible."""

from ...mdr import energy
from ..crosscheck import Problem, Results, RunningIn, Sampler, Stages, choose_spaces, method


def solve(problem: Problem) -> tuple[Results, RunningIn | None]:
    """Return the results of a problem and, in full contact, the running-in."""
    if not problem.full_contact:
        return method("mdr").solve(problem, Stages("mdr")).results, None
    space = choose_spaces(problem).fine
    compliance = energy.compliance(space, problem.ground)
    wear = RunningIn(
        compliance,
        problem.merged.wear_coefficients,
        problem.shortest_decay,
        indentation=problem.indentation,
        loading=problem.loading,
    )
    return Sampler(problem, space, compliance).history(wear.modal(problem.times)), wear
