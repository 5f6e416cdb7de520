"""List the figures of a run: file name, caption, drawing function, and required data.

What draws them, and matplotlib, is loaded when the first figure is drawn.
"""

from collections.abc import Callable, Iterable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...meshes import SceneError
from ..crosscheck import OVER_TIME, did_you_mean, shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Picture(NamedTuple):
    """A figure of a run.

    Parameters
    ----------
    file : str
        Name of the file in the folder of results.
    caption : str
        Caption on the page.
    draw : Result -> Figure
        Function that draws the figure.
    drawn_for : Result -> bool
        Function that returns whether a result has the data of the figure.
    quantities : tuple of str
        Quantities that the figure shows by every method and by every other program.
    of_inside : bool
        Whether it shows the inside of the half-space.
    """

    file: str
    caption: str
    draw: "Callable[[Any], Figure]"
    drawn_for: Callable[[Any], bool]
    quantities: tuple[str, ...] = ()
    of_inside: bool = False

    @property
    def name(self) -> str:
        """Name of the figure: that of its file without the ending."""
        return Path(self.file).stem

    def figure(self, result: Any) -> "Figure":
        """Return the figure of a result."""
        from .style import in_style

        with in_style():
            return self.draw(result)

    def write(self, result: Any, path: Path) -> None:
        """Draw the figure of a result and write it as PNG."""
        from .style import save

        save(path, self.draw, result)


def picture_of(pictures: Iterable[Picture], name: str = "") -> Picture:
    """Return the picture of a name; without one, the first.

    Raises
    ------
    SceneError
        if there is no such picture; the message lists the available ones
    """
    by_name = {picture.name: picture for picture in pictures}
    name = name or next(iter(by_name), "")
    if not isinstance(name, str) or name not in by_name:
        available = ", ".join(by_name) or "none: all selected quantities are numbers"
        hint = did_you_mean(name, by_name, f"give one of {available}")
        raise SceneError(f"no figure {shown(name)} of these results{hint}")
    return by_name[name]


def drawn_by(place: str, **options: Any) -> "Callable[[Any], Figure]":
    """Return a function that draws by another one, whose module is loaded at the first call.

    Parameters
    ----------
    place : module of the function within `figures`, a colon, and its name
    options : arguments of the function besides the result
    """
    module, name = place.split(":")
    return lambda result: getattr(import_module(f".{module}", __package__), name)(result, **options)


def _has_history(result: Any) -> bool:
    problem = result.scene.problem
    return problem.earliest > 0 and problem.wants("rms_slope") and result.gives("displacement_max")


# quantities that the figure of a contact with moving edges needs
IN_CONTACT = ("contact_edge", "ring_force", "normal_force", "ring_worn_volume")


def _has_changing_contact(result: Any) -> bool:
    """Return whether the contact, or the force of a falling load, changes over the times."""
    problem = result.scene.problem
    changes = problem.keeps_contact or not problem.full_contact
    return changes and problem.earliest > 0 and result.gives(*IN_CONTACT)


PICTURES = (
    Picture(
        "profiles_and_pressures.png",
        "Worn profiles, minus a height printed above each, and contact pressures, at some of the "
        "times.",
        drawn_by("states:draw_states"),
        lambda result: result.gives("profile", "pressure"),
        ("profile", "pressure"),
    ),
    Picture(
        "history.png",
        "Running-in: greatest displacement and RMS slope over time, and the differences of the "
        "methods.",
        drawn_by("history:draw_history"),
        _has_history,
        ("displacement_max", "indentation", "normal_force", "rms_slope"),
    ),
    Picture(
        "contact.png",
        "Edges of the contact over time, its inside shaded, and force and worn volume of each "
        "ring.",
        drawn_by("history:draw_contact"),
        _has_changing_contact,
    ),
    Picture(
        "steady_state.png",
        "The steady state: limiting profile and pressure.",
        drawn_by("states:draw_steady"),
        lambda result: result.gives("steady_profile", "steady_pressure"),
    ),
    Picture(
        "difference.png",
        "One method minus the other: pressure, worn profile and displacement along the radius, "
        "relative to their norms, with the error estimate of each method as a band; and the same "
        "differences over radius and time, with the largest one marked.",
        drawn_by("difference:draw_result_difference"),
        lambda result: bool(result.field_comparisons),
        OVER_TIME,
    ),
    Picture(
        "stress.png",
        "Von Mises stress in the half-space under the contact.",
        drawn_by("mesh:draw_stress"),
        lambda result: result.has_inside and any(map(len, result.inside().parts)),
        of_inside=True,
    ),
    Picture(
        "mesh.png",
        "The mesh of the half-space.",
        drawn_by("mesh:draw_result_mesh"),
        lambda result: result.has_inside,
    ),
)


def picture_of_field(name: str, index: int) -> Picture:
    """Return the figure of a field along the radius, at the time with an index."""
    return Picture(
        f"{name}.png",
        f"{name} along the radius, at one of the times.",
        drawn_by("states:draw_field", name=name, index=index),
        lambda result: result.gives(name),
    )
