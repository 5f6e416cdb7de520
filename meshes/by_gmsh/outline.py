"""The outline of the quarter disc in gmsh: its arc, its axis, and lines at interfaces of layers."""

from collections.abc import Sequence
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
    geometry: Any, outline: Outline, corners: Corners, on_surface: Sequence[int]
) -> None:
    """Add one surface for each layer of the quarter disc to a geometry of gmsh.

    Parameters
    ----------
    geometry : gmsh's `model.geo`
    outline : of the quarter disc
    corners : tags of its corners
    on_surface : tags of the curves along the surface, from the origin to the arc
    """
    outer, (origin, on_arc, axis_ends) = outline.outer, corners
    # each layer is bounded by two lines, a part of the axis and a part of the arc
    curves, on_axis = list(on_surface), origin
    for depth, below in zip(outline.bottoms, axis_ends, strict=True):
        across, bottom = below, []
        if depth < outer:
            across = geometry.addPoint(np.sqrt((outer - depth) * (outer + depth)), depth, 0)
            bottom = [geometry.addLine(across, below)]
        curves.append(geometry.addCircleArc(on_arc, origin, across))
        sides = [*curves, *bottom, geometry.addLine(below, on_axis)]
        geometry.addPlaneSurface([geometry.addCurveLoop(sides)])
        curves, on_axis, on_arc = [-curve for curve in bottom], below, across
