"""Quantities of the user: functions of the result of a run, measured at several tolerances."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from ..crosscheck import Scene
from ..crosscheck.result.run import run
from ..extremes.oracles import other_theory
from ..study.levels import Family
from ..study.options import Options, Quantity
from ..tables import Row
from .measure import row_of_accuracy, time_runs
from .tolerances import TOLERANCES
from .ways import expected_seconds, tolerance_of


def families_of_quantities(
    scene: Scene, options: Options, names: tuple[str, ...]
) -> Iterator[Family]:
    """Yield a family for each quantity of the user and each method."""
    problem, tolerances = scene.problem, TOLERANCES[scene.problem.full_contact]
    finest = scene.changed(accuracy={"rtol": tolerances.of_reference(options.quick)})
    reference_methods = dict.fromkeys(map(other_theory, names))
    references = {name: run(finest, [name]) for name in reference_methods}
    settings = [f"rtol {rtol:.0e}" for rtol in tolerances.asked(options.quick)]
    for label, quantity in options.quantities.items():
        for name in names:
            exact = float(quantity(references[other_theory(name)]))
            solve = partial(_solve_quantity, label, name, scene, quantity, exact)
            yield Family(
                f"{label}, {name}",
                dict.fromkeys(settings, np.nan),
                solve,
                work=partial(expected_seconds, problem, name),
            )


def _solve_quantity(
    label: str, name: str, scene: Scene, quantity: Quantity, exact: float, setting: str
) -> Row:
    """Return the row of one level of a quantity of the user."""
    tolerance = tolerance_of(setting)
    row = {"group": label, "method": name, "tolerance": tolerance, "worst quantity": label}
    return {**row, **measure_quantity(name, scene, quantity, exact, tolerance)}


def measure_quantity(name: str, scene: Scene, quantity: Quantity, exact: float, rtol: float) -> Row:
    """Return seconds and true error of a function of the result of a run.

    Functions of a result have no error estimate.

    Parameters
    ----------
    name : name of the method
    scene : scene to run
    quantity : function of the result
    exact : its value by another theory at a finer tolerance
    rtol : tolerance of the run
    """
    scene_at_rtol = scene.changed(accuracy__rtol=rtol)
    result, timing = time_runs(lambda: run(scene_at_rtol, [name]))
    error = abs(float(quantity(result)) / exact - 1) if exact else abs(float(quantity(result)))
    unknowns = result.solutions[name].unknowns
    return {"unknowns": unknowns, **timing.row, **row_of_accuracy(error, np.nan)}
