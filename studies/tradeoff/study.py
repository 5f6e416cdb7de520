"""Speed against accuracy: seconds, tolerance, error estimate and true error of every method.

Each group of quantities is computed by itself at several tolerances. The true error of a level is
the greatest error of the quantities of the group, each in its norm, relative to a reference by
another theory at a finer tolerance: boundary elements for MDR, and MDR for all other methods.
"""

import os
import platform
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from ..crosscheck import METHODS, Scene, SceneError, method
from ..crosscheck.problem.written import shown
from ..study.levels import Record
from ..study.options import Options
from ..study.study import Study
from .draw import draw
from .own_quantities import families_of_quantities
from .prices import (
    conclude_effectivities,
    conclude_prices,
    list_effectivities,
    list_prices,
)
from .tolerances import TOLERANCES
from .ways import BY_TOLERANCE, NAIVE, WAYS, Ways

COLUMNS = [
    "group",
    "method",
    "setting",
    "unknowns",
    "seconds",
    "least seconds",
    "greatest seconds",
    "runs",
    "tolerance",
    "estimate",
    "error",
    "effectivity",
    "worst quantity",
    "estimate of the reference",
]
DEFAULT_TIMES = (0.01, 0.1, 1.0)
"""Times in a/(E* k_max v0) for a scene that has none after the start."""


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Measure every method, and conclude the price of a digit and the effectivity of estimates.

    Raises
    ------
    SceneError
        if the study has no method of a given name
    RingwearError
        if the reference cannot be computed
    """
    names = choose_methods(options)
    problem = scene.problem
    if not problem.earliest:
        problem = replace(problem, times=np.array(DEFAULT_TIMES))
    for name in options.methods:
        if name in METHODS and (reason := method(name).refusal(problem)):
            raise SceneError(reason)
    with threadpool_limits(1):
        if options.quantities:
            families = list(families_of_quantities(scene, options, names))
        else:
            families = list(Ways.with_references(problem, names, options.quick).families())
    table = record.solve("tradeoff", families, COLUMNS)
    rows = table.dropna(subset="error")
    numbers = ["seconds", "least seconds", "greatest seconds", "tolerance", "estimate", "error"]
    rows = rows.astype(dict.fromkeys([*numbers, "effectivity"], float))
    prices, effectivities = list_prices(rows), list_effectivities(rows)
    tables = {"digit_price": prices, "effectivity": effectivities}
    return Study(
        "tradeoff",
        scene,
        table,
        conclusions=(
            *conclude_effectivities(effectivities),
            *conclude_prices(prices),
            *list_omissions(names, scene, options),
            f"Measured on {platform.platform()}, one thread of {os.cpu_count()}; seconds are "
            "medians of at least three runs.",
            *record.conclusions,
        ),
        figures={"tradeoff": draw(rows, effectivities, scene.title)} if len(rows) else {},
        tables={name: table for name, table in tables.items() if len(table)},
    )


def choose_methods(options: Options) -> tuple[str, ...]:
    """Return the methods and marches to measure: those of the options, or else all.

    Raises
    ------
    SceneError
        if the study has no method of a given name, or if it cannot compute quantities of the user
    """
    known: Sequence[str] = BY_TOLERANCE if options.quantities else WAYS
    for name in options.methods:
        if name not in known:
            which = (
                "study tradeoff with your quantities" if options.quantities else "study tradeoff"
            )
            raise SceneError(
                f"methods: {which} has no {shown(name)}: give some of {', '.join(known)}"
            )
    return options.methods or tuple(known)


def list_omissions(names: tuple[str, ...], scene: Scene, options: Options) -> Iterator[str]:
    """Yield the methods that are left out for a scene, with the reason."""
    applicable = TOLERANCES[scene.problem.full_contact].with_full_contact_methods
    if NAIVE in names and not applicable and not options.quantities:
        yield (
            "Left out for a shaped punch: the naive finite elements, because their nodes stick to "
            "the whole face, and Euler's marches and the paper's grid, because they assume full "
            "contact."
        )
