"""Runs along one parameter: true error and stated error of every method, and the naive choice.

The panels are listed in `panels.toml`. A level is one run at one value of the parameter.
"""

import json
import time
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from importlib.resources import files
from typing import Any

import numpy as np

from ...meshes.errors import RingwearError
from ..crosscheck.accuracy import solved_to_accuracy
from ..crosscheck.promise import allowed_error
from ..methods.base import Solution, method
from ..problem.problem import Problem
from ..progress import Stages
from ..sampling.norms import differences
from ..scene.scene import Scene
from ..study.levels import Family
from ..tables import Row
from . import naive
from .oracles import judge_by_reference, judge_by_theory, other_theory, solve_reference
from .verdicts import Verdict, rank_by_error, worst_of

NAIVE = "naive"
"""What the naive choice is called among the methods."""
METHODS = ("mdr", "bem", "fem")
"""Methods that a panel has if it names no others."""
FORMULAS: dict[str, Callable[[float], float]] = {
    "x": lambda x: x,
    "0.5 + x": lambda x: 0.5 + x,
    "1 - x": lambda x: 1 - x,
    "(1 - x) / 2": lambda x: (1 - x) / 2,
    "1 / x, from 5 to 40": lambda x: int(np.clip(round(1 / x), 5, 40)),
}
"""What texts in `panels.toml` stand for."""

Setting = tuple[float, str]
"""The value of the parameter, and the method."""


@dataclass(frozen=True)
class Panel:
    """One parameter x, its values, and what it changes.

    Parameters
    ----------
    name : of the parameter
    xlabel : what its axis is called
    values, quick : of x: all of them, and those of the quick study
    changes : of scene keys, with texts of `FORMULAS` for numbers
    base : the scene that is changed
    methods : that are run, with the far field or the march that is chosen after a comma
    naive : why the naive choice fails, and
    fails_at : at which x
    naive_changes : arguments of the naive solver, with texts of `FORMULAS`
    reference : accuracy of the solution that errors are measured by
    seconds : that a run of each method takes
    linear : whether the axis of x is linear, not logarithmic
    zero_at : where x = 0 is drawn on a logarithmic axis
    """

    name: str
    xlabel: str
    values: tuple[float, ...]
    quick: tuple[float, ...]
    changes: Mapping[str, Any]
    base: Scene
    naive: str
    fails_at: float
    methods: tuple[str, ...] = METHODS
    naive_changes: Mapping[str, Any] = field(default_factory=dict)
    reference: float = 1e-6
    seconds: Mapping[str, float] = field(default_factory=dict)
    linear: bool = False
    zero_at: float | None = None

    def scene(self, x: float, of_method: str) -> Scene:
        """Return the scene at a value of the parameter, with the sizes of one method alone.

        Raises
        ------
        SceneError
            if the scene cannot have that value
        """
        sizes = {"fem": "accuracy.fem.", "mdr": "accuracy.mdr.", "bem": "accuracy.mdr."}
        own = sizes.get(of_method.split(",")[0])
        changes = {
            key.replace(".", "__"): at(x, value)
            for key, value in self.changes.items()
            if not key.startswith(("accuracy.fem.", "accuracy.mdr.")) or f"{own}" in key
        }
        return self.base.changed(**changes)

    def family(self, quick: bool) -> Family:
        """Return the runs of the panel: every method, and the naive choice, at every x.

        When quick, boundary elements are left out: their pressures are on the space of the MDR, and
        their errors are the same.
        """
        # ten times coarser is enough where little time is to be spent
        rtol = self.reference * (10 if quick else 1)
        references = cache(partial(self._solve_reference, rtol))
        values = self.quick if quick else self.values
        methods = [name for name in self.methods if not (quick and name == "bem")]
        settings = {(x, name): x for x in values for name in (*methods, NAIVE)}
        return Family(
            self.name,
            settings,
            lambda setting: self._judge(setting, references),
            xlabel=self.xlabel,
            work=lambda setting: self.seconds[setting[1].split(",")[0]],
        )

    def _judge(self, setting: Setting, reference: "Callable[[float, str], Solution]") -> Row:
        """Return a row of the table: a run, by the worst of its quantities."""
        (x, name), start = setting, time.perf_counter()
        found: list[Verdict] = []
        row: dict[str, Any] = {"part": "panel", "method": name, "x": x}
        if name == NAIVE:
            row |= self._judge_naive(x, reference)
        else:

            def judge() -> Iterable[Verdict]:
                scene = self.scene(x, name)
                row["parameters"] = json.dumps(scene.table())
                problem = with_variant(scene.problem, name, x)
                row["promised"] = allowed_error(problem)
                solver = method(name.split(",")[0])
                if refused := solver.refusal(problem):
                    raise RingwearError(refused)
                solution = solved_to_accuracy(solver, [problem], Stages(name))[0]
                # at the radii of the face that the reference is known at
                problem = replace(problem, compared_on=problem.face)
                exact = reference(x, other_theory(name))
                found.extend(judge_by_reference(problem, name, solution, exact))
                found.extend(judge_by_theory(scene, problem, solution))
                return found

            row |= worst_of(judge, rank_by_error)
        if found:
            row["greatest error"] = max(each["error"] for each in found)
            row["greatest estimate"] = max(each["estimate"] for each in found)
        return {"seconds": round(time.perf_counter() - start, 4)} | row

    def _solve_reference(self, rtol: float, x: float, name: str) -> Solution:
        """Return the solution of a method that others are judged by, at one value of x."""
        problem = self.scene(x, name).problem
        return solve_reference(problem, name, min(rtol, 0.1 * problem.rtol))

    def _judge_naive(self, x: float, reference: "Callable[[float, str], Solution]") -> Row:
        """Return the greatest error of the naive choice: infinite where it overflows."""
        try:
            scene = self.scene(x, NAIVE)
            errors = naive_errors(self, x, reference(x, other_theory(NAIVE)))
        except RingwearError as error:
            return {"message": str(error)}
        worst = max(errors, key=lambda name: errors[name])
        return {
            "quantity": worst,
            "error": errors[worst],
            "greatest error": errors[worst],
            "promised": allowed_error(scene.problem),
        }


