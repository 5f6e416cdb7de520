"""Unknowns of the finite elements by counting, before any mesh is made.

Within 50 % on random scenes of 1 to 64 rings.

Where neighbouring fields meet, and elements come whole, the factors below were fitted to the meshes
of forty of the scenes that `ringwear study estimates` draws.
"""

import numpy as np

from ...meshes.radial import Array
from ...meshes.sizes import LOWEST, falls, patch_layers, patch_widths
from ..problem.defaults import quad_sizes, triangle_degree, triangle_sizes
from ..problem.problem import Problem

SIDE = np.sqrt(3) / 4  # area of an equilateral triangle of side one
BISECTION = 2.6  # triangles by bisection for one by gmsh, at equal sizes
PER_QUAD = 1.58  # unknowns over the square of the degree


def counted(problem: Problem) -> tuple[int, int]:
    """Unknowns and pressures of the finite elements that a problem asks for."""
    return _on_quads(problem) if problem.fem.meshed_by == "quads" else _on_triangles(problem)


def _on_triangles(problem: Problem) -> tuple[int, int]:
    field, degree = triangle_sizes(problem), triangle_degree(problem)
    sizes = np.array([field.centre_size, *field.ring_sizes, field.rim_size])
    gaps = np.diff(field.ring_edges)
    reach = np.minimum(np.append(gaps[0], gaps), np.append(gaps, np.inf)) / 2
    # in half a disc round each edge; in the column below it, where the size grows with the depth
    cells = (
        92
        + 1.09 * _in_half_discs(sizes, field.growth, reach).sum()
        + 3.85 * 2 * len(reach) / field.growth**2 / SIDE
    )
    cells *= BISECTION if problem.fem.mesher == "bisection" else 1
    facets = (
        np.sum(np.log1p(field.growth * gaps / 2 / np.stack([sizes[:-1], sizes[1:]]))) / field.growth
    )
    return round(degree**2 * cells), round(40 + 3.4 * facets)


def _in_half_discs(size: Array, growth: float, reach: Array) -> Array:
    """Triangles in half a disc whose size grows from its centre.

    Its area over that of the local triangle, integrated.
    """
    grown = growth * reach / size
    return np.asarray(np.pi / growth**2 * (np.log1p(grown) - grown / (1 + grown)) / SIDE)


def _on_quads(problem: Problem) -> tuple[int, int]:
    chosen, rings = quad_sizes(problem), problem.merged
    widths = patch_widths(rings.ring_edges)
    layers = patch_layers(widths, np.append(chosen.ring_sizes, chosen.rim_size), chosen.factor)
    lowered = falls(widths, layers, chosen.factor, chosen.sharpness)
    patches = [np.maximum(chosen.degree - fall, min(LOWEST, chosen.degree)) for fall in lowered]
    # four quadrilaterals to a layer, two in the middle
    in_patches = sum(4 * np.sum(degrees**2) - 2 * degrees[-1] ** 2 for degrees in patches)
    unlike = np.abs(np.diff(np.log2(rings.widths))).sum()
    between = 7.7 + 10 * len(rings.widths) + 2.6 * unlike
    # of every patch both sides are on the contact, of that at the rim one
    sides = [2.0] * (len(patches) - 1) + [1.0]
    pressures = sum(
        side * np.sum(np.maximum(degrees - 2, 1))
        for side, degrees in zip(sides, patches, strict=True)
    )
    pressures += (2 + 0.5 * unlike) * (chosen.degree - 2) + len(layers)
    return round(PER_QUAD * (in_patches + between * chosen.degree**2)), round(pressures)
