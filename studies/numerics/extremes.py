"""A map of the limits.

Every method at parameters far from the usual ones, each result against a reference solution.

A cell is one scene by one method. Its verdict is the worst of its quantities:

    within      the error is within the method's own estimate degraded    the estimate states an
    error above ten times the accuracy asked for, or falls short of the error by less
                than `FACTOR`, or the error is at least within the accuracy asked for
    refused     a RingwearError says why not
    wrong       the error is beyond both, and nothing says so: a defect
    crashed     any other exception or a RuntimeWarning: a defect
"""

import argparse
import json
import time
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from threadpoolctl import threadpool_limits

from ...meshes.errors import RingwearError
from ...meshes.radial import Array
from ..crosscheck.run import run
from ..methods.base import method
from ..methods.by_compliance import Discretised, compliance_method
from ..methods.estimate import estimated
from ..methods.quantities import QUANTITIES, array
from ..problem.problem import D0, Problem, Rings
from ..problem.scene import Scene
from ..problem.sections import FemAccuracy, MdrAccuracy
from ..progress import Stages, progress
from ..tables import Table, keeping_rows, write_page
from ..wear.archard import RunningIn
from .cells import DIRECT, FEM, MDR, Cell, all_cells
from .map import LOOKS, draw, limits
from .reference import Reference

FACTOR = 3.0
REFERENCE = 2e-10  # relative accuracy of the quadratures of the reference solution
RINGS_OF_SLOPES = (
    64  # with more of them the quadrature of the reference would take longer than the study
)
FIELDS = (
    "family",
    "method",
    "x",
    "y",
    "verdict",
    "quantity",
    "error",
    "estimate",
    "rtol",
    "seconds",
    "message",
    "parameters",
)


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Judge every cell.

    Writes `extremes.csv`, `extremes.md` and `extremes.png`. Of the scene, Poisson's ratio is taken.
    """
    table, conclusions = Table(out / "extremes.csv", FIELDS), list[str]()
    with threadpool_limits(1), keeping_rows(conclusions):
        cells = list(all_cells(scene.half_space.poisson_ratio, options.quick))
        for cell in progress(cells, "extremes", lambda cell: f"{cell.family} by {cell.method}"):
            table.add(**row(cell))
    if table.rows:
        draw(table.rows, out / "extremes.png")
    counts = Counter(row["verdict"] for row in table.rows)
    conclusions.append(
        f"{len(table.rows)} cells: "
        + ", ".join(f"{counts[verdict]} {verdict}" for verdict in LOOKS)
    )
    page = {"Limits": limits(table.rows, out / "extremes_limits.csv")}
    write_page(out / "extremes.md", "Limits of the methods", conclusions, page)
    return conclusions


def row(cell: Cell) -> dict[str, Any]:
    """The cell as a row of the table, by the worst of its quantities."""
    start = time.perf_counter()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            verdicts = list(LOOKS)
            worst = max(
                judgements(cell),
                key=lambda one: (verdicts.index(one["verdict"]), one["error"] / one["estimate"]),
            )
    except RingwearError as error:
        worst = {"verdict": "refused", "message": str(error)}
    except Exception as error:  # whatever else comes out is what the study looks for
        worst = {"verdict": "crashed", "message": f"{type(error).__name__}: {error}"}
    about = {"rtol": cell.scene.accuracy.rtol, "parameters": json.dumps(cell.scene.table())}
    return cell._asdict() | worst | about | {"seconds": round(time.perf_counter() - start, 4)}


def judgements(cell: Cell) -> Iterator[dict[str, Any]]:
    """Every number that the reference solution has, and the balance of forces."""
    problem = cell.scene.problem
    expected = known(problem, cell.method)
    results, errors = (
        in_units(cell.scene, expected) if cell.scaled else solved(problem, cell.method)
    )
    for name, (exact, accuracy) in expected.items():
        wrong = np.abs(results[name].values / exact - 1)
        for error, estimate in np.nditer([wrong, errors[name] + accuracy]):
            yield judged(name, float(error), float(estimate), problem.rtol)
    for forces in array(results, "ring_force"):
        yield judged(
            "force balance", abs(float(forces.sum()) - 1), 1e-9, 1e-9
        )  # whatever the discretisation


def judged(quantity: str, error: float, estimate: float, rtol: float) -> dict[str, Any]:
    """A number with its verdict, in the module's own words."""
    if error <= estimate:
        verdict = "within" if error <= 10 * rtol else "degraded"
    else:
        verdict = "degraded" if error <= max(rtol, FACTOR * estimate) else "wrong"
    return {"verdict": verdict, "quantity": quantity, "error": error, "estimate": estimate}


