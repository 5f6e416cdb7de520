"""Measure the rates by which `ringwear plan` predicts seconds, memory and errors on this machine, and write `costs.json`.

Every scene is run in a process of its own, whose processor time counts: other work on the machine disturbs it least. The
finite elements are measured with CHOLMOD, which must be installed, and once more as if it were not.
"""

import json
import resource
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from scipy.optimize import nnls

from ringwear.meshes.radial import Array
from ringwear.studies.crosscheck import run as running
from ringwear.studies.methods.base import method
from ringwear.studies.methods.costs import check_terms, direct_terms, memory_terms, output_terms, terms
from ringwear.studies.problem.scene import Scene

DIALS = {
    "flat_punch": (1e-2, 1e-5, 1e-7),
    "five_rings": (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    "many_rings": (1e-2, 1e-3, 1e-5),
}
ALL = ["mdr", "direct", "fem"]


@dataclass(frozen=True)
class Measured:
    """Processor seconds by method, for the check of operators and for the output; GiB; own errors of the indentation."""

    methods: dict[str, float]
    check: float
    output: float
    memory: float
    errors: dict[str, float]


def scenes() -> Iterator[Scene]:
    """What is measured: dials, rings, times, ratios and steps, each over decades."""
    five = Scene.load("five_rings")
    for name, dials in DIALS.items():
        for rtol in dials:
            yield Scene.load(name).changed(methods=ALL, accuracy__rtol=rtol)
    for rtol in (1e-3, 1e-6):
        yield five.changed(methods=ALL, accuracy__rtol=rtol, wear__times=[])
        yield five.changed(methods=ALL, accuracy__rtol=rtol, punch__wear_coefficients=[1.0, 1e-3])
        yield five.changed(methods=ALL, accuracy__rtol=rtol, wear__times=[1e-6, 1e-4, 1e-2])
        yield five.changed(methods=["bem"], accuracy__rtol=rtol)
    for rings, rtol in ((2, 1e-4), (12, 1e-4), (12, 1e-6), (64, 1e-3), (128, 1e-2), (128, 1e-4)):
        yield five.changed(methods=ALL, accuracy__rtol=rtol, punch__rings=rings)
    yield five.changed(methods=["bem"], punch__rings=32)
    for count in (300, 3000, 30000):
        yield five.changed(methods=["mdr"], wear__times=np.geomspace(1e-3, 10, count).tolist())
    for step in (1e-3, 1e-4):
        yield five.changed(methods=["mdr"], wear__march="implicit", wear__step=step)
    for rings in (256, 1024):
        yield five.changed(methods=["direct"], punch__rings=rings, wear__times=[])
    for mesher in ("gmsh", "bisection"):
        for rings, rtol in ((1, 1e-2), (5, 1e-2), (5, 1e-3), (5, 1e-4), (5, 1e-5), (32, 1e-2), (32, 1e-3)):
            yield five.changed(methods=["fem"], punch__rings=rings, accuracy__rtol=rtol, accuracy__fem={"mesher": mesher})


def measured(scene: Scene, cholmod: bool = True) -> Measured:
    """Run a scene and write its results; what is loaded for the first run is not timed."""
    from ringwear.studies.output.folder import held
    from ringwear.studies.output.of_run import draw, write_numbers

    with patch.dict(sys.modules, {} if cholmod else {"kvxopt": None}), tempfile.TemporaryDirectory() as directory:
        first = Scene.load("flat_punch").changed(accuracy__rtol=1e-2, methods=scene.methods)
        with held(Path(directory), "run") as folder:
            draw(running.run(first), folder)
        seconds = dict[str, float]()
        solve, compare = running.solved_to_accuracy, running.compare_operators

        def timed(one: Any, problems: Any, stages: Any) -> Any:
            start = time.process_time()
            found = solve(one, problems, stages)
            seconds[one.name] = time.process_time() - start
            return found

        def compared(*arguments: Any) -> Any:
            start = time.process_time()
            found = list(compare(*arguments))
            seconds["check"] = time.process_time() - start
            return found

        with patch.object(running, "solved_to_accuracy", timed), patch.object(running, "compare_operators", compared):
            result = running.run(scene)
        start = time.perf_counter()  # figures are drawn in processes of their own
        with held(Path(directory), "run") as folder:
            write_numbers(result, folder)
            draw(result, folder)
        output = time.perf_counter() - start
        errors = {name: solution.error_estimate for name, solution in result.solutions.items()}
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return Measured(seconds, seconds.pop("check"), output, memory, errors)


def by_processes(every: list[Scene], cholmod: bool = True) -> list[Measured]:
    """Each scene in a process of its own, one after the other."""
    with ProcessPoolExecutor(1, get_context("spawn"), max_tasks_per_child=1) as pool:
        return list(pool.map(measured, every, [cholmod] * len(every)))


def fitted(rows: Iterable[Array], values: Iterable[float]) -> list[float]:
    """Rates that are not negative: least squares of relative errors."""
    known = np.array(list(values))
    return nnls(np.array(list(rows)) / known[:, None], np.ones(len(known)))[0].tolist()


def measure() -> dict[str, dict[str, list[float]]]:
    """Rates of every kind of method, of the check, of the output and of memory."""
    every = list(scenes())
    found = list(zip(every, by_processes(every), strict=True))
    table = of_methods(found)
    # predictions of the rest are made by the counts alone
    costs = [{name: method(name).cost(scene.problem) for name in scene.methods} for scene in every]
    pairs = [(scene, one, cost) for (scene, one), cost in zip(found, costs, strict=True)]
    checked = [(check_terms(cost["fem"].pressures, scene.problem), one.check) for scene, one, cost in pairs if len(cost) > 2]
    table["check"] = {"seconds": fitted(*zip(*checked, strict=True))}
    written = [(output_terms(scene.problem, list(cost.values()), cost.get("fem")), one.output) for scene, one, cost in pairs]
    table["output"] = {"seconds": fitted(*zip(*written, strict=True))}
    held = [(sum(memory_terms(scene.problem, cost).values()), one.memory) for scene, one, cost in pairs]
    table["memory"] = {"gib": fitted(*zip(*held, strict=True))}
    by_elements = [scene for scene in every if scene.methods == ["fem"] or scene.title == Scene.load("five_rings").title]
    with patch.dict(sys.modules, {"kvxopt": None}):
        few = [scene.changed(methods=["fem"]) for scene in by_elements if "fem" in scene.methods]
        without = of_methods(list(zip(few, by_processes(few, cholmod=False), strict=True)))
    return table | without


def of_methods(found: list[tuple[Scene, Measured]]) -> dict[str, dict[str, list[float]]]:
    """Rates of every kind of method that the scenes name."""
    rows: dict[str, list[tuple[Array, float]]] = defaultdict(list)
    errors: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for scene, one in found:
        problem = scene.problem
        for name, seconds in one.methods.items():
            this = method(name)
            unknowns, pressures = this.counted(problem)
            row = direct_terms(pressures) if name == "direct" else terms(unknowns, pressures, problem)
            rows[this.kind(problem)].append((row, seconds))
            if len(problem.times) and one.errors[name] > 0:
                errors[this.kind(problem)].append((np.log10(problem.rtol), np.log10(one.errors[name])))
    table = {kind: {"seconds": fitted(*zip(*of, strict=True))} for kind, of in rows.items()}
    for kind, known in errors.items():
        asked, stated = np.transpose(known)
        table[kind]["error"] = np.polyfit(asked, stated, 1).tolist()
    return table


if __name__ == "__main__":
    (Path(__file__).parents[1] / "costs.json").write_text(json.dumps(measure(), indent=1) + "\n", "utf-8")
