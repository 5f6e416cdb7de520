"""The scope of a run in words: what is computed for a scene, and what is left out.

The command `plan` prints it before a run, and the summary contains it after the run.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ....meshes.errors import SceneError
from ..methods.base import Method, method
from ..problem.problem import Problem
from ..problem.sections import LEAST_TRUNCATION
from ..problem.written import check_one_line
from ..scene.scene import Scene
from ..wear.time_scale import MOST_RINGS, slowest_relaxation_time, spreading_times

Methods = Mapping[str, Method]
# mean pressure over the plane strain modulus above which strains are not small
MOST_STRAIN = 0.01
# what a history starts from, and how the modal march proceeds in time, by whether the punch is in
# full contact
HISTORY = {
    True: ("the flat start", "exact in time, by its relaxation modes"),
    False: ("the unworn face", "in implicit steps of second order, chosen from rtol"),
}
INEQUALITIES = (
    "inequalities: pressure >= 0, gap >= 0, and one of them is zero at each point; contact opens, "
    "closes and spreads"
)
# what is not computed, with the reasons, by whether the punch is in full contact
LEFT_OUT = {
    True: {
        "inequality p >= 0": "a punch that starts flat never loses contact, because the pressure "
        "can only rise where it is close to zero",
    },
    False: {
        "springs' rule of the MDR": "q = d - g holds only if the contact is one disc; the energy "
        "of the MDR is used instead, which is valid for any contact",
        "relaxation modes": "modes exist only while the contact does not change; running-in times "
        "are reported if all of the face comes into contact",
        "ring pressures at the start": "they may be infinite at contact edges or on the axis",
    },
}


def methods_of(entries: Sequence[str | Method]) -> Methods:
    """Return methods by their names, from a sequence of names or method objects.

    Raises
    ------
    SceneError
        if the name of a method, or of a program whose results are one, is not one line of text
    """
    methods = [method(entry) if isinstance(entry, str) else entry for entry in entries]
    try:
        return {check_one_line(entry.name): entry for entry in methods}
    except ValueError as error:
        raise SceneError(f"the name of a method or a program: {error}") from None


def chosen_methods(scene: Scene) -> Methods:
    """Return the methods that solve a scene, by their names.

    They are those that the scene names. If it names none, they are those of the default methods
    that can solve it and compute something that it asks for; all of them if none can, so that
    `refuse` gives the reasons.
    """
    methods, unsuitable = methods_of(scene.methods), unsuitable_methods(scene)
    return {name: entry for name, entry in methods.items() if name not in unsuitable} or methods


def omitted_methods(scene: Scene, methods: Methods) -> dict[str, str]:
    """Return the default methods that are left out of those that solve a scene, with reasons.

    None are left out if the user has chosen the methods.
    """
    unsuitable = unsuitable_methods(scene)
    return unsuitable if methods.keys() == set(scene.methods) - unsuitable.keys() else {}


def unsuitable_methods(scene: Scene) -> dict[str, str]:
    """Return the default methods that a scene without `methods` cannot use, with reasons."""
    if scene.names_methods:
        return {}
    reasons = {
        name: _why_omitted(entry, scene.problem)
        for name, entry in methods_of(scene.methods).items()
    }
    return {name: reason for name, reason in reasons.items() if reason}


def _why_omitted(entry: Method, problem: Problem) -> str:
    """Return why a default method is of no use for a problem; empty if it is."""
    if (beyond := entry.beyond(problem)) is not None:
        return beyond.reason
    wanted = {"history": len(problem.times) > 0, "steady state": problem.steady}
    lacking = [entry.lacks[item] for item, asked in wanted.items() if asked and item in entry.lacks]
    return lacking[0] if lacking and len(lacking) == sum(wanted.values()) else ""


def modelled(scene: Scene, methods: Methods) -> list[str]:
    """Return lines of text about what is computed."""
    problem = scene.problem
    lines = [f"{name}: {entry.what or 'a user-defined method'}" for name, entry in methods.items()]
    # describe the march if some method computes everything; the others describe their own
    if len(problem.times) and not all(entry.lacks for entry in methods.values()):
        start, march = HISTORY[problem.full_contact]
        if problem.march != "modal":
            march = f"by steps of {problem.march} Euler"
        if not problem.full_contact:
            lines.append(INEQUALITIES)
        lines.append(f"history: {len(problem.times)} times from {start}, {march}")
    if scene.half_space.punch_youngs_modulus is not None:
        lines.append(
            "two elastic bodies, whose compliances add; the punch is also treated as a half-space, "
            "so that the deformation of its real shape is not modelled"
        )
    if problem.ground.layered:
        count, base = len(problem.ground.thicknesses), "a rigid base"
        if not problem.ground.rigid:
            base = "an elastic half-space"
        lines.append(f"layers: {count}, bonded to each other and to {base}")
    if problem.as_wide_as_scar:
        radius = scene.unit_names.write(problem.units.length, "length", 3)
        lines.append(
            f"face: up to r = {radius}, which is wider than the contact gets by the last time"
        )
    if problem.inner_radius:
        lines.append(
            "hole: the surface under it is free; the flat start is computed with the pressures of "
            "a flat annulus"
        )
    if problem.loading.varies:
        lines.append(
            "load over time: linear between the given times, and wear is integrated over the "
            "sliding distance; the steady state is that of the last force and speed, and "
            "relaxation times are those at the greatest speed"
        )
    if (cycles := scene.load_.repeat) > 1:
        lines.append(f"cycles: all {cycles} cycles of the load are computed, none extrapolated")
    if not problem.loading.forces.all():
        lines.append(
            "no force: while it is 0, the punch rests on its foremost point and does not wear"
        )
    lacking = all("steady state" in entry.lacks for entry in methods.values())
    if problem.steady and not lacking:
        line = "steady state: without any march"
        if not problem.full_contact:
            line += "; it is that of the flat punch: wear ends with all of the face in contact"
        lines.append(line)
    return lines


def left_out(scene: Scene, methods: Methods) -> dict[str, str]:
    """Return what is not computed, with the reason of each item."""
    problem = scene.problem
    reasons = {
        "friction and temperature": "not part of the model: the contact is frictionless",
        **LEFT_OUT[problem.full_contact],
    }
    if problem.loading.varies:
        reasons["times to 90 % and 99 % of running-in"] = (
            "they are defined only for a constant load"
        )
    if problem.keeps_contact:
        reasons["inequality p >= 0"] = (
            "although the force falls, the punch stays in full contact: in a small solution, the "
            "pressure stays positive everywhere"
        )
    if problem.ground.layered and problem.full_contact:
        reasons |= {
            "inequality p >= 0": "on these layers a flat punch is in contact everywhere at the "
            "start; a run that would lead to tension later is refused"
        }
    if problem.as_wide_as_scar:
        reasons["relaxation modes"] = reasons["times of running-in and full contact"] = (
            "the scar goes on growing; the scene gives no punch.radius at which it would end"
        )
        reasons["RMS slope"] = "it is an average over a face whose radius is not given"
    selection = f"output.quantities selects only {', '.join(scene.output.quantities)}"
    if scene.output.quantities != type(scene.output)().quantities:
        reasons["all other quantities"] = selection
    if not len(problem.times):
        reasons["history"] = selection if scene.wear.times else "the scene gives no times"
    if problem.indentation is not None:
        reasons["steady state"] = (
            "at a fixed indentation, wear continues until the pressure vanishes"
        )
    elif scene.wear.steady and problem.reason_not_steady:
        reasons["steady state"] = problem.reason_not_steady
    elif not problem.steady:
        reasons["steady state"] = (
            selection if scene.wear.steady else "the scene says steady = false"
        )
    reasons |= omitted_methods(scene, methods)
    if "fem" in methods and len(creases := problem.profile.creases):
        radii = creases * problem.units.length
        written = ", ".join(scene.unit_names.write(radius, "length", 3) for radius in radii)
        reasons[f"errors of stresses near r = {written}"] = (
            "stresses are singular where the slope of the unworn face jumps, as at the tip of a "
            "cone; their error estimates leave it out"
        )
    for name, entry in methods.items():
        lacks = {
            f"{item} by {name}": reason
            for item, reason in entry.lacks.items()
            if item not in reasons
        }
        reasons |= lacks
    for entry in methods.values():
        reasons |= entry.modelling_errors(problem)
    if (merged := len(problem.ring_edges) - len(problem.merged.ring_edges)) > 0:
        reasons["ring edges"] = (
            f"{merged} of them separate rings with equal k and therefore have no effect"
        )
    return reasons


def refuse(scene: Scene, methods: Methods) -> None:
    """Refuse a scene that methods cannot compute, before any work and in the same words.

    Raises
    ------
    SceneError
        with all reasons, each with a remedy
    """
    refused = [entry.refusal(scene.problem) for entry in methods.values()]
    problem = scene.problem
    if scene.output.field_times and not (problem.full_contact or len(problem.times)):
        refused.append(
            "output.field_times asks for fields inside the half-space under a contact that "
            "changes, which need a history: give wear.times, and ask for a quantity over time"
        )
    if problem.ground.layered and scene.output.depth is not None:
        # triangles under contact that moves have a mesh of their own size
        remedy = "leave it out: half_space.vtu has all of the mesh"
        if problem.full_contact:
            radius = max(scene.output.depth / problem.units.length, LEAST_TRUNCATION)
            remedy = (
                f"give accuracy.fem.truncation = {radius:.3g} in place of it, the radius of the "
                "mesh in punch radii: half_space.vtu has all of the mesh"
            )
        refused.append(
            f"output.depth adds the far field of a half-space without layers: with "
            f"half_space.layers {remedy}"
        )
    if any(refused):
        raise SceneError("; ".join(dict.fromkeys(filter(None, refused))))


def beyond_the_model(scene: Scene) -> list[str]:
    """Return a warning if the strains of a scene with units are not small."""
    problem, units = scene.problem, scene.problem.units
    strain = units.pressure / np.pi / units.modulus * (problem.indentation or 1.0)
    if scene.unit_names.base is None or strain <= MOST_STRAIN:
        return []
    return [
        f"the mean pressure is {strain:.2g} of the plane strain modulus, more than "
        f"{MOST_STRAIN:g}: strains are not small, and linear elasticity, which all methods assume, "
        "is not valid"
    ]


def time_scale(scene: Scene) -> list[str]:
    """Return how long the running-in will take, and a note if the times do not show it."""
    problem = scene.problem
    if not problem.earliest:
        return []
    slowest = slowest_relaxation_time(problem)
    if not np.isfinite(slowest):
        return [f"running-in: its duration is not estimated for more than {MOST_RINGS} rings"]

    def written(time: float) -> str:
        return scene.unit_names.write(time * problem.units.time, "time", 3)

    lines = [f"running-in: slowest relaxation time of the full face {written(slowest)}"]
    # the spreading of contact has another time scale
    if not (problem.full_contact or problem.loading.varies):
        start, end = map(written, spreading_times(problem))
        until = f"to {end}" if problem.constant_force else "on"
        lines.append(f"contact spreads from about {start} {until}")
    return lines + [f"note: {line}" for line in outside(problem, slowest)]


def outside(problem: Problem, slowest: float) -> list[str]:
    """Return a warning if the times of a flat punch do not show its running-in.

    `slowest` is the slowest relaxation time, non-dimensional, or NaN if it is unknown; then there
    is no warning.
    """
    remedy = 'times = "running-in" covers all of it'
    if not (problem.full_contact and problem.earliest):
        return []
    if problem.distances[-1] < 0.01 * slowest:
        return [f"all times are before the running-in, of which they show little: {remedy}"]
    if problem.earliest > 5 * slowest:
        return [f"all times are after the running-in, of which they show nothing: {remedy}"]
    return []