def solved(problem: Problem, name: str) -> tuple[xarray.Dataset, dict[str, Array]]:
    """The results of a method, and their errors."""
    if name == DIRECT:
        solution = method(name).solve(problem, Stages(name))
        return solution.results, solution.errors
    ready = discretised(problem, name)
    assert ready.coarser is not None
    known = estimated(problem, ready.compliance, ready.coarser, safety=ready.safety)
    return known.result.results, known.errors


def in_units(scene: Scene, names: Iterable[str]) -> tuple[xarray.Dataset, dict[str, Array]]:
    """The results of a whole run, some of them from its dataset in the scene's own units, and their
    errors.
    """
    result, units = run(scene), scene.problem.units
    (solution,) = result.solutions.values()
    sizes = {name: getattr(units, QUANTITIES[name].unit) for name in names}
    scaled = solution.results.assign(
        {name: result.dataset[name].variable[0] / size for name, size in sizes.items()}
    )
    return scaled, solution.errors


def known(problem: Problem, name: str) -> dict[str, tuple[Array | float, Array | float]]:
    """What the results of a method must be, and how accurately that is known."""
    exact = reference(tuple(problem.ring_edges))
    wear_coefficients, times = problem.wear_coefficients, problem.times
    pressures = exact.pressures(wear_coefficients)
    rate, greatest = (
        float(wear_coefficients[0] * pressures[0]),
        exact.greatest_displacement(pressures),
    )
    # at every ring edge but the last a disc of one pressure less the other ends, at the rim one of
    # its own pressure
    cancelled = (np.ptp(pressures) * problem.ring_edges[:-1].sum() + pressures.max()) / greatest
    values: dict[str, tuple[Array | float, Array | float]] = {
        "steady_wear_rate": (rate, REFERENCE),
        # against 60 digits: up to 3.6e-15 of what cancels
        "steady_displacement_max": (greatest, REFERENCE + 5e-15 * cancelled),
    }
    if len(wear_coefficients) <= RINGS_OF_SLOPES:
        slope = np.sqrt(pressures @ exact.grams[0] @ pressures)
        values["steady_rms_slope"] = slope, REFERENCE + 3e-15 / problem.rings.widths.min()
    if len(times) and name != DIRECT:
        # after fifty of the slowest relaxation times, 0.4 / k_min, only the steady state is left
        late = times > 50 * 0.4 / wear_coefficients.min()
        between = ~late & (times > 0)
        indentation = np.where(late, rate * times + pressures @ exact.grams[1] @ pressures, D0)
        if between.any():
            other = replace(problem, rtol=1e-6, fem=FemAccuracy(), mdr=MdrAccuracy())
            compliance = discretised(other, FEM if name == MDR else MDR, coarser=False).compliance
            indentation[between] = (
                RunningIn(compliance, problem.merged.wear_coefficients)
                .modal(times[between])
                .indentation
            )
        values["indentation"] = indentation, np.where(between, 5e-7, REFERENCE)
    return values


# neighbouring cells have them in common
reference = lru_cache(maxsize=16)(lambda ring_edges: Reference(np.array(ring_edges)))


def discretised(problem: Problem, name: str, coarser: bool = True) -> Discretised:
    """A method prepared, which does not depend on later times."""
    settings = {
        setting: getattr(problem, setting) for setting in ("poisson_ratio", "rtol", "fem", "mdr")
    }
    ring_edges, wear_coefficients = (tuple(part) for part in problem.merged)
    return _discretised(name, coarser, ring_edges, wear_coefficients, problem.earliest, **settings)


@lru_cache(maxsize=16)
def _discretised(
    name: str,
    coarser: bool,
    ring_edges: tuple[float, ...],
    wear: tuple[float, ...],
    earliest: float,
    **settings: Any,
) -> Discretised:
    rings = Rings(np.array(ring_edges), np.array(wear))
    return compliance_method(name).discretised(
        Problem(rings, np.array([earliest]), **settings), Stages(name), coarser
    )
