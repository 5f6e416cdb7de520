"""List the figures of a run: file name, caption, drawing function, and required data."""

from functools import partial

from ..crosscheck import OVER_TIME, Result
from .difference import draw_result_difference
from .history import draw_contact, draw_history
from .mesh import draw_result_mesh, draw_stress
from .states import draw_field, draw_states, draw_steady
from .style import Picture


def _has_history(result: Result) -> bool:
    problem = result.scene.problem
    return problem.earliest > 0 and problem.wants("rms_slope") and result.gives("displacement_max")


# quantities that the figure of a contact with moving edges needs
IN_CONTACT = ("contact_edge", "ring_force", "normal_force", "ring_worn_volume")


def _has_changing_contact(result: Result) -> bool:
    """Return whether the contact, or the force of a falling load, changes over the times."""
    problem = result.scene.problem
    changes = problem.keeps_contact or not problem.full_contact
    return changes and problem.earliest > 0 and result.gives(*IN_CONTACT)


PICTURES = (
    Picture(
        "profiles_and_pressures.png",
        "Worn profiles, minus a height printed above each, and contact pressures, at some of the "
        "times.",
        draw_states,
        lambda result: result.gives("profile", "pressure"),
        ("profile", "pressure"),
    ),
    Picture(
        "history.png",
        "Running-in: greatest displacement and RMS slope over time, and the differences of the "
        "methods.",
        draw_history,
        _has_history,
        ("displacement_max", "indentation", "normal_force", "rms_slope"),
    ),
    Picture(
        "contact.png",
        "Edges of the contact over time, its inside shaded, and force and worn volume of each "
        "ring.",
        draw_contact,
        _has_changing_contact,
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
        "relative to their norms, with the error estimate of each method as a band; and the same "
        "differences over radius and time, with the largest one marked.",
        draw_result_difference,
        lambda result: bool(result.field_comparisons),
        OVER_TIME,
    ),
    Picture(
        "stress.png",
        "Von Mises stress in the half-space under the contact.",
        draw_stress,
        lambda result: result.has_inside and any(map(len, result.inside().parts)),
        of_inside=True,
    ),
    Picture(
        "mesh.png",
        "The mesh of the half-space.",
        draw_result_mesh,
        lambda result: result.has_inside,
    ),
)


def picture_of_field(name: str, index: int) -> Picture:
    """Return the figure of a field along the radius, at the time with an index."""
    return Picture(
        f"{name}.png",
        f"{name} along the radius, at one of the times.",
        partial(draw_field, name=name, index=index),
        lambda result: result.gives(name),
    )
