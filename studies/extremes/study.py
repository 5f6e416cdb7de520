"""A map of the limits: every method at parameters far from the usual ones, each result against an independent oracle.

A cell is one scene by one method, through the public door. Its verdict is the worst of its quantities:

    within      the error is within the method's own estimate
    degraded    the estimate tells of an error above ten times the accuracy asked, or falls short of the error by less
                than `FACTOR`, or the error is at least within the accuracy asked
    refused     a RingwearError says why not
    wrong       the error is beyond both, and nothing says so: a defect
    crashed     any other exception or a RuntimeWarning: a defect
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from collections import Counter, OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from ringwear.meshes.errors import RingwearError
from ringwear.meshes.radial import Array
from ringwear.studies.convergence.levels import Table, keeping_rows, write_markdown
from ringwear.studies.crosscheck.run import run
from ringwear.studies.extremes.cells import Cell, all_cells
from ringwear.studies.extremes.map import draw, groups
from ringwear.studies.extremes.reference import Rings, units
from ringwear.studies.methods.model import Model
from ringwear.studies.methods.outcome import Outcome, estimated, from_direct_integration
from ringwear.studies.methods.radial import MODELS
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report, Stages
from ringwear.studies.wear.archard import Wear
from threadpoolctl import threadpool_limits

FACTOR = 3.0
# relative accuracy of the oracle: of its quadratures, of slopes beside a ring by its width
ORACLE = 2e-10
PER_WIDTH = 3e-15
CANCELLED = 5e-15  # times what cancels in its displacements, discs over narrow rings; against 60 digits: up to 3.6e-15
CROSS = 5e-7  # of the other method
RINGS_OF_SLOPES = 64  # with more of them the oracle's quadrature would take longer than the study
LATE = 50.0  # slowest relaxation times, about 0.4/k_min, after which only the steady state is left
MODAL: dict[str, Any] = {"march": "modal", "step": None}
VERDICTS = ("within", "degraded", "refused", "wrong", "crashed")
DEFECTS = ("wrong", "crashed")
FIELDS = (
    "family", "method", "x", "y", "verdict", "quantity", "error", "estimate", "rtol", "seconds", "message", "parameters",
)  # fmt: skip


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Judge every cell; writes `extremes.csv`, `extremes.md` and `extremes.png`. Scales are those of the scene."""
    table = Table(out / "extremes.csv", FIELDS)
    conclusions: list[str] = []
    judge = Judge()
    family, start = "", time.perf_counter()
    with threadpool_limits(1), keeping_rows(conclusions):
        for cell in all_cells(scene, bool(options.quick)):
            if cell.family != family:
                family = cell.family
                report(f"extremes: {family} (cell {len(table.rows)}, {time.perf_counter() - start:.0f} s) ...")
            table.add(**judge.row(cell))
    if table.rows:
        draw(table.rows, out / "extremes.png")
    conclusions += conclude(table.rows)
    write_markdown(out / "extremes.md", "Limits of the methods", conclusions, {"Limits": _limits(table.rows, out)})
    return conclusions


@dataclass(frozen=True)
class Judgement:
    """One quantity of a cell: its verdict, its relative error and the method's estimate of that."""

    verdict: str
    quantity: str
    error: float
    estimate: float


