"""Figures of contact that opens, closes and spreads: where it is, and what it does to each ring, over time."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ringwear.meshes.radial import Array
from ringwear.studies.figures.style import curve, legend_of, method_curve, new_figure, save, styled, time_axis, titled
from ringwear.studies.methods.base import Solution
from ringwear.studies.methods.quantities import array
from ringwear.studies.problem.scene import Scene

MOST_RINGS = 6


@styled
def draw_contact(scene: Scene, solutions: Mapping[str, Solution], path: Path) -> None:
    """Edges of the contact by every method, its inside shaded; and forces and worn volumes of rings by the first."""
    every = {name: one.results for name, one in solutions.items() if "contact_edge" in one.results}
    if not every:
        return
    problem, times = scene.problem, np.array(scene.wear.times)
    figure = new_figure(12, 3.8)
    where, force, volume = figure.subplots(1, 3)
    first = next(iter(every.values()))
    carries = array(first, "contact") > 0
    for number, radius in enumerate(problem.ring_edges[1:-1]):
        where.axhline(radius, color="0.75", linewidth=0.6, zorder=0, label="ring edges" if number == 0 else None)
    where.pcolormesh(times, problem.radii, carries.T, cmap="Greys", vmin=0, vmax=5, shading="nearest", zorder=-1)
    for name, results in every.items():
        look = method_curve(name) | {
            "linestyle": "none",
            "marker": "o_x+"[len(where.lines) % 4],
            "markersize": 5,
            "alpha": 1,
        }
        where.plot(times, array(results, "contact_edge"), **look)
    where.set(ylim=(0, 1.02), ylabel="edges of the contact $r/a$ (inside shaded)")
    _once(where)
    rings = np.unique(np.linspace(0, len(problem.wear_coefficients) - 1, MOST_RINGS).round().astype(int))
    for number, ring in enumerate(rings):
        force.plot(times, array(first, "ring_force")[:, ring], **curve(number), label=f"ring {ring + 1}")
        volume.plot(times, array(first, "ring_worn_volume")[:, ring], **curve(number))
    force.plot(times, array(first, "normal_force"), color="black", linewidth=0.8, label="all")
    force.set_ylim(0, 1.1 * float(array(first, "normal_force").max()))
    force.set_ylabel("force on a ring over $F$" if problem.indentation is None else r"force over $2 a E^* d$")
    volume.set_ylabel("worn volume $V E^* / (F a)$" if problem.indentation is None else r"worn volume over $2 a^2 d$")
    for axes in (where, force, volume):
        time_axis(axes, times)
        axes.set_xlabel("time $t$" + (f" ({scene.units})" if scene.units else ""))
    legend_of(figure, [force])
    figure.suptitle(titled(scene.title, "contact over time"), fontsize=10)
    save(figure, path)


def _once(axes: Any) -> None:
    """A legend in which each label stands once."""
    handles, labels = axes.get_legend_handles_labels()
    kept: dict[str, Array] = dict(zip(labels, handles, strict=True))
    axes.legend(kept.values(), kept.keys(), fontsize=8)
