"""Data of the slider on the page: profiles and pressures over time and in the steady state."""

from typing import Any

import numpy as np

from ...meshes import Array, ring_of
from ..crosscheck import Result
from ..figures.scale import (
    Scale,
    face_depths,
    high_pressure,
    panel_tops,
    shown_times,
    subtracted_height,
)
from ..figures.style import rings_differ
from ..figures.ticks import short_number


def slides(result: Result) -> dict[str, Any] | None:
    """Return the data that `slides.js` draws, in the units of its axes.

    Return None if no profiles and pressures along the radius are available.
    """
    if not {"profile", "pressure"} <= result.table.data_vars.keys():
        return None
    scale, problem = Scale(result.scene), result.scene.problem
    _, states = result.between
    radii, profiles, pressures = (states[name] for name in ("radius", "profile", "pressure"))
    known_states = np.flatnonzero(~np.isnan(profiles).all(axis=1))
    selected = known_states[shown_times(states["time"][known_states], 48)]
    labels = [scale.when(time) for time in states["time"][selected]]
    profiles, pressures = profiles[selected], pressures[selected]
    steady_count = 0
    if not np.isnan(states.get("steady_profile", np.nan)).any():
        labels.append(scale.steady_state)
        profiles = np.vstack([profiles, states["steady_profile"]])
        pressures = np.vstack([pressures, states["steady_pressure"]])
        steady_count = 1
    if not labels or len(radii) <= 10:
        return None
    subtracted = subtracted_height(problem, profiles)
    # the least height of the limiting profile is already zero
    subtracted[len(subtracted) - steady_count :] = 0.0
    heights = profiles - subtracted[:, None]
    unworn = problem.profile(problem.radii) * problem.units.displacement
    tops = panel_tops([high_pressure(pressure) for pressure in pressures])
    # use a part of the radii if there are many, so that the page stays small
    stride = slice(None, None, 1 + len(radii) // 1100)
    # parts of the face that are much further back than the worn parts are cut off
    depths = face_depths(heights, unworn - subtracted[:, None], pressures > 0)
    deepest = float(depths.max()) or 1.0
    # height in the 3-D view that the greatest difference of heights has, over the radius
    drawn_height, edges = 0.3, problem.ring_edges * result.scene.punch.radius
    log_wear = np.log(problem.wear_coefficients) * rings_differ(problem.wear_coefficients)
    # in the steady state the wear is unlimited: move the unworn face out of the frame
    subtracted[len(subtracted) - steady_count :] = 10 * deepest
    # as for pressures: states whose heights differ by orders of magnitude have their own scales
    frames = panel_tops(depths)
    scale.suit("profile", frames)
    scale.suit("pressure", tops)
    return {
        "radii": _round(scale.shown("radius", radii[stride])),
        "edges": _round(scale.shown("radius", edges)),
        "shade": _round((log_wear - log_wear.min()) / (np.ptp(log_wear) or 1.0)),
        "ring": ring_of(edges, radii[stride]).tolist(),
        "labels": labels,
        "profile": _round(scale.shown("profile", heights[:, stride])),
        "pressure": _round(scale.shown("pressure", pressures[:, stride])),
        "unworn": _round(scale.shown("profile", unworn[stride])),
        "subtracted": _round(scale.shown("profile", subtracted)),
        "highest": _round(1.15 * scale.shown("pressure", tops)),
        "deepest": _round(1.08 * scale.shown("profile", frames)),
        "solid": scale.shown("profile", deepest),
        "drawn": drawn_height,
        "magnified": short_number(drawn_height * result.scene.punch.radius / deepest),
        "axes": {name: scale.label(name) for name in ("radius", "profile", "pressure")},
    }


def _round(values: Array) -> Any:
    """Return numbers rounded to four digits, which is enough for a screen."""
    sizes = np.abs(np.where(np.isfinite(values) & (values != 0), values, 1.0))
    ten_thousandths = 10.0 ** (3 - np.floor(np.log10(sizes)))
    return (np.round(values * ten_thousandths) / ten_thousandths).tolist()
