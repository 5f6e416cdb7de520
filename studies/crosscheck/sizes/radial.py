"""Sizes and degrees of the radial mesh of dimensionality reduction and of boundary elements.

Lengths are in punch radii a. The comment on a constant names the test under `tests/` or the study
that justifies it.
"""

from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np

from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array, Indices
from ....meshes.sizes import degree_reduction
from ..problem.problem import Problem
from .degrees import degree_of_modes, pressure_degree, with_affordable_field_tolerance
from .layers import narrowed_for_layers
from .ring_edges import RADIAL_ROUNDOFF, axis_size, rim_size, ring_sizes, smallest_size

# Size ratio of neighbouring elements. A larger ratio needs more elements to reach the same smallest
# size, a smaller one a higher degree on each (physics/test_size_rules.py, `ringwear study
# tradeoff`).
RADIAL_GRADING = 0.2
# Highest degree of the pressure.
HIGHEST_DEGREE = 20
# Strength of a kink of the wear coefficient (`Rings.kinks`) below which an edge needs no layer.
WEAK_KINK = 0.1
# Largest size at an edge of a ring over the width of the ring.
LARGEST_PART_OF_RING = 0.1


@dataclass(frozen=True, eq=False)
class RadialSizes:
    """Sizes of a radial mesh, chosen once for a run.

    Parameters
    ----------
    degree : highest degree of the pressure
    rim_size : wanted size at the rim
    ring_size : wanted size at the other ring edges, one number or (M-1,), one for each
    grading : size ratio of neighbouring elements
    degree_of_modes : degree that smooth modes need on the largest elements
    axis_size : wanted size at the axis; None if the solution is smooth there
    """

    degree: int
    rim_size: float
    ring_size: float | Array
    grading: float
    degree_of_modes: int = 1
    axis_size: float | None = None

    @property
    def summary(self) -> dict[str, float]:
        """The sizes by name; the smallest where each ring edge has its own."""
        sizes = {field.name: getattr(self, field.name) for field in fields(self)}
        chosen = {name: size for name, size in sizes.items() if size is not None and np.size(size)}
        return {name: np.min(size).item() for name, size in chosen.items()}

    def space(self, problem: Problem) -> PressureSpace:
        """Return the space of a problem, whose degrees rise away from the singular points.

        In the largest elements the degrees are at least those that smooth modes need. At each of
        its edges, a ring has a layer that is no wider than a tenth of the ring, even if the wanted
        sizes are larger. An edge where the wear coefficient has only a weak kink may have none.
        """
        rings = problem.merged
        part_of_ring = np.where(rings.kinks < WEAK_KINK, 1.0, LARGEST_PART_OF_RING)
        part_of_ring[-1] = LARGEST_PART_OF_RING
        wanted = np.append(np.broadcast_to(self.ring_size, len(part_of_ring) - 1), self.rim_size)
        sizes = np.minimum(wanted, part_of_ring * rings.widths_at_edges)
        space = PressureSpace.graded(rings.ring_edges, sizes, self.grading, 1)
        if self.axis_size:
            space = space.with_layers_at_axis(self.axis_size, self.grading)
        space = narrowed_for_layers(space, problem.ground)
        degrees = _degrees(problem, space, self.degree, self.grading, self.degree_of_modes)
        return replace(space, degrees=degrees)


@lru_cache(maxsize=16)
def radial_sizes(problem: Problem) -> RadialSizes:
    """Return the sizes that the tolerance of a problem requires.

    Sizes at ring edges and at the rim are those of `ring_sizes` and `rim_size`, but at least
    `smallest_size`. Degrees are those of `pressure_degree` and `degree_of_modes`, rounded up.
    Values that the scene sets replace these. Shown by
    physics/test_five_rings.py::test_rtol_bounds_the_indentation_by_mdr.
    """
    scene_sizes, grading = problem.mdr, problem.mdr.grading or RADIAL_GRADING
    fields_problem = with_affordable_field_tolerance(problem, grading)
    modes = np.ceil(degree_of_modes(problem))
    degree = np.ceil(pressure_degree(fields_problem, grading))
    smallest = smallest_size(problem, RADIAL_ROUNDOFF)
    at_edges = np.maximum(ring_sizes(problem, fields_problem), smallest)
    return RadialSizes(
        degree=scene_sizes.degree or min(int(degree), HIGHEST_DEGREE),
        rim_size=scene_sizes.rim_size or max(rim_size(problem, fields_problem), smallest),
        ring_size=scene_sizes.ring_size or at_edges,
        grading=grading,
        degree_of_modes=scene_sizes.degree or min(int(modes), HIGHEST_DEGREE),
        axis_size=axis_size(fields_problem),
    )


def _degrees(
    problem: Problem, space: PressureSpace, highest: int, grading: float, of_modes: int
) -> Indices:
    """Return the degree of each element of a space.

    The degree is `highest` where the amplitude of high degrees is largest. Elsewhere it is lower,
    as far as the amplitude allows, but at least 2 and at least the degree that smooth modes need.
    That degree halves from layer to layer towards the edges, because the elements there are several
    times smaller.

    Parameters
    ----------
    problem, space : the problem, and a space with the same elements
    highest : highest degree of the pressure
    grading : size ratio of neighbouring elements
    of_modes : degree that smooth modes need on the largest elements
    """
    edges, ring = problem.merged.ring_edges, space.ring
    at_edges, element = np.searchsorted(space.sort_keys, edges + 0j), np.arange(len(ring))
    # distances of the far end of each element from both edges of its ring
    from_inner = np.where(edges[ring] > 0, space.distance(at_edges[ring], element + 1), np.inf)
    from_outer = space.distance(element, at_edges[ring + 1])
    # amplitudes are those at edges except the centre
    nearest = np.where(from_outer <= from_inner, ring + 1, ring) - int(edges[0] == 0)
    distance, half_width = np.minimum(from_inner, from_outer), np.diff(edges)[ring] / 2
    fields = with_affordable_field_tolerance(problem, grading)
    amplitude = fields.edge_amplitude(distance, half_width, nearest)
    layer = np.log(np.minimum(distance / half_width, 1.0)) / np.log(grading)
    lowest = np.maximum(np.ceil(of_modes * 0.5**layer), 2).astype(np.int64)
    # If `highest` is below the wanted degree, elements whose own wanted degree is possible keep it.
    lacking = max(int(np.ceil(pressure_degree(fields, grading))) - highest, 0)
    # `pressure_degree` counts a hole like a ring at the axis
    hole = edges[:1][edges[:1] > 0]
    in_hole = fields.edge_amplitude(hole, hole / 2, np.zeros(len(hole), dtype=np.int64))
    greatest = float(max(amplitude.max(), in_hole.max(initial=0.0)))
    lowered = highest - degree_reduction(amplitude, greatest, grading, lacking)
    return np.maximum(lowered, np.minimum(lowest, max(highest, of_modes)))
