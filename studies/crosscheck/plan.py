"""What a run will take, before it runs.

Sizes are those of one probe, the scene itself at a coarse accuracy, scaled by closed forms
(`sizes.py`), and so are its seconds: a sparse factor goes as unknowns^1.5, dense algebra as
pressures^2, and as pressures^3 once matrices are large, a march as its steps times pressures^2.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ..problem import defaults
from ..problem.marching import steps_between
from ..problem.problem import Problem
from ..problem.scene import Scene
from .run import run
from .scope import methods_of, refusals
from .sizes import Size, predict_memory, predict_size


def predict_work(name: str, problem: Problem) -> float:
    """Return about how much work a method has; what counts is the ratio of two problems.

    The factors between its parts were measured on the bundled scenes.
    """
    _, unknowns, pressures = predict_size(name, problem)
    order, step = pressures / 1e3, problem.step
    if name == "mdr-grid":
        step = defaults.grid_step(problem, 4 / np.pi / problem.mdr.grid)
    steps = float(steps_between(problem.times, step).sum()) if step else 0.0
    marching = 6e-4 * steps * order**2
    if not problem.full_contact and len(problem.times):
        # the steps that suit rtol go as the third root of its inverse; the rest is the first press
        return 0.15 * (1 + order**2 * problem.rtol ** (-1 / 3)) + marching
    dense = 0.5 * order**2 * (1 + order / 3)
    sampling = 3e-7 * order * len(problem.times) * len(problem.radii)
    factor = 0.1 * (unknowns / 1e4) ** 1.5
    return 0.02 + dense + sampling + factor + marching


def coarsen(scene: Scene) -> Scene:
    """Return the probe of a scene: a coarse accuracy, few rings, times and steps."""
    problem, step, rings = scene.problem, scene.wear.step, scene.problem.rings
    fem = problem.fem.model_dump(include={"far_field"}, exclude_unset=True)
    accuracy = {
        "rtol": max(problem.rtol, 1e-2),
        "fem": fem | {"mesher": problem.fem.meshed_by},
        "mdr": {"grid": min(problem.mdr.grid, 100)},
    }
    times = list(scene.wear.times)[:: len(scene.wear.times) // 20 + 1]
    if step is not None and times:
        times = [0.0, min(times[-1], 100 * step)]
    changes: dict[str, Any] = {"accuracy": accuracy, "wear__times": times, "output__radii": None}
    if problem.full_contact and len(rings.wear_coefficients) > 16:
        edges = (rings.ring_edges[1:17] * problem.units.length).tolist()
        coefficients = rings.wear_coefficients[:16] * problem.units.wear_coefficient
        changes["punch"] = {
            "radius": edges[-1],
            "ring_edges": edges,
            "wear_coefficients": coefficients.tolist(),
        }
    return scene.changed(**changes)


def measure(scene: Scene) -> tuple[dict[str, tuple[Size, float]], list[str]]:
    """Return sizes and seconds by method, scaled from the probe of a scene, and notes on meshes."""
    probe = coarsen(scene)
    run(probe)  # loads libraries, and is not timed
    result = run(probe)
    measured = {}
    for name, solution in result.solutions.items():
        settings, seconds = solution.settings, sum(result.stages[name].seconds.values())
        # where the mesher has been replaced, both are by the other
        mesher = {"mesher": settings.get("mesher", scene.problem.fem.meshed_by)}
        problem, coarse = (
            replace(each, fem=each.fem.model_copy(update=mesher))
            for each in (scene.problem, probe.problem)
        )
        size, before = predict_size(name, problem), predict_size(name, coarse)
        if size.unknowns:
            pressures = settings.get("multipliers", settings.get("pressures", solution.unknowns))
            scales = solution.unknowns / before.unknowns, pressures / before.pressures
            size = Size(size.made_of, size.unknowns * scales[0], size.pressures * scales[1])
        work = predict_work(name, problem) / predict_work(name, coarse)
        measured[name] = size, seconds * work
    return measured, [note for note in result.notes if note.startswith("meshed by")]


def plan(scene: Scene) -> list[str]:
    """Say what each method will be made of and take, by closed forms and one coarse probe.

    Parameters
    ----------
    scene : Scene
        What would be computed.

    Returns
    -------
    list of str
        Lines of text: sizes, seconds on one thread, GiB, refusals and notes.
    """
    refused = refusals(scene, methods_of(scene.methods))
    if refused:
        return [f"refused: {reason}" for reason in refused]
    lines, (measured, notes) = list[str](), measure(scene)
    for name, (size, seconds) in measured.items():
        unknowns, pressures = (float(f"{count:.2g}") for count in size[1:])
        counts = f"about {unknowns:.0f} unknowns, {pressures:.0f} pressures, " if unknowns else ""
        lines += [f"{name}: {size.made_of}", f"    {counts}about {seconds:.2g} s"]
    total = sum(seconds for _, seconds in measured.values())
    lines.append(f"in all: about {total:.2g} s, and a few for loading, files and figures")
    memory = predict_memory(scene)
    parts = ", ".join(f"{value:.2g} for {key}" for key, value in memory.items())
    lines.append(f"memory: about {sum(memory.values()):.2g} GiB: {parts}")
    return lines + [f"note: {note}" for note in notes]
