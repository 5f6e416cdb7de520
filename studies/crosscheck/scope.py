"""What a scene requires, and what it does not: said before a run by `plan`, and after it in the summary."""

import numpy as np

from ringwear.studies.methods.base import method
from ringwear.studies.problem.defaults import truncation
from ringwear.studies.problem.scene import Scene


def _marches(scene: Scene) -> bool:
    """Whether any method goes through the scene's times by its march."""
    methods = (method(name) for name in scene.methods)
    return bool(scene.wear.times) and any(not one.own_march and "history" not in one.lacks for one in methods)


def modelled(scene: Scene) -> list[str]:
    """What is computed, a line each."""
    lines = [f"{name}: {method(name).what}" for name in scene.methods]
    if _marches(scene):
        modal = scene.wear.march == "modal"
        how = "exactly in time, by its relaxation modes" if modal else f"by {scene.wear.march} steps"
        start = "the flat start"
        if scene.problem.profile is not None:
            start = "the unworn face"
            how = "in implicit steps of second order that suit rtol" if modal else "by steps of implicit Euler"
            lines.append("inequality: pressure >= 0, gap >= 0, one of them zero; contact opens, closes and spreads")
        lines.append(f"history: {len(scene.wear.times)} times from {start}, {how}")
    if (
        scene.wear.steady
        and scene.load_.indentation is None
        and any("steady state" not in method(name).lacks for name in scene.methods)
    ):
        flat = "" if scene.problem.profile is None else ", that of the flat punch: wear ends with all of the face in contact"
        lines.append(f"steady state: without any march{flat}")
    return lines


def left_out(scene: Scene) -> dict[str, str]:
    """What is not computed, with the reason."""
    problem = scene.problem
    reasons = {"friction and temperature": "not part of the model: the punch is rigid and frictionless"}
    if problem.profile is None:
        flat = "a punch that starts flat never loses contact: pressure can only rise where it is near zero"
        reasons = {"inequality p >= 0": flat, **reasons}
    else:
        reasons["springs' rule of the MDR"] = (
            "q = d - g holds only while contact is one disc; the energy of the MDR needs no disc"
        )
        reasons["relaxation modes"] = "they are those of a contact that does not change"
        reasons["inside of the half-space"] = "stresses are computed for flat punches only"
        reasons["methods as operators"] = "compared for flat punches only"
    if not scene.wear.times:
        reasons["history"] = "the scene gives no times"
    elif scene.wear.march == "modal" and problem.profile is None and _marches(scene):
        reasons["time steps"] = "the modal march is exact in time"
    if not scene.wear.steady:
        reasons["steady state"] = "the scene says steady = false"
    elif problem.indentation is not None:
        reasons["steady state"] = "at a fixed indentation wear goes on until nothing presses any more"
    for name in scene.methods:
        for what, why in method(name).lacks.items():
            if what not in reasons:
                reasons[f"{what} by {name}"] = why
    if "fem" not in scene.methods:
        reasons["mesh"] = "no method of the scene needs one: neither gmsh nor scikit-fem was loaded"
    elif scene.accuracy.fem.far_field == "fixed":
        reasons["far field"] = "the scene clamps the outer boundary: expect the indentation to err by 1.1 a/R"
    merged = len(problem.wear_coefficients) - len(problem.merged.wear_coefficients)
    if merged:
        reasons["ring edges"] = f"{merged} of them separate rings of equal wear, so nothing happens there"
    return reasons


def plan(scene: Scene) -> list[str]:
    """What each method will be made of and cost, without making it; then what is worth knowing before it runs."""
    problem = scene.problem
    lines, seconds = [], {}
    for name in scene.methods:
        cost = method(name).cost(problem)
        lines.append(f"{name}: {method(name).described(problem)}")
        unknown = "error by the sizes given" if problem.profile is None else "error told by the run"
        error = unknown if np.isnan(cost.error) else f"error about {cost.error:.0e}"
        size = f"about {cost.unknowns} unknowns, {cost.pressures} pressures"
        lines.append(f"    {size}, {cost.seconds:.2g} s, {cost.memory:.2g} GiB, {error}")
        if np.isfinite(cost.seconds) and not ("history" in method(name).lacks and scene.wear.times):
            seconds[name] = cost.seconds
    if seconds:
        lines.append(f"cheapest for rtol {problem.rtol:.0e}: {min(seconds, key=seconds.__getitem__)}")
    lines += [f"note: {note}" for name in scene.methods for note in method(name).notes(problem)]
    if problem.profile is not None:
        lines += [f"note: it will not run: {no}" for name in scene.methods if (no := method(name).refusal(problem))]
    if "fem" in scene.methods and {"mdr", "bem"}.isdisjoint(scene.methods):
        lines.append(
            "note: in full contact the MDR gives the same at a fraction of the cost; add 'mdr' to see how far they agree"
        )
    if "fem" in scene.methods and problem.fem.far_field == "fixed":
        outer = truncation(problem)
        lines.append(f"note: a fixed boundary at {outer:g} a will err by {1.1 / outer:.1e}; "
                     "far_field = 'boussinesq' does not")  # fmt: skip
    return lines
