"""Measure the rates by which `ringwear plan` predicts seconds, memory and errors on this machine,
and write `costs.json`.

Every scene is run by the command, in a process of its own, whose processor time counts: other work
on the machine disturbs it least. The finite elements are measured with CHOLMOD, which must be
installed, and once more as if it were not.
"""

import json
import resource
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any, cast
from unittest.mock import patch

import numpy as np
from scipy.optimize import nnls

from ...meshes.radial import Array
from ..crosscheck import run as running
from ..methods.base import method
from ..methods.costs import (
    OF_TIMES,
    check_terms,
    direct_terms,
    figure_terms,
    march_terms,
    memory_terms,
    number_terms,
    terms,
)
from ..output import files
from ..problem.scene import Scene

DIALS = {
    "flat_punch": (1e-2, 1e-5, 1e-7),
    "five_rings": (1e-2, 1e-4, 1e-5, 1e-7),
    "many_rings": (1e-2, 1e-3, 1e-5),
}
ALL = ["mdr", "direct", "fem"]
# scenes at a time, as many as a machine has cores that nobody else needs
WORKERS = 2
compare = running.compare_operators


@dataclass(frozen=True)
class Measured:
    """Processor seconds by method, for the check of operators, figures and the rest.

    GiB; own errors of the indentation.
    """

    methods: dict[str, float]
    check: float
    figures: float
    numbers: float
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
    for count in (3000, 30000):
        yield five.changed(methods=["mdr"], wear__times=np.geomspace(1e-3, 10, count).tolist())
    for rtol in (1e-2, 1e-4, 1e-5):
        yield five.changed(methods=ALL, accuracy__rtol=rtol, punch__rings=10, wear__times=[])
    for rtol, step in ((1e-2, 1e-3), (1e-2, 1e-4), (1e-4, 1e-2), (1e-4, 1e-3)):
        yield five.changed(
            methods=["mdr"], accuracy__rtol=rtol, wear__march="implicit", wear__step=step
        )
    for sizes, step in ((1e-2, 1e-4), (1e-3, 1e-5), (3e-4, 4e-6)):
        rough = {"rim_size": sizes, "ring_size": sizes}
        yield five.changed(
            methods=["mdr"], accuracy__mdr=rough, wear__march="explicit", wear__step=step
        )
    for rings in (256, 1024):
        yield five.changed(methods=["direct"], punch__rings=rings, wear__times=[])
    yield from scenes_of_elements()


def scenes_of_elements() -> Iterator[Scene]:
    """What every mesher is measured on, and every solver."""
    five = Scene.load("five_rings")
    for mesher in ("quads", "gmsh", "bisection"):
        for rings, rtol in ((1, 1e-2), (5, 1e-2), (5, 1e-3), (5, 1e-5), (32, 1e-2), (32, 1e-3)):
            yield five.changed(
                methods=["fem"],
                punch__rings=rings,
                accuracy__rtol=rtol,
                accuracy__fem={"mesher": mesher},
            )


def measured(scene: Scene, cholmod: bool = True) -> Measured:
    """Run a scene by the command; what is loaded for the first run is not counted as a method's."""
    seconds: dict[str, float] = defaultdict(float)
    results = []

    def timed(name: str, action: Callable[..., Any]) -> Callable[..., Any]:
        def wrapped(*arguments: Any, **named: Any) -> Any:
            start = processor()
            found = action(*arguments, **named)
            seconds[name or arguments[0].name] += processor() - start
            if name == "run":
                results.append(found)
            return found

        return wrapped

    first = Scene.load("flat_punch").changed(accuracy__rtol=1e-2, methods=scene.methods)
    if not cholmod:
        # for the rest of this process, which ends with the scene
        cast(dict[str, Any], sys.modules)["kvxopt"] = None
    with tempfile.TemporaryDirectory() as directory:
        file = Path(directory) / "scene.toml"
        file.write_text(scene.to_toml(), "utf-8")
        running.run(first)
        loaded = processor()
        running.run(first)
        started = processor()
        loaded -= started - loaded
        with (
            patch.object(running, "solved_to_accuracy", timed("", running.solved_to_accuracy)),
            patch.object(
                running, "compare_operators", timed("check", lambda *of: list(compare(*of)))
            ),
            patch.object(running, "run", timed("run", running.run)),
            patch.object(files, "draw", timed("figures", files.draw)),
        ):
            # the command is above all that it commands
            command = import_module("ringwear.studies.cli")
            status = command.main(["run", str(file), "--out", directory])
    assert status in (command.Status.DONE, command.Status.DISAGREE), scene.title
    whole = loaded + processor() - started
    methods = {name: seconds[name] for name in scene.methods}
    numbers = whole - sum(methods.values()) - seconds["check"] - seconds["figures"]
    errors = {name: solution.error_estimate for name, solution in results[0].solutions.items()}
    memory = (
        max(
            resource.getrusage(who).ru_maxrss
            for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        )
        / 2**20
    )
    return Measured(methods, seconds["check"], seconds["figures"], numbers, memory, errors)


