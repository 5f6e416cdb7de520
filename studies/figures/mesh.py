"""Figures of the half-space: its mesh, and the stresses in it."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.ticker import MaxNLocator

from ...meshes.radial import Array
from ..crosscheck.interior import NEAR, Interior
from ..problem.scene import Scene
from .scale import Scale
from .style import PAGE, RED, Margins, footing, heading, page, save, styled, titled


@styled
def draw_stress(scene: Scene, fields: Interior, path: Path) -> None:
    """Von Mises stress under the rings, at every state whose inside was recovered."""
    ring_edges, count, scale = scene.problem.ring_edges, len(fields.labels), Scale(scene)
    width = min(PAGE, 0.5 + 2.7 * count + 0.9)
    margins = Margins(top=0.5, bottom=0.55, right=0.75, across=0.1)
    side = (width - margins.left - margins.right - (count - 1) * margins.across) / count
    figure, panels = page(1, count, side * 1.08 / 1.3, margins, width, sharey=True)
    r, z = fields.points
    beneath = (r < 1.3) & (z > 0.04) & (z < 1.0)
    shown = fields.von_mises * scale.pressure.factor
    levels = MaxNLocator(12).tick_values(0, 1.2 * float(shown[:, beneath].max()))
    near = fields.triangles[
        :, (r[fields.triangles].min(axis=0) < 1.3) & (z[fields.triangles].min(axis=0) < 1.0)
    ]
    for values, label, error, axes in zip(
        shown, fields.labels, fields.errors["von_mises"], panels[0], strict=True
    ):
        filled = axes.tricontourf(r, z, near.T, values, levels, cmap="viridis", extend="max")
        axes.plot([0, 1], [-0.02, -0.02], color=RED, linewidth=2)
        axes.plot(
            ring_edges[1:-1], np.full(len(ring_edges) - 2, -0.05), "|", color=RED, markersize=3
        )
        axes.set(xlim=(0, 1.3), ylim=(1.0, -0.08), aspect="equal", xlabel="$r/a$", anchor="W")
        state = "steady state" if label == "steady" else scale.when(float(label.removeprefix("t=")))
        axes.set_title(f"{state}; errors up to {error:.0e} F/(πa²)")
    panels[0, 0].set_ylabel("depth $z/a$")
    low, high = margins.bottom / figure.get_figheight(), 1 - margins.top / figure.get_figheight()
    bar = figure.add_axes((1 - 0.62 / width, low, 0.12 / width, high - low))
    figure.colorbar(filled, cax=bar, label=scale.pressure.label("von Mises stress", "\\sigma"))
    note = (
        f"errors: by their own estimate, further than {NEAR:g} a from the rim and from ring edges, "
        "which are marked"
    )
    footing(figure, (), "; ".join(part for part in (note, scale.note.rpartition(", ")[2]) if part))
    heading(figure, titled(scene.title, "von Mises stress under the rings"))
    save(figure, path)


@styled
def draw_mesh(mesh: Any, mesher: str, ring_edges: Array, path: Path) -> None:
    """The whole mesh, the mesh under the punch, and the mesh at the rim."""
    from ...meshes.half_space import contact_radii, truncation

    figure, (panels,) = page(1, 3, 2.05, Margins(top=0.45, bottom=0.35, across=0.4))
    rim = max(30 * float(np.diff(contact_radii(mesh)).min()), 1e-6)
    mesh_panel(panels[0], mesh, (0, truncation(mesh)), "whole", "$r/a$")
    mesh_panel(panels[1], mesh, (0, 1.15), "under the punch", "$r/a$")
    panels[1].plot(
        ring_edges[1:-1], np.full(len(ring_edges) - 2, -0.035), "|", color=RED, markersize=3
    )
    mesh_panel(panels[2], mesh, (-rim, rim), "at the rim", "$(r-a)/a$", centre=1.0)
    panels[0].set_ylabel("depth $z/a$")
    heading(figure, f"half-space mesh by {mesher}; the punch is red, ring edges are marked")
    save(figure, path)


def mesh_panel(
    axes: Any, mesh: Any, view: tuple[float, float], name: str, label: str, centre: float = 0.0
) -> None:
    """The elements in a square view of the surface from `view[0]` to `view[1]`, radii counted from
    `centre`.
    """
    low, high = view
    depth = high - low
    corners = mesh.p[:, mesh.t].transpose(2, 1, 0) - [centre, 0.0]
    inside = (corners[:, :, 0].max(axis=1) >= low) & (corners[:, :, 0].min(axis=1) <= high)
    shown = corners[inside & (corners[:, :, 1].min(axis=1) <= depth)]
    width = 0.35 if len(shown) < 3000 else 0.15
    axes.add_collection(
        PolyCollection(shown, facecolors="none", edgecolors="black", linewidths=width)
    )
    axes.plot([low, min(high, 1 - centre)], [-0.015 * depth] * 2, color=RED, linewidth=2)
    axes.set(xlim=(low, high), ylim=(depth, -0.06 * depth), aspect="equal")
    axes.set_title(f"{name}: {len(shown)} elements")
    power = int(np.floor(np.log10(depth))) if depth < 0.1 else 0
    axes.set_xlabel(label + (rf" in $10^{{{power}}}$" if power else ""))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