@dataclass
class Judge:
    """Evaluates cells; keeps the last compliances and oracles, which many neighbouring cells share."""

    models: OrderedDict[str, Model] = field(default_factory=OrderedDict)
    rings: OrderedDict[bytes, Rings] = field(default_factory=OrderedDict)

    def row(self, cell: Cell) -> dict[str, Any]:
        """The cell as a row of the table."""
        start = time.perf_counter()
        message = ""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)
                scene = Scene.from_table(cell.table)
                found = self.judgements(scene, cell)
            worst = max(found, key=lambda one: (VERDICTS.index(one.verdict), one.error / max(one.estimate, 1e-300)))
        except RingwearError as error:
            worst, message = Judgement("refused", "", np.nan, np.nan), str(error)
        except KeyboardInterrupt:
            raise
        except Exception as error:  # whatever else comes out is the finding
            worst, message = Judgement("crashed", "", np.nan, np.nan), f"{type(error).__name__}: {error}"
        return {
            "family": cell.family, "method": cell.method, "x": cell.x, "y": cell.y, "verdict": worst.verdict,
            "quantity": worst.quantity, "error": worst.error, "estimate": worst.estimate,
            "rtol": cell.table["accuracy"]["rtol"], "seconds": round(time.perf_counter() - start, 4),
            "message": message, "parameters": json.dumps(cell.table),
        }  # fmt: skip

    def judgements(self, scene: Scene, cell: Cell) -> list[Judgement]:
        """Every quantity of the scene that the oracle knows."""
        natural = scene.natural
        if cell.scaled:
            return _scaled(scene, self.oracle(natural))
        if cell.method == "direct":
            result, errors = from_direct_integration(natural)
        else:
            result, errors, *_ = estimated(natural, self.model(natural, cell.method))
        known = self.known(natural, cell.method)
        return [
            _judged(name, getattr(result, name), exact, getattr(errors, name) + slack, scene.accuracy.rtol)
            for name, (exact, slack) in known.items()
            if getattr(result, name).size
        ] + _forces(result)

    def known(self, natural: NaturalScene, method: str) -> dict[str, tuple[Array, float | Array]]:
        """What the results must be, and how accurately the oracle knows that."""
        oracle, wear = self.oracle(natural), natural.wear
        pressures, greatest = oracle.pressures(wear), oracle.greatest_displacement(wear)
        # at every ring edge but the last a disc of one pressure less the other ends, at the rim one of its own pressure
        cancelled = (np.ptp(pressures) * natural.edges[:-1].sum() + pressures.max()) / greatest
        exact: dict[str, tuple[Array, float | Array]] = {
            "steady_wear_rate": (wear[:1] * pressures[:1], ORACLE),
            "steady_displacement_max": (np.array([greatest]), ORACLE + CANCELLED * cancelled),
        }
        if len(wear) <= RINGS_OF_SLOPES:
            slope = oracle.rms_slope(wear, natural.scene.output.gradient_average)
            exact["steady_rms_slope"] = np.array([slope]), ORACLE + PER_WIDTH / float(np.diff(natural.edges).min())
        times = natural.times
        if len(times):
            late = times > LATE * 0.4 / wear.min()
            between = ~late & (times > 0)
            indentation = np.where(late, oracle.late_indentation(wear, times), 0.5)
            if between.any():
                other = natural.scene.changed(accuracy={"rtol": 1e-6}, wear=natural.scene.table()["wear"] | MODAL).natural
                twin = self.model(other, "fem" if method == "mdr" else "mdr")
                indentation[between] = Wear(twin.compliance, natural.phases[1]).modal(times[between]).indentation
            exact["indentation"] = indentation, np.where(between, CROSS, ORACLE)
        return exact

    def oracle(self, natural: NaturalScene) -> Rings:
        key = natural.edges.tobytes()
        return _kept(self.rings, key, lambda: Rings(natural.edges))

    def model(self, natural: NaturalScene, method: str) -> Model:
        """The method made ready; the compliance depends on ring edges, solid, accuracy and times, not on the wear."""
        scene = natural.scene
        accuracy = scene.accuracy.model_dump_json()
        key = f"{method} {natural.phases[0].tolist()} {scene.half_space.poisson_ratio} {natural.times.tolist()} {accuracy}"
        return _kept(self.models, key, lambda: MODELS[method](natural, Stages(method)))


def _kept(store: OrderedDict, key: Any, make: Callable[[], Any]) -> Any:
    if key not in store:
        store[key] = make()
        if len(store) > 12:
            store.popitem(last=False)
    return store[key]


