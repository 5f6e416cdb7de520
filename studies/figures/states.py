"""Draw profiles and pressures over the radius, at several times and in the steady state.

The former is the paper's Fig. 4. The least worn height, or the least height of a face that is worn
below all recesses, is subtracted from the profiles, because it may be most of the wear; the figure
prints it.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ...meshes import Array
from ..crosscheck import Result
from .scale import Scale, face_depths, high_pressure, panel_tops, shown_times, subtracted_height
from .style import FAINT, PAGE, RED, complete, new_panels, rings_differ, set_linear


@dataclass(frozen=True, eq=False)
class State:
    """The face of the punch at a time, in the units of the scene.

    Parameters
    ----------
    time : the time
    subtracted : height that is subtracted from profiles (`subtracted_height`)
    unworn : (R,) heights of the unworn face minus `subtracted`
    profiles, pressures : (R,) heights minus `subtracted`, and pressures, by method
    touching : (R,) whether a radius is in contact by any method
    reach : radius up to which the face is drawn
    high : pressure to which panels are scaled
    """

    time: float
    subtracted: float
    unworn: Array
    profiles: dict[str, Array]
    pressures: dict[str, Array]
    touching: NDArray[np.bool_]
    reach: float
    high: float

    @classmethod
    def of(cls, result: Result, index: int) -> "State":
        """Return the state of a result at the time with an index."""
        problem, radii = result.scene.problem, result.coordinates["radius"]
        profiles, pressures = (result.by_method(name, index) for name in ("profile", "pressure"))
        unworn = problem.profile(problem.radii) * problem.units.displacement
        subtracted = min(
            float(subtracted_height(problem, heights)) for heights in profiles.values()
        )
        if subtracted < 1e-6 * problem.units.displacement:
            subtracted = 0.0
        unworn = unworn - subtracted
        profiles = {method: heights - subtracted for method, heights in profiles.items()}
        touching = np.logical_or.reduce([values > 0 for values in pressures.values()])
        length = problem.units.length
        reach = min(1.25 * radii[touching].max(initial=0.0), length) or length
        return cls(
            float(result.coordinates["time"][index]),
            subtracted,
            unworn,
            profiles,
            pressures,
            touching,
            reach,
            max(high_pressure(values) for values in pressures.values()),
        )


def draw_states(result: Result) -> Figure:
    """Draw profiles and pressures at several times, all methods in the same panels.

    If the punch is not flat, panels show the neighbourhood of the contact. The unworn face is above
    a panel if the height subtracted from the profile is larger than the height of the panel.
    """
    scale, problem = Scale.of(result), result.scene.problem
    selected = shown_times(problem.times, 2 if scale.many_rings else 5)
    states = [State.of(result, number) for number in selected]
    figure, panels = new_panels(PAGE, 4.0, 2, len(states))
    # outside the drawn part of a face, use the values at its first radius
    radii = result.coordinates["radius"]
    in_reach = np.array([radii <= state.reach for state in states])
    heights, unworn, touching = (
        np.where(in_reach, values, np.array(values)[:, :1])
        for values in (
            [np.fmax.reduce(list(state.profiles.values())) for state in states],
            [state.unworn for state in states],
            [state.touching for state in states],
        )
    )
    deepest, depths = heights.max(axis=1), panel_tops(face_depths(heights, unworn, touching))
    highs = panel_tops([state.high for state in states])
    scale.suit("profile", depths)
    scale.suit("pressure", highs)
    for state, depth, (upper, lower) in zip(states, depths, panels.T, strict=True):
        _draw_profile(upper, result, state, float(depth), scale)
        scale.plot_radial(lower, "pressure", result.coordinates["radius"], state.pressures)
        for axes in (upper, lower):
            axes.set_xlim(scale.first_radius(state.reach), scale.shown("radius", state.reach))
        less = f" − {scale.height(state.subtracted)}" if state.subtracted else ""
        upper.set_title(f"{scale.when(state.time)}\nΔf = f{less}")
        upper.xaxis.set_visible(False)
    for row, name, heights in zip(panels, ("profile", "pressure"), (depths, highs), strict=True):
        tops = scale.shown(name, heights)
        for axes, top in zip(row, tops, strict=True):
            # the axis of heights points down, as the punch does
            axes.set_ylim((1.08 * top, -0.06 * top) if name == "profile" else (0, 1.25 * top))
            set_linear(axes, "y")
            if axes is not row[0]:
                axes.set_ylabel("")
                # ticks take most of the time of a figure with many panels
                axes.yaxis.set_visible(bool(np.ptp(tops)))
    notes = _shaded(scale), *_hidden(states, depths, deepest, scale)
    titles = result.scene.title, "profiles and pressures"
    # panels with different axes need space for labels
    distance_of_panels = 0.5 if np.ptp(depths) or np.ptp(highs) else 0.4
    return complete(
        figure, titles, panels[:, 0], "\n".join(filter(None, notes)), across=distance_of_panels
    )


def _draw_profile(axes: Axes, result: Result, state: State, depth: float, scale: Scale) -> None:
    """Draw the face of the punch, the unworn face, and the worn-off material between them."""
    radii = result.coordinates["radius"]
    scale.plot_radial(axes, "profile", radii, state.profiles)
    # limit heights that are far above the panel
    unworn = np.maximum(state.unworn, -depth)
    faces = (
        scale.shown("profile", unworn),
        scale.shown("profile", next(iter(state.profiles.values()))),
    )
    places = scale.shown("radius", radii)
    axes.plot(places, faces[0], **FAINT, label="unworn punch")
    axes.fill_between(places, *faces, color=RED, alpha=0.15, linewidth=0, label="worn off")


def _hidden(states: list[State], depths: Array, deepest: Array, scale: Scale) -> list[str]:
    """Return notes about parts that are outside of the panels."""
    lines = []
    if any(state.unworn.max() < -0.06 * depth for state, depth in zip(states, depths, strict=True)):
        lines.append(
            "If more has worn off everywhere than a panel shows, the unworn punch is above it."
        )
    if (cut := deepest > 1.1 * depths).any():
        furthest = scale.height(float(deepest[cut].max()))
        lines.append(
            f"Panels are cut off below: the greatest height of the face is Δf = {furthest}."
        )
    return lines


def _draw_along_radius(
    axes: Axes, name: str, radii: Array, values: dict[str, Array], scale: Scale
) -> None:
    """Draw a field of each method along the radius, in a panel of its own."""
    scale.suit(name, np.array(list(values.values())))
    scale.plot_radial(axes, name, radii, values)
    set_linear(axes, "x")
    set_linear(axes, "y")


def draw_field(result: Result, name: str, index: int) -> Figure:
    """Draw a field along the radius at the time with an index, all methods in one panel."""
    scale, values = Scale.of(result), result.by_method(name, index)
    figure, ((axes,),) = new_panels(PAGE, 2.8)
    _draw_along_radius(axes, name, result.coordinates["radius"], values, scale)
    if name != "pressure":
        # the axis of heights points down, as the punch does
        axes.invert_yaxis()
    when = scale.when(float(result.coordinates["time"][index]))
    return complete(figure, (result.scene.title, when), [axes], _shaded(scale))


def draw_steady(result: Result) -> Figure:
    """Draw limiting profile and steady pressure, all methods in the same panels."""
    scale, names = Scale.of(result), ("steady_profile", "steady_pressure")
    figure, panels = new_panels(PAGE, 2.8, columns=2)
    for axes, name in zip(panels[0], names, strict=True):
        values = result.by_method(name)
        _draw_along_radius(axes, name, result.coordinates["radius"], values, scale)
    panels[0, 0].invert_yaxis()
    panels[0, 1].set_ylim(0, 1.08 * panels[0, 1].dataLim.y1)
    titles = result.scene.title, scale.steady_state
    return complete(figure, titles, panels[0, :1], _shaded(scale))


def _shaded(scale: Scale) -> str:
    """Return the note about shaded rings; empty if none are shaded."""
    differ = rings_differ(scale.problem.wear_coefficients)
    return "shaded: rings that wear faster" if differ else ""
