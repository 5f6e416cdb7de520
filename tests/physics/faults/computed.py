"""Faults of computed results: the table and the fields on the face have the same error."""

from collections.abc import Iterator

from .changes import (
    Change,
    late,
    move_force,
    offset,
    scale,
    scale_on_ring,
    scale_together,
    smear,
    stretch,
    tilt,
)
from .scenes import DEPTHS, HISTORY, MOVING, SIZES, STEADY


def faults(kind: str) -> Iterator[tuple[str, Change]]:
    """Yield the name of each fault for a kind of scene, and its change of the solution."""
    size, full = SIZES[kind], kind not in MOVING
    for name in HISTORY + (STEADY if kind not in ("held", "rising") else []):
        yield f"{name} found too great", scale(name, size)
        if kind == "flat" and name not in ("ring_force", "steady_profile"):
            yield f"{name} found slightly too great", scale(name, 0.4 * size)
    yield (
        "heights found too great",
        scale_together(["rms_slope", *DEPTHS], size),
    )
    yield "indentation found too great later", scale("indentation", size, slice(1, None))
    yield "worn heights found too great", scale_together(["profile", "rms_slope"], size)
    yield (
        "pressures and forces found too great",
        scale_together(["pressure", "ring_force", "normal_force"], size),
    )
    yield "pressure found too great on one ring", scale_on_ring("pressure", 5 * size)
    yield "profile found too great on one ring", scale_on_ring("profile", 5 * size)
    yield "profile found with an offset", offset("profile", size)
    yield "force moved between rings", move_force(size)
    yield "pressure smeared at an edge", smear(0.03 if full else 0.1)
    yield "pressure of other radii", stretch("pressure", 0.01 if full else 0.05)
    yield "profile of other radii", stretch("profile", 0.01 if full else 0.05)
    yield "all of the time before", late(HISTORY, -2)
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
