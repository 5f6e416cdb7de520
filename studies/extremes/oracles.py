"""References for true errors: a finer solution by another theory, closed forms and balances.

Everything is non-dimensional. Boundary elements are the reference for the MDR, and the MDR is the
reference for all other methods. For the first contact of a sphere or a cone, the solutions of Hertz
and Love [1, 2] are exact; for a face in full contact, those of flat punches. At any time the forces
of the rings add up to the force on the punch, and by Archard's law the worn volumes V_j satisfy
``sum_j V_j / k_j = F v0 t``.

[1] Hertz: Ueber die Beruehrung fester elastischer Koerper, J. Reine Angew. Math. 92 (1882).
[2] Love: Boussinesq's problem for a rigid cone, Q. J. Math. 10 (1939).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..crosscheck import Problem, Scene, Solution, Stages, flat_punch, method
from ..crosscheck.problem.fields import Cone, Parabola
from ..crosscheck.problem.sections import FemAccuracy, MdrAccuracy
from ..crosscheck.verdict.agreement import compare
from ..crosscheck.verdict.promise import allowed_error, unresolved
from .verdicts import Verdict, verdict_on_promise


def other_theory(name: str) -> str:
    """Return the reference method for a method, whose name may end with a variant."""
    return "bem" if name.split(",")[0] == "mdr" else "mdr"


def solve_reference(problem: Problem, name: str, rtol: float) -> Solution:
    """Return the reference solution of a problem at a finer tolerance.

    Parameters
    ----------
    problem : of the method to judge; fields are compared at the radii of its face
    name : name of the reference method
    rtol : tolerance of the reference

    Raises
    ------
    RingwearError
        if the reference cannot be computed
    """
    finer = replace(
        problem,
        rtol=rtol,
        compared_on=problem.face,
        fem=FemAccuracy(),
        mdr=MdrAccuracy(),
        march="modal",
        step=None,
    )
    return method(name).solve(finer, Stages(name))


def judge_by_reference(
    problem: Problem, name: str, solution: Solution, reference: Solution
) -> Iterator[Verdict]:
    """Yield the verdict on every quantity at every time at which its accuracy is promised.

    Parameters
    ----------
    problem : compared at the radii of the reference
    name : name of the method, with its variant
    solution, reference : of the method, and of the other theory
    """
    allowed = allowed_error(problem)
    for quantity, difference in compare(problem, (solution, reference)).items():
        pairs = zip(difference.size, difference.first, strict=True)
        for index, (error, estimate) in enumerate(pairs):
            if not unresolved(problem, quantity, {name: solution}, index):
                yield verdict_on_promise(quantity, float(error), float(estimate), allowed)


def judge_by_theory(scene: Scene, problem: Problem, solution: Solution) -> Iterator[Verdict]:
    """Yield the verdicts on the start, if it has a closed form, and on both balances."""
    allowed, times = allowed_error(problem), problem.times[problem.compared_rows]
    if len(times) and times[0] == 0 and problem.march == "modal":
        for quantity, exact in start_in_closed_form(scene).items():
            error = abs(float(solution.compared[quantity][0]) / exact - 1)
            estimate = float(solution.compared_error(problem, quantity)[0])
            yield verdict_on_promise(
                f"{quantity} at the start, in closed form", error, estimate, allowed
            )
    if not problem.constant_force:
        return
    wear = problem.wear_coefficients
    for name, balance, factors, sums in (
        ("ring_force", "ring forces add up to F", np.ones(len(wear)), np.ones(len(times))),
        ("ring_worn_volume", "Archard's balance of worn volumes", 1 / wear, times),
    ):
        values = solution.compared.get(name)
        if values is None or name not in solution.errors or values.shape[1] != len(factors):
            continue
        estimates = solution.compared_error(problem, name)
        for value, exact, estimate in zip(values @ factors, sums, estimates, strict=True):
            if exact > 0:
                error = abs(float(value) / float(exact) - 1)
                # a sum over many elements is exact to roundoff only
                yield verdict_on_promise(balance, error, max(float(estimate), 1e-12), allowed)


def start_in_closed_form(scene: Scene) -> dict[str, float]:
    """Return the non-dimensional quantities of the first contact that have a closed form.

    There are none if the force or the speed varies, if the indentation is given, or if the contact
    of a shaped punch is not a disc within the face.
    """
    problem = scene.problem
    return STARTS[problem.full_contact](scene) if problem.constant_force else {}


def _start_of_flat(scene: Scene) -> dict[str, float]:
    """Return the indentation of a flat punch in full contact."""
    return {"indentation": float(flat_punch(scene.problem.inner_radius).indentation)}


def _start_of_shaped(scene: Scene) -> dict[str, float]:
    """Return the contact radius and the indentation of a sphere or a cone within the face."""
    profile, units = scene.punch.profile, scene.problem.units
    pressed = units.force / (units.modulus * units.length**2)
    if isinstance(profile, Parabola):
        curvature = profile.curvature_radius / units.length
        contact = (0.75 * pressed * curvature) ** (1 / 3)
        depth = contact**2 / curvature
    elif isinstance(profile, Cone):
        contact = (2 * pressed / (np.pi * profile.slope)) ** 0.5
        depth = np.pi / 2 * profile.slope * contact
    else:
        return {}
    if contact >= 1:
        return {}
    return {"contact_radius": float(contact), "indentation": float(depth / pressed)}


STARTS = {True: _start_of_flat, False: _start_of_shaped}
"""Functions that compute the start in closed form, by whether the punch is in full contact."""
