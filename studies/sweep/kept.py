"""Which quantities of each scene are kept."""

from typing import TYPE_CHECKING, Any

from ...meshes.errors import SceneError
from ..problem.sections import WearSection

if TYPE_CHECKING:
    from ..methods.quantities import Quantity

# answers (`studies/crosscheck/answer.py`) that can be kept, and the quantities that they are found
# from; methods state no errors of them
ANSWERS = {
    "worn_volume": ("profile",),
    "force_share": ("indentation", "steady_pressure", "steady_displacement_max"),
    "running_in_time": ("indentation",),
    "time_to_90": ("indentation",),
    "time_to_99": ("indentation",),
}
# of scenes that several methods compute, by the quantities kept
JUDGED = {
    "disagreement": (
        "greatest difference of two methods over its uncertainty: above 1 they disagree"
    ),
    "effectivity": "least error stated, over the error that a far more accurate method shows",
}


def keepable() -> dict[str, "Quantity"]:
    """Return the quantities and answers of a flat punch that can be kept."""
    from ..methods.quantities import ANSWER, OF_PROFILES, QUANTITIES

    flat = {name: QUANTITIES[name] for name in QUANTITIES if name not in OF_PROFILES}
    return flat | {name: ANSWER[name] for name in ANSWERS}


def checked_keep(keep: Any, wear: WearSection, name: str) -> tuple[str, ...]:
    """The quantities to keep.

    Those named, or all that need no radius and no ring and that the scene asks for.
    """
    from ..methods.quantities import HISTORIES

    known = keepable()
    if keep is None:
        plain = [name for name in known if not {"radius", "ring"} & set(known[name].dims)]
        return tuple(name for name in plain if name not in ANSWERS and asked_for(wear, name))
    if not (isinstance(keep, list) and keep and all(isinstance(one, str) for one in keep)):
        raise SceneError(
            f"{name}: keep = {keep!r}: give a list of quantities, some of {', '.join(known)}"
        )
    for one in keep:
        if one not in known:
            raise SceneError(
                f"{name}: keep names '{one}', which is no quantity of a flat punch: give some of "
                f"{', '.join(known)}"
            )
        if not asked_for(wear, one) and one != "relaxation_time":
            missing = "wear.times" if one in HISTORIES or one in ANSWERS else "wear.steady = true"
            raise SceneError(
                f"{name}: keep names '{one}', which the base does not ask for: give it {missing}"
            )
    return tuple(dict.fromkeys(keep))


def asked_for(wear: WearSection, name: str) -> bool:
    """Whether a scene with such times asks for a quantity."""
    if name in ANSWERS:
        return any(asked_for(wear, needed) for needed in ANSWERS[name])
    return wear.steady if name.startswith("steady_") else bool(wear.times)
