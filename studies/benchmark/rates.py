"""Measure the rates by which `ringwear plan` predicts seconds and errors on this machine, and write `costs.json`."""

import json
import time
from pathlib import Path

import numpy as np
from scipy.optimize import nnls

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
    for name, sizes in (("mdr", {}), ("bem", {}), *(("fem", {"mesher": one}) for one in ("quads", "gmsh", "bisection"))):
        rows, errors = [], list[float]()
        for title, rtol in MEASURED:
            scene = Scene.load(title).changed(methods=[name], accuracy__rtol=rtol, accuracy__fem=sizes)
            run(scene)  # what is loaded for the first run is not timed
            start = time.perf_counter()
            solution = run(scene).solutions[name]
            seconds = time.perf_counter() - start
            assert solution.wear is not None
            rows.append(terms(solution.unknowns, solution.wear.compliance.space.size) / seconds)
            errors.append(solution.error_estimate)
        kinds[method(name).kind(scene.problem)] = {
            "seconds": nnls(np.array(rows), np.ones(len(rows)))[0].tolist(),
            "error": np.polyfit(np.log10([rtol for _, rtol in MEASURED]), np.log10(errors), 1).tolist(),
        }
    return kinds


if __name__ == "__main__":
    (Path(__file__).parents[1] / "costs.json").write_text(json.dumps(measure(), indent=1) + "\n", "utf-8")
