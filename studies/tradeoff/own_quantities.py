"""Quantities of the user's own: functions of the result of a run, measured by tolerance."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from ..extremes.oracles import other_theory
from ..outcome.run import run
from ..scene.scene import Scene
from ..study.levels import Family
from ..study.options import Options, Quantity
from ..tables import Row
from .measure import row_of_accuracy, time_runs
from .tolerances import TOLERANCES
from .ways import expected_seconds, tolerance_of


def families_of_quantities(
    scene: Scene, options: Options, names: tuple[str, ...]
) -> Iterator[Family]:
    """Yield a family for each quantity of the user's own and each method."""
    problem, tolerances = scene.problem, TOLERANCES[scene.problem.contact]
    finest = scene.changed(accuracy={"rtol": tolerances.of_reference(options.quick)})
    needed = dict.fromkeys(map(other_theory, names))
    references = {name: run(finest, [name]) for name in needed}
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
    """Return the row of a level of a quantity of the user's own."""
    tolerance = tolerance_of(setting)
    row = {"group": label, "method": name, "tolerance": tolerance, "worst quantity": label}
    return {**row, **measure_quantity(name, scene, quantity, exact, tolerance)}


def measure_quantity(name: str, scene: Scene, quantity: Quantity, exact: float, rtol: float) -> Row:
    """Return seconds and true error of a function of the result of a run.

    Functions of a result have no error estimate.

    Parameters
    ----------
    name : of the method
    scene : that is run
    quantity : function of the result
    exact : its value by another theory, to a finer accuracy
    rtol : accuracy that is asked for
    """
    asked = scene.changed(accuracy__rtol=rtol)
    result, timing = time_runs(lambda: run(asked, [name]))
    error = abs(float(quantity(result)) / exact - 1) if exact else abs(float(quantity(result)))
    unknowns = result.solutions[name].unknowns
    return {"unknowns": unknowns, **timing.row, **row_of_accuracy(error, np.nan)}
