"""Work and precision: error against processor seconds, for every method and group of quantities.

Each group is asked for alone, at accuracies from 1e-1 on. Errors are the greatest of its
quantities, each in its norm, against an MDR of an accuracy of its own; seconds are of one thread
for one whole solution with its estimate, the least of some repeats after a warm-up.
"""

import os
import platform
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ..crosscheck.agreement import compare
from ..methods.base import Solution, method
from ..problem.problem import Problem
from ..problem.quantities import GROUPS
from ..problem.scene import Scene
from ..problem.sections import MdrAccuracy
from ..progress import Stages
from ..study.errors_over_size import Curves, draw_errors
from ..study.levels import Family, Record, Theory
from ..study.options import Options
from ..study.orders import Sequence
from ..study.study import Study
from ..tables import Row

# what is asked for alone
ASKED = {
    "indentation, force, relaxation times": frozenset(
        ["indentation", "normal_force", "relaxation_time"]
    ),
    "history": GROUPS["history"],
    "fields": GROUPS["fields"],
    "steady state": GROUPS["steady"],
}
BY_DIAL = ("mdr", "bem", "fem")


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Measure every method, and conclude what a digit more costs."""
    problem = replace(scene.problem, march="modal", step=None)
    if not problem.earliest:
        problem = replace(problem, times=np.array([0.01, 0.1, 1.0]))
    columns = ["group", "method", "setting", "unknowns", "seconds", "error", "estimate", "rtol"]
    measured = families(problem, options.quick)
    table = record.solve("tradeoff", measured, columns)
    rows, conclusions = table.dropna(subset="error"), list(record.conclusions)
    for group, of_group in rows.dropna(subset="rtol").groupby("group", sort=False):
        costs = []
        for name, of_method in of_group.groupby("method", sort=False):
            seconds, rtols = (of_method[column].iloc[[0, -1]] for column in ("seconds", "rtol"))
            # of one accuracy alone, after an early interruption, no digit is told
            if np.ptp(rtols):
                cost = (seconds.iloc[1] / seconds.iloc[0]) ** (1 / np.ptp(np.log10(rtols)))
                costs.append(f"{name} {cost:.2f}")
        if costs:
            told = f"{group}: a digit more costs, in times the seconds, {', '.join(costs)}."
            conclusions.append(told)
    conclusions.append(f"Measured on {platform.platform()}, one thread of {os.cpu_count()}.")
    figures = {"tradeoff": draw(rows)}
    return Study("tradeoff", scene, table, conclusions=tuple(conclusions), figures=figures)


def families(problem: Problem, quick: bool) -> Iterator[Family]:
    """Yield a family of problems for each group of quantities and each method.

    Each method is asked for several accuracies. For histories of flat punches, the implicit march
    is also asked for several time steps, and `mdr-grid` for several numbers of springs on the
    uniform grid.
    """
    dial = [1e-1, 1e-2, 1e-4] if quick else [10.0**-digits for digits in range(1, 9)]
    exact_problem = replace(problem, rtol=1e-3 * min(dial) if quick else 1e-9)
    if not problem.full_contact:
        # matrices on cells are dense
        dial = dial[: 2 if quick else 4]
        exact_problem = replace(problem, rtol=max(0.01 * min(dial), 1e-5))
    exact = method("mdr").solve(exact_problem, Stages("mdr"))
    # at the radii of the exact one
    problem = replace(problem, compared_on=exact_problem.face)
    for group, quantities in ASKED.items():
        alone = problem.asking_for(quantities)
        by_dial = {f"rtol {rtol:.0e}": replace(alone, rtol=rtol) for rtol in dial}
        # nothing is steady at a fixed indentation
        ways = {} if method("mdr").refusal(alone) else dict.fromkeys(BY_DIAL, by_dial)
        if problem.full_contact and quantities <= GROUPS["history"]:
            stepped = replace(alone, march="implicit", rtol=1e-4)
            ways["mdr implicit"] = {
                f"step {step:g}": replace(stepped, step=step) for step in (0.1, 0.01, 0.001)
            }
            ways["mdr-grid"] = {
                f"n = {count}": replace(alone, mdr=MdrAccuracy(grid=count))
                for count in ((100, 200) if quick else (100, 200, 400))
            }
            if problem.inner_radius:
                # it knows discs only
                del ways["mdr-grid"]
        for name, problems in ways.items():
            solve = partial(measure, group, name, problems, exact, quick)
            yield Family(f"{group}, {name}", dict.fromkeys(problems, np.nan), solve)


def measure(
    group: str, name: str, problems: dict[str, Problem], exact: Solution, quick: bool, setting: str
) -> Row:
    """Measure seconds (the least of five repeats, or one), error and the method's estimate."""
    problem, seconds = problems[setting], []
    for _ in range(2 if quick else 6):
        start = time.process_time()
        solution = method(name.split()[0]).solve(problem, Stages(name))
        seconds.append(time.process_time() - start)
    compared = compare(problem, (solution, exact)).values()
    return {
        "group": group,
        "method": name,
        "unknowns": solution.unknowns,
        "seconds": min(seconds[1:]),  # the first is a warm-up
        "error": max(float(np.max(difference.size)) for difference in compared),
        "estimate": max(float(np.max(difference.first)) for difference in compared),
        "rtol": problem.rtol if name in BY_DIAL else np.nan,
    }


def draw(rows: pd.DataFrame) -> Figure:
    """Draw errors over seconds, a panel for each group."""
    panels = dict[str, Curves]()
    for (group, name), of_method in rows.groupby(["group", "method"], sort=False):
        values = of_method[["seconds", "error"]].to_numpy(float).T
        curve = Sequence(name, group, Theory(), *values)
        panels.setdefault(f"processor seconds, {group}", {})[name] = curve
    return draw_errors(panels, "greatest relative error")