def _judged(name: str, value: Array, exact: Array, estimate: Array, rtol: float) -> Judgement:
    """The worst entry of a result against what it must be."""
    error = np.abs(value - exact) / np.abs(exact)
    allowed = np.asarray(estimate)
    if not np.isfinite(error).all():
        return Judgement("wrong", name, np.inf, float(np.nan_to_num(allowed, nan=np.inf).max()))
    worst = int(np.argmax(error / allowed))
    return Judgement(
        verdict(float(error[worst]), float(allowed[worst]), rtol), name, float(error[worst]), float(allowed[worst])
    )


def verdict(error: float, estimate: float, rtol: float) -> str:
    """See the module's own words."""
    if error <= estimate:
        return "within" if error <= 10 * rtol else "degraded"
    return "degraded" if error <= max(rtol, FACTOR * estimate) else "wrong"


def _forces(result: Outcome) -> list[Judgement]:
    """The forces on the rings must add to the load at every time, whatever the discretisation."""
    if not result.ring_force.size:
        return []
    error = float(np.abs(result.ring_force.sum(axis=1) - 1).max())
    return [Judgement(verdict(error, 1e-9, 1e-9), "force balance", error, 1e-9)]


def _scaled(scene: Scene, oracle: Rings) -> list[Judgement]:
    """A whole run in the scene's own units, to its dataset."""
    known, unit = oracle, units(scene)
    result = run(scene)
    data, wear, rtol = result.dataset, scene.natural.wear, scene.accuracy.rtol
    p = known.pressures(wear)
    exact = {
        "steady_displacement_max": known.greatest_displacement(wear) * unit["displacement"],
        "steady_rms_slope": known.rms_slope(wear, scene.output.gradient_average) * unit["slope"],
        "steady_wear_rate": float(wear[0] * p[0]) * unit["wear_rate"],
    }
    method = scene.methods[0]
    found = []
    for name, value in exact.items():
        exactly, estimate = np.array([value]), getattr(result.errors[method], name) + ORACLE
        found.append(_judged(name, data[name].values, exactly, estimate, rtol))
    if result.outcomes[method].indentation.size:
        start = np.array([unit["displacement"] / 2])
        given, told = data["indentation"].values[0, :1], result.errors[method].indentation[:1]
        found.append(_judged("indentation", given, start, told + ORACLE, rtol))
    return found


def conclude(rows: list[dict[str, Any]]) -> list[str]:
    """Counts by verdict, and the defects by family and method."""
    counts = Counter(row["verdict"] for row in rows)
    lines = [f"{len(rows)} cells: " + ", ".join(f"{counts[name]} {name}" for name in VERDICTS)]
    found = Counter((r["family"], r["method"], r["verdict"], r["quantity"] or r["message"][:60])
                     for r in rows if r["verdict"] in DEFECTS)  # fmt: skip
    lines += [f"defect: {family}, {method}: {n} cells {kind} ({what})" for (family, method, kind, what), n in found.items()]
    return lines


def _limits(rows: list[dict[str, Any]], out: Path) -> Table:
    """For each family and method: how many of each verdict, and between which values every cell is well."""
    table = Table(out / "extremes_limits.csv", ("family", "method", *VERDICTS, "x all well", "y all well", "greatest error"))
    for family, method, own in groups(rows):
        counts = Counter(row["verdict"] for row in own)
        errors = [row["error"] for row in own if np.isfinite(row["error"])]
        spans = {f"{axis} all well": _span(own, axis) for axis in ("x", "y")}
        greatest = f"{max(errors):.1e}" if errors else ""
        numbers = {name: counts[name] for name in VERDICTS}
        table.add(family=family, method=method, **numbers, **spans, **{"greatest error": greatest})
    return table


def _span(rows: list[dict[str, Any]], axis: str) -> str:
    """Values of one parameter at which no cell is worse than within."""
    values = list(dict.fromkeys(row[axis] for row in rows))
    well = [v for v in values if all(row["verdict"] == "within" for row in rows if row[axis] == v)]
    if len(well) == len(values):
        return "all"
    return " ".join(v if isinstance(v, str) else f"{v:.3g}" for v in well) or "none"
