"""The quarter disc in graded triangles, meshed by gmsh: of given sizes, or on cells of the contact.

Bisection (`meshes/bisection.py`) makes both without any library, but has no lines at interfaces of
layers.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from skfem import MeshTri

from ..contact_cells import ContactCells
from ..half_space import as_half_space
from ..radial import Array, from_axis
from ..sizes import SizeField, rounded_to_octaves
from .outline import Outline, add_corners, add_surfaces
from .session import TRIANGLE, Band, elements, first_that_succeeds, session, set_sizes

# factors on the growth, in the order that is tried
GROWTH_FACTORS = (1.0, 0.95, 0.9)
# greatest size of triangles below cells, over the truncation radius
FAR_SIZE_BELOW_CELLS = 0.125
# greatest size of triangles in a layer over its thickness: longer ones across a thin layer are flat
SIZE_OF_LAYER = 3.0


def mesh(field: SizeField) -> MeshTri:
    """Mesh the quarter disc with the sizes of the size field.

    If gmsh fails, the mesh is tried again with a slightly smaller growth.

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails with every growth
    """

    def generate(factor: float) -> MeshTri:
        outline, radii = Outline(field.truncation), from_axis(field.ring_edges)
        return _generate(outline, radii, field.sizes, factor * field.growth, field.largest)

    return as_half_space(first_that_succeeds(generate, GROWTH_FACTORS), np.array(field.ring_edges))


def mesh_below_cells(cells: ContactCells, growth: float, outline: Outline) -> MeshTri:
    """Mesh a quarter disc of layers whose facets on the contact are the given cells.

    If gmsh fails, the mesh is tried again with a slightly smaller growth.

    Parameters
    ----------
    cells : of the contact
    growth : growth of the size of triangles with the distance from the contact
    outline : of the quarter disc, with the interfaces of its layers

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails with every growth
    """
    radii = cells.from_axis().breakpoints()
    widths = np.diff(radii)
    narrower = np.minimum(np.append(widths, np.inf), np.append(np.inf, widths))
    sizes, largest = rounded_to_octaves(narrower), FAR_SIZE_BELOW_CELLS * outline.outer
    bands = [
        Band(top, bottom, min(largest, SIZE_OF_LAYER * (bottom - top)))
        for top, bottom in itertools.pairwise((0.0, *outline.interfaces))
    ]

    def generate(factor: float) -> MeshTri:
        return _generate(outline, radii, sizes, factor * growth, largest, bands, undivided=True)

    return as_half_space(
        first_that_succeeds(generate, GROWTH_FACTORS), np.array(cells.ring_edges), outline.base
    )


def _generate(
    outline: Outline,
    radii: Array,
    sizes: Array,
    growth: float,
    largest: float,
    bands: Sequence[Band] = (),
    undivided: bool = False,
) -> MeshTri:
    """Mesh the quarter disc once.

    Parameters
    ----------
    outline : of the quarter disc
    radii : (n,) radii of vertices on the contact, from 0 to 1
    sizes : (n,) sizes there
    growth : increase of the size per distance from them
    largest : largest size anywhere
    bands : ranges of depth in which the largest size is smaller
    undivided : whether each interval between two radii is one facet
    """
    with session() as gmsh:
        geometry = gmsh.model.geo
        corners = add_corners(geometry, outline)
        points = [corners.origin, *(geometry.addPoint(radius, 0, 0) for radius in radii[1:])]
        ends = itertools.pairwise([*points, corners.surface_end])
        curves = [geometry.addLine(*pair) for pair in ends]
        if undivided:
            for curve in curves[:-1]:
                geometry.mesh.setTransfiniteCurve(curve, 2)
        add_surfaces(geometry, outline, corners, curves)
        geometry.synchronize()
        refined = sizes < largest
        set_sizes(gmsh, np.array(points)[refined], sizes[refined], growth, largest, bands)
        gmsh.model.mesh.generate(2)
        return MeshTri(*elements(gmsh, TRIANGLE))
