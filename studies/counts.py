"""Unknowns of the finite elements by counting, before any mesh is made."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from meshes.half_space import SizeField
from meshes.radial import Array
from meshes.stars import LARGEST_FILL, fill_sizes, star_shells

from . import stars, triangles
from .natural import NaturalScene

SIDE = np.sqrt(3) / 4  # area of an equilateral triangle of side one
MULTIPLIERS_PER_FACET = 2.6
# a mesh of whole triangles has more of them than its size field asks for, the more so where it is coarse
# (measured on random scenes: unknowns and multipliers by the counts below, within 25 %)
MORE_UNKNOWNS, LEAST_UNKNOWNS = 1.3, 1300
MORE_PRESSURES, LEAST_PRESSURES = 1.25, 35
MORE_BETWEEN, MORE_ON_CONTACT = 1.7, 1.2
BISECTION = 2.6  # triangles by bisection for one by gmsh, at equal sizes


def counted(natural: NaturalScene) -> tuple[int, int]:
    """Unknowns and pressures of the finite elements that a scene asks for."""
    return _on_stars(natural) if natural.scene.accuracy.fem.meshed_by == "stars" else _on_triangles(natural)


def _on_triangles(natural: NaturalScene) -> tuple[int, int]:
    field, degree = triangles.size_field(natural), triangles.degree(natural)
    cells = count_triangles(field, field.truncation)
    if natural.scene.accuracy.fem.mesher == "bisection":
        cells *= BISECTION
    unknowns = degree**2 * (MORE_UNKNOWNS * cells + LEAST_UNKNOWNS / 16)
    return round(unknowns), round(MORE_PRESSURES * MULTIPLIERS_PER_FACET * count_facets(field)) + LEAST_PRESSURES


def _on_stars(natural: NaturalScene) -> tuple[int, int]:
    chosen, (edges, _) = stars.settings(natural), natural.phases
    half_widths, layers = star_shells(edges, chosen.sizes, chosen.rim_size, stars.GRADING)
    # degree of each shell, from the innermost on; the core has the lowest
    within = np.arange(layers.sum()) - np.repeat(np.cumsum(layers) - layers, layers)
    lowest = stars.lowest_degree(natural)
    degrees = np.minimum(chosen.degree, lowest + within)
    quadrilaterals = 4 * np.sum(degrees**2) + 2 * len(layers) * lowest**2
    truncation = natural.scene.accuracy.fem.truncation

    def between(points: Array) -> Array:
        return _between_stars(points, edges[1:], half_widths, truncation)

    cells = MORE_BETWEEN * count_triangles(between, truncation)
    # of every star both sides are on the contact, of that at the rim one
    rim = np.sum(degrees[-layers[-1] :] - 2) + lowest - 2
    inside = 2 * (np.sum(degrees - 2) + (lowest - 2) * len(layers)) - rim
    ends = np.append(edges[1:-1] + half_widths[:-1], 1.0), np.append(edges[1:-1] - half_widths[:-1], 1 - half_widths[-1])
    open_line = zip(np.append(0.0, ends[0][:-1]), ends[1], strict=True)
    facets = sum(max(1.0, _facets(between, start, stop)) for start, stop in open_line)
    unknowns = 2 * quadrilaterals + cells * chosen.degree**2
    on_contact = inside + facets * (chosen.degree - 2) + len(layers)
    return round(unknowns), round(MORE_ON_CONTACT * on_contact)


def _facets(field: Callable[[Array], Array], start: float, stop: float) -> float:
    """Facets of the sizes of a field between two radii on the surface."""
    radii = start + (stop - start) * (np.arange(32) + 0.5) / 32
    return float(np.mean(1 / field(np.stack([radii, np.zeros_like(radii)], axis=1)))) * (stop - start)


def _between_stars(points: Array, centres: Array, half_widths: Array, truncation: float) -> Array:
    """Sizes of the triangles between the stars."""
    size, beside = np.full(len(points), LARGEST_FILL * truncation), fill_sizes(half_widths)
    for smallest in np.unique(beside):
        singular = np.stack([centres[beside == smallest], np.zeros((beside == smallest).sum())], axis=1)
        distance = np.maximum(cKDTree(singular).query(points)[0] - smallest, 0.0)
        size = np.minimum(size, smallest + stars.GROWTH * distance)
    return size


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
