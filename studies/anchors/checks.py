"""Check what a method reports against everything that applies to the scene.

Anchors test the table that is written, made non-dimensional by a second reading of the scene. So a
number that is scaled, sampled or derived wrongly shows, and so does an error that all methods
share. Each method is checked by itself. In full contact, with the greatest force 1,

    F = int p dA, on each ring too           force
    int F v0 dt = int f / k dA               what has worn is what the pressure has worn
    V_j(t2) - V_j(t1) = k_j int F_j ds       the same on each ring
    d = F d0 + int f p0 dA                   reciprocity with the flat punch, u0 = d0
    d = int us p dA + int f ps dA            reciprocity with the steady pressures ps
    d'(2 t) = int k p^2 dA                   power, at F = 1

and at a fixed indentation, with ``d0 F`` for d0 and ``-d0 F'`` for d' in the fourth and the last,

    F(t2) dt <= int df / k dA <= F(t1) dt    what wears from t1 to t2 = t1 + dt, because F decays
    A d = int (f + m + u1 p - gap) dA        reciprocity with a uniform pressure on the face of
                                             area A; m unworn
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from numpy.typing import ArrayLike

from ..methods.base import Solution
from ..problem.problem import Problem
from ..problem.quantities import HISTORIES, STEADY
from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT
from ..scene.scene import Scene
from . import answers, balances, fields, inputs, moving, start, steady, wear
from .anchor import Anchor, Rows, judge
from .reported import Reported


class Check(NamedTuple):
    """A function that yields anchors.

    Parameters
    ----------
    run : yields them
    needs : quantities that a method has to give with an error estimate
    applies : whether a scene has them; needs alone decide if it is None
    """

    run: Callable[[Reported], Rows]
    needs: str = ""
    applies: Callable[[Reported], bool] | None = None


def _full(report: Reported) -> bool:
    return report.full


def _later(report: Reported) -> bool:
    return bool(report.later.any())


def _full_and_later(report: Reported) -> bool:
    return report.full and bool(report.later.any())


def _fixed(report: Reported) -> bool:
    return report.fixed


def _fixed_and_later(report: Reported) -> bool:
    return report.fixed and report.full and bool(report.later.any())


def _given_force_and_later(report: Reported) -> bool:
    return not report.fixed and _full_and_later(report)


def _moving(report: Reported) -> bool:
    return not report.full and report.times.size > 0


MOVING_FIELDS = "pressure profile displacement indentation normal_force"
CHECKS = (
    Check(inputs.check_inputs),
    Check(inputs.check_times),
    Check(steady.check_steady_state, " ".join(sorted(STEADY))),
    Check(balances.check_forces, "ring_force pressure"),
    Check(balances.check_worn_volumes, "ring_worn_volume"),
    Check(balances.check_decay, "normal_force ring_worn_volume", _fixed),
    Check(
        balances.check_fixed_indentation,
        "indentation normal_force pressure profile displacement ring_worn_volume",
        _fixed,
    ),
    Check(start.check_start, "indentation", _full),
    Check(start.check_start_pressures, "pressure ring_force", _full),
    Check(fields.check_modes, "relaxation_time", _full),
    Check(
        fields.check_fields,
        "indentation profile displacement displacement_centre displacement_max",
        _full,
    ),
    Check(fields.check_slopes, "profile rms_slope", _full),
    Check(fields.check_output, "indentation pressure profile displacement", _later),
    Check(wear.check_wear, "indentation pressure profile", _given_force_and_later),
    Check(wear.check_wear, "indentation pressure profile normal_force", _fixed_and_later),
    Check(wear.check_power, "pressure", _full_and_later),
    Check(wear.check_ring_volumes, "indentation profile ring_force", _full_and_later),
    Check(answers.check_times_of_running_in, "indentation", _full),
    Check(answers.check_repeated_numbers),
    Check(answers.check_worn_volumes_of_profile, "indentation profile"),
    Check(moving.check_kinematics, MOVING_FIELDS, _moving),
    Check(moving.check_reciprocity, MOVING_FIELDS, _moving),
    Check(
        moving.check_numbers_of_fields,
        f"{MOVING_FIELDS} contact_radius displacement_centre displacement_max rms_slope",
        _moving,
    ),
    Check(moving.check_pressures_inside, MOVING_FIELDS, _moving),
    Check(moving.check_disc, MOVING_FIELDS, _moving),
    Check(moving.check_peak, MOVING_FIELDS, _moving),
)

# anchors that every report of a kind has, by name: where one is missing, nothing was checked
OF_INPUTS = (
    "rtol as asked",
    "average as asked",
    "ring edges as asked",
    "wear coefficients as asked",
    "wear coefficients reported",
    "inner radii reported",
    "outer radii reported",
)
OF_STEADY_STATES = ("steady_wear_rate in closed form", "steady pressures of Eq. 24")
OF_CONTACT = {
    FULL_CONTACT: (
        "flat start of the answer",
        "force shares of the answer at the start",
        "running-in time of the answer",
        "displacement, u = d - f",
        "greatest displacement",
        "reciprocity with the flat punch",
        "modes add up to the flat start",
        "worn volumes of the answer, of the profile",
    ),
    MOVING_CONTACT: (
        "u + f = d where it presses",
        "no gap below zero",
        "F = int p dA",
        "reciprocity with a uniform pressure",
        "reciprocity with the flat punch",
        "contact ends where p does",
        "greatest displacement",
    ),
}
# by the quantity that the load does not give
OF_RESPONSE = {
    "indentation": ("ring forces add up to F",),
    "normal_force": ("worn, unworn and pressed in, of the overlap A d",),
}


def anchors(
    scene: Scene, name: str, table: Mapping[str, ArrayLike], solution: Solution
) -> list[Anchor]:
    """Return all anchors that apply to what a method reports.

    Parameters
    ----------
    scene : what was asked for
    name : name of the method
    table : what is written of it, by the names of quantities, in the scene's units
    solution : what the method states of the face, and of its own errors
    """
    report = Reported(scene, name, table, solution)
    stated = solution.checked.keys() & solution.errors.keys()
    given = set(filter(scene.problem.wants, stated))
    if not report.times.size:
        given -= HISTORIES
    return [
        anchor
        for check in CHECKS
        if given.issuperset(check.needs.split()) and (not check.applies or check.applies(report))
        for row in check.run(report)
        for anchor in judge(row, name)
    ]


def expected_anchors(problem: Problem, solution: Solution) -> tuple[str, ...]:
    """Return the names of the anchors that a method's report must have.

    A run that asks for some quantities only has those of the inputs at the least.
    """
    names: tuple[str, ...] = OF_INPUTS
    if problem.quantities is not None:
        return names
    if problem.steady and "steady_pressure" in solution.checked:
        names += OF_STEADY_STATES
    marched = solution.wear is not None or solution.march is not None
    if not (marched and problem.earliest and problem.march == "modal"):
        return names
    return names + OF_CONTACT[problem.contact] + OF_RESPONSE[problem.load_regime.response]
