"""Draw the mesh of the half-space and the stresses in it, and write the mesh."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ...meshes import Array, Ground
from ..crosscheck import NEAR, Interior, Result, Scene
from .scale import FAR_APART, Scale, panel_tops
from .style import BLUE, PAGE, RED, complete, new_panels, save, set_linear
from .ticks import one_digit

# Least depth of a rigid base over the depth of a view. A view of thinner layers ends a little below
# their base, and its depths are stretched.
LEAST_DEPTH_OF_BASE = 0.1
# Depth of the bottom of such a view over the depth of the base.
SHOWN_BELOW_BASE = 1.15


def draw_stress(result: Result) -> Figure:
    """Draw the von Mises stress under the rings in up to four states with contact.

    All states have the same scales of colour and length, unless they differ by orders of magnitude;
    then up to three states are drawn.
    """
    fields, scale, problem = result.inside(), Scale.of(result), result.scene.problem
    states_in_contact = [number for number, parts in enumerate(fields.parts) if len(parts)]
    radius = scale.shown("radius", problem.units.length)
    r, z = fields.points * radius
    for most in (4, 3):
        states = [
            states_in_contact[at]
            for at in np.linspace(
                0, len(states_in_contact) - 1, min(most, len(states_in_contact))
            ).astype(int)
        ]
        depths = panel_tops(fields.reach[states] * radius)
        bottoms = _bottoms_of_views(problem.ground, radius, depths)
        stress = fields.von_mises[states] * problem.units.pressure
        highest = np.array(
            [
                values[(r < 1.3 * depth) & (z > 0.04 * bottom) & (z < bottom)].max()
                for values, depth, bottom in zip(stress, depths, bottoms, strict=True)
            ]
        )
        own_colours = highest.max() > FAR_APART * highest.min()
        if not own_colours:
            break
    own_lengths = bool(np.ptp(depths))
    count = len(states)
    # widths in inches of a colour bar with its labels, and of the labels of an axis
    distance_of_panels = 0.25 + 0.62 * own_colours + 0.2 * own_lengths
    bars = 0.62 * (count if own_colours else 1)
    # the note below needs 5.7 inches
    width = min(PAGE, max(5.7, 1.4 + 2.7 * count))
    panel = (
        width - 0.7 - bars - distance_of_panels * (count - 1) + 0.62 * own_colours * (count - 1)
    ) / count
    figure, panels = new_panels(width, 0.83 * panel + 1.45, columns=count)
    images = []
    for axes, state, values, top, depth, bottom in zip(
        panels[0], states, stress, highest, depths, bottoms, strict=True
    ):
        tops = top if own_colours else highest
        unit, name = scale.unit(float(tops.max()), "pressure")
        levels = _levels(tops.min() / unit, tops.max() / unit)
        shown = np.maximum(values / unit, 0.1 * levels[0])
        image = axes.tricontourf(
            *(r, z, fields.triangles.T, shown, levels), norm=LogNorm(), extend="both"
        )
        symbol = "σ" if own_colours else "von Mises stress σ"
        images.append((image, f"{symbol} ({name})" if name else symbol))
        _draw_punch(axes, bottom, fields.parts[state] * radius, problem.ring_edges * radius)
        _draw_layers(axes, problem.ground, radius, 1.3 * depth)
        axes.set(xlim=(0, 1.3 * depth), ylim=(bottom, -0.08 * bottom))
        axes.set(aspect="equal" if bottom == depth else "auto")
        axes.set(xlabel=scale.label("radius"), ylabel=scale.label("depth"))
        set_linear(axes, "x", most=4)
        set_linear(axes, "y")
        label = fields.labels[state]
        state_in_words = scale.steady_state
        if label != "steady":
            state_in_words = scale.when(float(label.removeprefix("t=")))
        error = one_digit(100 * fields.errors["von_mises"][state])
        axes.set_title(f"{state_in_words}\nerrors up to {error} % of pₘ")
        if axes is not panels[0, 0]:
            axes.set_ylabel("")
            axes.yaxis.set_visible(own_lengths)
    titles = result.scene.title, "von Mises stress under the rings"
    note = _note(fields, count, stretched=bool((bottoms != depths).any()))
    complete(figure, titles, note=note, across=distance_of_panels, right=0.7)
    # one colour bar for each panel, or a single one next to the last panel
    for axes, (image, label) in zip(panels[0], images, strict=True):
        if own_colours or axes is panels[0, -1]:
            _draw_bar(axes, image, label)
    return figure


def _bottoms_of_views(ground: Ground, unit: float, depths: Array) -> Array:
    """Return the depths (n,) at which views end that are otherwise as deep as `depths` (n,).

    They end below a rigid base, so that thin layers fill them; `unit` scales depths of the ground.
    """
    if not ground.rigid:
        return depths
    base = float(ground.depths[-1]) * unit
    return np.where(base < LEAST_DEPTH_OF_BASE * depths, SHOWN_BELOW_BASE * base, depths)


def _note(fields: Interior, count: int, stretched: bool) -> str:
    """Return the note below the figure: errors, colours, and states that are not drawn.

    Parameters
    ----------
    fields : fields inside
    count : number of states that are drawn
    stretched : whether depths have another scale than radii
    """
    in_contact = sum(len(parts) > 0 for parts in fields.parts)
    note = (
        f"errors: estimates, over the mean pressure pₘ, beyond {NEAR:g} of the contact radius "
        "from its edges and from ring edges\nred: parts of the punch in contact, and ring edges"
    )
    if without_contact := len(fields.labels) - in_contact:
        note += f"; states without contact, not drawn: {without_contact}"
    if in_contact > count:
        note += f"; more states in half_space.vtu: {in_contact - count}"
    if stretched:
        note += "; depths are stretched, to show thin layers"
    if len(fields.creases):
        place = "the tip of the unworn face"
        if fields.creases.any():
            place = "radii at which the slope of the unworn face jumps"
        note += f"\nerrors also leave out {place}, where stresses are singular"
    return note


def _draw_bar(axes: Axes, image: Any, label: str) -> None:
    """Draw the colour bar of a panel, with ticks at 1, 2 and 5 times powers of ten."""
    # there are ten levels in a decade, of which numbers 0, 3 and 7 are 1, 2 and 5
    ticks = [level for level in image.levels if round(10 * np.log10(level)) % 10 in (0, 3, 7)]
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    axes.apply_aspect()
    place = axes.get_position()
    inch = 1 / figure.get_figwidth()
    bar_axes = figure.add_axes((place.x1 + 0.07 * inch, place.y0, 0.09 * inch, place.height))
    bar = figure.colorbar(image, cax=bar_axes, ticks=ticks)
    bar.ax.set_yticks(ticks, [one_digit(tick) for tick in ticks])
    bar.minorticks_off()
    bar.set_label(label)


def _levels(least: float, greatest: float) -> Array:
    """Return levels of colour, ten in a decade, from a fifth of `least` to `greatest`.

    The arguments are the least and the greatest of the highest stresses of the panels. Ten levels
    in a decade are close to 1, 1.25, 1.6, 2, 2.5, 3.15, 4, 5, 6.3 and 8.
    """
    first, last = np.floor(10 * np.log10(0.2 * least)), np.ceil(10 * np.log10(greatest))
    return 10.0 ** (np.arange(first, last + 1) / 10)


def draw_result_mesh(result: Result) -> Figure:
    """Draw the mesh of the finite elements."""
    fem = result.solutions["fem"]
    assert fem.half_space is not None
    mesh = fem.half_space.solid.mesh
    # triangles on cells of the contact
    mesher_on_cells = "gmsh" if result.scene.half_space.layers else "bisection"
    return draw_mesh(result.scene, mesh, fem.settings.get("mesher", mesher_on_cells))


def draw_mesh(scene: Scene, mesh: Any, mesher: str) -> Figure:
    """Draw the whole mesh, the mesh under the punch, and the mesh at the rim.

    Parameters
    ----------
    mesh : mesh of the half-space, in punch radii; it is drawn in the scene's unit of length
    mesher : name of the program or algorithm that generated it, for the title
    """
    from ...meshes import contact_radii, truncation

    scale, ring_edges = Scale(scene), scene.problem.ring_edges
    radius = scale.shown("radius", scene.problem.units.length)
    rim = max(30 * float(np.diff(contact_radii(mesh)).min()), 1e-6)
    # the view of the rim has another unit of length
    unit, name = scale.unit(rim * scene.problem.units.length, "length")
    enlarged = scene.problem.units.length / unit
    unit_at_rim = f" ({name})" if name else ""
    labels, rim_labels = (
        (scale.label("radius"), scale.label("depth")),
        (f"radius r − a{unit_at_rim}", f"depth z{unit_at_rim}"),
    )
    views = (
        ("whole mesh", 0.0, radius, 0.0, truncation(mesh), labels),
        ("under the punch", 0.0, radius, 0.0, 1.15, labels),
        ("at the rim", 1.0, enlarged, -rim, rim, rim_labels),
    )
    figure, panels = new_panels(PAGE, 2.75, columns=len(views))
    for axes, (name, centre, length, low, high, (across, down)) in zip(
        panels[0], views, strict=True
    ):
        elements = (mesh.p[:, mesh.t].transpose(2, 1, 0) - [centre, 0.0]) * length
        axes.add_collection(
            PolyCollection(elements, facecolors="none", edgecolors="black", linewidths=0.3)
        )
        depth, edges = (high - low) * length, (ring_edges - centre) * length
        bottom = float(_bottoms_of_views(scene.problem.ground, length, np.array([depth]))[0])
        _draw_punch(axes, bottom, edges[None, [0, -1]], edges)
        _draw_layers(axes, scene.problem.ground, length, high * length)
        axes.set(xlim=(low * length, high * length), ylim=(bottom, -0.06 * bottom))
        axes.set(aspect="equal" if bottom == depth else "auto")
        axes.set(xlabel=across, ylabel=down, title=name)
        set_linear(axes, "x", most=4)
        set_linear(axes, "y")
    title = (
        f"half-space mesh by {mesher}, {mesh.nelements} elements; the punch is red, ring edges are "
        "marked"
    )
    if scene.problem.ground.layered:
        title += ", interfaces of layers are blue"
    return complete(figure, [title])


def _draw_punch(axes: Axes, depth: float, parts: Array, ring_edges: Array) -> None:
    """Draw parts (n, 2) of the punch as bars above a view of some depth, and mark ring edges."""
    for ends in parts:
        axes.plot(ends, [-0.015 * depth] * 2, color=RED, linewidth=2, solid_capstyle="butt")
    edges = ring_edges[1:-1]
    axes.plot(edges, np.full(len(edges), -0.03 * depth), "|", color=RED, markersize=3)


def _draw_layers(axes: Axes, ground: Ground, unit: float, width: float) -> None:
    """Mark the interfaces of layers, and hatch a rigid base; `unit` scales the depths."""
    depths = ground.depths * unit
    for depth in depths:
        axes.axhline(depth, color=BLUE, linewidth=1)
    if ground.rigid:
        base = Rectangle((0, depths[-1]), 10 * width, 10 * width, hatch="///", linewidth=0)
        base.set(facecolor="none", edgecolor=BLUE)
        axes.add_patch(base)


def write_mesh(scene: Scene, mesh: Any, mesher: str, directory: Path) -> None:
    """Write a mesh in the format of scikit-fem and in the scene's units, and its figure.

    The file contains the boundaries of the mesh. `skfem.Mesh.load` can read it, and `ringwear study
    refinement --mesh` accepts it as a user's mesh.
    """
    from skfem.io.meshio import to_meshio

    from ...meshes import quality, without_low_parts

    scaled = without_low_parts(mesh).scaled(scene.punch.radius)
    content = to_meshio(scaled, cell_data={"quality": [quality(mesh)]})
    content.points = np.column_stack([content.points, np.zeros(len(content.points))])
    content.write(directory / "mesh.vtu", file_format="vtu")
    save(directory / "mesh.png", draw_mesh, scene, mesh, mesher)