def processor() -> float:
    """Seconds of this process and of those it has waited for.

    Figures are drawn in processes of their own.
    """
    every = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in every)


def by_processes(every: list[Scene], cholmod: bool = True) -> list[Measured]:
    """Each scene in a process of its own, one after the other."""
    with ProcessPoolExecutor(WORKERS, get_context("spawn"), max_tasks_per_child=1) as pool:
        return list(pool.map(measured, every, [cholmod] * len(every)))


def fitted(rows: Iterable[Array], values: Iterable[float]) -> list[float]:
    """Rates that are not negative: least squares of relative errors."""
    known = np.array(list(values))
    return nnls(np.array(list(rows)) / known[:, None], np.ones(len(known)))[0].tolist()


Runs = list[tuple[Scene, Measured]]
Rates = dict[str, dict[str, list[float]]]


def measure() -> Rates:
    """Rates of every kind of method and march, of the check, of files, figures and memory."""
    every, few = list(scenes()), list(scenes_of_elements())
    with_cholmod = list(zip(every, by_processes(every), strict=True))
    return rates_of(with_cholmod, list(zip(few, by_processes(few, cholmod=False), strict=True)))


def rates_of(found: Runs, without_cholmod: Runs) -> Rates:
    """Rates by what was measured."""
    modal = [(scene, one) for scene, one in found if scene.wear.march == "modal"]
    table = of_methods(modal)
    table |= of_marches(table["mdr"]["seconds"], found)
    with patch.dict(sys.modules, {"kvxopt": None}):
        without = of_methods(without_cholmod, table["mdr"]["seconds"])
    for kind, of in without.items():
        # errors are those of the elements, and were measured on more scenes
        table[kind] = of | {"error": table[kind.split(",")[0]]["error"]}
    # predictions of the rest are made by the counts alone
    costs = [
        {name: method(name).cost(scene.problem) for name in scene.methods} for scene, _ in found
    ]
    pairs = [(scene, one, cost) for (scene, one), cost in zip(found, costs, strict=True)]
    checked = [
        (check_terms(cost["fem"].pressures, scene.problem), one.check)
        for scene, one, cost in pairs
        if len(cost) > 2
    ]
    table["check"] = {"seconds": fitted(*zip(*checked, strict=True))}
    for name, rows in (("numbers", number_terms), ("figures", figure_terms)):
        output = [(rows(scene.problem, cost), getattr(one, name)) for scene, one, cost in pairs]
        table[name] = {"seconds": fitted(*zip(*output, strict=True))}
    held = [
        (sum(memory_terms(scene.problem, cost).values()), one.memory) for scene, one, cost in pairs
    ]
    return table | {"memory": {"gib": fitted(*zip(*held, strict=True))}}


def of_methods(found: Runs, by_modes: list[float] | None = None) -> Rates:
    """Rates of every kind of method that the scenes name, those of the MDR among them unless they
    are given.
    """
    rows: dict[str, list[tuple[Array, float]]] = defaultdict(list)
    errors: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for scene, one in found:
        problem = scene.problem
        for name, seconds in one.methods.items():
            this = method(name)
            unknowns, pressures = this.counted(problem)
            row = (
                direct_terms(pressures) if name == "direct" else terms(unknowns, pressures, problem)
            )
            rows[this.kind(problem)].append((row, seconds))
            if len(problem.times) and one.errors[name] > 0:
                errors[this.kind(problem)].append(
                    (np.log10(problem.rtol), np.log10(one.errors[name]))
                )
    by_modes = by_modes or fitted(*zip(*rows["mdr"], strict=True))
    table: Rates = {}
    for kind, of in rows.items():
        if kind in ("mdr", "direct"):
            table[kind] = {"seconds": fitted(*zip(*of, strict=True))}
        else:
            # measured at few times only, which take what they take by the MDR
            few = [
                (np.concatenate([row[:-OF_TIMES], np.zeros(OF_TIMES)]), seconds)
                for row, seconds in of
            ]
            table[kind] = {
                "seconds": fitted(*zip(*few, strict=True))[:-OF_TIMES] + by_modes[-OF_TIMES:]
            }
    for kind, known in errors.items():
        asked, stated = np.transpose(known)
        table[kind]["error"] = np.polyfit(asked, stated, 1).tolist()
    return table


def of_marches(by_modes: list[float], found: Runs) -> Rates:
    """Rates of marches in steps.

    What they take more than the modes by which their error is estimated.
    """
    rows: dict[str, list[tuple[Array, float]]] = defaultdict(list)
    for scene, one in found:
        problem = scene.problem
        if problem.march != "modal":
            sizes = method("mdr").counted(problem)
            more = one.methods["mdr"] - float(np.array(by_modes) @ terms(*sizes, problem))
            rows[problem.march].append(
                (march_terms(sizes[1], problem), max(more, 0.1 * one.methods["mdr"]))
            )
    return {march: {"seconds": fitted(*zip(*of, strict=True))} for march, of in rows.items()}


if __name__ == "__main__":
    (Path(__file__).parents[1] / "costs.json").write_text(
        json.dumps(measure(), indent=1) + "\n", "utf-8"
    )
