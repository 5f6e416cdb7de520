"""The outline of the quarter disc in gmsh: its arc, its axis, and lines at interfaces of layers."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

# Largest depth of an interface within the mesh over the truncation radius.
MAX_INTERFACE_DEPTH = 0.8


def truncation_with_interfaces(interfaces: Sequence[float], min_radius: float) -> float:
    """Return the truncation radius that is large enough to avoid slivers at interfaces.

    Parameters
    ----------
    interfaces : depths of the interfaces, in punch radii
    min_radius : smallest truncation radius, in punch radii

    Notes
    -----
    An interface that meets the outer arc near the axis would leave a sliver between them. The
    radius R is therefore increased until no interface is between ``MAX_INTERFACE_DEPTH R`` and R.
    """
    outer = min_radius
    for depth in sorted(interfaces):
        if MAX_INTERFACE_DEPTH * outer < depth < outer:
            outer = depth / MAX_INTERFACE_DEPTH
    return outer


class Outline(NamedTuple):
    """Describe the boundaries of the quarter disc and the lines that divide it.

    Parameters
    ----------
    outer : radius of the arc, in punch radii
    interfaces : depths of the interfaces, which are lines across the quarter disc
    base : depth of the rigid base at which the mesh ends, equal to the last interface; infinite
        without one
    """

    outer: float
    interfaces: tuple[float, ...] = ()
    base: float = np.inf

    @classmethod
    def of_layers(cls, outer: float, interfaces: tuple[float, ...], rigid: bool) -> "Outline":
        """Return the outline of a quarter disc of layers.

        Interfaces that lie deeper than the radius of the arc are left out.

        Parameters
        ----------
        outer : radius of the arc
        interfaces : depths of all interfaces
        rigid : whether the base below the last interface is rigid
        """
        within = tuple(depth for depth in interfaces if depth < outer)
        base = within[-1] if rigid and within == interfaces else np.inf
        return cls(outer, within, base)

    @property
    def bottoms(self) -> tuple[float, ...]:
        """Depths at which the layers end, the last of them at the arc or at a rigid base."""
        return self.interfaces if np.isfinite(self.base) else (*self.interfaces, self.outer)


class Corners(NamedTuple):
    """Tags of the corners of a quarter disc in gmsh.

    Parameters
    ----------
    origin : at the centre of the contact
    surface_end : where the arc meets the surface
    axis_ends : where each layer ends on the axis, from the surface down
    """

    origin: int
    surface_end: int
    axis_ends: tuple[int, ...]


def add_corners(geometry: Any, outline: Outline) -> Corners:
    """Add the corners of a quarter disc to gmsh's `model.geo`, and return their tags."""
    origin, surface_end = (geometry.addPoint(r, 0, 0) for r in (0, outline.outer))
    axis_ends = tuple(geometry.addPoint(0, depth, 0) for depth in outline.bottoms)
    return Corners(origin, surface_end, axis_ends)


def add_surfaces(
    geometry: Any,
    outline: Outline,
    corners: Corners,
    on_surface: Sequence[int],
    blocks: "Blocks | None" = None,
) -> None:
    """Add one surface for each layer of the quarter disc to a geometry of gmsh.

    Parameters
    ----------
    geometry : gmsh's `model.geo`
    outline : of the quarter disc
    corners : tags of its corners
    on_surface : tags of the curves along the surface, from the origin or from the end of the blocks
        to the arc
    blocks : parts of the first layer near the axis that already are surfaces
    """
    outer, (origin, on_arc, axis_ends) = outline.outer, corners
    # each layer is bounded by two lines, a part of the axis and a part of the arc
    curves, on_axis = list(on_surface), origin
    for number, (depth, below) in enumerate(zip(outline.bottoms, axis_ends, strict=True)):
        beside = blocks if number == 0 else None
        inner_end = beside.corner if beside else below
        across, bottom = inner_end, []
        if depth < outer:
            across = geometry.addPoint(np.sqrt((outer - depth) * (outer + depth)), depth, 0)
            bottom = [geometry.addLine(across, inner_end)]
        curves.append(geometry.addCircleArc(on_arc, origin, across))
        inner_side = beside.side if beside else geometry.addLine(below, on_axis)
        _add_surface(geometry, [*curves, *bottom, inner_side])
        bottom = [*(beside.bottoms if beside else ()), *bottom]
        curves, on_axis, on_arc = [-curve for curve in bottom], below, across


def _add_surface(geometry: Any, curves: Sequence[int]) -> int:
    return int(geometry.addPlaneSurface([geometry.addCurveLoop(list(curves))]))


@dataclass
class Blocks:
    """Parts of the first layer from the axis on, divided by upright lines, in gmsh's `model.geo`.

    Parameters
    ----------
    geometry : gmsh's `model.geo`
    thickness : of the first layer
    corner : tag of the point at its bottom where the next part begins
    side : tag of the line at which the next part begins, which points upwards
    bottoms : tags of the curves along the bottom, outwards; each points inwards
    """

    geometry: Any
    thickness: float
    corner: int
    side: int
    bottoms: list[int] = field(default_factory=list)

    def add(
        self, on_surface: Sequence[int], end: int, radius: float, columns: int | None = None
    ) -> None:
        """Add the next part.

        Parameters
        ----------
        on_surface : tags of its curves along the surface, outwards
        end, radius : tag and radius of the point where they end
        columns : number of columns of two rows, if the part is a block of them
        """
        geometry = self.geometry
        end_below = geometry.addPoint(radius, self.thickness, 0)
        side = geometry.addLine(end, end_below)
        self.bottoms.append(geometry.addLine(end_below, self.corner))
        surface = _add_surface(geometry, [*on_surface, side, self.bottoms[-1], self.side])
        geometry.mesh.setTransfiniteCurve(side, 3)
        if columns is not None:
            for curve in (*on_surface, self.bottoms[-1]):
                geometry.mesh.setTransfiniteCurve(curve, columns + 1)
            geometry.mesh.setTransfiniteCurve(abs(self.side), 3)
            geometry.mesh.setTransfiniteSurface(surface)
        self.corner, self.side = end_below, -side
