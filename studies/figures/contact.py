"""Draw contact with moving edges: its edges, and force and worn volume of each ring, over time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from ..crosscheck import Result
from .scale import Scale
from .style import PAGE, cell_edges, complete, curve, new_panels, set_linear, show_values


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
