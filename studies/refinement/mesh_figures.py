"""Draw meshes under the punch at three levels of each way, and pressure errors over the radius."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ..figures.style import PAGE, RED, complete, new_panels, set_logarithmic, shade_rings
from .case import TIMES, Case, Level
from .own_meshes import worst_place

WIDTH, DEPTH, PUNCH = 1.45, 0.6, 0.13
"""Width and depth of the drawn part of the half-space, and height of the punch, in punch radii."""
DECADES = 3
"""Decades of the squared error indicator that the colours cover."""
MOST_OWN_MESHES = 4
"""Greatest number of meshes of the user that are drawn: the first, the last, and some between."""


def draw_meshes(case: Case, levels: Sequence[Level]) -> Figure:
    """Draw the meshes of each way at three levels, with the punch, coloured by the indicator.

    The way that raises the degree is left out because its mesh does not change. The meshes of the
    user have their own figure.
    """
    ways = _three_of_each(levels, without=("degree", "file"))
    figure, panels = new_panels(PAGE, 0.75 + 1.35 * max(len(ways), 1), max(len(ways), 1), 3)
    for row, (way, way_levels) in zip(panels, ways.items(), strict=False):
        for axes, level in zip(row, way_levels, strict=False):
            _draw_mesh(axes, case, level)
            axes.set_title(f"{way}: {level.unknowns} unknowns")
        for axes in row[len(way_levels) :]:
            axes.set_axis_off()
        row[0].set_ylabel("depth z/a")
    for axes in panels[-1]:
        axes.set_xlabel("r/a")
    note = (
        "Above the surface: the punch; rings that wear faster are darker.\nColour: squared error "
        f"indicator of each triangle, from 1/{10**DECADES} of the greatest (white) to the greatest "
        "(red)."
    )
    title = f"{case.title}: meshes at three levels of each way"
    return complete(figure, [title], note=note, across=0.35, down=0.25)


def draw_pressure_errors(case: Case, levels: Sequence[Level]) -> Figure:
    """Draw pressure errors over the radius at the first time after the start, at three levels."""
    ways = _three_of_each(levels, without=())
    columns = min(3, len(ways))
    rows = -(-len(ways) // columns)
    figure, panels = new_panels(PAGE, 0.9 + 1.75 * rows, rows, columns, sharey=True)
    for axes, (way, way_levels) in zip(panels.ravel(), ways.items(), strict=False):
        _draw_pressure_errors(axes, case, way_levels)
        axes.set_title(f"{way}: {', '.join(str(level.unknowns) for level in way_levels)} unknowns")
    for axes in panels.ravel()[len(ways) :]:
        axes.set_axis_off()
    for row in panels:
        row[0].set_ylabel("|error of p| / norm of p")
    for axes in panels.ravel()[: len(ways)][-columns:]:
        axes.set_xlabel("r/a")
    title = f"{case.title}: error of the pressure over the radius, t = {TIMES[1]:g} a/(E* k v₀)"
    several_materials = np.ptp(case.problem.wear_coefficients) > 0
    note = "Grey bands: rings that wear faster." if several_materials else ""
    return complete(figure, [title], panels.ravel(), note, across=0.3, down=0.48)


def draw_own_meshes(case: Case, levels: Sequence[Level]) -> Figure:
    """Draw the user's meshes, the pressure error on each, and the place of the greatest error."""
    if len(levels) > MOST_OWN_MESHES:
        indices = np.linspace(0, len(levels) - 1, MOST_OWN_MESHES).round().astype(np.int64)
        levels = [levels[index] for index in indices]
    figure, panels = new_panels(PAGE, 3.7, 2, len(levels))
    for (mesh_axes, error_axes), level in zip(panels.T, levels, strict=True):
        worst = worst_place(case, level)
        _draw_mesh(mesh_axes, case, level)
        mesh_axes.plot(worst.facet, [0, 0], color=RED, linewidth=3, solid_capstyle="butt")
        mesh_axes.plot([np.mean(worst.facet)], [0.04], "^", color=RED, markersize=4)
        mesh_axes.set_title(f"{level.setting}\n{level.unknowns} unknowns, degree {level.degree}")
        _draw_pressure_errors(error_axes, case, [level])
        error_axes.axvspan(*worst.facet, color=RED, alpha=0.3, linewidth=0)
        error_axes.set_title(
            f"{worst.share:.0%} of the squared\nerror next to r = {worst.edge:.3g} a"
        )
        error_axes.set_xlabel("r/a")
    panels[0, 0].set_ylabel("depth z/a")
    panels[1, 0].set_ylabel("|error of p| / norm of p")
    title = f"{case.title}: your meshes, and their pressure errors, t = {TIMES[1]:g} a/(E* k v₀)"
    note = (
        "Red: the facet with the greatest part of the error.\nColour: squared error indicator of "
        f"each triangle, from 1/{10**DECADES} of the greatest (white) to the greatest (red)."
    )
    return complete(figure, [title], note=note, across=0.45, down=0.5)


