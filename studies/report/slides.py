"""The states that the slider of the page goes through.

Profiles and pressures at times from the start on, and in the steady state.
"""

from typing import Any

import numpy as np

from ...meshes.radial import Array, ring_of
from ..figures.scale import (
    Scale,
    face_depths,
    high_pressure,
    least_wear,
    panel_tops,
    shown_times,
)
from ..figures.style import rings_differ
from ..outcome.outcome import Outcome


def slides(result: Outcome) -> dict[str, Any] | None:
    """Return what the script of the page draws, in the units of its axes.

    Nothing where no state is known over the radius.
    """
    if not {"profile", "pressure"} <= set(result.table.variables):
        return None
    scale, problem = Scale(result.scene), result.scene.problem
    _, states = result.between
    radii, profiles, pressures = (states[name] for name in ("radius", "profile", "pressure"))
    given = np.flatnonzero(~np.isnan(profiles).all(axis=1))
    chosen = given[shown_times(states["time"][given], 48)]
    labels = [scale.when(time) for time in states["time"][chosen]]
    profiles, pressures = profiles[chosen], pressures[chosen]
    steady = 0
    if not np.isnan(states.get("steady_profile", np.nan)).any():
        labels.append(scale.steady_state)
        profiles = np.vstack([profiles, states["steady_profile"]])
        pressures = np.vstack([pressures, states["steady_pressure"]])
        steady = 1
    if not labels or len(radii) <= 10:
        return None
    worn = least_wear(problem, profiles)
    heights = profiles - worn[:, None]
    unworn = problem.profile(problem.radii) * problem.units.displacement
    tops = panel_tops([high_pressure(pressure) for pressure in pressures])
    # so that a page of hundreds of rings stays small
    some = slice(None, None, 1 + len(radii) // 1100)
    # parts of the face that are further back than those that wear are cut off
    depths = face_depths(heights, unworn - worn[:, None], pressures > 0)
    deepest = float(depths.max()) or 1.0
    # part of the radius that the greatest difference of heights is drawn as, in 3-D
    drawn, edges = 0.3, problem.ring_edges * result.scene.punch.radius
    order = np.log(problem.wear_coefficients) * rings_differ(problem.wear_coefficients)
    # in the steady state, all of the face has worn by any height
    worn[len(worn) - steady :] = 10 * deepest
    scale.suit("profile", deepest)
    scale.suit("pressure", tops)
    return {
        "radii": _round(scale.shown("radius", radii[some])),
        "edges": _round(scale.shown("radius", edges)),
        "shade": _round((order - order.min()) / (np.ptp(order) or 1.0)),
        "ring": ring_of(edges, radii[some]).tolist(),
        "labels": labels,
        "profile": _round(scale.shown("profile", heights[:, some])),
        "pressure": _round(scale.shown("pressure", pressures[:, some])),
        "beside": _round(scale.shown("profile", unworn[some])),
        "above": _round(scale.shown("profile", worn)),
        "highest": _round(1.15 * scale.shown("pressure", tops)),
        "deepest": scale.shown("profile", deepest),
        "drawn": drawn,
        "magnified": f"{drawn * result.scene.punch.radius / deepest:.3g}",
        "axes": {name: scale.label(name) for name in ("radius", "profile", "pressure")},
    }


def _round(values: Array) -> Any:
    """Return numbers to four digits, which a screen cannot tell from more."""
    return [_round(row) if np.ndim(row) else float(f"{row:.4g}") for row in values]
