"""Faults of reported results: the table differs from what the method computed."""

import re
from collections.abc import Iterator
from math import nan

from .changes import (
    Change,
    late,
    offset,
    scale,
    scale_on_ring,
    shift_radii,
    smear,
    swap,
    swap_states,
    take,
)
from .scenes import HISTORY, MOVING, SIZES, STEADY

OF_FLAT = ["relaxation_time", "indentation_start", "running_in_time", "worn_volume"]
OF_FLAT += ["pressure_min", "pressure_max", "force_share"]
OF_MOVING = ["normal_force", "ring_worn_volume", "contact_radius", "worn_volume"]
TABLES = {
    "flat": [*HISTORY, *STEADY, "indentation_steady", *OF_FLAT, "time_to_90", "time_to_99"],
    "graded": [*HISTORY, *STEADY, "indentation_steady", *OF_FLAT, "time_to_90", "time_to_99"],
    "rising": [*HISTORY, *STEADY, "indentation_steady", *OF_FLAT, "normal_force"],
    "held": [
        *(*HISTORY, *OF_FLAT, "normal_force", "ring_worn_volume"),
        *("force_start", "force_end", "time_to_half_force"),
    ],
    "up_and_down": [*HISTORY, *STEADY, "indentation_steady", *OF_MOVING],
    "sphere": [
        *(*HISTORY, *STEADY, "indentation_steady", *OF_MOVING, "indentation_start", "force_share"),
        *("contact_radius_start", "pressure_peak_start"),
    ],
}


def common(kind: str) -> Iterator[tuple[str, Change]]:
    size = SIZES[kind]
    for name in TABLES[kind]:
        yield f"{name} scaled", scale(name, size)
    for name in ("time", "radius", "wear_coefficient", "ring_inner_radius", "ring_outer_radius"):
        yield f"{name} scaled", scale(name, size)
    for name in ("pressure", "profile", "indentation", "rms_slope", "ring_force"):
        yield f"{name} at the last time", scale(name, size, -1)
    if kind != "held":
        # its error is relative to the indentation, which has grown by wear
        yield "displacement at the last time", scale("displacement", 10 * size, -1)
    yield "indentation at the first later time", scale("indentation", size, 1)
    yield "indentation that is no number", scale("indentation", nan)
    for name in ("indentation", "pressure", "profile", "ring_force", "rms_slope"):
        if (kind, name) != ("held", "indentation"):
            # with k(r), the last two times differ too little
            yield f"{name} of the time before", late([name], -2 if kind == "graded" else -1)
    yield "pressure scaled on one ring", scale_on_ring("pressure", 5 * size)
    yield "profile scaled on one ring", scale_on_ring("profile", size, True)
    yield "displacement scaled on one ring", scale_on_ring("displacement", size, True)
    yield "profile with an offset", offset("profile", size)
    yield "displacement with an offset", offset("displacement", size)
    yield "displacement with the other sign", scale("displacement", -2)
    yield "profile with the other sign", scale("profile", -2)
    yield "pressure in MPa", scale("pressure", 1e-6 - 1)
    yield "ring forces swapped", swap("ring_force")
    yield "wear coefficients swapped", swap("wear_coefficient")
    yield "worn volume wrong on one ring", scale("worn_volume", 10 * size, 0)
    yield "worn volumes swapped", swap("worn_volume")
    yield "pressure of the next radius", shift_radii("pressure")
    yield "one ring edge shifted", scale("ring_outer_radius", size)
    yield "times in another unit", scale("time", 59.0)
    yield "pressure smeared at a ring edge", smear(0.05)


def special(kind: str) -> Iterator[tuple[str, Change]]:
    size, full = SIZES[kind], kind not in MOVING
    if full:
        for mode in range(8):
            yield f"relaxation time {mode + 1}", scale("relaxation_time", size, mode)
        yield "pressure_min at the start", scale("pressure_min", size, 0)
        yield "force share of one ring at the start", scale("force_share", 5 * size, 0, -1)
        yield "running-in time of the second mode", take("running_in_time", "relaxation_time", 1)
    if kind in ("flat", "graded", "rising"):
        yield "pressure_max of the steady state", scale("pressure_max", size, 1)
        yield "force share of one ring, steady", scale("force_share", 5 * size, 1, -1)
        yield "force shares of the other state", swap_states("force_share")
        yield "pressures of the other state", swap_states("pressure_min")
    if kind in ("flat", "graded"):
        for name in ("time_to_90", "time_to_99"):
            yield f"{name} by 1 %", scale(name, 0.01)
        yield "time_to_99 is time_to_90", take("time_to_99", "time_to_90")
    if kind == "held":
        yield "force of the time before", late(["normal_force"])
        yield "force_end of the time before", take("force_end", "normal_force", -2)
        yield "volume of the time before", late(["ring_worn_volume"])
        yield "time_to_half_force by 10 %", scale("time_to_half_force", 0.1)
    if kind in ("rising", "up_and_down"):
        yield "force of the time before", late(["normal_force"])
        yield "force at one time", scale("normal_force", size, 2)
    if not full:
        yield "contact radius at the last time", scale("contact_radius", 0.1, -1)
        yield "volume of the time before", late(["ring_worn_volume"])
        yield "volume of one ring", scale("ring_worn_volume", 10 * size, slice(None), 0)
        yield "contact radius of the start by 10 %", scale("contact_radius_start", 0.1)
    if kind == "sphere":
        yield "peak pressure by 10 %", scale("pressure_peak_start", 0.1)
        yield "indentation by 10 %", scale("indentation", 0.1)
        yield "start pressure by 10 %", scale("pressure", 0.1, 0)


def faults(kind: str) -> Iterator[tuple[str, Change]]:
    """Yield the name of each fault for a kind of scene, and its change of the table."""
    for name, change in (*common(kind), *special(kind)):
        # these quantities do not depend on a varying load; the flat scene covers them
        if kind != "rising" or not re.match("steady|relaxation|pressure_m", name):
            yield name, change
