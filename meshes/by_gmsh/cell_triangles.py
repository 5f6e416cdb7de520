"""Graded triangles on given cells of the contact, above interfaces of layers, by gmsh.

Bisection (`bisection.py`) makes triangles on cells without any library, but has no lines at
interfaces of layers. Here each cell of the contact is one facet of the mesh, and triangles grow
with the distance from it.
"""

import itertools
from contextlib import suppress

import numpy as np
from skfem import MeshTri

from ..contact_cells import ContactCells
from ..errors import MeshError
from ..half_space import as_half_space
from ..sizes import rounded_to_octaves
from .outline import Outline, add_corners, add_surfaces
from .session import TRIANGLE, Band, elements, session, set_sizes
from .triangles import GROWTH_FACTORS

# greatest size of triangles over the truncation radius
FAR_SIZE = 0.125
# greatest size of triangles in a layer over its thickness: longer ones across a thin layer are flat
SIZE_OF_LAYER = 3.0


def mesh(cells: ContactCells, growth: float, outline: Outline) -> MeshTri:
    """Mesh a quarter disc of layers whose facets on the contact are the given cells.

    If gmsh leaves a degenerate triangle, the mesh is made again with a slightly smaller growth.

    Parameters
    ----------
    cells : of the contact
    growth : growth of the size of triangles with the distance from the contact
    outline : of the quarter disc, with the interfaces of its layers

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails
    """
    for factor in GROWTH_FACTORS[:-1]:
        with suppress(MeshError):
            return _generate(cells, factor * growth, outline)
    return _generate(cells, GROWTH_FACTORS[-1] * growth, outline)


def _generate(cells: ContactCells, growth: float, outline: Outline) -> MeshTri:
    """Mesh the quarter disc once."""
    radii = cells.from_axis().breakpoints()
    widths = np.diff(radii)
    narrower = np.minimum(np.append(widths, np.inf), np.append(np.inf, widths))
    largest = FAR_SIZE * outline.outer
    bands = [
        Band(top, bottom, min(largest, SIZE_OF_LAYER * (bottom - top)))
        for top, bottom in itertools.pairwise((0.0, *outline.interfaces))
    ]
    with session() as gmsh:
        geometry = gmsh.model.geo
        corners = add_corners(geometry, outline)
        points = [corners.origin, *(geometry.addPoint(radius, 0, 0) for radius in radii[1:])]
        facets = [geometry.addLine(*ends) for ends in itertools.pairwise(points)]
        for facet in facets:
            geometry.mesh.setTransfiniteCurve(facet, 2)
        free_surface = geometry.addLine(points[-1], corners.surface_end)
        add_surfaces(geometry, outline, corners, [*facets, free_surface])
        geometry.synchronize()
        set_sizes(gmsh, np.array(points), rounded_to_octaves(narrower), growth, largest, bands)
        gmsh.model.mesh.generate(2)
        triangles = MeshTri(*elements(gmsh, TRIANGLE))
    return as_half_space(triangles, np.array(cells.ring_edges), outline.base)
