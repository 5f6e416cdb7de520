"""Figures of contact that opens, closes and spreads.

Where it is, and what it does to each ring, over time.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..methods.base import Solution
from ..methods.quantities import array
from ..problem.scene import Scene
from .scale import Scale
from .style import (
    Margins,
    curve,
    footing,
    heading,
    method_curve,
    page,
    save,
    styled,
    time_axis,
    titled,
)

MOST_RINGS = 5


@styled
def draw_contact(scene: Scene, solutions: Mapping[str, Solution], path: Path) -> None:
    """Edges of the contact by every method, its inside shaded.

    And forces and worn volumes of rings by the first.
    """
    every = {name: one.results for name, one in solutions.items() if "contact_edge" in one.results}
    if not every:
        return
    problem, scale = scene.problem, Scale(scene)
    times, radius = problem.times * scale.time.factor, scale.radius.factor
    figure, ((where, force, volume),) = page(1, 3, 1.9, Margins(across=0.55, top=0.3, bottom=0.68))
    first = next(iter(every.values()))
    for number, edge in enumerate(problem.ring_edges[1:-1]):
        where.axhline(
            edge * radius,
            color="0.75",
            linewidth=0.6,
            zorder=0,
            label="ring edge" if number == 0 else None,
        )
    carries = array(first, "contact") > 0
    where.pcolormesh(
        times,
        problem.radii * radius,
        carries.T,
        cmap="Greys",
        vmin=0,
        vmax=5,
        shading="nearest",
        zorder=-1,
    )
    for number, (name, results) in enumerate(every.items()):
        label, *others = [name.upper()] + [None] * (array(results, "contact_edge").shape[1] - 1)
        look = {
            "linestyle": "none",
            "marker": "ox+^"[number % 4],
            "markersize": 4,
            "color": method_curve(name)["color"],
        }
        for edge, named in zip(array(results, "contact_edge").T, (label, *others), strict=True):
            where.plot(times, edge * radius, markerfacecolor="none", label=named, **look)
    where.set(
        ylim=(0, 1.04 * radius), ylabel=scale.radius.label("contact (shaded), its edges", "r")
    )
    rings = np.unique(
        np.linspace(0, len(problem.wear_coefficients) - 1, MOST_RINGS).round().astype(int)
    )
    forces, volumes = array(first, "ring_force"), array(first, "ring_worn_volume")
    unit, factor = _volume(scene, scale, float(volumes.max()))
    for number, ring in enumerate(rings):
        look = curve(number) | {"markersize": 2.5}
        force.plot(times, forces[:, ring], **look, label=f"ring {ring + 1}")
        volume.plot(times, volumes[:, ring] * factor, **look)
    force.plot(times, array(first, "normal_force"), color="black", linewidth=0.8, label="all rings")
    force.set_ylim(0, 1.1 * float(array(first, "normal_force").max()))
    force.set_ylabel("force over $F$" if problem.indentation is None else r"force over $2 a E^* d$")
    volume.set_ylabel(f"worn volume {unit}")
    volume.set_ylim(bottom=0)
    for axes in (where, force, volume):
        time_axis(axes, times)
        axes.set_xlabel(scale.time.label("time", "t"))
    footing(figure, (where, force), "" if scale.names.si else scale.note)
    heading(figure, titled(scene.title, "contact over time"))
    save(figure, path)


def _volume(scene: Scene, scale: Scale, greatest: float) -> tuple[str, float]:
    """The unit of worn volumes up to so much, and by what non-dimensional ones are to be
    multiplied.
    """
    if not scale.names.si:
        return "$V E^* / (F a)$" if scene.problem.indentation is None else "over $2 a^2 d$", 1.0
    unit, name = scale.names.readable(greatest * scale.units.volume, "volume")
    return f"$V$ ({name})", scale.units.volume / unit
