"""Draw the running-in and the contact over time.

The running-in is greatest displacement and RMS slope, the quantities of the paper's Fig. 5, and the
differences of methods in them. The contact has edges that move, and forces and worn volumes of
rings.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from ...meshes import Array
from ..crosscheck import Result
from .scale import Scale
from .style import (
    FAINT,
    PAGE,
    Look,
    cell_edges,
    complete,
    curve,
    label_of,
    new_panels,
    set_linear,
    set_logarithmic,
    show_values,
)


def draw_history(result: Result) -> Figure:
    """Draw displacement and RMS slope over time, and the differences of methods from the first.

    The RMS slope is left out if it has no finite value at any time.
    Values are marked at the times of the scene. The force is drawn instead of the displacement if
    the scene prescribes the indentation, and the indentation if more methods compute it.
    Differences are drawn in panels below, relative to the value.
    """
    scale = Scale.of(result)
    after_start = result.coordinates["time"] > 0
    times = result.coordinates["time"][after_start]
    # results of other programs may contain the indentation only
    fixed = result.scene.problem.indentation is not None
    candidates = "normal_force" if fixed else "displacement_max", "indentation"
    names = [max(candidates, key=lambda name: len(result.by_method(name)))]
    if result.gives("rms_slope"):
        names.append("rms_slope")
    method_between, values_between = result.between
    rows = min(2, len(result.by_method(names[-1])))
    figure, panels = new_panels(
        PAGE, 2.6 + 0.6 * rows, rows, len(names), sharex=True, height_ratios=[2.2, 1][:rows]
    )
    for name, (values, *below) in zip(names, panels.T, strict=True):
        methods = result.by_method(name, after_start)
        scale.suit(name, np.array(list(methods.values())))
        for method, heights in methods.items():
            look = scale.look(method)
            if method == method_between:
                look["marker"] = ""
                scale.plot(
                    values, name, "time", values_between["time"], values_between[name], **look
                )
            else:
                # draw marks without a line if another method has a curve
                look = {"marker": "."} | look | ({"linestyle": "none"} if method_between else {})
                scale.plot(values, name, "time", times, heights, **look)
        steady = scale.shown(name, result.first(f"steady_{name}"))
        if np.isfinite(steady):
            values.axhline(steady, **FAINT, label=scale.steady_state)
        show_values(values)
        _mark_running_in(values, result, scale)
        for axes in below:
            _draw_differences(axes, times, methods, scale)
            values.set_xlabel("")
    titles = result.scene.title, "running-in"
    return complete(figure, titles, panels[:, 0])


def _mark_running_in(axes: Axes, result: Result, scale: Scale) -> None:
    """Mark the times at which 90 % and 99 % of the running-in are complete, above the panel."""
    start, end = axes.get_xlim()
    for percentage, side in ((90, "right"), (99, "left")):
        time = scale.shown("time", float(result.first(f"time_to_{percentage}")))
        if start < time < end:
            axes.axvline(time, color="0.6", linewidth=0.6, zorder=0)
            place = axes.get_xaxis_transform()
            axes.text(time, 1.01, f"{percentage} %", transform=place, ha=side, va="bottom")


def _draw_differences(axes: Axes, times: Array, methods: dict[str, Array], scale: Scale) -> None:
    """Draw differences of each method from the first, relative to its value; omit zeros."""
    (first, reference), *others = methods.items()
    # lower bound: without contact, displacements are only roundoff
    reference_size = np.maximum(reference, 1e-9 * np.nanmax(reference))
    for method, heights in others:
        differences = np.abs(heights - reference) / reference_size
        # the colour and the mark of the method, as in the panel above
        look: Look = {"marker": "."} | scale.look(method) | {"linewidth": 0.8, "clip_on": False}
        look["label"] = f"{label_of(method)} minus {label_of(first)}"
        shown = np.where(differences > 0, differences, np.nan)
        axes.plot(scale.shown("time", times), shown, **look)
    set_logarithmic(axes, "y", most=3)
    axes.set(xlabel=scale.label("time"), ylabel="rel. difference")
    # limit the axis to whole decades
    low, high = np.log10(axes.get_ylim())
    axes.set_ylim(10 ** np.floor(low), 10 ** np.ceil(high))


def draw_contact(result: Result) -> Figure:
    """Draw the edges of the contact, the forces on rings and the worn volumes of rings over time.

    The figure shows edges by every method, and shades the inside of the contact. Forces and worn
    volumes are by the first method. Of more than five rings, five are shown.
    """
    scale, (_, history) = Scale.of(result), result.between
    figure, panels = new_panels(PAGE, 2.9, columns=3)
    edges, forces, volumes = panels.flat
    _draw_edges(edges, result, scale)
    scale.suit("normal_force", history["normal_force"])
    scale.suit("ring_worn_volume", history["ring_worn_volume"])
    count = len(result.coordinates["ring"])
    for number, ring in enumerate(np.unique(np.linspace(0, count - 1, min(count, 5)).astype(int))):
        look = curve(number) | {"marker": "", "label": f"ring {ring + 1}"}
        for axes, name in ((forces, "ring_force"), (volumes, "ring_worn_volume")):
            scale.plot(axes, name, "time", history["time"], history[name][:, ring], **look)
    look = curve(0) | {"marker": "", "color": "0.75", "linewidth": 2.5, "label": "all rings"}
    # behind the rings: the force on a single ring is that on all rings
    look["zorder"] = 1.5
    scale.plot(forces, "normal_force", "time", history["time"], history["normal_force"], **look)
    for axes in panels.flat:
        axes.set_ylim(0, 1.04 * axes.dataLim.y1)
        show_values(axes)
        axes.set_xlim(edges.get_xlim())
        if not scale.logarithmic:
            set_linear(axes, "x", most=4)
    return complete(figure, (result.scene.title, "contact over time"), figure.axes)


def _draw_edges(axes: Axes, result: Result, scale: Scale) -> None:
    """Draw the edges of the contact by every method, and shade its inside by the first of them.

    The centre of a solid punch is no edge. The shading begins at the first time that is shown.
    """
    problem, (_, history) = scale.problem, result.between
    for number, (method, radii) in enumerate(result.by_method("contact_edge").items()):
        look = curve(number) | {"color": scale.look(method)["color"], "marker": "ox+^"[number % 4]}
        look |= {"linestyle": "", "clip_on": False, "label": scale.look(method)["label"]}
        edges = np.where(radii > 0, radii, np.nan)
        scale.plot(axes, "contact_edge", "time", result.coordinates["time"], edges, **look)
    for height in scale.shown("radius", result.coordinates["ring_outer_radius"][:-1]):
        axes.axhline(height, color="0.75", linewidth=0.6, zorder=0, label="ring edge")
    shown = history["time"] > 0 if scale.logarithmic else np.isfinite(history["time"])
    times, radii = (scale.shown(name, history[name]) for name in ("time", "radius"))
    times, (inner, outer) = (
        times[shown],
        scale.shown("radius", problem.ring_edges[[0, -1]] * problem.units.length),
    )
    if len(times) > 1:
        ends = cell_edges(times).clip(times[0], times[-1]), cell_edges(radii).clip(inner, outer)
        touching = np.ma.masked_less(history["contact"][shown].T, 0.5)
        axes.pcolormesh(*ends, touching, cmap=ListedColormap(["0.87"]), zorder=-1)
        axes.set_xlim(times[0], times[-1])
