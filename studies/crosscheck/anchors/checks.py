"""List all anchors, and check a method's report against those that apply to the scene.

Anchors test the table in `results.nc`, made non-dimensional with a second reading of the scene.
They therefore detect numbers that are scaled, sampled or derived wrongly, and errors that all
methods share. Each method is checked on its own. In full contact, with the greatest force 1,

    F = int p dA, on each ring too           force
    int F v0 dt = int f / k dA               Archard's law, integrated over face and time
    V_j(t2) - V_j(t1) = k_j int F_j ds       the same on each ring
    d'(2 t) = int k p^2 dA                   power, at F = 1

At a fixed indentation F is the decaying force, and ``-d0 F'`` replaces d' in the last equation.
In addition,

    F(t2) dt <= int df / k dA <= F(t1) dt    wear from t1 to t2 = t1 + dt, because F decays
    A d = int (f + m + u1 p - gap) dA        reciprocity with a uniform pressure on the face of
                                             area A, with the unworn profile m
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from numpy.typing import ArrayLike

from ..methods.base import Solution
from ..problem.problem import Problem
from ..problem.quantities import HISTORIES, STEADY
from ..scene.scene import Scene
from . import answers, closed_forms, fields, identities, modes
from .anchor import Anchor, Rows, judge
from .reading import Reading
from .reported import Reported


class Check(NamedTuple):
    """A function that yields anchors.

    Parameters
    ----------
    run : the function
    needs : quantities that the method must report with an error estimate, separated by spaces
    applies : whether the anchors apply to a report; None if they always do
    """

    run: Callable[[Reported], Rows]
    needs: str = ""
    applies: Callable[[Reported], bool] | None = None


def _full_contact(report: Reported) -> bool:
    return report.full_contact


def _sliding(report: Reported) -> bool:
    return bool(report.has_slid.any())


def _given_force_and_sliding(report: Reported) -> bool:
    return report.full_contact and not report.fixed_indentation and _sliding(report)


FIELDS_OF_CONTACT = "pressure profile displacement indentation normal_force"
CHECKS = (
    Check(answers.check_inputs),
    Check(answers.check_table),
    Check(closed_forms.check_steady_state, " ".join(sorted(STEADY))),
    Check(identities.check_forces, "ring_force pressure"),
    Check(identities.check_mean_contact_radius, "mean_contact_radius normal_force pressure"),
    Check(identities.check_worn_volumes, "ring_worn_volume"),
    Check(closed_forms.check_start, "indentation", _full_contact),
    Check(closed_forms.check_start_pressures, "pressure ring_force", _full_contact),
    Check(modes.check_relaxation_times, "running_in_time"),
    Check(modes.check_modes_of_history, "", _full_contact),
    Check(fields.check_output, "indentation pressure profile displacement", _sliding),
    Check(closed_forms.check_wear, "indentation pressure profile", _given_force_and_sliding),
    Check(answers.check_times_of_running_in, "indentation"),
    Check(answers.check_time_to_full_contact, "time_to_full_contact"),
    Check(answers.check_repeated_numbers),
    Check(answers.check_peak, "pressure pressure_peak_start"),
    Check(identities.check_kinematics, FIELDS_OF_CONTACT),
    Check(identities.check_force, FIELDS_OF_CONTACT),
    Check(identities.check_reciprocity, FIELDS_OF_CONTACT),
    Check(
        identities.check_extremes,
        f"{FIELDS_OF_CONTACT} displacement_centre displacement_max",
    ),
    Check(identities.check_slope, f"{FIELDS_OF_CONTACT} rms_slope"),
    Check(fields.check_contact, f"{FIELDS_OF_CONTACT} contact_radius"),
)

# names of the anchors that every report of a kind must have; the verdict is undecided without them
INPUT_ANCHORS = (
    "rtol as in the scene",
    "gradient average as in the scene",
    "ring edges as in the scene",
    "wear coefficients as in the scene",
    "reported wear coefficients",
    "the table has the numbers of the solution",
)
STEADY_ANCHORS = ("steady_wear_rate in closed form", "steady pressures of Eq. 24")
CONTACT_ANCHORS = (
    "u + f = d in contact",
    "F = int p dA",
    "greatest displacement",
    "reciprocity with the flat punch",
)
FULL_CONTACT_ANCHORS = (
    "flat start of the answer",
    "running-in time of the answer",
    "modes add up to the flat start",
)
MOVING_CONTACT_ANCHORS = (
    "no negative gap",
    "reciprocity with a uniform pressure",
    "contact radius, the outermost edge",
    "edges of the contact, by the pressure",
)


def anchors(
    scene: Scene,
    reports: Mapping[str, tuple[Mapping[str, ArrayLike], Mapping[str, ArrayLike], Solution]],
) -> list[Anchor]:
    """Return all anchors that apply to the reports of methods.

    Parameters
    ----------
    scene : the scene that was solved
    reports : by the name of each method, its values in `results.nc` and its answer by the names of
        quantities, in the scene's units, and its solution with the error estimates
    """
    # references that depend on the scene alone are computed once for all methods
    reading = Reading.of(scene)
    return [
        anchor
        for name, report in reports.items()
        for anchor in _anchors_of(Reported(scene, reading, name, *report))
    ]


def _anchors_of(report: Reported) -> list[Anchor]:
    """Return all anchors that apply to a method's report."""
    scene, solution = report.scene, report.solution
    with_error = solution.compared.keys() & solution.errors.keys()
    wanted = set(filter(scene.problem.wants, with_error))
    if not report.times.size:
        wanted -= HISTORIES
    return [
        anchor
        for check in CHECKS
        if wanted.issuperset(check.needs.split()) and (not check.applies or check.applies(report))
        for row in check.run(report)
        for anchor in judge(row, report.name)
    ]


def expected_anchors(problem: Problem, solution: Solution) -> tuple[str, ...]:
    """Return the names of the anchors that a method's report must have.

    A run for selected quantities must have the anchors of the inputs only.
    """
    names: tuple[str, ...] = INPUT_ANCHORS
    if problem.quantities is not None:
        return names
    if problem.steady and "steady_pressure" in solution.compared:
        names += STEADY_ANCHORS
    marched = solution.wear is not None or solution.evolution is not None
    if not (marched and problem.earliest and problem.march == "modal"):
        return names
    of_kind = FULL_CONTACT_ANCHORS if problem.full_contact else MOVING_CONTACT_ANCHORS
    return names + CONTACT_ANCHORS + of_kind