def _three_of_each(levels: Sequence[Level], without: tuple[str, ...]) -> dict[str, list[Level]]:
    """Return the first, the middle and the last level of each way, or all if there are fewer."""
    ways: dict[str, list[Level]] = {}
    for level in levels:
        if level.family not in without:
            ways.setdefault(level.family, []).append(level)
    return {
        way: [all_levels[place] for place in sorted({0, len(all_levels) // 2, len(all_levels) - 1})]
        for way, all_levels in ways.items()
    }


def _draw_mesh(axes: Axes, case: Case, level: Level) -> None:
    """Draw the mesh under the punch, coloured by the indicators of its triangles."""
    corners = level.mesh.p[:, level.mesh.t]
    visible = (corners[0].min(axis=0) < WIDTH) & (corners[1].min(axis=0) < DEPTH)
    elements = PolyCollection(
        corners[:, :, visible].transpose(2, 1, 0),
        facecolors="white",
        edgecolors="0.25",
        linewidths=0.25,
    )
    if level.indicators is not None:
        greatest_indicator = level.indicators.max()
        clipped_indicators = np.maximum(
            level.indicators[visible], 10.0**-DECADES * greatest_indicator
        )
        elements.set(
            array=clipped_indicators,
            cmap="Reds",
            norm=LogNorm(10.0**-DECADES * greatest_indicator, greatest_indicator),
        )
    axes.add_collection(elements)
    rings = case.problem.merged
    wear = rings.wear_coefficients.mean(axis=0)
    for inner, outer, ring_wear in zip(rings.ring_edges, rings.ring_edges[1:], wear, strict=False):
        shade = "0.5" if ring_wear > np.sqrt(wear.min() * wear.max()) else "0.8"
        axes.add_patch(
            Rectangle((inner, -PUNCH), outer - inner, PUNCH, facecolor=shade, edgecolor="white")
        )
    axes.set(xlim=(0, WIDTH), ylim=(DEPTH, -PUNCH), aspect="equal", yticks=[0, DEPTH / 2, DEPTH])


def _draw_pressure_errors(axes: Axes, case: Case, levels: Sequence[Level]) -> None:
    """Draw pressure errors at the first time after the start, with darker lines on finer levels."""
    face = case.compared_problem.face
    names = ["coarsest", "middle", "finest"] if len(levels) == 3 else ["coarsest", "finest"]
    for number, level in enumerate(levels):
        shade = 0.72 * (1 - (number + 1) / len(levels))
        errors = np.maximum(level.pressure_errors[0], 1e-12)
        label = f"{names[number]} level" if len(levels) > 1 else None
        axes.plot(face.radii, errors, color=str(shade), linewidth=0.5 + 0.15 * number, label=label)
    shade_rings(axes, case.problem.ring_edges, case.problem.wear_coefficients)
    set_logarithmic(axes, "y")
