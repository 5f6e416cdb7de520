"""What errors are measured by: a finer solution by another theory, closed forms and balances.

Non-dimensional. Boundary elements judge dimensionality reduction, which judges all others. Where
contact begins on a sphere or a cone, Hertz's and Love's solutions [1, 2] are exact; where it is the
whole flat face, flat punches are. At any time the forces of the rings add up to the force on the
punch, and by Archard's law ``sum_j V_j / k_j = F v0 t`` of the worn volumes.

[1] Hertz: Ueber die Beruehrung fester elastischer Koerper, J. Reine Angew. Math. 92 (1882).
[2] Love: Boussinesq's problem for a rigid cone, Q. J. Math. 10 (1939).
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...mdr.flat_punch import flat_punch
from ..crosscheck.agreement import compare
from ..crosscheck.promise import allowed_error, unresolved
from ..methods.base import Solution, method
from ..problem.fields import Cone, Parabola
from ..problem.problem import Problem
from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT, ONE_FORCE
from ..problem.sections import FemAccuracy, MdrAccuracy
from ..progress import Stages
from ..scene.scene import Scene
from .verdicts import Verdict, verdict_on_promise


def other_theory(judged: str) -> str:
    """Return the name of the method that a method is judged by."""
    return "bem" if judged.split(",")[0] == "mdr" else "mdr"


def solve_reference(problem: Problem, name: str, rtol: float) -> Solution:
    """Return the solution that a method is judged by, to a finer accuracy.

    Parameters
    ----------
    problem : as the judged method is asked for it; its face is where fields are compared
    name : method of the reference
    rtol : accuracy of the reference

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
    """Yield the verdict on every quantity at every time at which its accuracy is promised."""
    allowed = allowed_error(problem)
    for quantity, difference in compare(problem, (solution, reference)).items():
        pairs = zip(difference.size, difference.first, strict=True)
        for at, (error, estimate) in enumerate(pairs):
            if not unresolved(problem, quantity, {name: solution}, at):
                yield verdict_on_promise(quantity, float(error), float(estimate), allowed)


def judge_by_theory(scene: Scene, problem: Problem, solution: Solution) -> Iterator[Verdict]:
    """Yield the verdict on the start, where that is known in closed form, and on both balances."""
    allowed, times = allowed_error(problem), problem.times[problem.checked]
    if len(times) and times[0] == 0 and problem.march == "modal":
        for quantity, exact in start_in_closed_form(scene).items():
            error = abs(float(solution.checked[quantity][0]) / exact - 1)
            estimate = float(solution.checked_error(problem, quantity)[0])
            yield verdict_on_promise(
                f"{quantity} at the start, in closed form", error, estimate, allowed
            )
    if problem.load_regime is not ONE_FORCE:
        return
    wear = problem.rings.ends.mean(axis=0)[-len(problem.rings.widths) :]
    for name, balance, per_ring, whole in (
        ("ring_force", "ring forces add up to F", np.ones(len(wear)), np.ones(len(times))),
        ("ring_worn_volume", "Archard's balance of worn volumes", 1 / wear, times),
    ):
        values = solution.checked.get(name)
        if values is None or name not in solution.errors or values.shape[1] != len(per_ring):
            continue
        stated = solution.checked_error(problem, name)
        for value, exact, estimate in zip(values @ per_ring, whole, stated, strict=True):
            if exact > 0:
                error = abs(float(value) / float(exact) - 1)
                # sums of many elements are known to roundoff
                yield verdict_on_promise(balance, error, max(float(estimate), 1e-12), allowed)


def start_in_closed_form(scene: Scene) -> dict[str, float]:
    """Return quantities of the first contact that are known in closed form, non-dimensional.

    None are known if the contact is not a disc within the face, or if the load is no force.
    """
    problem = scene.problem
    return STARTS[problem.contact](scene) if problem.load_regime is ONE_FORCE else {}


def _start_of_flat(scene: Scene) -> dict[str, float]:
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


STARTS = {FULL_CONTACT: _start_of_flat, MOVING_CONTACT: _start_of_shaped}
