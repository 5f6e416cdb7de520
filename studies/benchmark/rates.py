"""Measure the rates by which `ringwear plan` predicts seconds and errors on this machine, and write `costs.json`."""

from __future__ import annotations

import json
import resource
import time
from pathlib import Path

import numpy as np
from scipy.optimize import nnls

from ringwear.meshes.radial import Array
from ringwear.studies.crosscheck.run import run
from ringwear.studies.methods.base import method, terms
from ringwear.studies.problem.scene import Scene

MEASURED = (
    *(("flat_punch", rtol) for rtol in (1e-2, 1e-5)),
    *(("five_rings", rtol) for rtol in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)),
    *(("many_rings", rtol) for rtol in (1e-2, 1e-3, 1e-5)),
)


def measure() -> dict[str, dict[str, list[float]]]:
    """For each kind of method, rates of seconds and the error by rtol (powers of ten): least squares over runs."""
    kinds = {}
    for name, mesher in (("mdr", None), ("bem", None), ("fem", "quads"), ("fem", "gmsh"), ("fem", "bisection")):
        changes = {"methods": [name], "accuracy__fem": {"mesher": mesher} if mesher else {}}
        rows, errors = [], list[tuple[float, float]]()
        for title, rtol in MEASURED:
            scene = Scene.load(title).changed(accuracy__rtol=rtol, **changes)
            own_terms, error = measured(scene)
            rows.append(own_terms)
            errors.append((float(np.log10(rtol)), float(np.log10(error))))
        rates, powers = nnls(np.array(rows), np.ones(len(rows)))[0], np.array(errors)
        kinds[method(name).kind(scene.problem)] = {
            "seconds": [float(rate) for rate in rates],
            "error": [float(term) for term in np.polyfit(powers[:, 0], powers[:, 1], 1)],
        }
    return kinds


def measured(scene: Scene) -> tuple[Array, float]:
    """The terms over the seconds that a scene of one method takes, once everything is loaded, and its error estimate."""
    run(scene)
    start = time.perf_counter()
    (solution,) = run(scene).solutions.values()
    seconds = time.perf_counter() - start
    assert solution.wear is not None
    return terms(solution.unknowns, solution.wear.compliance.space.size) / seconds, solution.error_estimate


if __name__ == "__main__":
    (Path(__file__).parents[1] / "costs.json").write_text(json.dumps(measure(), indent=1) + "\n", "utf-8")
    print(f"written; peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.2f} GiB")
