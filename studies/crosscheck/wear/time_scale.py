"""Predict the time scale of running-in before a run: the slowest relaxation time of a coarse MDR.

The slowest mode has a long wavelength, so a few elements in each ring represent it. A face that is
not flat first wears until all of it is in contact, which happens about when the rigid overlap (all
that protrudes from the flat face) has worn off.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from ....mdr.energy import compliance
from ....meshes.compliance import Compliance
from ....meshes.ground.ground import HALF_SPACE, Ground
from ....meshes.pressure_space import BandedCholesky, PressureSpace
from ....meshes.radial import Array
from ..problem.problem import Problem, Rings
from ..problem.sections import RUNNING_IN
from .modes import slowest_times

# a function that returns the compliance of the half-space on a pressure space
HalfSpaceOn = Callable[[PressureSpace, Ground], Compliance]
# greatest number of rings; with more, the prediction would take longer than many runs do
MOST_RINGS = 64
# (polynomial degree, element size at the rim in punch radii, ratio of neighbouring element sizes):
# `COARSE` gives a few digits, and `FINE` more digits to check these
COARSE, FINE = (3, 1e-3, 0.3), (6, 1e-6, 0.2)
# least number of elements across a ring: all of the eight slowest modes may lie on one ring, where
# the eighth then has two half-waves in each element
ELEMENTS_PER_RING = 4


def running_in(problem: Problem, counts: Sequence[float]) -> Array:
    """Return multiples of the slowest relaxation time of the full face (T,), non-dimensional.

    If the face is not flat and `counts` are those of ``times = "running-in"``, the result is
    instead the time 0 and a geometric sequence of times. It begins when the contact first spreads
    and ends the last of `counts` relaxation times after full contact.

    Parameters
    ----------
    problem : Problem
        Problem whose running-in is predicted.
    counts : sequence of float
        The multiples.
    """
    slowest = slowest_relaxation_time(problem)
    if problem.full_contact or list(counts) != RUNNING_IN:
        return slowest * np.array(counts)
    first_time, overlap_time = spreading_times(problem)
    return np.append(
        0.0, np.geomspace(first_time, overlap_time + RUNNING_IN[-1] * slowest, 2 * len(counts))
    )


def spreading_times(problem: Problem) -> tuple[float, float]:
    """Estimate when contact first spreads, and when it becomes full, non-dimensional.

    Contact widens noticeably after wear by a hundredth of the first indentation d. That indentation
    is about the solution of ``2 d sqrt(A / pi) = F`` with the area A of the face below the plane at
    depth d. Under a force, contact becomes full at about `Problem.time_to_wear_flat`. Under a fixed
    indentation the second time is 0, because the relaxation modes alone determine the running-in.
    """
    radii, heights = problem.profile.sampled()
    areas = np.pi * np.diff(radii**2)
    means = (heights[1:] + heights[:-1]) / 2
    order = np.argsort(means)
    depths, cut_areas = means[order], np.cumsum(areas[order])
    stiffness = 2 * np.sqrt(cut_areas / np.pi)
    if problem.indentation is None:
        overlap_time = problem.time_to_wear_flat
        index = int(np.searchsorted(depths * stiffness, 1.0))
    else:
        overlap_time, index = 0.0, int(np.searchsorted(depths, problem.indentation)) - 1
    index = min(max(index, 0), len(cut_areas) - 1)
    # time = 0.01 d / mean pressure, and mean pressure = stiffness d / area
    return float(0.01 * cut_areas[index] / stiffness[index]), overlap_time


def slowest_relaxation_time(problem: Problem) -> float:
    """Return the slowest relaxation time, non-dimensional, to a few digits.

    It is NaN for more than `MOST_RINGS` rings.
    """
    fixed = problem.indentation is not None
    times = slowest_relaxation_times(problem.merged, fixed, ground=problem.ground)
    return float(times[0]) if len(times) else float("nan")


def slowest_relaxation_times(
    rings: Rings,
    fixed: bool,
    sizes: tuple[int, float, float] = COARSE,
    half_space: HalfSpaceOn = compliance,
    ground: Ground = HALF_SPACE,
) -> Array:
    """Return the slowest relaxation times (m,), non-dimensional, to a few digits.

    The modes are pressures that carry no force, or any pressures at a fixed indentation. The array
    is empty for more than `MOST_RINGS` rings.

    Parameters
    ----------
    rings : Rings
        Ring edges and wear coefficients.
    fixed : bool
        Whether the indentation is given.
    sizes : tuple
        Polynomial degree, element size at the rim, and ratio of neighbouring element sizes.
    half_space : callable
        Returns the compliance on a pressure space.
    ground : Ground, optional
        Layers.
    """
    if len(rings.widths) > MOST_RINGS:
        return np.empty(0)
    coefficients = tuple(map(tuple, rings.wear_coefficients))
    return _slowest_times(tuple(rings.ring_edges), coefficients, fixed, sizes, half_space, ground)


@lru_cache(maxsize=8)  # the anchors of every method use the same result
def _slowest_times(
    ring_edges: tuple[float, ...],
    wear_coefficients: tuple[tuple[float, ...], ...],
    fixed: bool,
    sizes: tuple[int, float, float],
    half_space: HalfSpaceOn,
    ground: Ground,
) -> Array:
    degree, rim_size, grading = sizes
    rings = Rings(np.array(ring_edges), np.array(wear_coefficients))
    smallest = np.append(0.2 * rings.narrower, min(rim_size, 0.1 * rings.widths[-1]))
    space = PressureSpace.graded(rings.ring_edges, smallest, grading, degree)
    widest = rings.widths[space.ring] / ELEMENTS_PER_RING
    space = space.no_wider(np.minimum(widest, ground.first_thickness))
    to_pressure = space.joined(rings.wear_coefficients)
    mass = BandedCholesky(to_pressure.T @ space.mass(rings.wear_coefficients) @ to_pressure)
    factor = mass.forward(to_pressure.T @ half_space(space, ground).factor.T)
    weights = None if fixed else mass.forward(to_pressure.T @ space.weights)
    return slowest_times(factor @ factor.T, weights)
