"""What a run will take, before it runs.

Sizes and bytes are in closed form by the default sizes (`problem/defaults.py`), within a factor of
about 1.5 of what meshes will have. Seconds, and sizes once more, are those of one probe: the scene
itself, solved at a coarse accuracy, scaled by what is known of each part of the work. A sparse
factor goes as unknowns^1.5, dense algebra as pressures^2, and as pressures^3 once matrices are
large, a march as its steps times pressures^2.
"""

import os
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...meshes.radial import Array
from ..problem import defaults
from ..problem.marching import steps_between
from ..problem.problem import Problem
from ..problem.scene import Scene
from .scope import refusals

GIB = 2.0**30
PROBE_RTOL = 1e-2


class Size(NamedTuple):
    """What a method is made of, in words, and about how large.

    Parameters
    ----------
    made_of : str
    unknowns : float
        Of the system behind the compliance; zero if there is none.
    pressures : float
        Order of the dense matrices.
    """

    made_of: str
    unknowns: float
    pressures: float


def predict_size(name: str, problem: Problem) -> Size:
    """Return about how large a method's systems will be, in closed form."""
    if name == "direct":
        return Size("closed form, nothing to resolve", 0, len(problem.merged.widths))
    if name == "mdr-grid":
        springs = problem.mdr.grid
        return Size(f"a uniform grid of {springs} springs", springs + 1, springs + 1)
    if name not in ("mdr", "bem", "fem"):
        return Size("its sizes are known by the run", 0, 0)
    if not problem.full_contact and len(problem.times):
        return _on_cells(name, problem)
    return _on_elements(problem) if name == "fem" else _on_radii(problem)


def _on_cells(name: str, problem: Problem) -> Size:
    """Return the size of a march in which contact opens, closes and spreads."""
    space = defaults.cells_of(problem).space()
    words = f"linear pressures on {len(space.degrees)} cells and more where contact begins"
    pressures = 1.3 * space.size
    return Size(words, 80 * pressures + 8000 if name == "fem" else pressures, pressures)


def _on_radii(problem: Problem) -> Size:
    """Return the size of the radial mesh; degrees fall with the layers, from the highest to 2."""
    sizes = defaults.mdr_sizes(problem)
    at_rings = np.broadcast_to(sizes["ring_size"], len(problem.merged.narrower))
    smallest = np.append(at_rings, sizes["rim_size"])
    pressures = 0.69 * sizes["degree"] * _count_layers(problem, smallest, sizes["grading"])
    words = f"pressures of degree up to {sizes['degree']}, {_in_words(smallest)}"
    return Size(words, pressures, pressures)


def _on_elements(problem: Problem) -> Size:
    """Return the size of the finite elements; the factors were fitted to meshes of random scenes.

    Triangles fill the column below each edge, their sides grow with the distance from it.
    """
    mesher, rings = problem.fem.meshed_by, len(problem.merged.widths)
    if mesher == "quads":
        quads = defaults.quad_sizes(problem)
        degree, smallest = quads.degree, np.array([*quads.ring_sizes, quads.rim_size])
        layers = _count_layers(problem, smallest, quads.factor)
        pressures = 0.58 * layers * (degree - 2) + 2.6 * rings * degree
        unknowns = degree**2 * (2.8 * layers + 19 * (rings + 1))
    else:
        field = defaults.triangle_sizes(problem)
        degree, growth = defaults.triangle_degree(problem), field.growth
        smallest = np.array([*field.ring_sizes, field.rim_size])
        sides = _sum_over_edges(
            problem, smallest, lambda size, reach: np.log1p(growth * reach / size) / growth
        )
        pressures = 4 * sides + 15
        unknowns = degree**2 * (6.7 * sides / growth + 150)
        unknowns *= 1.75 if mesher == "bisection" else 1.0
    what = "quadrilaterals" if mesher == "quads" else f"triangles by {mesher}"
    far_field = {"boussinesq": "Boussinesq's far field", "fixed": "clamped"}[problem.fem.far_field]
    outer = f"{far_field} at R = {defaults.truncation(problem):g} a"
    words = f"{what} of degree {degree}, {_in_words(smallest)}, {outer}"
    return Size(words, unknowns, pressures)


def _count_layers(problem: Problem, smallest: Array, ratio: float) -> float:
    """Return how many elements lead from the middle of every ring to its edges, each smaller by a
    ratio than its outer neighbour.
    """
    return _sum_over_edges(
        problem, smallest, lambda size, reach: np.maximum(np.log(size / reach) / np.log(ratio), 1)
    )


def _sum_over_edges(
    problem: Problem, smallest: Array, count: Callable[[Array, Array], Array]
) -> float:
    """Return the sum over both sides of every ring edge, and over the inner side of the rim."""
    reach = problem.merged.widths / 2
    return float(count(smallest, reach).sum() + count(smallest[:-1], reach[1:]).sum())


def _in_words(smallest: Array) -> str:
    at_edges = f"{smallest[:-1].min():.0e} a at ring edges and " if len(smallest) > 1 else ""
    return f"elements down to {at_edges}{smallest[-1]:.0e} a at the rim"


def predict_memory(scene: Scene) -> dict[str, float]:
    """Return about how many GiB a run will need, by the scene keys that cause it.

    They are for some 14 dense matrices, for the sparse factor, and for fields over time.
    """
    problem = scene.problem
    sizes = [predict_size(name, problem) for name in scene.methods]
    numbers = sum(
        14 * size.pressures**2 + 50 * size.unknowns * np.log2(size.unknowns + 1) for size in sizes
    )
    fields = 6.0 * len(problem.times) * len(problem.radii) * len(sizes)
    return {
        "libraries": 0.23,
        "punch.rings and accuracy": float(8 * numbers / GIB),
        "wear.times and output.radii": 8 * fields / GIB,
    }


def beyond_memory(memory: dict[str, float], limit: float) -> str:
    """Say why a run would not fit into so many GiB, and by which key; empty if it fits."""
    total, key = sum(memory.values()), max(memory, key=memory.__getitem__)
    if total <= limit:
        return ""
    return (
        f"about {total:.2g} GiB are needed, {memory[key]:.2g} of them for {key}, and {limit:.2g} "
        "are allowed: ask for less there, or give --memory GIB if there is more"
    )


def machine_memory() -> float:
    """Return the GiB of this machine."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIB


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
        "rtol": max(problem.rtol, PROBE_RTOL),
        "fem": fem | {"mesher": problem.fem.meshed_by},
        "mdr": {"grid": min(problem.mdr.grid, 100)},
    }
    times = list(scene.wear.times)[:: len(scene.wear.times) // 20 + 1]
    if step is not None:
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
    from .run import run

    probe = coarsen(scene)
    run(probe)  # loads libraries, and is not timed
    result = run(probe)
    measured = {}
    for name, solution in result.solutions.items():
        settings = solution.settings
        # where the mesher has been replaced, both are by the other
        problem, coarse = (
            each.changed(accuracy__fem__mesher=settings["mesher"]).problem
            if "mesher" in settings
            else each.problem
            for each in (scene, probe)
        )
        size, before = predict_size(name, problem), predict_size(name, coarse)
        if size.unknowns:
            pressures = settings.get("multipliers", settings.get("pressures", solution.unknowns))
            size = Size(
                size.made_of,
                size.unknowns * solution.unknowns / before.unknowns,
                size.pressures * pressures / before.pressures,
            )
        seconds = sum(result.stages[name].seconds.values())
        scaled = seconds * predict_work(name, problem) / predict_work(name, coarse)
        measured[name] = size, scaled
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
    refused = refusals(scene)
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
