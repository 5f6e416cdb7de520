"""The time scale of running-in, before a run: the slowest relaxation time, by a coarse MDR.

The slowest mode is a long wave, for which a few elements in each ring are enough. A face that is
not flat first wears until all of it carries, about when its rigid overlap has worn off.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from ...mdr.energy import compliance
from ...meshes.compliance import Compliance
from ...meshes.ground.ground import Ground
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, graded_breakpoints
from ..problem.problem import Problem, Rings
from ..problem.sections import RUNNING_IN
from .modes import BandedCholesky, slowest_times

# gives the compliance of the half-space on a pressure space
HalfSpaceOn = Callable[[PressureSpace, Ground | None], Compliance]
# with more rings it would take longer than many a run
MOST_RINGS = 64
# degree, size at the rim and ratio of neighbouring sizes: a few digits; and more, to check them
COARSE, FINE = (3, 1e-3, 0.3), (6, 1e-6, 0.2)


def running_in(problem: Problem, counts: Sequence[float]) -> Array:
    """Return counts (T,) of the slowest relaxation time of the full face, non-dimensional.

    Those of all of the running-in of a face that is not flat go from when it first spreads.
    """
    slowest = slowest_relaxation_time(problem)
    if problem.full_contact or list(counts) != RUNNING_IN:
        return slowest * np.array(counts)
    first, overlap = spreading(problem)
    return np.append(0.0, np.geomspace(first, overlap + RUNNING_IN[-1] * slowest, 2 * len(counts)))


def spreading(problem: Problem) -> tuple[float, float]:
    """Return about when contact first spreads, and when all of the face carries, non-dimensional.

    A wear that is a hundredth of the first indentation widens contact; that is about d of ``2 d
    sqrt(A / pi) = F`` with the area A that the plane at d cuts off. A force wears off the rigid
    overlap in the time to wear flat; a fixed indentation has no more to wear than its modes do: 0.
    """
    radii, heights = problem.profile.sampled()
    areas = np.pi * np.diff(radii**2)
    means = (heights[1:] + heights[:-1]) / 2
    order = np.argsort(means)
    depths, cut = means[order], np.cumsum(areas[order])
    stiffness = 2 * np.sqrt(cut / np.pi)
    if problem.indentation is None:
        overlap = problem.time_to_wear_flat
        at = int(np.searchsorted(depths * stiffness, 1.0))
    else:
        overlap, at = 0.0, int(np.searchsorted(depths, problem.indentation)) - 1
    at = min(max(at, 0), len(cut) - 1)
    # d over the mean pressure, which is stiffness times d over the area
    return float(0.01 * cut[at] / stiffness[at]), overlap


def slowest_relaxation_time(problem: Problem) -> float:
    """Return the slowest relaxation time, non-dimensional, to a few digits.

    NaN for more than `MOST_RINGS`.
    """
    fixed = problem.indentation is not None
    times = slowest_relaxation_times(problem.merged, fixed, ground=problem.ground)
    return float(times[0]) if len(times) else float("nan")


def slowest_relaxation_times(
    rings: Rings,
    fixed: bool,
    sizes: tuple[int, float, float] = COARSE,
    half_space: HalfSpaceOn = compliance,
    ground: Ground | None = None,
) -> Array:
    """Return the slowest relaxation times (m,), non-dimensional, to a few digits.

    They are those of pressures that carry no force, or of all pressures at a fixed indentation.
    There are none for more than `MOST_RINGS`.

    Parameters
    ----------
    rings : with their wear coefficients
    fixed : whether the indentation is given
    sizes : degree, size at the rim, and ratio of neighbouring sizes
    half_space : gives the compliance on a pressure space
    ground : layers, if there are any
    """
    if len(rings.widths) > MOST_RINGS:
        return np.empty(0)
    ends = tuple(map(tuple, rings.ends))
    return _slowest_times(tuple(rings.ring_edges), ends, fixed, sizes, half_space, ground)


@lru_cache(maxsize=8)  # the anchors of every method ask for it
def _slowest_times(
    ring_edges: tuple[float, ...],
    wear_coefficients: tuple[tuple[float, ...], ...],
    fixed: bool,
    sizes: tuple[int, float, float],
    half_space: HalfSpaceOn,
    ground: Ground | None,
) -> Array:
    degree, rim, grading = sizes
    rings = Rings(np.array(ring_edges), np.array(wear_coefficients))
    breakpoints = graded_breakpoints(
        rings.ring_edges, 0.2 * rings.narrower, min(rim, 0.1 * rings.widths[-1]), grading
    )
    in_hole = (breakpoints[1:] <= rings.ring_edges[1]) & rings.hollow
    space = PressureSpace(breakpoints, np.where(in_hole, 0, degree), rings.ring_edges)
    if ground is not None:
        space = space.no_wider(ground.first_thickness)
    to_pressure = space.joined(rings.wear_coefficients)
    mass = BandedCholesky(to_pressure.T @ space.mass(rings.wear_coefficients) @ to_pressure)
    factor = mass.forward(to_pressure.T @ half_space(space, ground).factor.T)
    weights = None if fixed else mass.forward(to_pressure.T @ space.weights)
    return slowest_times(factor @ factor.T, weights)
