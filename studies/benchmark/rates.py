"""Measure the rates by which `ringwear plan` predicts seconds and errors on this machine, and write `costs.json`.

The finite elements are measured with CHOLMOD, which must be installed, and once more as if it were not.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any
from unittest.mock import patch

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
    """Rates of every kind of method, by its name."""
    by_fem: list[tuple[str, dict[str, Any]]] = [("fem", {"mesher": one}) for one in ("quads", "gmsh", "bisection")]
    rates = dict(measured(name, sizes) for name, sizes in [("mdr", {}), ("bem", {}), *by_fem])
    with patch.dict(sys.modules, {"kvxopt": None}):
        return rates | dict(measured(name, sizes) for name, sizes in by_fem)


def measured(name: str, sizes: dict[str, Any]) -> tuple[str, dict[str, list[float]]]:
    """A kind of method, and its rates of seconds and the error by rtol (powers of ten): least squares over runs."""
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
    return method(name).kind(scene.problem), {
        "seconds": nnls(np.array(rows), np.ones(len(rows)))[0].tolist(),
        "error": np.polyfit(np.log10([rtol for _, rtol in MEASURED]), np.log10(errors), 1).tolist(),
    }


if __name__ == "__main__":
    (Path(__file__).parents[1] / "costs.json").write_text(json.dumps(measure(), indent=1) + "\n", "utf-8")
