"""What a scene requires, and what it does not: told before a run by `plan`, and after it in the summary."""

from __future__ import annotations

import numpy as np
from ringwear.studies.problem.scene import Scene

METHODS = {
    "mdr": "the half-space by dimensionality reduction, exact for full contact but for the pressure space",
    "bem": "the half-space by boundary elements: the ring kernel of Eq. 19, no identity of the MDR in it",
    "direct": "the steady state by direct integration, in closed form",
    "fem": "the half-space by finite elements: a graded quarter disc with Boussinesq's far field, condensed to the contact",
}


def modelled(scene: Scene) -> list[str]:
    """What is computed, a line each."""
    lines = [f"{method}: {METHODS[method]}" for method in scene.methods]
    if scene.wear.times and set(scene.methods) - {"direct"}:
        how = {"modal": "exactly in time, by its relaxation modes"}.get(scene.wear.march, f"by {scene.wear.march} steps")
        lines.append(f"history: {len(scene.wear.times)} times from the flat start, {how}")
    if scene.wear.steady:
        lines.append("steady state: without any march")
    return lines


def left_out(scene: Scene) -> dict[str, str]:
    """What is not computed, with the reason."""
    reasons = {
        "inequality p >= 0": "a punch that starts flat never loses contact: pressure can only rise where it is near zero",
        "friction and temperature": "not part of the model: the punch is rigid and frictionless",
    }
    natural = scene.natural
    if not scene.wear.times:
        reasons["history"] = "the scene gives no times"
    elif "direct" in scene.methods:
        reasons["history by direct"] = "direct integration knows the steady state only"
    if scene.wear.times and scene.wear.march == "modal":
        reasons["time steps"] = "the modal march is exact in time"
    if not scene.wear.steady:
        reasons["steady state"] = "the scene says steady = false"
    if "fem" not in scene.methods:
        reasons["mesh"] = "no method of the scene needs one: neither gmsh nor scikit-fem was loaded"
    elif scene.accuracy.fem.far_field == "fixed":
        reasons["far field"] = "the scene clamps the outer boundary: expect the indentation to err by 1.1 a/R"
    merged = len(natural.wear) - len(natural.phases[1])
    if merged:
        reasons["ring edges"] = f"{merged} of them separate rings of equal wear, so nothing happens there"
    return reasons


def plan(scene: Scene) -> list[str]:
    """What each method will be made of and cost, without making it; then what is worth knowing before it runs."""
    from ringwear.studies.crosscheck.costs import predicted
    from ringwear.studies.methods.fem import described, truncation
    from ringwear.studies.methods.radial import mdr_settings

    natural = scene.natural
    lines, seconds = [], {}
    for method in scene.methods:
        if method == "fem":
            made_of = described(natural)
        elif method == "direct":
            made_of = "closed form, nothing to resolve"
        else:
            made_of = ", ".join(f"{name} {value:.3g}" for name, value in mdr_settings(natural).items())
        cost = predicted(natural, method)
        seconds[method] = cost.seconds
        lines.append(f"{method}: {made_of}")
        lines.append(
            f"    about {cost.unknowns} unknowns, {cost.pressures} pressures, {cost.seconds:.2g} s, {cost.memory:.2g} GiB, "
            + ("error by the sizes given" if np.isnan(cost.error) else f"error about {cost.error:.0e}")
        )
    able = {method: value for method, value in seconds.items() if method != "direct" or not scene.wear.times}
    if able:
        lines.append(f"cheapest for rtol {scene.accuracy.rtol:.0e}: {min(able, key=lambda method: able[method])}")
    if "fem" in scene.methods and {"mdr", "bem"}.isdisjoint(scene.methods):
        lines.append(
            "note: in full contact the MDR gives the same at a fraction of the cost; add 'mdr' to see how far they agree"
        )
    if scene.accuracy.fem.far_field == "fixed" and "fem" in scene.methods:
        outer = truncation(natural)
        lines.append(f"note: a fixed boundary at {outer:g} a will err by {1.1 / outer:.1e}; "
                     "far_field = 'boussinesq' does not")  # fmt: skip
    return lines
