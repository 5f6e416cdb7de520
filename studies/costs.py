"""What a scene will cost, told before it is computed: unknowns by counting, seconds and memory by measured rates.

The rates are a small table in the package, `costs.json`; `python -m studies.costs` measures them again on this machine.
"""

from __future__ import annotations

import itertools
import json
import resource
import time
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
from scipy.optimize import nnls

from meshes.half_space import SizeField
from meshes.radial import Array

from .methods import mdr_settings, mdr_space, size_field
from .natural import NaturalScene
from .scene import Scene

SIDE = np.sqrt(3) / 4  # area of an equilateral triangle of side one
MULTIPLIERS_PER_FACET = 2.6
# a mesh of whole triangles has more of them than its size field asks for, the more so where it is coarse
# (measured on random scenes: unknowns and multipliers by the counts below, within 25 %)
MORE_UNKNOWNS, LEAST_UNKNOWNS = 1.3, 1300
MORE_PRESSURES, LEAST_PRESSURES = 1.25, 35
BISECTION = 2.6  # triangles by bisection for one by gmsh, at equal sizes


@dataclass(frozen=True)
class Cost:
    """Predicted cost of one method: unknowns, pressures among them, seconds on one thread and GiB."""

    unknowns: int
    pressures: int
    seconds: float
    memory: float


def count_triangles(field: SizeField) -> float:
    """Triangles that a size field asks for: its area in triangles of the local size, summed over a quadtree."""
    corner, side, total = np.zeros((1, 2)), field.truncation, 0.0
    while len(corner):
        centre = corner + side / 2
        size = field(centre)
        # a leaf is smaller than the local element: the field hardly changes in it
        leaf = side <= size
        inside = np.hypot(*centre.T) < field.truncation
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


def predicted(natural: NaturalScene, method: str) -> Cost:
    """Cost of a method on a scene."""
    if method == "direct":
        rings = len(natural.phases[1])
        return Cost(0, rings, 1e-3 + 4e-6 * rings**2, 0.1)
    if method == "fem":
        chosen, field = natural.scene.accuracy.fem, size_field(natural)
        triangles = count_triangles(field) * (BISECTION if chosen.mesher == "bisection" else 1.0)
        unknowns = round(MORE_UNKNOWNS * chosen.degree**2 * triangles + LEAST_UNKNOWNS * chosen.degree**2 / 16)
        pressures = round(MORE_PRESSURES * MULTIPLIERS_PER_FACET * count_facets(field)) + LEAST_PRESSURES
    else:
        unknowns = pressures = mdr_space(natural, **mdr_settings(natural)).size
    rates = json.loads((files("studies") / "costs.json").read_text("utf-8"))[method]
    seconds = float(np.dot(rates, _terms(unknowns, pressures)))
    # the factor, and a dozen dense matrices of the pressures
    memory = 0.15 + (400.0 * unknowns * np.log2(max(unknowns, 2)) / 8 + 12 * 8.0 * pressures**2) / 2**30
    return Cost(unknowns, pressures, seconds, memory)


def _terms(unknowns: int, pressures: int) -> Array:
    """What seconds are proportional to: a start, the mesh and its matrix, its factor, and dense algebra."""
    return np.array([1.0, unknowns, unknowns**1.5, pressures**2, pressures**3], dtype=float)


def measure() -> dict[str, list[float]]:
    """Rates of every method, by least squares of relative errors over runs of the bundled scenes."""
    from .runs import run

    rates = {}
    for method in ("mdr", "bem", "fem"):
        rows, seconds = [], []
        for name, rtol in (("flat_punch", 1e-2), ("flat_punch", 1e-5), ("five_rings", 1e-2), ("five_rings", 1e-3),
                           ("five_rings", 1e-4), ("five_rings", 1e-5), ("five_rings", 1e-6), ("many_rings", 1e-2),
                           ("many_rings", 1e-3)):  # fmt: skip
            scene = Scene.load(name).changed(methods=[method], accuracy__rtol=rtol)
            run(scene)
            start = time.perf_counter()
            result = run(scene)
            seconds.append(time.perf_counter() - start)
            model = result.models[method]
            rows.append(_terms(model.unknowns, model.compliance.space.size) / seconds[-1])
        rates[method] = [float(rate) for rate in nnls(np.array(rows), np.ones(len(rows)))[0]]
    return rates


if __name__ == "__main__":
    Path(__file__).with_name("costs.json").write_text(json.dumps(measure(), indent=1) + "\n", "utf-8")
    print(f"written; peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GiB")
