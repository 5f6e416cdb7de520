"""The figures of a run: what each is called, shows and needs; the folder and the page follow it."""

from ..outcome.outcome import Outcome
from .contact import draw_contact
from .difference import draw_result_difference
from .history import draw_history
from .mesh import draw_result_mesh, draw_stress
from .operators import draw_operators
from .states import draw_states, draw_steady
from .style import Picture


def _has_history(result: Outcome) -> bool:
    return result.scene.problem.earliest > 0 and result.gives("displacement_max", "rms_slope")


# what is drawn of a contact that opens, closes and spreads
IN_CONTACT = ("contact_edge", "ring_force", "normal_force", "ring_worn_volume")
PICTURES = (
    Picture(
        "profiles_and_pressures.png",
        "Worn profiles less their least wear, and contact pressures, at some of the times.",
        draw_states,
        lambda result: result.gives("profile", "pressure"),
    ),
    Picture(
        "history.png",
        "Running-in: greatest displacement and RMS slope over time, and by how much the methods "
        "differ.",
        draw_history,
        _has_history,
    ),
    Picture(
        "contact.png",
        "Edges of the contact over time, its inside shaded, and what each ring carries and has "
        "worn off.",
        draw_contact,
        lambda result: result.scene.problem.earliest > 0 and result.gives(*IN_CONTACT),
    ),
    Picture(
        "steady_state.png",
        "The steady state: limiting profile and pressure.",
        draw_steady,
        lambda result: result.gives("steady_profile", "steady_pressure"),
    ),
    Picture(
        "difference.png",
        "One method minus the other: pressure, worn profile and displacement along the radius, "
        "relative to their norms, with the error that each method states as a band; and the same "
        "differences over radius and time, the largest of them marked and named.",
        draw_result_difference,
        lambda result: bool(result.field_comparisons),
    ),
    Picture(
        "operator_difference.png",
        "The methods compared for every pressure at once. The answer is made of the long waves at "
        "the right. The waves in the shaded part are finer than the elements, and large "
        "differences there do not matter.",
        draw_operators,
        lambda result: bool(result.operators),
    ),
    Picture(
        "stress.png",
        "Von Mises stress in the half-space, where the punch presses on it.",
        draw_stress,
        lambda result: result.has_inside and any(map(len, result.inside.parts)),
    ),
    Picture(
        "mesh.png",
        "The mesh of the half-space.",
        draw_result_mesh,
        lambda result: result.has_inside,
    ),
)
