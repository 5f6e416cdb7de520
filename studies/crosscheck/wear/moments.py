"""Compute the moments of a profile, which represent the punch face in contact problems.

The height that the elements of a space cannot resolve is computed, too.
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legvander

from ....meshes.pressure_space import PressureSpace, shapes
from ....meshes.radial import Array, Indices, ring_of, unit_gauss
from ..problem.profile import InitialProfile


def moments(profile: InitialProfile, space: PressureSpace, radius: float = 1.0) -> Array:
    """Return the moments (size,) ``int f phi_i dA`` of a profile f.

    The integrals are broken at kinks of the profile and at ring edges.

    Parameters
    ----------
    profile : InitialProfile
        Heights of the punch face.
    space : PressureSpace
        Space on the face, or on a smaller disc that is scaled to the unit disc.
    radius : float
        Radius of that disc. The integrals are over the unit disc.
    """
    points = _points(profile, space, radius)
    values = shapes(points.local, space.top)
    parts = np.einsum(
        "eq,eqi->ei", 2 * np.pi * points.radii * points.weights * points.heights, values
    )
    result = np.zeros(space.size + 1)
    np.add.at(result, space.dofs[points.element], parts)
    return result[:-1]


def unresolved_height(profile: InitialProfile, space: PressureSpace, depth: float) -> float:
    """Return the greatest difference between the face and its best parabola on any element.

    The parabolas are least-squares fits. The elements represent a face that is smooth in each. The
    indentations of two faces under the same force differ by at most the difference of the faces, so
    the result bounds the error of the indentation.

    Parameters
    ----------
    profile : InitialProfile
        Heights of the punch face.
    space : PressureSpace
        Space on the face.
    depth : float
        Elements on which all heights are greater than this indentation cannot touch and are
        ignored.
    """
    points, count = _points(profile, space, 1.0), len(space.degrees)
    legendre = legvander(points.local, 2)
    # in the local coordinate, elements have length 2
    lengths = np.diff(space.breakpoints)[points.element, None]
    parts = np.einsum(
        "eq,eqj->ej", points.weights / lengths * points.heights, legendre * (2 * np.arange(3) + 1)
    )
    parabolas = np.zeros((count, 3))
    np.add.at(parabolas, points.element, parts)
    missed = np.abs(points.heights - np.einsum("eqj,ej->eq", legendre, parabolas[points.element]))
    least = np.full(count, np.inf)
    np.minimum.at(least, points.element, points.heights.min(axis=1))
    touched = least[points.element] <= depth
    return float(missed.max(axis=1)[touched].max(initial=0.0))


class _Points(NamedTuple):
    """Q Gauss points in each of P pieces of elements.

    Parameters
    ----------
    element : (P,) array of int
        Index of the element of each piece.
    radii, local : (P, Q) arrays
        Radii, and coordinates from -1 to 1 within the element.
    weights : (P, Q) array
        Weights of ``dr``.
    heights : (P, Q) array
        Heights of the profile.
    """

    element: Indices
    radii: Array
    local: Array
    weights: Array
    heights: Array


def _points(profile: InitialProfile, space: PressureSpace, radius: float) -> _Points:
    """Return Gauss points on the pieces between breakpoints, kinks and ring edges."""
    edges = np.concatenate([profile.ring_edges, profile.kinks]) / radius
    cuts = np.union1d(space.breakpoints, edges[(edges > 0) & (edges < 1)])
    # more points than polynomials of that degree need, because heights may be any function
    node, weight = unit_gauss(space.top + 8)
    width = np.diff(cuts)[:, None]
    element = np.searchsorted(space.breakpoints, cuts[:-1], side="right") - 1
    radii = cuts[:-1, None] + width * node
    start, size = space.breakpoints[element, None], np.diff(space.breakpoints)[element, None]
    # computed from coordinates within the element: radii have too few digits in small elements
    local = 2 * (cuts[:-1, None] - start + width * node) / size - 1
    ring = np.broadcast_to(
        ring_of(profile.ring_edges, radius * (cuts[:-1] + cuts[1:]) / 2)[:, None], radii.shape
    )
    heights = profile.in_ring(np.minimum(radius * radii, 1.0), ring)
    return _Points(element, radii, local, width * weight, heights)
