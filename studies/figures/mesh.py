"""The half-space: its mesh, and the stresses in it."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ...ground.ground import Ground
from ...meshes.radial import Array
from ..crosscheck.dataset import Result
from ..inside.interior import NEAR
from ..problem.scene import Scene
from .scale import Scale
from .style import BLUE, PAGE, RED, complete, new_panels, power_of_ten, save


def draw_stress(result: Result) -> Figure:
    """Draw the von Mises stress under the rings, at every state whose inside was recovered."""
    fields, scale, problem = result.inside, Scale(result.scene), result.scene.problem
    count = len(fields.labels)
    width = min(PAGE, 1.4 + 2.7 * count)
    figure, panels = new_panels(width, 0.78 * (width - 1.6) / count + 1.25, columns=count)
    radius = scale.shown("radius", problem.units.length)
    r, z = fields.points * radius
    depth = float(fields.reach.max()) * radius
    stress = scale.shown("von_mises", fields.von_mises * problem.units.pressure)
    beneath = stress[:, (r < 1.3 * depth) & (z > 0.04 * depth) & (z < depth)]
    highest = beneath.max(axis=1)
    least = min(highest[highest > 0], default=1.0)
    levels = np.geomspace(0.2 * least, max(highest.max(), least), 16)
    # where nothing presses there is none
    stress = np.maximum(stress, 0.1 * levels[0])
    for axes, values, label, error in zip(
        panels[0], stress, fields.labels, fields.errors["von_mises"], strict=True
    ):
        filled = axes.tricontourf(
            r, z, fields.triangles.T, values, levels, norm=LogNorm(), extend="both"
        )
        _draw_punch(axes, depth, problem.ring_edges * radius)
        _draw_layers(axes, problem.ground, radius, 1.3 * depth)
        axes.set(xlim=(0, 1.3 * depth), ylim=(depth, -0.08 * depth), aspect="equal")
        axes.set(xlabel=scale.label("radius"), ylabel=scale.label("depth"))
        state = "steady state" if label == "steady" else scale.when(float(label.removeprefix("t=")))
        axes.set_title(f"{state}\nerrors up to {error:.0e} pₘ")
        axes.label_outer()
    note = (
        f"errors: estimates, over pₘ = F/(πc²), c the radius of the contact, beyond {NEAR:g} c "
        "of its edges and ring edges (marked)"
    )
    titles = result.scene.title, "von Mises stress under the rings"
    complete(figure, titles, note=note, across=0.25)
    bar = figure.colorbar(
        filled, ax=panels[0], ticks=levels[::3], format="%.2g", fraction=0.1, pad=0.02
    )
    bar.set_label(scale.label("von_mises"))
    return figure


def draw_result_mesh(result: Result) -> Figure:
    """Draw the mesh of the finite elements."""
    fem = result.solutions["fem"]
    assert fem.half_space is not None
    problem, mesh = result.scene.problem, fem.half_space.solid.mesh
    mesher = fem.settings.get("mesher", "bisection")
    return draw_mesh(mesh, mesher, problem.ring_edges, problem.ground)


def draw_mesh(mesh: Any, mesher: str, ring_edges: Array, ground: Ground | None = None) -> Figure:
    """Draw the whole mesh, the mesh under the punch, and the mesh at the rim."""
    from ...meshes.half_space import contact_radii, truncation  # a run without fem needs no skfem

    rim = max(30 * float(np.diff(contact_radii(mesh)).min()), 1e-6)
    power = 10 ** np.floor(np.log10(rim))
    views = (
        ("the whole", 0.0, 1.0, 0.0, truncation(mesh), "r/a"),
        ("under the punch", 0.0, 1.0, 0.0, 1.15, "r/a"),
        ("at the rim", 1.0, power, -rim, rim, f"(r − a)/a in {power_of_ten(power)}"),
    )
    figure, panels = new_panels(PAGE, 2.75, columns=len(views))
    for axes, (name, centre, unit, low, high, label) in zip(panels[0], views, strict=True):
        elements = (mesh.p[:, mesh.t].transpose(2, 1, 0) - [centre, 0.0]) / unit
        axes.add_collection(
            PolyCollection(elements, facecolors="none", edgecolors="black", linewidths=0.3)
        )
        depth = (high - low) / unit
        _draw_punch(axes, depth, (ring_edges - centre) / unit)
        _draw_layers(axes, ground, 1 / unit, high / unit)
        axes.set(xlim=(low / unit, high / unit), ylim=(depth, -0.06 * depth))
        axes.set(aspect="equal", xlabel=label, title=name)
    panels[0, 0].set_ylabel("depth z/a")
    title = (
        f"half-space mesh by {mesher}, {mesh.nelements} elements; the punch is red, ring edges are "
        "marked"
    )
    if ground is not None:
        title += ", interfaces of layers are blue"
    return complete(figure, [title])


def _draw_punch(axes: Axes, depth: float, ring_edges: Array) -> None:
    """Draw the punch as a bar above a view of that depth, and mark its ring edges."""
    axes.plot(ring_edges[[0, -1]], [-0.015 * depth] * 2, color=RED, linewidth=2)
    edges = ring_edges[1:-1]
    axes.plot(edges, np.full(len(edges), -0.03 * depth), "|", color=RED, markersize=3)


def _draw_layers(axes: Axes, ground: Ground | None, unit: float, width: float) -> None:
    """Mark the interfaces of layers, and hatch a rigid base; depths are in a unit."""
    if ground is None:
        return
    depths = ground.depths * unit
    for depth in depths:
        axes.axhline(depth, color=BLUE, linewidth=1)
    if ground.rigid:
        base = Rectangle((0, depths[-1]), 10 * width, 10 * width, hatch="///", linewidth=0)
        base.set(facecolor="none", edgecolor=BLUE)
        axes.add_patch(base)


def write_mesh(scene: Scene, mesh: Any, mesher: str, directory: Path) -> None:
    """Write a mesh and its figure, in the format of scikit-fem and in the scene's units.

    The file contains the boundaries of the mesh. It can be read back: by `skfem.Mesh.load`, and as
    a mesh of one's own by `ringwear study refinement --mesh`.
    """
    from skfem.io.meshio import to_meshio

    from ...meshes.half_space import quality, rounded

    scaled = rounded(mesh).scaled(scene.punch.radius)
    content = to_meshio(scaled, cell_data={"quality": [quality(mesh)]})
    content.points = np.column_stack([content.points, np.zeros(len(content.points))])
    content.write(directory / "mesh.vtu", file_format="vtu")
    problem = scene.problem
    save(directory / "mesh.png", draw_mesh, mesh, mesher, problem.ring_edges, problem.ground)
