"""Default sizes.

Every rule from the wanted accuracy to a size or a degree, with the study that shows it.

`ringwear study tradeoff` shows that no other sizes reach an accuracy much faster, `ringwear study
estimates` that each accuracy is reached on scenes drawn at random, `ringwear study convergence` the
orders behind the powers. Lengths in punch radii.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ...meshes.contact_cells import ContactCells
from ...meshes.radial import Array
from ...meshes.sizes import SizeField, convergence
from ..problem.problem import Problem
from ..problem.quantities import COMPARED_MODES, FINEST
from ..problem.sections import DEGREES

# of the half-space: quadrilaterals with Boussinesq's far field, and anything else (`ringwear study
# truncation`)
TRUNCATION, WIDER_TRUNCATION = 2.5, 5.0
# of quadrilaterals: a layer is smaller by this than the one outside it; elements between the
# patches grow by that
FACTOR, GROWTH = 0.25, 0.5
# relative error of the RMS slope by roundoff, times the size of the smallest elements, in a: of
# finite elements, and of dimensionality reduction and boundary elements. Slopes of elements of size
# h err by roundoff / h. Measured by five rings on elements of 1e-10 to 1e-24 a. That of finite
# elements grows with the ratio of the wear coefficients (up to 1e-20 was measured for 1700), and is
# taken to grow with its power 2/3
FEM_ROUNDOFF, RADIAL_ROUNDOFF = 2e-22, 5e-27
# greatest size that this roundoff may ask for: larger elements would lose more than it takes
GREATEST_OF_SMALLEST = 1e-12
# first time over the slowest relaxation time below which roundoff of the modes is felt, too
EARLIEST_OF_MODES = 1e-16
# a quantity is felt in layers that a mesh has, or its coarser one lacks, if they are thinner than
# this many times its smallest elements: two layers of them
THIN = FACTOR**-2
# slowest modes that a history needs to the accuracy asked for, of which no relaxation time is told
MODES_OF_HISTORIES = 3
# greatest number of pressures: dense matrices of more take more than half a minute
MOST_PRESSURES = 3500


def pressure_degree(problem: Problem, ratio: float) -> float:
    """Return the highest degree of the pressure that an accuracy asks for."""
    half, amplitude = problem.merged.widths / 2, problem.edge_amplitude
    edges = np.arange(len(half))
    greatest = max(
        float(amplitude(half, half, edges).max()),
        float(amplitude(half[1:], half[1:], edges[:-1]).max(initial=0.0)),
    )
    return float(max(_relaxed_degree(np.log(greatest / problem.rtol) / convergence(ratio)), 2))


def _relaxed_degree(degree: Array | float) -> Array | float:
    """Return degrees that are enough, a little below those that the amplitude asks for.

    The estimate of the amplitude asks for more than is needed.
    """
    return degree - np.minimum(0.1 * degree, 0.7)


def degree_of_modes(problem: Problem) -> float:
    """Return the degree that the slowest modes ask for on the ring that has most of them.

    Measured: three relaxation times err by 1e-2, 2e-4, 7e-7, 1e-9 in degrees 4, 6, 8, 10 if all
    are of one ring, by 7e-5, 1e-7, 1e-10 in degrees 4, 6, 8 if two are, by 2e-8 in degree 4 if each
    has one. So another mode on a ring asks for 1.5 degrees more; with eight of them on one ring all
    eight err by less than .02 rtol, from 1e-2 to 1e-6.
    """
    slowest = problem.merged.widths / problem.merged.ends.mean(axis=0)
    count = COMPARED_MODES if problem.wants("relaxation_time") else MODES_OF_HISTORIES
    times = slowest[:, None] / np.arange(1, count + 1)
    most = (times >= np.sort(times, axis=None)[-count]).sum(axis=1).max()
    return float(2.8 - 1.15 * np.log10(problem.rtol) + 1.5 * (most - 3))


def pressures(problem: Problem, ratio: float) -> float:
    """Estimate how many pressures a graded mesh takes.

    The elements of the mesh shrink by a ratio towards every ring edge and the rim.
    """
    half, sizes, amplitude = problem.merged.widths / 2, edge_sizes(problem), problem.edge_amplitude
    total, most = 0.0, pressure_degree(problem, ratio)
    # on the inner side of each edge, and on the outer side of all but the rim
    for reach, size, edges in (
        (half, sizes, np.arange(len(half))),
        (half[1:], sizes[:-1], np.arange(len(half) - 1)),
    ):
        distance = reach[:, None] * ratio ** np.arange(np.ceil(np.log(sizes.min()) / np.log(ratio)))
        edges = np.broadcast_to(edges[:, None], distance.shape)
        digits = np.log(amplitude(distance, reach[:, None], edges) / problem.rtol)
        degrees = np.clip(_relaxed_degree(digits / convergence(ratio)), 2, most)
        total += float(np.sum(degrees, where=distance > size[:, None]))
    return total


def with_affordable_field_tolerance(problem: Problem, ratio: float) -> Problem:
    """Return the problem with the tolerance that its fields can have.

    With so many rings that it would take too many pressures, fields are as accurate as the root of
    what is asked for at the least: energies, which converge twice as fast, still reach it.
    """
    # what errs by the square of the fields' errors may have coarser fields
    fields = min(problem.rtol**0.5, 0.3) if problem.energies_only else problem.rtol
    fewer = replace(problem, rtol=fields)
    # dense matrices cost the third power of the pressures
    while fewer.rtol < problem.rtol**0.5 and pressures(fewer, ratio) > MOST_PRESSURES:
        fewer = replace(fewer, rtol=min(2 * fewer.rtol, problem.rtol**0.5))
    return fewer


def field_accuracy(problem: Problem) -> float:
    """Return the accuracy that fields are resolved to.

    It is the one asked for, unless only energies are wanted or there are too many rings.
    """
    return with_affordable_field_tolerance(problem, FACTOR).rtol


def mdr_sizes(problem: Problem) -> dict[str, Any]:
    """Return the sizes of the radial mesh of the MDR and of boundary elements."""
    chosen, grading = problem.mdr, problem.mdr.grading or 0.2
    fields, modes = (
        with_affordable_field_tolerance(problem, grading),
        np.ceil(degree_of_modes(problem)),
    )
    degree = np.ceil(pressure_degree(fields, grading))
    smallest = smallest_size(problem, RADIAL_ROUNDOFF)
    return {
        "degree": chosen.degree or min(int(degree), 20),
        "degree_of_modes": chosen.degree or min(int(modes), 20),
        "rim_size": chosen.rim_size or max(rim_size(problem, fields), smallest),
        "ring_size": chosen.ring_size or np.maximum(ring_sizes(problem, fields), smallest),
        "grading": grading,
    }


def edge_sizes(problem: Problem) -> Array:
    """Return the wanted sizes (N,) at every ring edge but the centre, the rim last."""
    rtol, narrower, worn = problem.rtol, problem.merged.narrower, problem.edge_amplitude
    narrower = np.append(narrower, problem.merged.widths[-1])
    at_rim = np.arange(len(narrower)) == len(narrower) - 1
    sharp = np.where(at_rim, 1.0, np.minimum(1.0, worn.worn_length_fast / narrower))
    # of the square of the slope, as much is missed as the size is of the ring, or of what wear has
    # blunted
    sizes = np.minimum(
        0.1 * rtol * narrower,
        np.where(at_rim, 0.03, 0.1) * rtol * np.minimum(worn.worn_length_slow, narrower) / sharp,
    )
    # of the pressure, the power 3/2 of that
    sizes = np.minimum(sizes, 0.3 * worn.worn_length_slow * (rtol / np.sqrt(sharp)) ** (2 / 3))
    # where wear is continuous, pressures of early times are a logarithm of the distance at most,
    # whose amplitude is that of the kink
    continuous = np.minimum(rtol**0.5 / np.maximum(problem.merged.kinks, rtol), 1.0) * narrower
    return np.asarray(np.where(problem.merged.smooth, np.maximum(sizes, continuous), sizes))


def rim_size(problem: Problem, fields: Problem) -> float:
    """Return the wanted size of the elements at the rim.

    `fields` is the problem with the accuracy of its fields.

    Pressures of the flat start err by up to three times that size, its energy by a tenth.
    """
    return float(min(edge_sizes(fields)[-1], 0.03 * problem.rtol))


def ring_sizes(problem: Problem, fields: Problem) -> Array:
    """Return the wanted sizes (N-1,) at the ring edges between centre and rim.

    The sizes are rounded to a few distinct values. `fields` is the problem with the accuracy of its
    fields.

    At the edge of a hole, pressures of the flat start are as at the rim.
    """
    sizes = edge_sizes(fields)[:-1]
    if problem.merged.hollow:
        scale = min(1.0, 3 * float(problem.merged.narrower[0]))
        sizes[0] = min(sizes[0], rim_size(problem, fields) * scale)
    return np.asarray(2.0 ** np.floor(np.log2(sizes)))


def smallest_size(problem: Problem, roundoff: float) -> float:
    """Return the least size of elements beside a ring edge, so that roundoff costs a third of rtol.

    Parameters
    ----------
    problem : with its accuracy and its times
    roundoff : of the method, `FEM_ROUNDOFF` or `RADIAL_ROUNDOFF`
    """
    slowest = float(problem.merged.ends.min())
    if 0 < problem.earliest * slowest < EARLIEST_OF_MODES:
        return GREATEST_OF_SMALLEST
    return min(3 * roundoff / problem.rtol, GREATEST_OF_SMALLEST)


def fem_smallest(problem: Problem) -> float:
    """Return the least size of finite elements beside a ring edge."""
    wear = problem.merged.ends[np.isfinite(problem.merged.ends)]
    return smallest_size(problem, FEM_ROUNDOFF * float(wear.max() / wear.min()) ** (2 / 3))


def missing_layers(problem: Problem, smallest: float) -> Array:
    """Return how many layers of elements (T,) a mesh lacks at each time.

    The times are those that errors are estimated at. A mesh lacks layers because its elements are
    no smaller than a least size.
    """
    missing = np.zeros(len(problem.estimate_times))
    for number, time in enumerate(problem.estimate_times):
        since = replace(problem, times=np.array([time]))
        wanted = float(edge_sizes(since).min()) if since.earliest else np.inf
        missing[number] = max(np.log(wanted / smallest) / np.log(FACTOR), 0.0) if smallest else 0.0
    return missing


def quad_sizes(problem: Problem) -> dict[str, Any]:
    """Return the sizes of quadrilaterals in geometric layers.

    The names are those of the arguments of `meshes.quads.graded`.
    """
    chosen, fields = problem.fem, with_affordable_field_tolerance(problem, FACTOR)
    wanted = np.maximum(ring_sizes(problem, fields), fem_smallest(problem))
    far = TRUNCATION if chosen.far_field == "boussinesq" else WIDER_TRUNCATION
    return {
        "sizes": np.full(len(wanted), chosen.ring_size) if chosen.ring_size else wanted,
        "rim_size": chosen.rim_size or max(rim_size(problem, fields), fem_smallest(problem)),
        "factor": FACTOR,
        "growth": chosen.growth or GROWTH,
        "outer": chosen.truncation or far,
        "edge_amplitude": fields.edge_amplitude,
    }


def quad_degree(problem: Problem) -> int:
    """Return the degree of the displacement on quadrilaterals.

    It is above that of the pressure (`ringwear study convergence`), and higher still towards
    incompressibility, which costs two digits in the end.
    """
    of_pressure = pressure_degree(with_affordable_field_tolerance(problem, FACTOR), FACTOR)
    compressibility = 1 - 2 * min(problem.poisson_ratio, 0.4999)
    wanted = (
        # of less, the coarser solution would have linear pressures, too far off to judge by
        max(of_pressure, degree_of_modes(problem), 3.0)
        + 1.45
        + max(0.0, -0.2 - 0.4 * np.log10(compressibility))
    )
    degree = int(np.clip(np.ceil(wanted), DEGREES["quads"][0], DEGREES["quads"][-1]))
    return problem.fem.degree or degree


def triangle_ring_sizes(problem: Problem) -> Array:
    """Return the wanted sizes (N-1,) of triangles at the ring edges.

    Their degree is low, and smaller ones would not help fields.
    """
    rtol, narrower = problem.rtol, problem.merged.narrower
    worn = max(0.5 * problem.earliest, rtol**0.75) if problem.earliest else 1.0
    wanted = np.minimum(min(10 * rtol**0.6, 0.25) * narrower, worn)
    if problem.merged.hollow:
        # as at the rim
        wanted[0] = min(0.1 * rtol, float(narrower[0]) / 4)
    return np.asarray(2.0 ** np.floor(np.log2(wanted)))


def triangle_degree(problem: Problem) -> int:
    """Return the degree of the displacement on triangles: the one given, else the highest."""
    highest = DEGREES["gmsh"][-1]
    return min(problem.fem.degree or highest, highest)


def triangle_sizes(problem: Problem) -> SizeField:
    """Return the sizes of graded triangles."""
    rtol, chosen, ring_edges = problem.rtol, problem.fem, problem.merged.ring_edges
    return SizeField(
        ring_edges=tuple(float(edge) for edge in ring_edges),
        rim_size=chosen.rim_size or min(0.1 * rtol, float(ring_edges[-1] - ring_edges[-2]) / 4),
        ring_size=chosen.ring_size or tuple(float(size) for size in triangle_ring_sizes(problem)),
        growth=chosen.growth or min(0.7 * (rtol / 1e-4) ** 0.115, 0.9),
        truncation=chosen.truncation or WIDER_TRUNCATION,
        centre_size=min(0.2 * (rtol / 1e-4) ** 0.115, 0.5),
        # in d0, sides of a quarter of the truncation cost 2e-6 in degree 3 and 1e-8 in degree 4, of
        # an eighth nothing
        far_size=0.25 if triangle_degree(problem) == DEGREES["gmsh"][-1] and rtol > 1e-6 else 0.125,
    )


def pole_orders(problem: Problem, truncation: float) -> tuple[int, ...]:
    """Return the orders of the poles tied to the outer boundary.

    They are those asked for, or enough of them for the accuracy.
    """
    from ...fem.far_field import enough_poles

    if problem.fem.poles:
        return tuple(range(0, 2 * problem.fem.poles, 2))
    return enough_poles(truncation, min(1e-9, problem.rtol / 10))


def grid_step(problem: Problem, stability_limit: float) -> float:
    """Return the step of the march on the uniform grid.

    It is the one asked for, or half of the greatest stable one (`ringwear study march`).
    """
    if problem.mdr.step:
        return problem.mdr.step / problem.units.time
    return problem.step if problem.step and problem.march == "explicit" else 0.5 * stability_limit


def tolerance_range(problem: Problem, pressures: int) -> tuple[float, float]:
    """Return the least and the greatest accuracy that sizes follow.

    For a shaped punch the least depends on `pressures`, the number of pressures at first.
    """
    if problem.full_contact:
        return FINEST, 1.0
    least, greatest = (1e-4 * (150 / count) ** 2 for count in (300, 80))
    # more than 800 pressures take half a minute; so do, where the load varies and steps begin anew
    # at each change of it, twice as many as at first
    ratio = max(pressures / 800, 0.5 * problem.loading.varies)
    return max(least, min(problem.rtol, greatest) * ratio**2), greatest


def cells_of(problem: Problem, finer: float = 1.0) -> ContactCells:
    """Return the cells that an accuracy asks for, before it is known where contact begins."""
    # where edges move d errs by about their inverse; as many as a tenth of 1e-4 asks for take
    # minutes
    count = finer * float(np.clip(150 * (1e-4 / problem.rtol) ** 0.5, 80, 300))
    edge = min(problem.rtol, 1e-3) / finer**2
    return ContactCells(
        tuple(problem.merged.ring_edges.tolist()),
        1 / count,
        edge,
        growth=0.4 / finer**0.5,
        spread=1 / count,
        hollow=problem.merged.hollow,
    )
