"""Finite-element half-spaces for contacts on part of the face.

Fitted to its edges, or fine all over the face.
"""

import numpy as np

from ..meshes import bisection
from ..meshes.contact_cells import ContactCells, contact_mesh_field
from ..meshes.pressure_space import PressureSpace
from ..meshes.quads import graded
from ..meshes.radial import Array, Indices
from .elasticity import AxisymmetricElasticity
from .far_field import enough_poles
from .half_space import HalfSpace, pressure_space

# a mark beside the axis, where a cone's pressure is infinite as a logarithm, and sizes as the
# radial mesh has them; those at free edges larger, for the stiffness of small elements has fewer
# digits
MARK, AT_FREE, AT_CORNER = 1e-2, 2.5e-7, 1e-10
FACTOR, GROWTH, TRUNCATION = 0.25, 0.8, 2.5
# of triangles whose contact line follows given cells
TRIANGLE_DEGREE, TRIANGLE_GROWTH, TRIANGLE_TRUNCATION = 3, 0.6, 5.0
# growth of the triangles of a coarser half-space, whose difference shows what they err by
COARSER_GROWTH = 0.9
FAR_FIELD = 1e-10


def fitted_half_space(
    edges: tuple[float, ...], infinite: tuple[bool, ...], degree: int, poisson_ratio: float
) -> HalfSpace:
    """Quadrilaterals of high degree in geometric layers round every edge of a contact.

    Parameters
    ----------
    edges : from 0 to 1; the pressure space is broken at each
    infinite : at which of them the pressure is infinite
    degree : of the displacement, two above that of the pressure
    poisson_ratio : of the half-space
    """
    marks = np.array(edges)
    sizes = np.where(infinite, AT_CORNER, AT_FREE)[1:]
    if edges[1] > 4 * MARK:
        marks, sizes = np.insert(marks, 1, MARK), np.insert(sizes, 0, MARK)
    mesh = graded(marks, sizes[:-1], float(sizes[-1]), FACTOR, GROWTH, TRUNCATION, _as_root).mesh
    return _half_space(AxisymmetricElasticity(mesh, degree, poisson_ratio), marks)


def even_half_space(
    cells: ContactCells, poisson_ratio: float, growth: float = TRIANGLE_GROWTH
) -> HalfSpace:
    """Triangles of degree 3 whose facets on the contact are no larger than the cells, with linear
    pressures on these.
    """
    mesh = bisection.mesh(contact_mesh_field(cells, growth, TRIANGLE_TRUNCATION))
    half_space = _half_space(
        AxisymmetricElasticity(mesh, TRIANGLE_DEGREE, poisson_ratio), np.array(cells.ring_edges)
    )
    space = half_space.space
    return HalfSpace(
        half_space.solid,
        PressureSpace(space.breakpoints, np.ones_like(space.degrees), space.ring_edges),
        half_space.poles,
    )


def _as_root(distance: Array, *_: Array | Indices) -> Array:
    """What stands behind high degrees beside an edge: pressures rise or fall there as a root."""
    return np.sqrt(distance)


def _half_space(solid: AxisymmetricElasticity, ring_edges: Array) -> HalfSpace:
    outer = float(solid.mesh.p[0].max())
    return HalfSpace(solid, pressure_space(solid, ring_edges), enough_poles(outer, FAR_FIELD))
