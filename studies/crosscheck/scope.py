"""What a scene requires, and what it does not.

Said before a run by `plan`, and after it in the summary.
"""

import numpy as np

from ..methods.base import method
from ..problem.defaults import truncation
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames
from ..wear.time_scale import MOST_RINGS, slowest_relaxation_time

# counts of the slowest relaxation time before which little has happened, and after which nothing
# does
BEFORE, AFTER = 0.01, 5.0
UNKNOWN_SECONDS = "seconds not known beforehand: contact opens, closes and spreads"


def _marches(scene: Scene) -> bool:
    """Whether any method goes through the scene's times by its march."""
    methods = (method(name) for name in scene.methods)
    return bool(scene.wear.times) and any(
        not one.own_march and "history" not in one.lacks for one in methods
    )


def modelled(scene: Scene) -> list[str]:
    """What is computed, a line each."""
    lines = [f"{name}: {method(name).what}" for name in scene.methods]
    if _marches(scene):
        modal = scene.wear.march == "modal"
        how = (
            "exactly in time, by its relaxation modes" if modal else f"by {scene.wear.march} steps"
        )
        start = "the flat start"
        if not scene.problem.full_contact:
            start = "the unworn face"
            how = (
                "in implicit steps of second order that suit rtol"
                if modal
                else "by steps of implicit Euler"
            )
            lines.append(
                "inequality: pressure >= 0, gap >= 0, one of them zero; contact opens, closes and "
                "spreads"
            )
        lines.append(f"history: {len(scene.wear.times)} times from {start}, {how}")
    if (
        scene.wear.steady
        and scene.load_.indentation is None
        and any("steady state" not in method(name).lacks for name in scene.methods)
    ):
        flat = (
            ""
            if scene.problem.full_contact
            else ", that of the flat punch: wear ends with all of the face in contact"
        )
        lines.append(f"steady state: without any march{flat}")
    return lines


def left_out(scene: Scene) -> dict[str, str]:
    """What is not computed, with the reason."""
    problem = scene.problem
    reasons = {
        "friction and temperature": "not part of the model: the punch is rigid and frictionless"
    }
    if problem.full_contact:
        flat = (
            "a punch that starts flat never loses contact: pressure can only rise where it is "
            "near zero"
        )
        reasons = {"inequality p >= 0": flat, **reasons}
    else:
        reasons["springs' rule of the MDR"] = (
            "q = d - g holds only while contact is one disc; the energy of the MDR needs no disc"
        )
        reasons["relaxation modes"] = (
            "they, and the running-in times, are those of a contact that does not change"
        )
        reasons["ring pressures at the start"] = (
            "they may be infinite at edges of the contact, or on its axis"
        )
        reasons["inside of the half-space"] = "stresses are computed for flat punches only"
        reasons["methods as operators"] = "compared for flat punches only"
    if not scene.wear.times:
        reasons["history"] = "the scene gives no times"
    elif scene.wear.march == "modal" and problem.full_contact and _marches(scene):
        reasons["time steps"] = "the modal march is exact in time"
    if not scene.wear.steady:
        reasons["steady state"] = "the scene says steady = false"
    elif problem.indentation is not None:
        reasons["steady state"] = (
            "at a fixed indentation wear goes on until nothing presses any more"
        )
    for name in scene.methods:
        for what, why in method(name).lacks.items():
            if what not in reasons:
                reasons[f"{what} by {name}"] = why
    if "fem" not in scene.methods:
        reasons["mesh"] = "no method of the scene needs one: neither gmsh nor scikit-fem was loaded"
    elif scene.accuracy.fem.far_field == "fixed":
        reasons["far field"] = (
            "the scene clamps the outer boundary: expect the indentation to err by 1.1 a/R"
        )
    merged = len(problem.wear_coefficients) - len(problem.merged.wear_coefficients)
    if merged:
        reasons["ring edges"] = (
            f"{merged} of them separate rings of equal wear, so nothing happens there"
        )
    return reasons


