"""About how large a run will be, in closed form by the default sizes (`problem/defaults.py`).

Within a factor of about 1.5 of what meshes will have. Nothing is meshed, and no library loaded.
"""

import os
from typing import NamedTuple

import numpy as np

from ...meshes.radial import Array
from ..problem import defaults
from ..problem.problem import Problem
from ..problem.scene import Scene

GIB = 2.0**30


class Size(NamedTuple):
    """What a method is made of, in words, and about how large.

    Parameters
    ----------
    made_of : str
    unknowns : float
        Of the system behind the compliance; zero if there is none.
    pressures : float
        Order of the dense matrices.
    """

    made_of: str
    unknowns: float
    pressures: float


def predict_size(name: str, problem: Problem) -> Size:
    """Return about how large a method's systems will be, in closed form."""
    if name == "direct":
        return Size("closed form, nothing to resolve", 0, len(problem.merged.widths))
    if name == "mdr-grid":
        springs = problem.mdr.grid
        return Size(f"a uniform grid of {springs} springs", springs + 1, springs + 1)
    if name not in ("mdr", "bem", "fem"):
        return Size("its sizes are known by the run", 0, 0)
    if not problem.full_contact and len(problem.times):
        return _on_cells(name, problem)
    return _on_elements(problem) if name == "fem" else _on_radii(problem)


def _on_cells(name: str, problem: Problem) -> Size:
    """Return the size of a march in which contact opens, closes and spreads."""
    space = defaults.cells_of(problem).space()
    words = f"linear pressures on {len(space.degrees)} cells and more where contact begins"
    pressures = 1.3 * space.size
    return Size(words, 80 * pressures + 8000 if name == "fem" else pressures, pressures)


def _on_radii(problem: Problem) -> Size:
    """Return the size of the radial mesh; degrees fall with the layers, from the highest to 2."""
    sizes = defaults.mdr_sizes(problem)
    at_rings = np.broadcast_to(sizes["ring_size"], len(problem.merged.narrower))
    smallest = np.append(at_rings, sizes["rim_size"])
    pressures = (
        0.69 * sizes["degree"] * _count_beside(problem, smallest, 1, -np.log(sizes["grading"]))
    )
    words = f"pressures of degree up to {sizes['degree']}, {_in_words(smallest)}"
    return Size(words, pressures, pressures)


def _on_elements(problem: Problem) -> Size:
    """Return the size of the finite elements; the factors were fitted to meshes of random scenes.

    Triangles fill the column below each edge, their sides grow with the distance from it.
    """
    mesher, rings = problem.fem.meshed_by, len(problem.merged.widths)
    if mesher == "quads":
        quads = defaults.quad_sizes(problem)
        degree, smallest = quads.degree, np.array([*quads.ring_sizes, quads.rim_size])
        layers = _count_beside(problem, smallest, 1, -np.log(quads.factor))
        pressures = 0.58 * layers * (degree - 2) + 2.6 * rings * degree
        unknowns = degree**2 * (2.8 * layers + 19 * (rings + 1))
    else:
        field = defaults.triangle_sizes(problem)
        degree, growth = defaults.triangle_degree(problem), field.growth
        smallest = np.array([*field.ring_sizes, field.rim_size])
        sides = _count_beside(problem, smallest, growth, growth)
        pressures = 4 * sides + 15
        unknowns = degree**2 * (6.7 * sides / growth + 150)
        unknowns *= 1.75 if mesher == "bisection" else 1.0
    what = "quadrilaterals" if mesher == "quads" else f"triangles by {mesher}"
    far_field = {"boussinesq": "Boussinesq's far field", "fixed": "clamped"}[problem.fem.far_field]
    outer = f"{far_field} at R = {defaults.truncation(problem):g} a"
    words = f"{what} of degree {degree}, {_in_words(smallest)}, {outer}"
    return Size(words, unknowns, pressures)


def _count_beside(problem: Problem, smallest: Array, growth: float, rate: float) -> float:
    """Return how many elements lead from the middle of every ring to its edges.

    Their size grows with the distance from the edge. The number is the integral of
    ``growth / rate`` over the size; layers that grow by a factor have the rate of its logarithm.
    """
    reach = problem.merged.widths / 2
    sides = ((smallest, reach), (smallest[:-1], reach[1:]))
    return sum(
        float(np.maximum(np.log1p(growth * widths / sizes) / rate, 1).sum())
        for sizes, widths in sides
    )


def _in_words(smallest: Array) -> str:
    at_edges = f"{smallest[:-1].min():.0e} a at ring edges and " if len(smallest) > 1 else ""
    return f"elements down to {at_edges}{smallest[-1]:.0e} a at the rim"


def predict_memory(scene: Scene) -> dict[str, float]:
    """Return about how many GiB a run will need, by the scene keys that cause it.

    They are for some 14 dense matrices, for the sparse factor, and for fields over time.
    """
    problem = scene.problem
    sizes = [predict_size(name, problem) for name in scene.methods]
    numbers = sum(
        14 * size.pressures**2 + 50 * size.unknowns * np.log2(size.unknowns + 1) for size in sizes
    )
    fields = 6.0 * len(problem.times) * len(problem.radii) * len(sizes)
    return {
        "libraries": 0.23,
        "punch.rings and accuracy": float(8 * numbers / GIB),
        "wear.times and output.radii": 8 * fields / GIB,
    }


def beyond_memory(memory: dict[str, float], limit: float) -> str:
    """Say why a run would not fit into so many GiB, and by which key; empty if it fits."""
    total, key = sum(memory.values()), max(memory, key=memory.__getitem__)
    if total <= limit:
        return ""
    return (
        f"about {total:.2g} GiB are needed, {memory[key]:.2g} of them for {key}, and {limit:.2g} "
        "are allowed: ask for less there, or give --memory GIB if there is more"
    )


def machine_memory() -> float:
    """Return the GiB of this machine."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIB
