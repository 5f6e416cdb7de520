"""The quarter disc in graded triangles, by gmsh."""

import itertools

import numpy as np
from skfem import MeshTri

from .gmsh_session import TRIANGLE, elements, session, set_sizes
from .half_space import as_half_space
from .sizes import SizeField


def mesh(field: SizeField) -> MeshTri:
    """Mesh the quarter disc to the size field.

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails
    """
    with session() as gmsh:
        geometry, outer = gmsh.model.geo, field.truncation
        on_contact = [geometry.addPoint(edge, 0, 0) for edge in field.ring_edges]
        surface_end, axis_end = geometry.addPoint(outer, 0, 0), geometry.addPoint(0, outer, 0)
        curves = [geometry.addLine(a, b) for a, b in itertools.pairwise([*on_contact, surface_end])]
        curves += [
            geometry.addCircleArc(surface_end, on_contact[0], axis_end),
            geometry.addLine(axis_end, on_contact[0]),
        ]
        geometry.addPlaneSurface([geometry.addCurveLoop(curves)])
        geometry.synchronize()
        wanted = field.sizes < field.largest
        points, sizes = np.array(on_contact)[wanted], field.sizes[wanted]
        set_sizes(gmsh, points, sizes, field.growth, field.largest)
        gmsh.model.mesh.generate(2)
        mesh = MeshTri(*elements(gmsh, TRIANGLE))
    return as_half_space(mesh, np.array(field.ring_edges))
