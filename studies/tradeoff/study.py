"""Speed against accuracy: seconds, tolerance, stated error and true error of every method.

Each group of quantities is asked for alone, to several tolerances. A true error is the greatest of
the quantities of the group, each in its norm, against a solution by another theory to a finer
accuracy: boundary elements for MDR, and MDR for all others.
"""

import os
import platform
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from ...meshes.errors import SceneError
from ..scene.scene import Scene
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
"""Non-dimensional times of a scene that has none."""


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Measure every method, and conclude what a digit costs and how far estimates are off.

    Raises
    ------
    SceneError
        if a method is not known to the study
    RingwearError
        if the reference cannot be computed
    """
    names = choose_methods(options)
    problem = scene.problem
    if not problem.earliest:
        problem = replace(problem, times=np.array(DEFAULT_TIMES))
    with threadpool_limits(1):
        if options.quantities:
            families = list(families_of_quantities(scene, options, names))
        else:
            families = list(Ways.of(problem, names, options.quick).families())
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
            *list_what_is_left_out(names, scene, options),
            f"Measured on {platform.platform()}, one thread of {os.cpu_count()}; seconds are "
            "medians of at least three runs.",
            *record.conclusions,
        ),
        figures={"tradeoff": draw(rows, effectivities, scene.title)} if len(rows) else {},
        tables={name: found for name, found in tables.items() if len(found)},
    )


def choose_methods(options: Options) -> tuple[str, ...]:
    """Return the methods and marches that are measured.

    Raises
    ------
    SceneError
        if one of those asked for is not known, or does not give quantities of the user's own
    """
    known: Sequence[str] = BY_TOLERANCE if options.quantities else WAYS
    for name in options.methods:
        if name not in known:
            which = "quantities of one's own" if options.quantities else "study tradeoff"
            raise SceneError(f"methods: {which} has no {name!r}: give some of {', '.join(known)}")
    return options.methods or tuple(known)


def list_what_is_left_out(names: tuple[str, ...], scene: Scene, options: Options) -> Iterator[str]:
    """Yield what is not measured for a scene, with the reason."""
    known = TOLERANCES[scene.problem.contact].knows_others
    if NAIVE in names and not known and not options.quantities:
        yield (
            "Left out for a shaped punch: the naive finite elements, whose nodes stick to the "
            "whole face, and Euler's marches and the paper's grid, which are of full contact."
        )
