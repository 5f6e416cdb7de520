"""The half-space: its mesh, and the stresses in it."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from ...meshes.radial import Array
from ..crosscheck.dataset import Result
from ..inside.interior import NEAR
from ..problem.scene import Scene
from .scale import Scale
from .style import PAGE, RED, complete, new_panels, save, set_linear
from .ticks import short_number


def draw_stress(result: Result) -> Figure:
    """Draw the von Mises stress under the rings in up to four states in which the punch presses.

    States have one scale, unless their stresses differ by orders of magnitude.
    """
    fields, scale, problem = result.inside, Scale.of(result), result.scene.problem
    pressing = [number for number, parts in enumerate(fields.parts) if len(parts)]
    states = [pressing[at] for at in np.unique(np.linspace(0, len(pressing) - 1, 4).astype(int))]
    radius = scale.shown("radius", problem.units.length)
    r, z = fields.points * radius
    depth = float(fields.reach[states].max()) * radius
    beneath = (r < 1.3 * depth) & (z > 0.04 * depth) & (z < depth)
    stress = fields.von_mises[states] * problem.units.pressure
    highest = stress[:, beneath].max(axis=1)
    own_scales = highest.max() > 10 * highest.min()
    scale.suit("von_mises", highest)
    stress, highest = scale.shown("von_mises", stress), scale.shown("von_mises", highest)
    shared = _levels(highest.min(), highest.max())
    count = len(states)
    # a scale beside each panel takes as much as its labels
    width, beside = min(PAGE, 1.4 + 2.7 * count), 0.55 if own_scales else 0.0
    height = 0.78 * (width - 1.6 - beside * (count - 1)) / count + 1.4
    figure, panels = new_panels(width, height, columns=count)
    filled = []
    for axes, state, values, top in zip(panels[0], states, stress, highest, strict=True):
        levels = _levels(top, top) if own_scales else shared
        filled.append(
            axes.tricontourf(
                *(r, z, fields.triangles.T, np.maximum(values, 0.1 * levels[0]), levels),
                norm=LogNorm(),
                extend="both",
            )
        )
        _draw_punch(axes, depth, fields.parts[state] * radius, problem.ring_edges * radius)
        axes.set(xlim=(0, 1.3 * depth), ylim=(depth, -0.08 * depth), aspect="equal")
        axes.set(xlabel=scale.label("radius"), ylabel=scale.label("depth"))
        set_linear(axes, "x", most=4)
        set_linear(axes, "y")
        label = fields.labels[state]
        when = scale.steady_state
        if label != "steady":
            when = scale.when(float(label.removeprefix("t=")))
        error = short_number(float(f"{100 * fields.errors['von_mises'][state]:.1g}"))
        axes.set_title(f"{when}\nerrors up to {error} % of pₘ")
        axes.label_outer()
    note = (
        f"errors: estimates, over pₘ = F/(πc²), c the radius of the contact, beyond {NEAR:g} c "
        "of its edges and of ring edges\nred: parts of the punch that touch, and ring edges"
    )
    if left := len(fields.labels) - len(pressing):
        note += f"; nothing presses in {left} more of the states asked for"
    if len(pressing) > count:
        note += f"; {len(pressing) - count} more states are in half_space.vtu"
    titles = result.scene.title, "von Mises stress under the rings"
    complete(figure, titles, note=note, across=0.25)
    groups = [[axes] for axes in panels[0]] if own_scales else [list(panels[0])]
    for image, group in zip(filled, groups, strict=False):
        # levels are ten to a decade: these are 1, 2 and 5 times a power of ten
        ticks = [level for level in image.levels if round(10 * np.log10(level)) % 10 in (0, 3, 7)]
        bar = figure.colorbar(image, ax=group, ticks=ticks, fraction=0.1, pad=0.02)
        bar.ax.set_yticks(ticks, [short_number(float(f"{tick:.1g}")) for tick in ticks])
        bar.minorticks_off()
    bar.set_label(scale.label("von_mises"))
    return figure


def _levels(least: float, greatest: float) -> Array:
    """Return levels of colour, ten to a decade, from a fifth of the least of some highest values.

    Ten steps to a decade are close to 1, 1.25, 1.6, 2, 2.5, 3.15, 4, 5, 6.3 and 8.
    """
    first, last = np.floor(10 * np.log10(0.2 * least)), np.ceil(10 * np.log10(greatest))
    return np.asarray(10.0 ** (np.arange(first, last + 1) / 10))


def draw_result_mesh(result: Result) -> Figure:
    """Draw the mesh of the finite elements."""
    fem = result.solutions["fem"]
    assert fem.half_space is not None
    mesh = fem.half_space.solid.mesh
    return draw_mesh(result.scene, mesh, fem.settings.get("mesher", "bisection"))


def draw_mesh(scene: Scene, mesh: Any, mesher: str) -> Figure:
    """Draw the whole mesh, the mesh under the punch, and the mesh at the rim.

    Parameters
    ----------
    mesh : of the half-space, in punch radii; it is drawn in the lengths of the scene
    """
    from ...meshes.half_space import contact_radii, truncation  # a run without fem needs no skfem

    scale, ring_edges = Scale(scene), scene.problem.ring_edges
    radius = scale.shown("radius", scene.problem.units.length)
    rim = max(30 * float(np.diff(contact_radii(mesh)).min()), 1e-6)
    # a radius of the view of the rim in a unit of its own
    unit, name = scale.unit(rim * scene.problem.units.length, "length")
    enlarged = scene.problem.units.length / unit
    of_rim = f"radius r − a{f' ({name})' if name else ''}"
    views = (
        ("the whole", 0.0, radius, 0.0, truncation(mesh), scale.label("radius")),
        ("under the punch", 0.0, radius, 0.0, 1.15, scale.label("radius")),
        ("at the rim", 1.0, enlarged, -rim, rim, of_rim),
    )
    figure, panels = new_panels(PAGE, 2.75, columns=len(views))
    for axes, (name, centre, length, low, high, label) in zip(panels[0], views, strict=True):
        elements = (mesh.p[:, mesh.t].transpose(2, 1, 0) - [centre, 0.0]) * length
        axes.add_collection(
            PolyCollection(elements, facecolors="none", edgecolors="black", linewidths=0.3)
        )
        depth, edges = (high - low) * length, (ring_edges - centre) * length
        _draw_punch(axes, depth, edges[None, [0, -1]], edges)
        axes.set(xlim=(low * length, high * length), ylim=(depth, -0.06 * depth))
        axes.set(aspect="equal", xlabel=label, title=name)
        set_linear(axes, "x", most=4)
        set_linear(axes, "y")
    panels[0, 0].set_ylabel(scale.label("depth"))
    title = (
        f"half-space mesh by {mesher}, {mesh.nelements} elements; the punch is red, ring edges are "
        "marked"
    )
    return complete(figure, [title])


def _draw_punch(axes: Axes, depth: float, parts: Array, ring_edges: Array) -> None:
    """Draw (n, 2) parts of the punch as bars above a view of that depth, and mark ring edges."""
    for ends in parts:
        axes.plot(ends, [-0.015 * depth] * 2, color=RED, linewidth=2, solid_capstyle="butt")
    edges = ring_edges[1:-1]
    axes.plot(edges, np.full(len(edges), -0.03 * depth), "|", color=RED, markersize=3)


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
    save(directory / "mesh.png", draw_mesh, scene, mesh, mesher)
