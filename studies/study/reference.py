"""The one reference of a case, which states its own error.

The reference is MDR at a finer tolerance. Its error is the greatest of its own error estimate and
of its difference to boundary elements at the same tolerance, a second theory. Values with a closed
form replace it: the start of a flat punch, of a sphere and of a cone [1, 2], and the steady state
of rings.

[1] Hertz: Ueber die Beruehrung fester elastischer Koerper, J. Reine Angew. Math. 92 (1882).
[2] Love: Boussinesq's problem for a rigid cone, Q. J. Math. 10 (1939).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...mdr import flat_punch_of
from ...meshes import RingwearError, SceneError
from ..crosscheck import (
    FINEST_RTOL,
    LOG,
    Cone,
    FemAccuracy,
    MdrAccuracy,
    Parabola,
    Results,
    Scene,
    Solution,
    Stages,
    method,
)
from .errors import (
    ITSELF,
    STRESS,
    at,
    error,
    estimate,
    pressure_space,
    states_inside,
    values_of_functions,
)
from .own import Named
from .way import LATER, START, Case, Part
from .ways.axis_stresses import boussinesq_stresses

FINEST_IN_MOVING_CONTACT, FINEST_QUICK = 1e-5, 1e-4
"""Finest tolerances of the reference if edges of the contact move: a finer march takes minutes."""
ROUNDOFF, ROUNDOFF_OF_MARCHES = 1e-14, 1e-12
"""Relative errors of values in closed form, and of a march by modes."""


@dataclass(frozen=True, eq=False)
class Reference:
    """Values that solutions of a case are compared with.

    Parameters
    ----------
    values : by quantity, at the compared times and on the face; non-dimensional
    errors : function part -> relative error of these values
    """

    values: Results
    errors: Callable[[Part], float]


def reference(
    case: Case,
    names: Sequence[str] = (),
    functions: Named | None = None,
    rtol: float = FINEST_RTOL,
    quick: bool = False,
    confirmed: bool = True,
) -> Reference:
    """Return the reference of a case.

    Parameters
    ----------
    case : what is solved
    names : quantities of finite elements that the reference must have
    functions : functions of a result that the user defines
    rtol : tolerance of the reference
    quick : whether a coarser reference is enough if edges of the contact move
    confirmed : whether boundary elements confirm it in full contact; this doubles its time

    Raises
    ------
    RingwearError
        if it cannot be computed
    SceneError
        if a function of the user fails
    """
    LOG.info("   %s: reference ...", case.name)
    if not case.problem.full_contact:
        rtol = max(rtol, FINEST_QUICK if quick else FINEST_IN_MOVING_CONTACT)
    finer = replace(case.problem, rtol=rtol, fem=FemAccuracy(), mdr=MdrAccuracy())
    solution = method("mdr").solve(finer, Stages("mdr"))
    values, others = dict(solution.compared), Results()
    if confirmed and finer.full_contact and not method("bem").refusal(finer):
        others = method("bem").solve(finer, Stages("bem")).compared
    closed = closed_forms(case, values)
    if STRESS in names and not finer.ground.layered and len(finer.times):
        states = states_inside(case.problem, solution)
        if len(states):
            space = pressure_space(solution)
            values[STRESS] = boussinesq_stresses(space, states, finer.poisson_ratio)
    if solution.wear is not None:
        values |= dict.fromkeys(ITSELF, np.ones(()))
    try:
        values |= values_of_functions(case, "mdr", solution, functions or {})
    except RingwearError as failure:
        # no level could be compared with it
        raise SceneError(str(failure)) from failure
    values |= closed

    def error_of(part: Part) -> float:
        if part.quantity in closed and part.when != LATER:
            return ROUNDOFF
        errors = [estimate(part, solution, finer), abs(error(part, others, values, finer))]
        return float(np.nanmax([0.0, *errors]))

    return Reference(values, error_of)


def closed_forms(case: Case, values: Results) -> Results:
    """Return the values with a closed form, at the start and in the steady state.

    Parameters
    ----------
    case : what is solved
    values : values of the numerical reference, whose later times are kept
    """
    problem, closed = case.problem, Results()
    if at(problem, START).any():
        for name, value in _start(case).items():
            if name in values:
                closed[name] = np.concatenate([np.asarray(value)[None], values[name][1:]])
    if problem.steady and not method("direct").refusal(problem):
        steady = method("direct").solve(problem, Stages("direct")).compared
        closed |= {name: value for name, value in steady.items() if name.startswith("steady_")}
    return closed


def _start(case: Case) -> dict[str, object]:
    """Return the quantities of the start that have a closed form."""
    problem, force = case.problem, float(case.problem.loading.forces[0])
    if problem.ground.layered:
        return {}
    if not problem.full_contact:
        return dict(shaped_start(case.scene)) if case.scene else {}
    flat = flat_punch_of(problem.inner_radius)
    if problem.indentation is not None:
        return {"normal_force": problem.indentation / flat.indentation}
    return {
        "indentation": force * flat.indentation,
        "pressure": force * flat.pressure_at(problem.face.radii),
    }


def shaped_start(scene: Scene) -> dict[str, float]:
    """Return contact radius and indentation of a sphere or a cone within the face, without units.

    There are none if the force or the speed varies, if the indentation is given, or if the contact
    is not a disc within the face.
    """
    profile, problem = scene.punch.profile, scene.problem
    units = problem.units
    pressed = units.force / (units.modulus * units.length**2)
    if not problem.constant_force:
        return {}
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


def solution_as_reference(solution: Solution) -> Reference:
    """Return a solution as the reference, such as the modal march for steps on the same space."""
    return Reference(dict(solution.compared), lambda _: ROUNDOFF_OF_MARCHES)
