"""Runs along one parameter: true error and error estimate of every method, and the naive solver.

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

from ..crosscheck import Problem, RingwearError, Scene, Solution, Stages, differences, method
from ..crosscheck.problem.fields import TomlTable
from ..crosscheck.verdict.accuracy import solved_to_accuracy
from ..crosscheck.verdict.promise import allowed_error
from ..study.levels import Family
from ..tables import Row
from . import naive
from .oracles import judge_by_reference, judge_by_theory, other_theory, solve_reference
from .verdicts import Verdict, rank_by_error, worst_of

NAIVE = "naive"
"""Name of the naive finite elements among the methods."""
METHODS = ("mdr", "bem", "fem")
"""Methods of a panel that lists none."""
FORMULAS: dict[str, Callable[[float], float]] = {
    "x": lambda x: x,
    "0.5 + x": lambda x: 0.5 + x,
    "1 - x": lambda x: 1 - x,
    "(1 - x) / 2": lambda x: (1 - x) / 2,
    "1 / x, from 5 to 40": lambda x: int(np.clip(round(1 / x), 5, 40)),
}
"""Functions of x, by the texts that stand for them in `panels.toml`."""

Setting = tuple[float, str]
"""The value of the parameter, and the method."""


@dataclass(frozen=True)
class Panel:
    """One parameter x, its values, and the scene keys that it changes.

    Parameters
    ----------
    name : name of the parameter
    xlabel : label of its axis
    values, quick : values of x, in the full and in the quick study
    changes : new values of scene keys, in which texts of `FORMULAS` stand for numbers
    base : scene to change
    naive_failure : reason why the naive finite elements fail
    fails_at : value of x at which their error is above one per cent (a test checks it)
    methods : methods to run; a far field or a march may follow after a comma
    naive_changes : arguments of the naive solver, in which texts of `FORMULAS` stand for numbers
    reference : tolerance of the reference solution that errors are measured against
    seconds : expected seconds of a run by each method
    linear : whether the axis of x is linear, not logarithmic
    zero_at : position at which x = 0 is drawn on a logarithmic axis
    """

    name: str
    xlabel: str
    values: tuple[float, ...]
    quick: tuple[float, ...]
    changes: TomlTable
    base: Scene
    naive_failure: str
    fails_at: float
    methods: tuple[str, ...] = METHODS
    naive_changes: TomlTable = field(default_factory=dict)
    reference: float = 1e-6
    seconds: Mapping[str, float] = field(default_factory=dict)
    linear: bool = False
    zero_at: float | None = None

    def scene(self, x: float, method_name: str) -> Scene:
        """Return the scene at a value of the parameter, for one method.

        Changes of the sizes of other methods are left out.

        Raises
        ------
        SceneError
            if the scene cannot have that value
        """
        sections = {"fem": "accuracy.fem.", "mdr": "accuracy.mdr.", "bem": "accuracy.mdr."}
        section = sections.get(method_name.split(",")[0])
        changes = {
            key.replace(".", "__"): value_at(x, value)
            for key, value in self.changes.items()
            if not key.startswith(("accuracy.fem.", "accuracy.mdr.")) or f"{section}" in key
        }
        return self.base.changed(**changes)

    def family(self, quick: bool) -> Family:
        """Return the runs of the panel: every method and the naive solver at every x.

        The quick study leaves out boundary elements: they have the pressure space of the MDR, and
        their errors are the same.
        """
        # the quick study saves time with references at ten times the tolerance
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
        """Return the row of a run: its worst verdict, its greatest error and greatest estimate."""
        (x, name), start = setting, time.perf_counter()
        verdicts: list[Verdict] = []
        row: TomlTable = {"part": "panel", "method": name, "x": x}
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
                # the reference has values at the radii of this face only
                problem = replace(problem, compared_on=problem.face)
                exact = reference(x, other_theory(name))
                verdicts.extend(judge_by_reference(problem, name, solution, exact))
                verdicts.extend(judge_by_theory(scene, problem, solution))
                return verdicts

            row |= worst_of(judge, rank_by_error)
        if verdicts:
            row["greatest error"] = max(verdict["error"] for verdict in verdicts)
            row["greatest estimate"] = max(verdict["estimate"] for verdict in verdicts)
        return {"seconds": round(time.perf_counter() - start, 4)} | row

    def _solve_reference(self, rtol: float, x: float, name: str) -> Solution:
        """Return the reference solution by a method at one value of x."""
        problem = self.scene(x, name).problem
        return solve_reference(problem, name, min(rtol, 0.1 * problem.rtol))

    def _judge_naive(self, x: float, reference: "Callable[[float, str], Solution]") -> Row:
        """Return the columns of the naive solver: its greatest error, infinite if it overflows."""
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
    """Return the greatest errors of the naive solver in the indentation and the pressure.

    Parameters
    ----------
    panel, x : the panel, and the value of its parameter
    exact : reference solution
    """
    problem = panel.scene(x, NAIVE).problem
    arguments = {key: value_at(x, value) for key, value in panel.naive_changes.items()}
    with np.errstate(all="ignore"):
        values = naive.solve(problem, **arguments)
        compared = {
            name: value[problem.compared_rows] if name != "time" else value
            for name, value in values.items()
        }
        errors = differences(compared, exact.compared, problem.face)
    given_quantity = problem.prescribed
    return {
        name: float(np.nan_to_num(np.max(error), nan=np.inf))
        for name, error in errors.items()
        if name != given_quantity
    }


def with_variant(problem: Problem, name: str, x: float) -> Problem:
    """Return a problem with the far field or the march that follows in the name of a method.

    The value x is the time step of a march, in the unit of the scene.
    """
    variant = name.partition(", ")[2]
    if variant == "clamped":
        return replace(problem, fem=problem.fem.model_copy(update={"far_field": "fixed"}))
    if variant:
        return replace(problem, march=variant, step=x / problem.units.time)
    return problem


def value_at(x: float, template: Any) -> Any:
    """Return a value of a scene key at x: texts of `FORMULAS` in the template become numbers."""
    if isinstance(template, str):
        return FORMULAS[template](x) if template in FORMULAS else template
    if isinstance(template, dict):
        return {key: value_at(x, value) for key, value in template.items()}
    return [value_at(x, value) for value in template] if isinstance(template, list) else template


def read_panels(poisson_ratio: float) -> Iterator[Panel]:
    """Yield the panels of `panels.toml`, with a Poisson's ratio unless a panel changes it."""
    listing = files("ringwear.studies") / "extremes" / "panels.toml"
    table = tomllib.loads(listing.read_text("utf-8"))
    base = Scene.from_table(table["base"]).changed(half_space__poisson_ratio=poisson_ratio)
    for panel in table["panels"]:
        scene = base.changed(**panel.pop("scene", {}))
        seconds = table["seconds"] | panel.pop("seconds", {})
        lists: TomlTable = {
            key: tuple(panel.pop(key)) for key in ("values", "quick", "methods") & panel.keys()
        }
        yield Panel(base=scene, seconds=seconds, **lists, **panel)
