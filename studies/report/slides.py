"""The states that the slider of the page goes through.

Profiles and pressures from the start to the steady state.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ...meshes.radial import Array, ring_of
from ..crosscheck.dataset import Result, in_units
from ..figures.scale import Scale, high_pressure, least_wear, panel_tops, shown_times
from ..methods.sampler import Sampler
from ..wear.full_contact import RunningIn

COUNT = 48


def slides(result: Result) -> dict[str, Any] | None:
    """Return what the script of the page draws, in the units of its axes.

    Nothing where no state is known over the radius.
    """
    if not {"profile", "pressure"} <= set(result.table.variables):
        return None
    scale, rings = Scale(result.scene), result.scene.problem.rings
    wears = (solution.wear for solution in result.solutions.values())
    wear, problem = next(filter(None, wears), None), result.scene.problem
    if wear is None or problem.loading.varies or not len(problem.times):
        states = _select_times(result)
        labels = [scale.when(time) for time in states["time"]]
    else:
        states, labels = _sample_times(result, wear)
    radii, profiles, pressures = (states[name] for name in ("radius", "profile", "pressure"))
    if not np.isnan(states.get("steady_profile", np.nan)).any():
        labels.append("steady state")
        profiles = np.vstack([profiles, states["steady_profile"]])
        pressures = np.vstack([pressures, states["steady_pressure"]])
    if not labels or len(radii) <= 10:
        return None
    # so that a page of hundreds of rings stays small
    step = -(-len(radii) // 1100)
    problem = replace(scale.problem, output_radii=radii / scale.problem.units.length)
    heights = profiles - least_wear(problem, profiles)[:, None]
    high = [high_pressure(pressure) for pressure in pressures]
    # what states are seen against: the unworn face, or the last of a flat punch
    beside, unworn = heights[-1], ""
    if not problem.full_contact:
        unworn = "the unworn face, and the pressure at "
        beside = problem.profile(problem.radii) * problem.units.displacement
    radii, pressures, heights = radii[::step], pressures[:, ::step], heights[:, ::step]
    deepest = float(heights.max()) or scale.axes["height"].unit
    # part of the radius that the greatest difference of heights is drawn as, in 3-D
    drawn, edges = 0.3, rings.ring_edges * result.scene.punch.radius
    order = np.log(rings.wear_coefficients)
    return {
        "radii": _round(scale.shown("radius", radii)),
        "edges": _round(scale.shown("radius", edges)),
        "shade": _round((order - order.min()) / (np.ptp(order) or 1.0)),
        "ring": ring_of(edges, radii).tolist(),
        "labels": labels,
        "profile": _round(scale.shown("profile", heights)),
        "pressure": _round(scale.shown("pressure", pressures)),
        "beside": _round(scale.shown("profile", beside[::step])),
        "dotted": f"{unworn}{labels[-1]}",
        "highest": _round(1.15 * scale.shown("pressure", panel_tops(high))),
        "deepest": scale.shown("profile", deepest),
        "drawn": drawn,
        "magnified": f"{drawn * result.scene.punch.radius / deepest:.3g}",
        "axes": {name: scale.label(name) for name in ("radius", "profile", "pressure")},
    }


def _sample_times(result: Result, wear: RunningIn) -> tuple[dict[str, Array], list[str]]:
    """Return states and their labels: at the start, then at times in equal ratios until the last
    one asked for, or until the punch has run in.
    """
    problem, scale = replace(result.scene.problem, output_radii=None), Scale(result.scene)
    done = wear.modes.time_to(0.995)
    first = problem.earliest or 1e-3 * done
    last = max(float(problem.times[-1]), done, 2 * first)
    times = np.array([0.0, *np.geomspace(first, last, COUNT)])
    labels = [
        f"{scale.when(time * problem.units.time)}, {100 * (1 - left):.3g} % run in"
        for time, left in zip(times, wear.modes.left(times), strict=True)
    ]
    sampler, units = Sampler(problem, wear.compliance.space), problem.units
    states = sampler.history(wear.modal(times))
    if problem.steady:
        states |= sampler.steady(wear.steady)
    return in_units(problem, states) | {"radius": problem.radii * units.length}, labels


def _select_times(result: Result) -> dict[str, Array]:
    """Return some of the states of a curve, and the steady state."""
    _, states = result.between
    chosen = np.flatnonzero(~np.isnan(states["profile"]).all(axis=1))
    chosen = chosen[shown_times(states["time"][chosen], COUNT)]
    return states | {name: states[name][chosen] for name in ("time", "profile", "pressure")}


def _round(values: Array) -> Any:
    """Return numbers to four digits, which a screen cannot tell from more."""
    return [_round(row) if np.ndim(row) else float(f"{row:.4g}") for row in values]
