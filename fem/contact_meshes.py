"""Finite-element half-spaces for contact on a part of the punch face."""

from dataclasses import replace

import numpy as np
from skfem import Mesh

from ..meshes import bisection
from ..meshes.by_gmsh import triangles
from ..meshes.by_gmsh.outline import Outline, truncation_with_interfaces
from ..meshes.by_gmsh.quads import graded
from ..meshes.contact_cells import ContactCells
from ..meshes.ground.ground import HALF_SPACE, Ground
from ..meshes.half_space import halved
from ..meshes.pressure_space import PressureSpace
from ..meshes.radial import Array, Indices
from ..meshes.sizes import FAR_TRUNCATION, NEAR_TRUNCATION, SizeField
from .elasticity import AxisymmetricElasticity
from .far_field import enough_poles
from .half_space import HalfSpace, contact_breakpoints, pressure_space

# increase of the triangle size per depth
TRIANGLE_GROWTH = 0.6
# the same on the coarser half-space of the error estimate
COARSER_GROWTH = 0.9
# share of the energy that the truncation may lose
NEGLIGIBLE_ENERGY = 1e-10


def fitted_half_space(
    edges: tuple[float, ...],
    sizes: tuple[float, ...],
    degree: int,
    ground: Ground,
) -> HalfSpace:
    """Return a half-space of quadrilaterals with geometric layers round every edge of a contact.

    Parameters
    ----------
    edges : edges of the contact, from 0 to 1; the pressure space is broken at each
    sizes : largest size of the smallest elements at each edge but the first
    degree : degree of the displacement, two above that of the pressure
    ground : layers, with lengths over the radius of the contact
    """
    marks = np.array(edges)

    def root_amplitude(distance: Array, *_: Array | Indices) -> Array:
        # amplitude of high degrees: near an edge the pressure varies as sqrt(distance) or its
        # inverse
        return np.sqrt(distance)

    # layers near the axis, where the pressure under a cone has a logarithmic singularity
    axis_layer_radius = 1e-2
    if edges[1] > 4 * axis_layer_radius:
        marks, sizes = np.insert(marks, 1, axis_layer_radius), (axis_layer_radius, *sizes)
    interfaces = tuple(ground.depths.tolist())
    mesh = graded(
        marks,
        sizes[:-1],
        sizes[-1],
        factor=0.25,
        growth=0.8,
        outer=truncation_with_interfaces(interfaces, NEAR_TRUNCATION),
        edge_amplitude=root_amplitude,
        interfaces=interfaces,
        rigid=ground.rigid,
    ).mesh
    solid = AxisymmetricElasticity(mesh, degree, ground)
    # moments of the face are integrated between rounded radii, and so must the pressures be
    space = replace(pressure_space(solid, marks), low_parts=None)
    poles = enough_poles(NEAR_TRUNCATION, NEGLIGIBLE_ENERGY)
    return HalfSpace(solid, space, poles).without_dependent_poles()


def even_half_space(
    cells: ContactCells,
    ground: Ground = HALF_SPACE,
    growth: float = TRIANGLE_GROWTH,
    degree: int = 3,
    halvings: int = 0,
) -> HalfSpace:
    """Return a half-space of triangles of one degree with piecewise linear contact pressures.

    The contact facets are no larger than the cells. The pressure is linear on each facet and may
    jump at ring edges. The displacement is defined on the same mesh, or on one obtained from it by
    halving: with linear displacements, the pressures are stable only if their facets are larger
    than those of the displacements.

    Parameters
    ----------
    cells : sizes of the contact facets
    ground : layers, whose interfaces gmsh makes lines of the mesh
    growth : increase of the triangle size per depth
    degree : degree of the displacement
    halvings : number of times that every triangle is halved for the displacement, at least 1 for
        degree 1; none on layers
    """
    edges = cells.ring_edges
    if not ground.layered:
        mesh, outer = _triangles_by_bisection(cells, growth), FAR_TRUNCATION
    else:
        interfaces = tuple(ground.depths.tolist())
        outer = truncation_with_interfaces(interfaces, NEAR_TRUNCATION)
        outline = Outline.of_layers(outer, interfaces, ground.rigid)
        mesh = triangles.mesh_below_cells(cells, growth, outline)
    breakpoints, low_parts = contact_breakpoints(mesh, np.array(edges))
    linear = np.ones(len(breakpoints) - 1, dtype=np.int64)
    space = PressureSpace(breakpoints, linear, np.array(edges), low_parts)
    if halvings:
        mesh = halved(mesh, np.array(edges), halvings)
    solid = AxisymmetricElasticity(mesh, degree, ground)
    poles = enough_poles(outer, NEGLIGIBLE_ENERGY)
    return HalfSpace(solid, space, poles).without_dependent_poles()


def _triangles_by_bisection(cells: ContactCells, growth: float) -> Mesh:
    size = cells.edge_size
    return bisection.mesh(
        SizeField(
            cells.ring_edges,
            rim_size=size,
            ring_size=size,
            growth=growth,
            truncation=FAR_TRUNCATION,
            centre_size=cells.largest,
            far_size=triangles.FAR_SIZE_BELOW_CELLS,
            cells=cells,
        )
    )
