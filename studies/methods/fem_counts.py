"""Unknowns of the finite elements by counting, before any mesh is made."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from ringwear.meshes.patches import LARGEST, LOWEST, beside, falls, patch_layers, patch_widths
from ringwear.meshes.radial import Array
from ringwear.meshes.size_field import SizeField
from ringwear.studies.methods import quads, triangles
from ringwear.studies.problem.problem import NaturalScene
from scipy.spatial import cKDTree

SIDE = np.sqrt(3) / 4  # area of an equilateral triangle of side one
MULTIPLIERS_PER_FACET = 2.6
# a mesh of whole triangles has more of them than its size field asks for, the more so where it is coarse
# (measured on random scenes: unknowns and multipliers by the counts below, within 25 %)
MORE_UNKNOWNS, LEAST_UNKNOWNS = 1.3, 1300
MORE_PRESSURES, LEAST_PRESSURES = 1.25, 35
MORE_BETWEEN, LEAST_BETWEEN, PER_QUAD = 2.8, 18, 1.58
BISECTION = 2.6  # triangles by bisection for one by gmsh, at equal sizes


def counted(natural: NaturalScene) -> tuple[int, int]:
    """Unknowns and pressures of the finite elements that a scene asks for."""
    return _on_quads(natural) if natural.scene.accuracy.fem.meshed_by == "quads" else _on_triangles(natural)


def _on_triangles(natural: NaturalScene) -> tuple[int, int]:
    field, degree = triangles.size_field(natural), triangles.degree(natural)
    cells = count_triangles(field, field.truncation)
    if natural.scene.accuracy.fem.mesher == "bisection":
        cells *= BISECTION
    unknowns = degree**2 * (MORE_UNKNOWNS * cells + LEAST_UNKNOWNS / 16)
    return round(unknowns), round(MORE_PRESSURES * MULTIPLIERS_PER_FACET * count_facets(field)) + LEAST_PRESSURES


def _on_quads(natural: NaturalScene) -> tuple[int, int]:
    chosen, (edges, _) = quads.settings(natural), natural.phases
    widths = patch_widths(edges)
    layers = patch_layers(widths, np.append(chosen.sizes, chosen.rim_size), quads.FACTOR)
    degrees = np.maximum(chosen.degree - np.concatenate(falls(layers)), min(LOWEST, chosen.degree))
    # four elements to a layer, two in the middle
    count = np.full(len(degrees), 4)
    count[np.cumsum(layers + 1) - 1] = 2
    singular = np.stack([edges[1:], np.zeros_like(edges[1:])], axis=1)
    sizes, depths = beside(widths), widths.mean(axis=1)

    def between(points: Array) -> Array:
        size = np.full(len(points), LARGEST * chosen.truncation)
        for smallest in np.unique(sizes):
            distance, nearest = cKDTree(singular[sizes == smallest]).query(points)
            distance = np.maximum(distance - depths[sizes == smallest][nearest], 0.0)
            size = np.minimum(size, smallest + chosen.growth * distance)
        return size

    cells = MORE_BETWEEN * max(count_triangles(between, chosen.truncation) / 2, LEAST_BETWEEN)
    # of every patch both sides are on the contact, of that at the rim one
    at_rim = len(degrees) - layers[-1] - 1
    pressures = np.maximum(degrees - 2, 1)
    on_contact = 2 * pressures.sum() - pressures[at_rim:].sum()
    unknowns = PER_QUAD * (np.sum(count * degrees**2) + cells * chosen.degree**2)
    gaps = np.maximum(np.append(edges[1], np.diff(edges[1:])) - np.append(0.0, widths[:-1, 1]) - widths[:, 0], 0.0)
    facets = np.sum(np.where(gaps > 1e-9, np.maximum(2, gaps / np.minimum(depths, np.append(np.inf, depths[:-1]))), 0))
    return round(unknowns), round(on_contact + facets * max(chosen.degree - 2, 1) + len(layers))


def count_triangles(field: Callable[[Array], Array], truncation: float) -> float:
    """Triangles that a size field asks for: its area in triangles of the local size, summed over a quadtree."""
    corner, side, total = np.zeros((1, 2)), truncation, 0.0
    while len(corner):
        centre = corner + side / 2
        size = field(centre)
        # a leaf is smaller than the local element: the field hardly changes in it
        leaf = side <= size
        inside = np.hypot(*centre.T) < truncation
        total += float(np.sum((side**2 / (SIDE * size**2))[leaf & inside]))
        split = corner[~leaf]
        side /= 2
        corner = (split[:, None] + side * np.array([[0, 0], [0, 1], [1, 0], [1, 1]])).reshape(-1, 2)
    return total


def count_facets(field: SizeField) -> float:
    """Facets on the contact line that a size field asks for."""
    edges = np.array(field.edges)
    total = 0.0
    for inner, outer in itertools.pairwise(edges):
        # crowded at both ends, where the sizes are smallest
        within = np.concatenate([np.geomspace(1e-9, 0.5, 400), 1 - np.geomspace(1e-9, 0.5, 400)[::-1]])
        radii = inner + (outer - inner) * within
        total += float(np.trapezoid(1 / field(np.stack([radii, np.zeros_like(radii)], axis=1)), radii))
    return total
