"""What a scene will cost, told before it is computed: unknowns by counting, seconds and memory by measured rates.

The rates are a small table in the package, `costs.json`;
`python -m ringwear.studies.crosscheck.costs` measures them again on this machine.
"""

from __future__ import annotations

import json
import resource
import time
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import numpy as np
from ringwear.meshes.radial import Array
from ringwear.studies.methods.fem_counts import counted
from ringwear.studies.methods.radial import mdr_settings, mdr_space
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import Scene
from scipy.optimize import nnls

MEASURED = (
    *(("flat_punch", rtol) for rtol in (1e-2, 1e-5)),
    *(("five_rings", rtol) for rtol in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)),
    *(("many_rings", rtol) for rtol in (1e-2, 1e-3, 1e-5)),
)


@dataclass(frozen=True)
class Cost:
    """Predicted cost of one method: unknowns, pressures among them, seconds on one thread and GiB.

    `error` is what its own estimate of the indentation will be about; nan where the user gave the sizes.
    """

    unknowns: int
    pressures: int
    seconds: float
    memory: float
    error: float


def predicted(natural: NaturalScene, method: str) -> Cost:
    """Cost of a method on a scene."""
    if method == "direct":
        rings = len(natural.phases[1])
        return Cost(0, rings, 1e-3 + 4e-6 * rings**2, 0.1, 1e-12)
    if method == "fem":
        unknowns, pressures = counted(natural)
    else:
        unknowns = pressures = mdr_space(natural, **mdr_settings(natural)).size
    measured = json.loads((files("ringwear.studies") / "costs.json").read_text("utf-8"))[_kind(natural, method)]
    seconds = float(np.dot(measured["seconds"], _terms(unknowns, pressures)))
    error = np.nan
    if not natural.scene.accuracy.gives_sizes(method):
        error = float(10 ** np.polyval(measured["error"], np.log10(natural.scene.accuracy.rtol)))
    # the factor, and a dozen dense matrices of the pressures
    memory = 0.15 + (400.0 * unknowns * np.log2(max(unknowns, 2)) / 8 + 12 * 8.0 * pressures**2) / 2**30
    return Cost(unknowns, pressures, seconds, memory, error)


def _kind(natural: NaturalScene, method: str) -> str:
    return f"fem {natural.scene.accuracy.fem.meshed_by}" if method == "fem" else method


def _terms(unknowns: int, pressures: int) -> Array:
    """What seconds are proportional to: a start, the mesh and its matrix, its factor, and dense algebra."""
    return np.array([1.0, unknowns, unknowns**1.5, pressures**2, pressures**3], dtype=float)


def measure() -> dict[str, dict[str, list[float]]]:
    """For each kind of method, rates of seconds and the error by rtol (powers of ten): least squares over runs."""
    kinds = {}
    for method, mesher in (("mdr", None), ("bem", None), ("fem", "quads"), ("fem", "gmsh"), ("fem", "bisection")):
        base = Scene.load("flat_punch").changed(methods=[method], accuracy__fem={"mesher": mesher})
        rows, errors = [], list[tuple[float, float]]()
        for title, rtol in MEASURED:
            scene = Scene.load(title).changed(methods=[method], accuracy__rtol=rtol, accuracy__fem={"mesher": mesher})
            terms, error = _measured(scene)
            rows.append(terms)
            errors.append((float(np.log10(rtol)), float(np.log10(error))))
        rates, powers = nnls(np.array(rows), np.ones(len(rows)))[0], np.array(errors)
        kinds[_kind(base.natural, method)] = {
            "seconds": [float(rate) for rate in rates],
            "error": [float(term) for term in np.polyfit(powers[:, 0], powers[:, 1], 1)],
        }
    return kinds


def _measured(scene: Scene) -> tuple[Array, float]:
    """The terms over the seconds that a scene of one method takes, once everything is loaded, and its error estimate."""
    from ringwear.studies.crosscheck.run import run

    run(scene)
    start = time.perf_counter()
    result = run(scene)
    seconds = time.perf_counter() - start
    (method,) = scene.methods
    model = result.models[method]
    return _terms(model.unknowns, model.compliance.space.size) / seconds, result.estimates[method]


if __name__ == "__main__":
    (Path(__file__).parents[1] / "costs.json").write_text(json.dumps(measure(), indent=1) + "\n", "utf-8")
    print(f"written; peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GiB")
