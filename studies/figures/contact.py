"""Contact that opens, closes and spreads: where it is, and what it does to each ring, over time."""

import numpy as np
from matplotlib.figure import Figure

from ..outcome.outcome import Outcome
from .scale import Scale
from .style import PAGE, complete, curve, method_curve, new_panels, show_values


def draw_contact(result: Outcome) -> Figure:
    """Draw the edges of the contact, the forces on rings and the worn volumes of rings over time.

    Edges are shown by every method, with the inside of the contact shaded. Forces and worn volumes
    are shown by the first method. If there are more than five rings, five of them are shown.
    """
    scale, (_, between) = Scale(result.scene), result.between
    figure, panels = new_panels(PAGE, 2.9, columns=3)
    where, force, volume = panels.flat
    for number, (method, radii) in enumerate(result.by_method("contact_edge").items()):
        color, marker = method_curve(method)["color"], "ox+^"[number % 4]
        look = curve(number) | {"color": color, "marker": marker, "label": method.upper()}
        look |= {"linestyle": "", "clip_on": False}
        scale.plot(where, "contact_edge", "time", result.coordinates["time"], radii, **look)
    for height in scale.shown("radius", result.coordinates["ring_outer_radius"][:-1]):
        where.axhline(height, color="0.75", linewidth=0.6, zorder=0, label="ring edge")
    times, radii = (scale.shown(name, between[name]) for name in ("time", "radius"))
    where.pcolormesh(
        times, radii, between["contact"].T, cmap="Greys", vmax=5, shading="gouraud", zorder=-1
    )
    count = len(result.coordinates["ring"])
    for number, ring in enumerate(np.unique(np.linspace(0, count - 1, min(count, 5)).astype(int))):
        look = curve(number) | {"marker": "", "label": f"ring {ring + 1}"}
        for axes, name in ((force, "ring_force"), (volume, "ring_worn_volume")):
            scale.plot(axes, name, "time", between["time"], between[name][:, ring], **look)
    look = curve(0) | {"marker": "", "color": "0.75", "linewidth": 2.0, "label": "all rings"}
    scale.plot(force, "normal_force", "time", between["time"], between["normal_force"], **look)
    for axes in panels.flat:
        axes.set_ylim(0, 1.04 * axes.dataLim.y1)
        show_values(axes)
    return complete(figure, (result.scene.title, "contact over time"), figure.axes)
