"""Moments of a profile against the pressures of a space.

All that contact knows of the punch face, and what they miss.
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial.legendre import legvander

from ...meshes.pressure_space import PressureSpace, shapes
from ...meshes.radial import Array, Indices, ring_of, unit_gauss
from ..problem.profile import InitialProfile


def moments(profile: InitialProfile, space: PressureSpace, radius: float = 1.0) -> Array:
    """Return the moments (size,) ``int f phi_i dA`` of a profile f.

    The integrals are broken at kinks of the profile and at ring edges.

    Parameters
    ----------
    profile : of the punch
    space : on the face, or on a disc within it as its own unit disc
    radius : of that disc; areas are those of the unit disc
    """
    at = _points(profile, space, radius)
    values = shapes(at.local, space.top)
    parts = np.einsum("eq,eqi->ei", 2 * np.pi * at.radii * at.weights * at.heights, values)
    out = np.zeros(space.size + 1)
    np.add.at(out, space.dofs[at.element], parts)
    return out[:-1]


def unresolved_height(profile: InitialProfile, space: PressureSpace, depth: float) -> float:
    """Return by how much the face differs from a parabola on any element that can touch.

    Indentations under one force differ by no more than the two faces do: the elements see a face
    that is smooth in each.

    Parameters
    ----------
    profile : of the punch
    space : on the face
    depth : indentation that elements whose heights are all greater do not feel
    """
    at, count = _points(profile, space, 1.0), len(space.degrees)
    legendre = legvander(at.local, 2)
    # lengths of elements are two in the local coordinate
    lengths = np.diff(space.breakpoints)[at.element, None]
    parts = np.einsum(
        "eq,eqj->ej", at.weights / lengths * at.heights, legendre * (2 * np.arange(3) + 1)
    )
    parabolas = np.zeros((count, 3))
    np.add.at(parabolas, at.element, parts)
    missed = np.abs(at.heights - np.einsum("eqj,ej->eq", legendre, parabolas[at.element]))
    least = np.full(count, np.inf)
    np.minimum.at(least, at.element, at.heights.min(axis=1))
    touched = (least[at.element] <= depth) & (space.degrees[at.element] > 0)
    return float(missed.max(axis=1)[touched].max(initial=0.0))


class _Points(NamedTuple):
    """Gauss points of pieces of elements.

    Element (P,), and (P, Q) radii, coordinates within it, weights of dr, heights.
    """

    element: Indices
    radii: Array
    local: Array
    weights: Array
    heights: Array


def _points(profile: InitialProfile, space: PressureSpace, radius: float) -> _Points:
    """Return Gauss points between breakpoints, kinks and ring edges."""
    edges = np.concatenate([profile.ring_edges, profile.kinks]) / radius
    cuts = np.union1d(space.breakpoints, edges[(edges > 0) & (edges < 1)])
    # more than a polynomial of its degree needs: heights may be anything
    node, weight = unit_gauss(space.top + 8)
    width = np.diff(cuts)[:, None]
    element = np.searchsorted(space.breakpoints, cuts[:-1], side="right") - 1
    radii = cuts[:-1, None] + width * node
    left, whole = space.breakpoints[element, None], np.diff(space.breakpoints)[element, None]
    # by coordinates within the elements: by radii, those of small ones would lose digits
    local = 2 * (cuts[:-1, None] - left + width * node) / whole - 1
    ring = np.broadcast_to(
        ring_of(profile.ring_edges, radius * (cuts[:-1] + cuts[1:]) / 2)[:, None], radii.shape
    )
    heights = profile.in_ring(np.minimum(radius * radii, 1.0), ring)
    return _Points(element, radii, local, width * weight, heights)
