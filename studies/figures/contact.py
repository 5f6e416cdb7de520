"""Contact that opens, closes and spreads: where it is, and what it does to each ring, over time."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..crosscheck.dataset import Result
from ..methods.quantities import array
from .scale import Scale
from .style import complete, curve, method_curve, page, time_axis, titled


def draw_contact(result: Result) -> Figure:
    """Draw edges of the contact by every method, its inside shaded, and forces and worn volumes of
    rings by the first; of many rings, five.
    """
    problem, scale, methods = result.scene.problem, Scale(result.scene), result.given("contact")
    figure, panels = page(1, 3, 1.9, across=0.55)
    where, force, volume = panels[0]
    times, radii = problem.times * scale.time.factor, problem.radii * scale.radius.factor
    first = next(iter(methods.values()))
    _draw_edges(where, result, scale)
    carries = array(first, "contact").T > 0
    where.pcolormesh(times, radii, carries, cmap="Greys", vmax=5, shading="nearest", zorder=-1)
    count = len(problem.wear_coefficients)
    rings = np.unique(np.linspace(0, count - 1, min(count, 5)).round().astype(int))
    volumes = array(first, "ring_worn_volume")
    unit, factor = _volume(scale, float(volumes.max()), problem.indentation is None)
    for number, ring in enumerate(rings):
        look = curve(number) | {"markersize": 2.5}
        force.plot(times, array(first, "ring_force")[:, ring], **look, label=f"ring {ring + 1}")
        volume.plot(times, volumes[:, ring] * factor, **look)
    force.plot(times, array(first, "normal_force"), color="black", linewidth=0.8, label="all rings")
    force.set_ylim(0, 1.1 * float(array(first, "normal_force").max()))
    force.set_ylabel("force over $F$" if problem.indentation is None else "force over $2 a E^* d$")
    volume.set_ylim(bottom=0)
    volume.set_ylabel(f"worn volume {unit}")
    for axes in panels[0]:
        time_axis(axes, times)
        axes.set_xlabel(scale.time.label("time", "t"))
    return complete(figure, titled(result.scene, "contact over time"), (where, force), scale.note)


def _draw_edges(axes: Any, result: Result, scale: Scale) -> None:
    radius, times = scale.radius.factor, result.scene.problem.times * scale.time.factor
    for edge in result.scene.problem.ring_edges[1:-1]:
        axes.axhline(edge * radius, color="0.75", linewidth=0.6, zorder=0, label="ring edge")
    for number, (name, results) in enumerate(result.given("contact_edge").items()):
        axes.plot(
            times,
            array(results, "contact_edge") * radius,
            "ox+^"[number % 4],
            label=name.upper(),
            markersize=4,
            markerfacecolor="none",
            color=method_curve(name)["color"],
        )
    axes.set_ylim(0, 1.04 * radius)
    axes.set_ylabel(scale.radius.label("contact (shaded), its edges", "r"))


def _volume(scale: Scale, greatest: float, under_force: bool) -> tuple[str, float]:
    """Return the unit of worn volumes, and by what non-dimensional ones are to be multiplied."""
    if not scale.names.si:
        return "$V E^* / (F a)$" if under_force else "over $2 a^2 d$", 1.0
    unit, name = scale.names.readable(greatest * scale.units.volume, "volume")
    return f"$V$ ({name})", scale.units.volume / unit
