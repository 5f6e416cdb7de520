"""Faults of computed results: the table and the fields on the face have the same error."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from given import judge

from ringwear import Result

from .scenes import HISTORY, MOVING, SIZES

Change = Callable[[dict, np.ndarray, object], None]

STEADY = "steady_pressure steady_profile steady_displacement_max steady_rms_slope steady_wear_rate"


def with_results(result: Result, change: Change) -> Result:
    """Return the result of two methods that share a changed solution.

    Parameters
    ----------
    change : (results by name, radii of their fields, problem) -> None
        Changes copies in place: once of the results at output radii, once of those on the face.
    """
    solution, problem = result.solutions["mdr"], result.scene.problem
    changed = {}
    for name, radii in (("results", problem.radii), ("compared", problem.face.radii)):
        values = {key: np.array(of) for key, of in getattr(solution, name).items()}
        change(values, radii, problem)
        changed[name] = values
    wrong = replace(solution, **changed)
    return judge(result.scene, mdr=wrong, twin=wrong)


def scale(name: str, size: float, *where) -> Change:
    def change(values, *_):
        values[name][where or ...] *= 1 + size

    return change


def scale_together(names: str, size: float) -> Change:
    """Scale several quantities by one factor, as a wrong unit would do."""

    def change(values, *_):
        for name in names.split():
            if name in values:
                values[name][...] *= 1 + size

    return change


def scale_on_ring(name: str, size: float, ring: int) -> Change:
    def change(values, radii, problem):
        on = (radii > problem.ring_edges[ring]) & (radii < problem.ring_edges[ring + 1])
        values[name][..., on] *= 1 + size

    return change


def add(name: str, part: float) -> Change:
    """Add a fraction of the indentation to a field everywhere."""

    def change(values, *_):
        values[name][...] += part * values["indentation"][:, None]

    return change


def move_force(size: float) -> Change:
    """Move a fraction of the total force from the first ring to the second."""

    def change(values, *_):
        forces = values["ring_force"]
        moved = size * forces.sum(axis=1)
        forces[:, 0] -= moved
        forces[:, 1] += moved

    return change


def smear(width: float) -> Change:
    """Average pressures over all radii within a distance from the first ring edge."""

    def change(values, radii, problem):
        near = np.abs(radii - problem.ring_edges[1]) < width
        weights = radii[near] * np.gradient(radii)[near]
        mean = (values["pressure"][:, near] @ weights) / weights.sum()
        values["pressure"][:, near] = mean[:, None]

    return change


def stretch(name: str, size: float) -> Change:
    """Stretch a field along the radius."""

    def change(values, radii, _):
        for row in values[name]:
            row[:] = np.interp(radii / (1 + size), radii, row)

    return change


def late(names: str) -> Change:
    """Replace values at the last time but one with those at the time before it."""

    def change(values, *_):
        for name in names.split():
            if name in values:
                values[name][-2] = values[name][-3]

    return change


def tilt(size: float) -> Change:
    """Add opposite errors to profile and displacement, so that their sum stays right."""

    def change(values, radii, _):
        off = size * values["indentation"][:, None] * radii
        off[values["time"] == 0] = 0.0
        values["profile"] += off
        values["displacement"] -= off

    return change


def faults(kind: str) -> Iterator[tuple[str, Change]]:
    """Yield the name of each fault for a kind of scene, and its change of the solution."""
    size, full = SIZES[kind], kind not in MOVING
    for name in HISTORY + (STEADY.split() if kind not in ("held", "rising") else []):
        yield f"{name} found too great", scale(name, size)
    yield (
        "heights found too great",
        scale_together(
            "profile displacement indentation displacement_centre displacement_max rms_slope", size
        ),
    )
    yield "worn heights found too great", scale_together("profile rms_slope", size)
    yield (
        "pressures and forces found too great",
        scale_together("pressure ring_force normal_force", size),
    )
    yield "pressure found too great on one ring", scale_on_ring("pressure", 5 * size, 1)
    yield "profile found too great on one ring", scale_on_ring("profile", 5 * size, 1)
    yield "profile found with an offset", add("profile", size)
    yield "force moved between rings", move_force(size)
    yield "pressure smeared at an edge", smear(0.03 if full else 0.1)
    yield "pressure of other radii", stretch("pressure", 0.01 if full else 0.05)
    yield "profile of other radii", stretch("profile", 0.01 if full else 0.05)
    yield "all of the time before", late(" ".join(HISTORY))
    yield "profile and displacement tilted", tilt(size)
    if full:
        yield "all relaxation times found too great", scale("relaxation_time", size)
        yield "the second relaxation time found too great", scale("relaxation_time", size, 1)
    if kind == "held":
        yield "force found too great", scale("normal_force", size)
        yield "volumes found too great", scale("ring_worn_volume", size)
        yield "time to half the force found too great", scale("time_to_half_force", size)
    if kind in ("flat", "graded"):
        for name in ("time_to_90", "time_to_99"):
            yield f"{name} found too great", scale(name, size)
    if not full:
        yield "volumes found too great", scale("ring_worn_volume", size)
        yield "contact radius found too great", scale("contact_radius", 0.1)
