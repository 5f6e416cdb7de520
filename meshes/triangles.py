"""The quarter disc in graded triangles, by gmsh."""

import itertools
from contextlib import suppress
from dataclasses import replace

import numpy as np
from skfem import MeshTri

from .errors import MeshError
from .gmsh_session import TRIANGLE, elements, session, set_sizes
from .half_space import as_half_space
from .sizes import SizeField

# gmsh leaves a degenerate triangle now and then: by these factors of the growth it meshes anew
GROWTHS = (1.0, 0.95, 0.9)


def mesh(field: SizeField) -> MeshTri:
    """Mesh the quarter disc to the size field, or to a slightly finer one if that fails.

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails
    """
    for factor in GROWTHS[:-1]:
        with suppress(MeshError):
            return _generate(replace(field, growth=factor * field.growth))
    return _generate(replace(field, growth=GROWTHS[-1] * field.growth))


def _generate(field: SizeField) -> MeshTri:
    """Mesh the quarter disc once."""
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
