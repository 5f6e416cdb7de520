"""What is computed for a scene, and what is not.

`plan` says it before a run, and the summary says it after the run.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ..methods.base import Method, method
from ..problem.problem import Problem
from ..problem.unit_names import UnitNames
from ..scene.scene import Scene
from ..wear.time_scale import MOST_RINGS, slowest_relaxation_time, spreading_times

Methods = Mapping[str, Method]


def methods_of(entries: Sequence[str | Method]) -> Methods:
    """Return methods, given themselves or by their names, each by its name."""
    methods = [method(entry) if isinstance(entry, str) else entry for entry in entries]
    return {entry.name: entry for entry in methods}


def modelled(scene: Scene, methods: Methods) -> list[str]:
    """Return what is computed, a line each."""
    problem = scene.problem
    lines = [f"{name}: {entry.what or 'a method of the user'}" for name, entry in methods.items()]
    # what lacks nothing marches from the start to the steady state; others tell their way
    if len(problem.times) and not all(entry.lacks for entry in methods.values()):
        contact, way = problem.contact, f"by steps of {problem.march} Euler"
        if problem.march == "modal":
            way = contact.march_description
        lines += contact.modelled
        lines.append(f"history: {len(problem.times)} times from {contact.start}, {way}")
    if scene.half_space.punch_youngs_modulus is not None:
        lines.append(
            "two elastic bodies: one half-space of their combined modulus; the punch counts as a "
            "half-space, too, so its own shape and height are not felt"
        )
    if problem.ground is not None:
        count, base = len(problem.ground.thicknesses), "a rigid base"
        if not problem.ground.rigid:
            base = "an elastic half-space"
        lines.append(f"layers: {count}, bonded to each other and to {base}")
    if problem.inner_radius:
        lines.append(
            "hole: the surface under it is free; the flat start is sought among the flat annulus's "
            "pressures"
        )
    lines += problem.load_regime.modelled
    if not problem.loading.forces.all():
        lines.append(
            "no force: while it is 0, the punch rests on its foremost point and does not wear"
        )
    lacking = all("steady state" in entry.lacks for entry in methods.values())
    if problem.steady and not lacking:
        lines.append(f"steady state: without any march{problem.contact.steady_state}")
    return lines


def left_out(scene: Scene, methods: Methods) -> dict[str, str]:
    """Return what is not computed, with the reason."""
    problem = scene.problem
    reasons = {
        "friction and temperature": "not part of the model: the punch is rigid and frictionless",
        **problem.contact.left_out,
        **problem.load_regime.left_out,
    }
    if problem.ground is not None and problem.full_contact:
        reasons |= {
            "inequality p >= 0": "on these layers a flat punch presses everywhere at the start; a "
            "run that would take tension later is refused"
        }
    alone = f"output.quantities asks for {', '.join(scene.output.quantities)} alone"
    if problem.quantities is not None:
        reasons["all other quantities"] = alone
    if not len(problem.times):
        reasons["history"] = alone if scene.wear.times else "the scene gives no times"
    if never := problem.load_regime.no_steady_state:
        reasons["steady state"] = never
    elif scene.wear.steady and problem.reason_not_steady:
        reasons["steady state"] = problem.reason_not_steady
    elif not problem.steady:
        reasons["steady state"] = alone if scene.wear.steady else "the scene says steady = false"
    for name, entry in methods.items():
        lacks = {
            f"{what} by {name}": why for what, why in entry.lacks.items() if what not in reasons
        }
        reasons |= lacks
    for entry in methods.values():
        reasons |= entry.modelling_errors(problem)
    modelled = len(problem.merged.ring_edges) - bool(problem.inner_radius)
    if (merged := len(problem.ring_edges) - modelled) > 0:
        reasons["ring edges"] = (
            f"{merged} of them separate rings of equal wear, so nothing happens there"
        )
    return reasons


def refusals(scene: Scene, methods: Methods) -> list[str]:
    """Return why methods cannot compute a scene, each with its remedy."""
    refused = [entry.refusal(scene.problem) for entry in methods.values()]
    problem = scene.problem
    if scene.output.field_times and not (problem.full_contact or len(problem.times)):
        refused.append(
            "output.field_times asks for the inside of the half-space under a contact that "
            "changes: give wear.times, and ask for some of its history"
        )
    if problem.ground is not None and scene.output.depth is not None:
        refused.append(
            "output.depth adds the far field of a half-space without layers: leave it out with "
            "half_space.layers"
        )
    return [reason for reason in refused if reason]


def time_scale(scene: Scene) -> list[str]:
    """Return how long running-in will take, and whether the times of the scene show it."""
    problem = scene.problem
    if not problem.earliest:
        return []
    slowest = slowest_relaxation_time(problem)
    if not np.isfinite(slowest):
        return [f"running-in: not known beforehand for more than {MOST_RINGS} rings"]

    def written(time: float) -> str:
        return UnitNames.of(scene.units).write(time * problem.units.time, "time", 3)

    lines = [f"running-in: slowest relaxation time of the full face {written(slowest)}"]
    # contact that spreads has a time scale of its own
    until = problem.load_regime.spreading_end_text
    if not problem.full_contact and until is not None:
        start, end = map(written, spreading_times(problem))
        lines.append(f"contact spreads from about {start}{until.format(end=end)}")
    return lines + outside(problem, slowest)


def outside(problem: Problem, slowest: float) -> list[str]:
    """Return a note if the times of a flat punch do not show its running-in; else an empty list.

    `slowest` is the slowest relaxation time, non-dimensional. If it is NaN, it is not known, and
    there is no note.
    """
    remedy = 'times = "running-in" shows all of it'
    if not (problem.full_contact and problem.earliest):
        return []
    if problem.distances[-1] < 0.01 * slowest:
        return [f"note: all times lie before the running-in, of which little is seen: {remedy}"]
    if problem.earliest > 5 * slowest:
        return [f"note: all times lie after the running-in, of which nothing is seen: {remedy}"]
    return []
