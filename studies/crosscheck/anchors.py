"""What no method can move.

Closed forms and balances (`reported.py`) that its *reported* results are held to, each method by
itself.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...meshes.radial import Array
from ..methods.base import Solution
from ..problem.scene import Scene
from .reported import Reported


@dataclass(frozen=True)
class Anchor:
    """A closed form or a balance that a method is held to.

    Relative difference and what is tolerated.
    """

    name: str
    method: str
    difference: float
    tolerance: float

    @property
    def holds(self) -> bool:
        return self.difference <= self.tolerance


def anchors(scene: Scene, name: str, table: Mapping[str, Any], solution: Solution) -> list[Anchor]:
    """Hold a method to all that applies to what it reports.

    Parameters
    ----------
    scene : what was asked for
    name : of the method
    table : what is written of it, by the names of quantities, in the scene's units
    solution : what the method said of the face, and of its own errors
    """
    reported = Reported(scene, table, solution)
    groups = [
        (
            "steady_pressure steady_profile steady_wear_rate steady_displacement_max "
            "steady_rms_slope",
            reported.check_steady_state,
        ),
    ]
    forces = "normal_force" if reported.fixed else ""
    if reported.times.size:
        groups += [
            ("ring_force pressure", reported.check_forces),
            ("ring_worn_volume", reported.check_volume),
        ]
    if reported.times.size and reported.fixed:
        groups += [
            ("normal_force ring_worn_volume", reported.check_decay),
            ("pressure profile displacement ring_worn_volume", reported.check_balance),
        ]
    if scene.problem.full_contact:
        groups.append(("relaxation_time", reported.check_modes))
    if scene.problem.full_contact and reported.times.size:
        groups += [
            ("indentation", reported.check_start),
            ("pressure ring_force", reported.check_start_pressures),
            (
                "indentation profile displacement displacement_centre displacement_max",
                reported.check_fields,
            ),
            ("profile rms_slope", reported.check_slopes),
        ]
    if scene.problem.full_contact and reported.later.any():
        groups += [
            (f"indentation pressure profile {forces}", reported.check_wear),
            ("indentation pressure profile displacement", reported.check_output),
            ("pressure", reported.check_power),
        ]
    given = set(filter(scene.problem.wants, solution.checked.keys() & solution.errors.keys()))
    return [
        anchor
        for quantities, rows in groups
        if given.issuperset(quantities.split())
        for label, *numbers in rows()
        for anchor in judge(label, name, *numbers)
    ]


def judge(
    name: str,
    method: str,
    value: Array | float,
    reference: Array | float,
    tolerance: Array | float,
    scale: Array | float | None = None,
) -> Iterator[Anchor]:
    """Yield an anchor where the difference is the greatest part of what is tolerated.

    It is relative to the reference, or to a scale. What is no number holds to nothing, and what may
    be infinitely wrong is no anchor.
    """
    difference = np.abs((value - reference) / (reference if scale is None else scale))
    # JSON cannot hold what is no number
    difference = np.nan_to_num(difference, nan=1e99)
    differences, tolerances = np.broadcast_arrays(np.atleast_1d(difference), tolerance)
    if (bound := np.isfinite(tolerances)).any():
        differences, tolerances = differences[bound], tolerances[bound]
        worst = np.argmax(differences / tolerances)
        yield Anchor(name, method, float(differences[worst]), float(tolerances[worst]))
