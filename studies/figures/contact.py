"""Contact that opens, closes and spreads: where it is, and what it does to each ring, over time."""

import numpy as np
from matplotlib.figure import Figure

from ..crosscheck.dataset import Result
from .scale import Scale, by_method
from .style import PAGE, complete, curve, method_curve, new_panels


def draw_contact(result: Result) -> Figure:
    """Draw edges of the contact by every method, its inside shaded, and forces and worn volumes of
    rings by the first; of many rings, five.
    """
    scale, data = Scale(result.scene), result.dataset
    figure, panels = new_panels(PAGE, 2.9, columns=3)
    where, force, volume = panels.flat
    methods = by_method(data.contact_edge)
    for number, (method, edges) in enumerate(methods.items()):
        look = {"linestyle": "none", "marker": "ox+^"[number % 4], "markerfacecolor": "none"}
        color = method_curve(method)["color"]
        scale.plot(where, edges, **look, markersize=4, color=color, label=method.upper())
    for edge in data.ring_outer_radius[:-1]:
        height = scale.shown("radius", float(edge))
        where.axhline(height, color="0.75", linewidth=0.6, zorder=0, label="ring edge")
    first = data.sel(solver=next(iter(methods)))
    times, radii = (scale.shown(name, first[name]) for name in ("time", "radius"))
    carries = first.contact.T > 0
    where.pcolormesh(times, radii, carries, cmap="Greys", vmax=5, shading="nearest", zorder=-1)
    count = first.sizes["ring"]
    for number, ring in enumerate(np.unique(np.linspace(0, count - 1, min(count, 5)).round())):
        look = curve(number) | {"markersize": 2.5, "label": f"ring {ring + 1:g}"}
        of_ring = first.isel(ring=int(ring))
        scale.plot(force, of_ring.ring_force, **look)
        scale.plot(volume, of_ring.ring_worn_volume, **look)
    scale.plot(force, first.normal_force, color="black", linewidth=0.8, label="all rings")
    for axes, high in ((where, 1.04 * radii.max()), (force, None), (volume, None)):
        axes.set_ylim(0, high)
    titles = result.scene.title, "contact over time"
    return complete(figure, titles, figure.axes, scale.note, across=0.56)
