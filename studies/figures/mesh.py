"""Figures of the half-space: its mesh, and the stresses in it."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.ticker import MaxNLocator

from ringwear.meshes.radial import Array
from ringwear.studies.crosscheck.interior import MEAN_PRESSURE, NEAR, Interior
from ringwear.studies.figures.style import RED, new_figure, titled
from ringwear.studies.problem.problem import P0
from ringwear.studies.problem.scene import Scene


def draw_stress(scene: Scene, fields: Interior, path: Path) -> None:
    """Von Mises stress under the rings, at every state whose inside was recovered."""
    ring_edges, count = scene.problem.ring_edges, len(fields.labels)
    figure = new_figure(4.4 * count + 0.8, 4.6)
    panels = figure.subplots(1, count, sharey=True, squeeze=False)[0]
    r, z = fields.points
    beneath = (r < 1.3) & (z > 0.04) & (z < 1.0)
    levels = MaxNLocator(18).tick_values(0, 1.2 * float(fields.von_mises[:, beneath].max() / P0))
    # over p0, as the colours are: the mean pressure is twice that
    errors = fields.errors["von_mises"] * MEAN_PRESSURE / P0
    for values, label, error, axes in zip(fields.von_mises / P0, fields.labels, errors, panels, strict=True):
        filled = axes.tricontourf(r, z, fields.triangles.T, values, levels, cmap="viridis", extend="max")
        axes.plot([0, 1], [-0.02, -0.02], color=RED, linewidth=2.5)
        axes.plot(ring_edges[1:-1], np.full(len(ring_edges) - 2, -0.045), "v", color=RED, markersize=3)
        axes.set(xlim=(0, 1.3), ylim=(1.0, -0.08), aspect="equal", xlabel="$r/a$")
        state = "steady state" if label == "steady" else f"${label}$"
        axes.set_title(f"{state}: error {error:.1e}", fontsize=9)
    panels[0].set_ylabel("depth $z/a$")
    figure.colorbar(filled, ax=panels, label="von Mises stress over $p_0$", shrink=0.9)
    figure.suptitle(titled(scene.title, "von Mises stress under the rings"), fontsize=10)
    note = f"error: its own estimate, over $p_0$, further than {NEAR:g} a from the rim and from ring edges"
    figure.supxlabel(note, fontsize=8)
    figure.savefig(path)


def draw_mesh(mesh: Any, mesher: str, ring_edges: Array, path: Path) -> None:
    """The whole mesh, the mesh under the punch, and the mesh at the rim."""
    from ringwear.meshes.half_space import contact_radii, truncation

    figure = new_figure(11, 3.9)
    panels = figure.subplots(1, 3)
    rim = max(30 * float(np.diff(contact_radii(mesh)).min()), 1e-6)
    mesh_panel(panels[0], mesh, (0, truncation(mesh)), "whole", "$r/a$")
    mesh_panel(panels[1], mesh, (0, 1.15), "under the punch", "$r/a$")
    panels[1].plot(ring_edges[1:-1], np.full(len(ring_edges) - 2, -0.035), "v", color=RED, markersize=3)
    mesh_panel(panels[2], mesh, (-rim, rim), "at the rim", "$(r-a)/a$", centre=1.0)
    panels[0].set_ylabel("depth $z/a$")
    figure.suptitle(f"half-space mesh by {mesher}; the punch is red, ring edges are marked", fontsize=10)
    figure.savefig(path)


def mesh_panel(axes: Any, mesh: Any, view: tuple[float, float], name: str, label: str, centre: float = 0.0) -> None:
    """The elements in a square view of the surface from `view[0]` to `view[1]`, radii counted from `centre`."""
    low, high = view
    depth = high - low
    corners = mesh.p[:, mesh.t].transpose(2, 1, 0) - [centre, 0.0]
    inside = (corners[:, :, 0].max(axis=1) >= low) & (corners[:, :, 0].min(axis=1) <= high)
    shown = corners[inside & (corners[:, :, 1].min(axis=1) <= depth)]
    width = 0.35 if len(shown) < 3000 else 0.15
    axes.add_collection(PolyCollection(shown, facecolors="none", edgecolors="black", linewidths=width))
    axes.plot([low, min(high, 1 - centre)], [-0.015 * depth] * 2, color=RED, linewidth=2.5)
    axes.set(xlim=(low, high), ylim=(depth, -0.06 * depth), aspect="equal")
    axes.set_title(f"{name}: {len(shown)} elements", fontsize=9)
    power = int(np.floor(np.log10(depth))) if depth < 0.1 else 0
    axes.set_xlabel(label + (rf" in $10^{{{power}}}$" if power else ""))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