def refusals(scene: Scene, methods) -> list[str]:
    """Why methods cannot compute a scene, each with its remedy."""
    refused = [refusal for entry in methods.values() if (refusal := entry.refusal(scene.problem))]
    if scene.output.field_times and not scene.problem.full_contact:
        refused.append(
            "output.field_times asks for the inside of the half-space, which is computed for "
            "flat punches under a force only: leave it out"
        )
    return refused


def plan(scene: Scene) -> list[str]:
    """What each method will be made of and cost, without making it.

    Then what is worth knowing before it runs.

    Parameters
    ----------
    scene : what would be computed

    Returns
    -------
    list of str
        lines of text: sizes, seconds on one thread, GiB, and the error that each method's own
        estimate will be about
    """
    problem = scene.problem
    lines, seconds = [], {}
    whole = expected(scene)
    for name, cost in whole.by_method.items():
        lines.append(f"{name}: {method(name).described(problem)}")
        unknown = "error by the sizes given" if problem.full_contact else "error known by the run"
        error = unknown if np.isnan(cost.error) else f"error about {cost.error:.0e}"
        size = f"about {cost.unknowns} unknowns, {cost.pressures} pressures"
        time = f"{cost.seconds:.2g} s, " if np.isfinite(cost.seconds) else ""
        lines.append(f"    {size}, {time}{error}")
        if np.isfinite(cost.seconds) and not ("history" in method(name).lacks and scene.wear.times):
            seconds[name] = cost.seconds
    if seconds:
        lines.append(
            f"cheapest for rtol {problem.rtol:.0e}: {min(seconds, key=seconds.__getitem__)}"
        )
    checked = f"comparing operators {whole.check:.2g} s, " if whole.check else ""
    most = max(whole.memory, key=whole.memory.__getitem__)
    total = f"{whole.seconds:.2g} s" if np.isfinite(whole.seconds) else UNKNOWN_SECONDS
    lines.append(
        f"in all: {total} ({checked}loading and files {whole.numbers:.2g} s, figures "
        f"{whole.figures:.2g} s), {whole.gib:.2g} GiB, most of it for {most}"
    )
    lines += [f"refused: {refusal}" for refusal in refusals(scene)]
    lines += [f"note: {note}" for name in scene.methods for note in method(name).notes(problem)]
    if "fem" in scene.methods and {"mdr", "bem"}.isdisjoint(scene.methods):
        lines.append(
            "note: in full contact the MDR gives the same at a fraction of the cost; add 'mdr' to "
            "see how far they agree"
        )
    if "fem" in scene.methods and problem.fem.far_field == "fixed":
        outer = truncation(problem)
        lines.append(
            f"note: a fixed boundary at {outer:g} a will err by {1.1 / outer:.1e}; "
            "far_field = 'boussinesq' does not"
        )
    return lines


def time_scale(scene: Scene) -> list[str]:
    """How long running-in will take, and whether the times asked for show it.

    Nothing without a history.
    """
    if not scene.problem.earliest:
        return []
    if not scene.problem.full_contact:
        return ["running-in: not known beforehand where contact opens, closes and spreads"]
    slowest = slowest_relaxation_time(scene.problem.rings)
    if not np.isfinite(slowest):
        return [f"running-in: not known beforehand for more than {MOST_RINGS} rings"]
    names, times = UnitNames.of(scene.units), [time for time in scene.wear.times if time]
    first, last = scene.problem.earliest / slowest, float(scene.problem.times[-1]) / slowest
    written = names.write(slowest * scene.problem.units.time, "time", 3)
    lines = [
        f"running-in: slowest relaxation time {written}; the {len(times)} times after the start go "
        f"from {first:.2g} to "
        f"{last:.2g} of it"
    ]
    return lines + outside(first, last)


def outside(first: float, last: float) -> list[str]:
    """A warning if all times, as counts of the slowest relaxation time, lie before or after the
    running-in.
    """
    remedy = 'times = "running-in" shows all of it'
    if last < BEFORE:
        return [
            "note: all times lie before the running-in, of which hardly anything is seen by then: "
            f"{remedy}"
        ]
    if first > AFTER:
        return [
            f"note: all times lie after the running-in, so that nothing of it is seen: {remedy}"
        ]
    return []
