"""The quarter disc in graded triangles, by gmsh."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from skfem import MeshTri

from ringwear.meshes.gmsh_session import TRIANGLE, elements, session, set_sizes
from ringwear.meshes.half_space import half_space
from ringwear.meshes.sizes import SizeField


def mesh(field: SizeField) -> MeshTri:
    """Mesh the quarter disc to the size field.

    Raises
    ------
    MeshError
        if gmsh cannot be loaded or fails
    """
    with session() as gmsh:
        _geometry(gmsh, field)
        gmsh.model.mesh.generate(2)
        points, triangles = elements(gmsh, TRIANGLE)
    return half_space(MeshTri(points, triangles), np.array(field.ring_edges))


def _geometry(gmsh: Any, field: SizeField) -> None:
    geometry, outer = gmsh.model.geo, field.truncation
    on_contact = [geometry.addPoint(edge, 0, 0) for edge in field.ring_edges]
    surface_end, axis_end = geometry.addPoint(outer, 0, 0), geometry.addPoint(0, outer, 0)
    line = [*on_contact, surface_end]
    curves = [geometry.addLine(a, b) for a, b in itertools.pairwise(line)]
    curves += [geometry.addCircleArc(surface_end, on_contact[0], axis_end), geometry.addLine(axis_end, on_contact[0])]
    geometry.addPlaneSurface([geometry.addCurveLoop(curves)])
    geometry.synchronize()
    at_edges = np.array(field.ring_sizes)
    groups = [(on_contact[-1:], field.rim_size)]
    if field.centre_size < field.largest:
        groups.append((on_contact[:1], field.centre_size))
    groups += [([on_contact[1 + i] for i in np.flatnonzero(at_edges == size)], size) for size in np.unique(at_edges)]
    set_sizes(gmsh, groups, field.growth, field.largest)
