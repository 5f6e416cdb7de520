"""Contact that opens, closes and spreads: where it is, and what it does to each ring, over time."""

import numpy as np
from matplotlib.figure import Figure

from ..crosscheck.dataset import Result
from .scale import Scale
from .style import PAGE, complete, curve, method_curve, new_panels


def draw_contact(result: Result) -> Figure:
    """Draw edges of the contact by every method, its inside shaded, and forces and worn volumes of
    rings by the first; of many rings, five.
    """
    scale, edges = Scale(result.scene), result.by_method("contact_edge")
    first = result.reported(next(iter(edges)))
    _, between = result.between
    all_times = first["time"]
    figure, panels = new_panels(PAGE, 2.9, columns=3)
    where, force, volume = panels.flat
    for number, (method, radii) in enumerate(edges.items()):
        look = {"linestyle": "none", "marker": "ox+^"[number % 4], "markerfacecolor": "none"}
        color = method_curve(method)["color"]
        look |= {"color": color, "label": method.upper()}
        scale.plot(
            where, "contact_edge", "time", all_times, radii, markersize=4, clip_on=False, **look
        )
    for height in scale.shown("radius", first["ring_outer_radius"][:-1]):
        where.axhline(height, color="0.75", linewidth=0.6, zorder=0, label="ring edge")
    times, radii = (scale.shown(name, between[name]) for name in ("time", "radius"))
    where.pcolormesh(
        times, radii, between["contact"].T, cmap="Greys", vmax=5, shading="gouraud", zorder=-1
    )
    count = len(first["ring"])
    for number, ring in enumerate(np.unique(np.linspace(0, count - 1, min(count, 5)).round())):
        look = curve(number) | {"markersize": 2.5, "label": f"ring {ring + 1:g}"}
        for axes, name in ((force, "ring_force"), (volume, "ring_worn_volume")):
            for values, part in (
                (between, {"marker": "", "label": ""}),
                (first, {"linestyle": ""}),
            ):
                of_ring = values[name][:, int(ring)]
                scale.plot(axes, name, "time", values["time"], of_ring, **look | part)
    look = {"color": "black", "label": "all rings"}
    total = between["normal_force"]
    scale.plot(force, "normal_force", "time", between["time"], total, linewidth=0.8, **look)
    for axes in panels.flat:
        axes.set_ylim(0, 1.04 * axes.dataLim.y1)
    titles = result.scene.title, "contact over time"
    return complete(figure, titles, figure.axes, scale.note, across=0.56)
