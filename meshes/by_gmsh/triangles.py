"""The quarter disc in graded triangles, meshed by gmsh."""

import itertools
from contextlib import suppress
from dataclasses import replace

import numpy as np
from skfem import MeshTri

from ..errors import MeshError
from ..half_space import as_half_space
from ..radial import from_axis
from ..sizes import SizeField
from .session import TRIANGLE, elements, session, set_sizes

# gmsh produces a degenerate triangle now and then; factors on the growth, tried in this order
GROWTH_FACTORS = (1.0, 0.95, 0.9)


def mesh(field: SizeField) -> MeshTri:
    """Mesh the quarter disc with the sizes of the size field.

    If gmsh fails, the mesh is tried again with a slightly smaller growth.

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails with every growth
    """
    for factor in GROWTH_FACTORS[:-1]:
        with suppress(MeshError):
            return _generate(replace(field, growth=factor * field.growth))
    return _generate(replace(field, growth=GROWTH_FACTORS[-1] * field.growth))


def _generate(field: SizeField) -> MeshTri:
    """Mesh the quarter disc once."""
    with session() as gmsh:
        geometry, outer = gmsh.model.geo, field.truncation
        on_contact = [geometry.addPoint(edge, 0, 0) for edge in from_axis(field.ring_edges)]
        surface_end, axis_end = geometry.addPoint(outer, 0, 0), geometry.addPoint(0, outer, 0)
        curves = [geometry.addLine(a, b) for a, b in itertools.pairwise([*on_contact, surface_end])]
        curves += [
            geometry.addCircleArc(surface_end, on_contact[0], axis_end),
            geometry.addLine(axis_end, on_contact[0]),
        ]
        geometry.addPlaneSurface([geometry.addCurveLoop(curves)])
        geometry.synchronize()
        refined = field.sizes < field.largest
        points, sizes = np.array(on_contact)[refined], field.sizes[refined]
        set_sizes(gmsh, points, sizes, field.growth, field.largest)
        gmsh.model.mesh.generate(2)
        mesh = MeshTri(*elements(gmsh, TRIANGLE))
    return as_half_space(mesh, np.array(field.ring_edges))
