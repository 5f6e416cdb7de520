"""Draw meshes under the punch at three levels of each way, and pressure errors over the radius."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from skfem import Mesh

from ...meshes import Array, contact_radii
from ..crosscheck import Results, Solution
from ..figures.style import PAGE, RED, complete, new_panels, set_logarithmic, shade_rings
from .draw import titled
from .way import Case, Way
from .ways.finite_elements import Estimated

WIDTH, DEPTH, PUNCH = 1.45, 0.6, 0.13
"""Width and depth of the drawn part of the half-space, and height of the punch, in punch radii."""
DECADES = 3
"""Decades of the squared error indicator that the colours cover."""
MOST_OWN_MESHES = 4
"""Greatest number of meshes of the user that are drawn: the first, the last, and some between."""
COLOURS = (
    "squared error indicator of each triangle, from 1/1000 of the greatest (white) to the greatest "
    "(red)."
)


@dataclass(frozen=True, eq=False)
class DrawnLevel:
    """What figures need of the solution of a level.

    Parameters
    ----------
    way, name : names of its way and of the level
    mesh : mesh with its named boundaries
    degree : polynomial degree of the displacement
    unknowns : number of unknowns of the displacement
    pressure_errors : (T, R) absolute errors of p(t) after the start, at the radii of the face, over
        the norm of p(t)
    indicators : (m,) squared error indicator of each triangle, the greatest over the states; None
        if there are none
    """

    way: str
    name: str
    mesh: Mesh
    degree: int
    unknowns: int
    pressure_errors: Array
    indicators: Array | None = None

    @classmethod
    def of(
        cls, case: Case, way: Way, level: Any, solution: Solution, exact: Results
    ) -> "DrawnLevel":
        """Return what figures need of a solution, whose pressures are compared with a reference."""
        half_space = solution.half_space
        assert half_space is not None
        later = case.problem.times[case.problem.compared_rows] > 0
        values, right = (results["pressure"][later] for results in (solution.compared, exact))
        weights = case.problem.face.weights
        norms = np.sqrt(np.sum(weights * right**2, axis=1) / np.sum(weights))
        return cls(
            way.name,
            str(level),
            half_space.solid.mesh,
            half_space.solid.degree,
            solution.unknowns,
            np.abs(values - right) / norms[:, None],
            solution.indicators if isinstance(solution, Estimated) else None,
        )


class WorstPlace(NamedTuple):
    """Place on the contact with the greatest error of the pressure.

    Parameters
    ----------
    time : time at which the error is greatest, in the unit of the scene
    edge : ring edge, or rim, with the greatest error near it, in punch radii
    share : fraction of the squared error at that time that is nearer to this edge than to any other
    facet : ends of the facet with the greatest part of that error, in punch radii
    share_of_facet : fraction of the squared error at that time on this facet and nearest to this
        edge
    """

    time: float
    edge: float
    share: float
    facet: tuple[float, float]
    share_of_facet: float


def later_times(case: Case) -> Array:
    """Return the compared times after the start, in the unit of the scene."""
    times = case.problem.times[case.problem.compared_rows]
    return times[times > 0] * case.problem.units.time


def worst_place(case: Case, level: DrawnLevel) -> WorstPlace:
    """Return the place of a mesh at which the squared error of the pressure is greatest."""
    face = case.problem.face
    squares = face.weights * level.pressure_errors**2
    worst_time = int(squares.sum(axis=1).argmax())
    shares = squares[worst_time] / squares[worst_time].sum()
    edges = case.problem.merged.from_axis[1:]
    nearest = np.abs(face.radii[:, None] - edges).argmin(axis=1)
    edge_shares = np.bincount(nearest, shares, len(edges))
    edge = int(edge_shares.argmax())
    facet_ends = contact_radii(level.mesh)
    facets = np.clip(
        np.searchsorted(facet_ends, face.radii, side="right") - 1, 0, len(facet_ends) - 2
    )
    facet_shares = np.bincount(facets, np.where(nearest == edge, shares, 0.0), len(facet_ends) - 1)
    facet = int(facet_shares.argmax())
    return WorstPlace(
        float(later_times(case)[worst_time]),
        float(edges[edge]),
        float(edge_shares[edge]),
        (float(facet_ends[facet]), float(facet_ends[facet + 1])),
        float(facet_shares[facet]),
    )


def draw_meshes(case: Case, title: str, levels: Sequence[DrawnLevel]) -> Figure:
    """Draw the meshes of each way at three levels, with the punch, coloured by the indicator."""
    ways = three_of_each(levels)
    figure, panels = new_panels(PAGE, 0.75 + 1.35 * max(len(ways), 1), max(len(ways), 1), 3)
    for row, (way, way_levels) in zip(panels, ways.items(), strict=False):
        for axes, level in zip(row, way_levels, strict=False):
            _draw_mesh(axes, case, level)
            axes.set_title(f"{way}: {level.unknowns} unknowns", fontsize=6.5)
        for axes in row[len(way_levels) :]:
            axes.set_axis_off()
        row[0].set_ylabel("depth z/a")
    for axes in panels[-1]:
        axes.set_xlabel("r/a")
    note = f"Above the surface: the punch; rings that wear faster are darker.\nColour: {COLOURS}"
    heading = titled(title, "meshes at three levels of each way")
    return complete(figure, [heading], note=note, across=0.35, down=0.25)


def draw_pressure_errors(case: Case, title: str, levels: Sequence[DrawnLevel]) -> Figure:
    """Draw pressure errors over the radius at the first time after the start, at three levels."""
    ways = three_of_each(levels)
    columns = min(3, len(ways))
    rows = -(-len(ways) // columns)
    figure, panels = new_panels(PAGE, 0.9 + 1.75 * rows, rows, columns, sharey=True)
    for axes, (way, way_levels) in zip(panels.ravel(), ways.items(), strict=False):
        _draw_pressure_errors(axes, case, way_levels)
        unknowns = ", ".join(str(level.unknowns) for level in way_levels)
        axes.set_title(f"{way}:\n{unknowns} unknowns")
    for axes in panels.ravel()[len(ways) :]:
        axes.set_axis_off()
    for row in panels:
        row[0].set_ylabel("|error of p| / norm of p")
    for axes in panels.ravel()[: len(ways)][-columns:]:
        axes.set_xlabel("r/a")
    heading = titled(title, f"error of the pressure over the radius, {_first_time(case)}")
    several_materials = np.ptp(case.problem.wear_coefficients) > 0
    note = "Grey bands: rings that wear faster." if several_materials else ""
    return complete(figure, [heading], panels.ravel(), note, across=0.3, down=0.58)


def draw_own_meshes(case: Case, title: str, levels: Sequence[DrawnLevel]) -> Figure:
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
        mesh_axes.set_title(f"{level.name}\n{level.unknowns} unknowns, degree {level.degree}")
        _draw_pressure_errors(error_axes, case, [level])
        error_axes.axvspan(*worst.facet, color=RED, alpha=0.3, linewidth=0)
        error_axes.set_title(
            f"{worst.share:.0%} of the squared\nerror next to r = {worst.edge:.3g} a"
        )
        error_axes.set_xlabel("r/a")
    panels[0, 0].set_ylabel("depth z/a")
    panels[1, 0].set_ylabel("|error of p| / norm of p")
    heading = titled(title, f"your meshes, and their pressure errors, {_first_time(case)}")
    note = f"Red: the facet with the greatest part of the error.\nColour: {COLOURS}"
    return complete(figure, [heading], note=note, across=0.45, down=0.5)


def _first_time(case: Case) -> str:
    """Return the first time after the start in words."""
    assert case.scene is not None
    return f"t = {case.scene.unit_names.write(float(later_times(case)[0]), 'time', 3)}"


def three_of_each(levels: Sequence[DrawnLevel]) -> dict[str, list[DrawnLevel]]:
    """Return the first, the middle and the last level of each way, or all if there are fewer."""
    ways: dict[str, list[DrawnLevel]] = {}
    for level in levels:
        ways.setdefault(level.way, []).append(level)
    return {
        way: [all_levels[place] for place in sorted({0, len(all_levels) // 2, len(all_levels) - 1})]
        for way, all_levels in ways.items()
    }


def _draw_mesh(axes: Axes, case: Case, level: DrawnLevel) -> None:
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
        greatest = level.indicators.max()
        least = 10.0**-DECADES * greatest
        elements.set(
            array=np.maximum(level.indicators[visible], least),
            cmap="Reds",
            norm=LogNorm(least, greatest),
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


def _draw_pressure_errors(axes: Axes, case: Case, levels: Sequence[DrawnLevel]) -> None:
    """Draw pressure errors at the first time after the start, with darker lines on finer levels."""
    names = ["coarsest", "middle", "finest"] if len(levels) == 3 else ["coarsest", "finest"]
    for number, level in enumerate(levels):
        shade = 0.72 * (1 - (number + 1) / len(levels))
        errors = np.maximum(level.pressure_errors[0], 1e-12)
        label = f"{names[number]} level" if len(levels) > 1 else None
        width = 0.5 + 0.15 * number
        axes.plot(case.problem.face.radii, errors, color=str(shade), linewidth=width, label=label)
    shade_rings(axes, case.problem.ring_edges, case.problem.wear_coefficients)
    set_logarithmic(axes, "y")