def naive_errors(panel: Panel, x: float, exact: Solution) -> dict[str, float]:
    """Return the greatest errors of the naive choice in the indentation and the pressure."""
    problem = panel.scene(x, NAIVE).problem
    arguments = {key: at(x, value) for key, value in panel.naive_changes.items()}
    with np.errstate(all="ignore"):
        values = naive.solve(problem, **arguments)
        checked = {
            name: value[problem.checked] if name != "time" else value
            for name, value in values.items()
        }
        found = differences(checked, exact.checked, problem.face)
    given = problem.load_regime.given
    return {
        name: float(np.nan_to_num(np.max(of), nan=np.inf))
        for name, of in found.items()
        if name != given
    }


def with_variant(problem: Problem, name: str, x: float) -> Problem:
    """Return a problem with the far field or the march that a method's name ends with."""
    variant = name.partition(", ")[2]
    if variant == "clamped":
        return replace(problem, fem=problem.fem.model_copy(update={"far_field": "fixed"}))
    if variant:
        return replace(problem, march=variant, step=x / problem.units.time)
    return problem


def at(x: float, template: Any) -> Any:
    """Return a value of a scene key at x: texts of `FORMULAS` in it become numbers."""
    if isinstance(template, str):
        return FORMULAS[template](x) if template in FORMULAS else template
    if isinstance(template, dict):
        return {key: at(x, value) for key, value in template.items()}
    return [at(x, value) for value in template] if isinstance(template, list) else template


def read_panels(poisson_ratio: float) -> Iterator[Panel]:
    """Yield the panels of `panels.toml`, with a Poisson's ratio where they have none."""
    listing = files("ringwear.studies") / "extremes" / "panels.toml"
    table = tomllib.loads(listing.read_text("utf-8"))
    base = Scene.from_table(table["base"]).changed(half_space__poisson_ratio=poisson_ratio)
    for panel in table["panels"]:
        scene = base.changed(**panel.pop("scene", {}))
        seconds = table["seconds"] | panel.pop("seconds", {})
        lists: dict[str, Any] = {
            key: tuple(panel.pop(key)) for key in ("values", "quick", "methods") & panel.keys()
        }
        yield Panel(base=scene, seconds=seconds, **lists, **panel)
