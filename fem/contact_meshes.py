"""Finite-element half-spaces for contact on a part of the punch face."""

from dataclasses import replace

import numpy as np

from ..meshes import bisection
from ..meshes.contact_cells import ContactCells
from ..meshes.half_space import halved
from ..meshes.pressure_space import PressureSpace
from ..meshes.quads import graded
from ..meshes.radial import Array, Indices
from ..meshes.sizes import SizeField
from .elasticity import AxisymmetricElasticity
from .far_field import enough_poles
from .half_space import HalfSpace, contact_breakpoints, pressure_space

# increase of the triangle size per depth
TRIANGLE_GROWTH = 0.6
# the same on the coarser half-space of the error estimate
COARSER_GROWTH = 0.9


def fitted_half_space(
    edges: tuple[float, ...], infinite: tuple[bool, ...], degree: int, poisson_ratio: float
) -> HalfSpace:
    """Return a half-space of quadrilaterals with geometric layers round every edge of a contact.

    Parameters
    ----------
    edges : edges of the contact, from 0 to 1; the pressure space is broken at each
    infinite : whether the pressure is infinite at each edge
    degree : degree of the displacement, two above that of the pressure
    poisson_ratio : Poisson's ratio of the half-space
    """
    marks = np.array(edges)

    def root_amplitude(distance: Array, *_: Array | Indices) -> Array:
        # amplitude of high degrees: near an edge the pressure varies as sqrt(distance) or its
        # inverse
        return np.sqrt(distance)

    # Size at an edge where the pressure is infinite, and at one where it falls to zero. On smaller
    # elements the stiffness would lose digits.
    sizes = np.where(infinite, 1e-10, 2.5e-7)[1:]
    # layers near the axis, where the pressure under a cone has a logarithmic singularity
    axis_layer_radius = 1e-2
    if edges[1] > 4 * axis_layer_radius:
        marks, sizes = (
            np.insert(marks, 1, axis_layer_radius),
            np.insert(sizes, 0, axis_layer_radius),
        )
    mesh = graded(marks, sizes[:-1], float(sizes[-1]), 0.25, 0.8, 2.5, root_amplitude).mesh
    solid = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    # moments of the face are integrated between rounded radii, and so must the pressures be
    space = replace(pressure_space(solid, marks), low_parts=None)
    return HalfSpace(solid, space, enough_poles(2.5, 1e-10))


def even_half_space(
    cells: ContactCells,
    poisson_ratio: float,
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
    poisson_ratio : Poisson's ratio of the half-space
    growth : increase of the triangle size per depth
    degree : degree of the displacement
    halvings : number of times that every triangle is halved for the displacement, at least 1 for
        degree 1
    """
    edges, size = cells.ring_edges, cells.edge_size
    field = SizeField(edges, size, size, growth, 5.0, cells.largest, 0.125, cells)
    mesh = bisection.mesh(field)
    breakpoints, low_parts = contact_breakpoints(mesh, np.array(edges))
    linear = np.where((breakpoints[1:] <= edges[1]) & cells.hollow, 0, 1)
    space = PressureSpace(breakpoints, linear, np.array(edges), low_parts)
    if halvings:
        mesh = halved(mesh, np.array(edges), halvings)
    solid = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    return HalfSpace(solid, space, enough_poles(5.0, 1e-10))
