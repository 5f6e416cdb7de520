"""The half-space: its mesh, and the stresses in it."""

from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ...meshes.half_space import contact_radii, truncation
from ...meshes.radial import Array
from ..crosscheck.dataset import Result
from ..crosscheck.interior import NEAR
from .scale import Scale
from .style import PAGE, RED, complete, new_figure


def draw_stress(result: Result) -> Figure:
    """Draw the von Mises stress under the rings, at every state whose inside was recovered."""
    fields, scale, count = result.inside, Scale(result.scene), len(result.inside.labels)
    width = min(PAGE, 1.4 + 2.7 * count)
    figure = new_figure(width, 0.75 * (width - 1.25) / count + 1.1)
    panels = figure.subplots(1, count, sharey=True, squeeze=False)[0]
    r, z = fields.points
    beneath = (r < 1.3) & (z > 0.04) & (z < 1.0)
    stress = scale.shown("von_mises", fields.von_mises * result.scene.problem.units.pressure)
    levels = MaxNLocator(12).tick_values(0, 1.2 * float(stress[:, beneath].max()))
    near = (r[fields.triangles].min(axis=0) < 1.3) & (z[fields.triangles].min(axis=0) < 1.0)
    for axes, values, label, error in zip(
        panels, stress, fields.labels, fields.errors["von_mises"], strict=True
    ):
        filled = axes.tricontourf(
            r, z, fields.triangles[:, near].T, values, levels, cmap="viridis", extend="max"
        )
        _draw_punch(axes, 1.0, result.scene.problem.ring_edges)
        axes.set(xlim=(0, 1.3), ylim=(1.0, -0.08), aspect="equal", xlabel="$r/a$")
        state = "steady state" if label == "steady" else scale.when(float(label.removeprefix("t=")))
        axes.set_title(f"{state}; errors up to {error:.0e} F/(πa²)")
    panels[0].set_ylabel("depth $z/a$")
    figure.colorbar(filled, ax=panels, label=scale.label("von_mises"))
    note = (
        f"errors: by their own estimate, further than {NEAR:g} a from the rim and from ring edges, "
        "which are marked"
    )
    titles = result.scene.title, "von Mises stress under the rings"
    return complete(figure, titles, note="\n".join(filter(None, (note, scale.note))))


def draw_result_mesh(result: Result) -> Figure:
    """Draw the mesh of the finite elements."""
    fem = result.solutions["fem"]
    assert fem.half_space is not None
    return draw_mesh(
        fem.half_space.solid.mesh, fem.settings["mesher"], result.scene.problem.ring_edges
    )


def draw_mesh(mesh: Any, mesher: str, ring_edges: Array) -> Figure:
    """Draw the whole mesh, the mesh under the punch, and the mesh at the rim."""
    figure = new_figure(PAGE, 2.75)
    whole, under, at_rim = figure.subplots(1, 3)
    rim = max(30 * float(np.diff(contact_radii(mesh)).min()), 1e-6)
    mesh_panel(whole, mesh, (0, truncation(mesh)), "whole", "$r/a$")
    mesh_panel(under, mesh, (0, 1.15), "under the punch", "$r/a$")
    _draw_punch(under, 1.15, ring_edges)
    mesh_panel(at_rim, mesh, (-rim, rim), "at the rim", "$(r-a)/a$", centre=1.0)
    whole.set_ylabel("depth $z/a$")
    title = f"half-space mesh by {mesher}; the punch is red, ring edges are marked"
    return complete(figure, [title])


def _draw_punch(axes: Any, depth: float, ring_edges: Array) -> None:
    """Draw the punch as a bar above a view of that depth, and mark its ring edges."""
    axes.plot([0, 1], [-0.015 * depth] * 2, color=RED, linewidth=2)
    edges = ring_edges[1:-1]
    axes.plot(edges, np.full(len(edges), -0.03 * depth), "|", color=RED, markersize=3)


def mesh_panel(
    axes: Any, mesh: Any, view: tuple[float, float], name: str, label: str, centre: float = 0.0
) -> None:
    """Draw the elements in a square view of the surface from `view[0]` to `view[1]`, radii counted
    from `centre`.
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
    axes.set(xlim=view, ylim=(depth, -0.06 * depth), aspect="equal")
    axes.set_title(f"{name}: {len(shown)} elements")
    power = int(np.floor(np.log10(depth))) if depth < 0.1 else 0
    axes.set_xlabel(label + (rf" in $10^{{{power}}}$" if power else ""))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(lambda value, _: f"{value / 10.0**power:g}")
