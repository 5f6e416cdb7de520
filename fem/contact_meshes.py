"""Finite-element half-spaces for contact on part of the face."""

from dataclasses import replace

import numpy as np
from skfem import Mesh

from ..meshes import bisection, cell_triangles
from ..meshes.contact_cells import ContactCells
from ..meshes.ground.ground import Ground
from ..meshes.half_space import halved
from ..meshes.outline import Outline, truncation_beside
from ..meshes.pressure_space import PressureSpace
from ..meshes.quads import graded
from ..meshes.radial import Array, Indices
from ..meshes.sizes import SizeField
from .elasticity import AxisymmetricElasticity
from .far_field import enough_poles
from .half_space import HalfSpace, contact_breakpoints, pressure_space

# growth of triangles with the depth, and that of a coarser half-space, whose difference shows what
# they err by
TRIANGLE_GROWTH = 0.6
COARSER_GROWTH = 0.9
# truncation radius, over the radius of the contact or of the punch, of elements of high degree and
# of layers, and that of triangles on a homogeneous half-space
NEAR_TRUNCATION = 2.5
FAR_TRUNCATION = 5.0
# greatest size of triangles over the truncation radius
FAR_SIZE = 0.125
# share of the energy that the truncation may lose
NEGLIGIBLE_ENERGY = 1e-10


def fitted_half_space(
    edges: tuple[float, ...],
    infinite: tuple[bool, ...],
    degree: int,
    poisson_ratio: float,
    ground: Ground | None = None,
) -> HalfSpace:
    """Return quadrilaterals of high degree in geometric layers round every edge of a contact.

    Parameters
    ----------
    edges : from 0 to 1; the pressure space is broken at each
    infinite : at which of them the pressure is infinite
    degree : of the displacement, two above that of the pressure
    poisson_ratio : of the half-space
    ground : layers, with lengths over the radius of the contact; homogeneous if not given
    """
    marks = np.array(edges)

    def as_root(distance: Array, *_: Array | Indices) -> Array:
        # what stands behind high degrees: pressures rise or fall at edges as a root
        return np.sqrt(distance)

    # infinite as a root, or falling to zero as one: smaller still, stiffnesses would lose digits
    sizes = np.where(infinite, 1e-10, 2.5e-7)[1:]
    # layers beside the axis, where a cone's pressure is infinite as a logarithm
    beside_axis = 1e-2
    if edges[1] > 4 * beside_axis:
        marks, sizes = np.insert(marks, 1, beside_axis), np.insert(sizes, 0, beside_axis)
    interfaces = () if ground is None else tuple(ground.depths.tolist())
    mesh = graded(
        marks,
        sizes[:-1],
        float(sizes[-1]),
        factor=0.25,
        growth=0.8,
        outer=truncation_beside(interfaces, NEAR_TRUNCATION),
        edge_amplitude=as_root,
        interfaces=interfaces,
        rigid=ground is not None and ground.rigid,
    ).mesh
    solid = AxisymmetricElasticity.on_ground(mesh, degree, poisson_ratio, ground)
    # moments of the face are taken between rounded radii: pressures have to be, too
    space = replace(pressure_space(solid, marks), low_parts=None)
    poles = enough_poles(NEAR_TRUNCATION, NEGLIGIBLE_ENERGY)
    return HalfSpace(solid, space, poles).without_dependent_poles()


def even_half_space(
    cells: ContactCells,
    poisson_ratio: float,
    growth: float = TRIANGLE_GROWTH,
    degree: int = 3,
    halvings: int = 0,
    ground: Ground | None = None,
) -> HalfSpace:
    """Return a half-space of triangles of one degree with piecewise linear contact pressures.

    The pressure is linear on each facet of a mesh whose facets are no larger than the cells, and
    may break at ring edges. The displacement has that mesh, or one halved from it: beneath linear
    displacements, pressures are stable if they have larger facets.

    Parameters
    ----------
    cells : of the contact
    poisson_ratio : of the half-space
    growth : of triangles with the depth
    degree : of the displacement
    halvings : times that every triangle is halved for the displacement, at least 1 for degree 1;
        none on layers
    ground : layers, whose interfaces gmsh makes lines of the mesh; homogeneous if not given
    """
    edges = cells.ring_edges
    if ground is None:
        mesh, outer = _triangles_by_bisection(cells, growth), FAR_TRUNCATION
    else:
        interfaces = tuple(ground.depths.tolist())
        outer = truncation_beside(interfaces, NEAR_TRUNCATION)
        outline = Outline.of_layers(outer, interfaces, ground.rigid)
        mesh = cell_triangles.mesh(cells, growth, outline)
    breakpoints, below = contact_breakpoints(mesh, np.array(edges))
    linear = np.where((breakpoints[1:] <= edges[1]) & cells.hollow, 0, 1)
    space = PressureSpace(breakpoints, linear, np.array(edges), below)
    if halvings:
        mesh = halved(mesh, np.array(edges), halvings)
    solid = AxisymmetricElasticity.on_ground(mesh, degree, poisson_ratio, ground)
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
            far_size=FAR_SIZE,
            cells=cells,
        )
    )
