"""Moments of a profile against the pressures of a space: what contact knows of the punch face."""

import numpy as np

from ringwear.meshes.pressure_space import PressureSpace, shapes
from ringwear.meshes.radial import Array, ring_of, unit_gauss
from ringwear.studies.problem.profile import InitialProfile

# Gauss points between two kinks of an element, more than a polynomial of its degree needs: heights may be anything
MORE_POINTS = 8


def moments(profile: InitialProfile, space: PressureSpace, radius: float = 1.0) -> Array:
    """(size,) ``int f phi_i dA``; integrals are broken at kinks and at ring edges.

    Parameters
    ----------
    profile : of the punch
    space : on the face, or on a disc within it as its own unit disc
    radius : of that disc; areas are those of the unit disc
    """
    edges = np.concatenate([profile.ring_edges, profile.kinks]) / radius
    cuts = np.union1d(space.breakpoints, edges[(edges > 0) & (edges < 1)])
    node, weight = unit_gauss(space.top + MORE_POINTS)
    width = np.diff(cuts)[:, None]
    element = np.clip(np.searchsorted(space.breakpoints, cuts[:-1], side="right") - 1, 0, len(space.degrees) - 1)
    radii = cuts[:-1, None] + width * node
    left, whole = space.breakpoints[element, None], np.diff(space.breakpoints)[element, None]
    # by coordinates within the elements: by radii, those of small ones would lose digits
    local = 2 * (cuts[:-1, None] - left + width * node) / whole - 1
    ring = np.broadcast_to(ring_of(profile.ring_edges, radius * (cuts[:-1] + cuts[1:]) / 2)[:, None], radii.shape)
    heights = profile.in_ring(np.minimum(radius * radii, 1.0), ring)
    parts = np.einsum("eq,eqi->ei", 2 * np.pi * radii * width * weight * heights, shapes(local, space.top))
    out = np.zeros(space.size + 1)
    np.add.at(out, space.dofs[element], parts)
    return out[:-1]
