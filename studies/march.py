"""March: which time step a history needs, at the times of a scene and in its units.

Steps and relaxation modes use the same coarse space. The modes are exact in time, so that the
difference is the error of the time steps alone. The explicit march is stable for steps below
2 / (greatest relaxation rate). This limit is lower on finer elements: on the uniform grid of the
paper with n springs, it is about ``4/(pi n k)``.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from ..mdr import UniformGrid
from ..meshes import SceneError
from .crosscheck import Problem, Scene, Source, method
from .study.accept import accept, steps_of
from .study.draw import draw, titled
from .study.measure import measure
from .study.own import Quantities, read_quantities
from .study.record import Record
from .study.reference import Reference, solution_as_reference
from .study.study import Study, choose_parts, remarks
from .study.theory import conclude_orders, observed_orders
from .study.way import Case, Part
from .study.ways.runs import coarse_stability_limit, on_coarse_space, steps_on_coarse_space

PARTS = tuple(0.5 / 2**n for n in range(1, 9))
"""Steps of the implicit march whose order is fitted, over the earliest time after the start."""
LONG_FACTOR, QUICK_LONG_FACTOR, MOST_LONG = 2.0, 4.0, 2000.0
"""Ratio of longer steps, and the longest one over the earliest time."""
LONG = "implicit Euler, longer steps"
"""Name of the way through steps too long for an order."""
EXPLICIT = tuple(0.5 / 2**n for n in range(7))
"""Steps of the explicit march, over the greatest stable one."""
QUICK_LEVELS, IMPLICIT = 4, "implicit Euler"
QUANTITIES = ("indentation", "normal_force", "pressure", "ring_force", "profile")
GOALS = (1e-2, 1e-3)
"""Errors for which the longest step is reported."""
SPRINGS, QUICK_SPRINGS = (25, 50, 100, 200, 400), (25, 50)
"""Numbers of springs for which the stability limit of the paper's grid is listed."""


def march(
    scene: Source = "five_rings",
    *,
    steps: Sequence[float] = (),
    quantities: Quantities = None,
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Compute the errors of both Euler marches at the times of a scene, and the step they need.

    Parameters
    ----------
    scene : a scene of a flat punch under a constant load
    steps : steps of both marches in the unit of the scene, from coarse to fine
    quantities : names as in results.nc, and functions of a result; the named ones are drawn
    quick : whether to use fewer steps
    record : rows so far, and the file that they are written to

    Raises
    ------
    SceneError
        if the scene or an option does not fit the study
    """
    scene = accept("march", scene, radial_wear=True)
    names, functions = read_quantities(quantities, QUANTITIES)
    scene, record = with_times(scene), record or Record()
    if scene.problem.loading.varies:
        raise SceneError("study march is about a constant load: give load.normal_force one number")
    case, last = Case.of(scene), slice(QUICK_LEVELS if quick else None)
    problem, unit = case.problem, case.problem.units.time
    limit, earliest = coarse_stability_limit(problem), problem.earliest
    given = steps_of(scene, steps)
    implicit = given or [part * earliest for part in PARTS[last]]
    stable = [step for step in given if step <= limit]
    explicit = stable if given else [min(part * limit, earliest) for part in EXPLICIT[last]]
    ways = [steps_on_coarse_space("implicit", implicit, problem)]
    if not given:
        longer = longer_steps(problem, QUICK_LONG_FACTOR if quick else LONG_FACTOR)
        ways = [replace(steps_on_coarse_space("implicit", longer, problem), name=LONG), *ways]
    if explicit:
        ways.append(steps_on_coarse_space("explicit", sorted(set(explicit))[::-1], problem))

    def exact(case: Case) -> Reference:
        return solution_as_reference(on_coarse_space(case.problem))

    table = measure([case], ways, QUANTITIES, record, functions, exact)
    table = table[table["when"] != "start"].assign(step=table["size"] * unit)
    fits = observed_orders(table, [way for way in ways if way.name != LONG])
    drawn = choose_parts(table, [(name, "later") for name in QUANTITIES], (*names, *functions))
    needed = longest_steps(table)
    words = scene.unit_names
    limits = stability_limits(problem, QUICK_SPRINGS if quick else SPRINGS, unit)
    title = titled(scene.title, "errors of time steps alone")
    xlabel = f"time step ({words.name('time')})" if words.name("time") != "1" else "time step"
    figures = {
        "march": draw(
            drawn.assign(size=drawn["step"]),
            panels=("quantity", "when"),
            orders=fits,
            title=title,
            xlabel=xlabel,
        )
    }
    sentences = (
        *conclude_steps(needed, limit * unit, scene),
        *left_out_steps(given, limit, unit, scene),
        *conclude_orders(fits),
        *([] if len(limits) else [NO_GRID]),
        *remarks(record, quick),
    )
    tables = {"longest_steps": needed, "paper_grid": limits}
    kept = {name: rows for name, rows in tables.items() if len(rows)}
    return Study("march", scene, table, fits, sentences, figures, kept)


NO_GRID = (
    "The paper's grid is left out: it needs a full disc with one wear coefficient on each ring."
)


def with_times(scene: Scene) -> Scene:
    """Return a scene with times; one without any gets a time at which half of it has run in."""
    if scene.problem.earliest:
        return scene
    return scene.changed({"wear.times": [0.0, 0.5 * scene.problem.units.time]})


def left_out_steps(
    given: Sequence[float], limit: float, unit: float, scene: Scene
) -> Iterator[str]:
    """Yield which steps of a user the explicit march cannot take."""
    unstable = [f"{step * unit:.4g}" for step in given if step > limit]
    if unstable:
        yield (
            f"The explicit march leaves out the steps {', '.join(unstable)}, which are longer than "
            f"its stability limit, {scene.unit_names.write(limit * unit, 'time', 3)}."
        )


def longer_steps(problem: Problem, factor: float) -> list[float]:
    """Return steps from the last time, or `MOST_LONG` earliest ones, down to the earliest."""
    longest = min(float(problem.distances[-1]), MOST_LONG * problem.earliest)
    count = 1 + int(np.ceil(np.log(longest / problem.earliest) / np.log(factor)))
    return np.geomspace(longest, problem.earliest, max(count, 1)).tolist()


def longest_steps(table: pd.DataFrame) -> pd.DataFrame:
    """Return the longest step with which each march keeps each goal, for each quantity."""
    rows, all_levels = [], table.dropna(subset=["error"])
    # both ways of the implicit march are one here
    marches = all_levels["way"].replace(LONG, IMPLICIT)
    for (way, quantity), levels in all_levels.groupby([marches, "quantity"], sort=False):
        errors, steps = levels["error"].abs().to_numpy(), levels["step"].to_numpy(float)
        for goal in GOALS:
            # longer steps may err less by chance
            too_long = steps[errors > goal].min(initial=np.inf)
            within = steps[steps < too_long]
            rows.append(
                {
                    "way": way,
                    "quantity": quantity,
                    "goal": goal,
                    "longest step": within.max(initial=0.0) or np.nan,
                    "longest tried": steps.max(),
                    "least error": errors.min(),
                }
            )
    return pd.DataFrame(rows)


def conclude_steps(needed: pd.DataFrame, limit: float, scene: Scene) -> Iterator[str]:
    """Yield which steps a pressure, an indentation and a profile need, and the stability limit."""
    if not len(needed):
        return
    words = scene.unit_names
    stable = f"explicit steps are stable below {words.write(limit, 'time', 3)}"
    of_implicit = needed[needed["way"] == IMPLICIT]
    for number, (quantity, rows) in enumerate(
        sorted(of_implicit.groupby("quantity", sort=False), key=lambda pair: pair[0] != "pressure")
    ):
        parts = list[str]()
        for row in rows.to_dict("records"):
            step = words.write(row["longest step"], "time", 3)
            needs = f"needs steps of at most {step}"
            if np.isnan(row["longest step"]):
                needs = (
                    f"needs shorter steps than were tried (least error {row['least error']:.1e})"
                )
            elif row["longest step"] == row["longest tried"]:
                needs = f"is kept by every step that was tried, up to {step}"
            parts.append(f"within {100 * row['goal']:g} % {needs}")
        tail = f"; {stable} on the coarse elements of this study" if not number else ""
        yield f"{Part(str(quantity))} {', '.join(parts)}{tail}."


def stability_limits(problem: Problem, springs: Sequence[int], unit: float) -> pd.DataFrame:
    """Return the greatest stable step of the paper's grid, and that for many springs.

    The table is empty if the grid cannot represent the punch.
    """
    if method("mdr-grid").beyond(problem) or problem.merged.linear or problem.inner_radius:
        return pd.DataFrame()
    rows = []
    for count in springs:
        ring_edges, (wear_coefficients, _) = problem.merged
        grid = UniformGrid(ring_edges, wear_coefficients, count)
        greatest_rate = np.abs(np.linalg.eigvals(grid.rate_matrix())).max()
        limit = grid.stability_limit()
        rows.append(
            {
                "springs": count,
                "stable step": 2 / greatest_rate * unit,
                "4/(pi n k)": limit * unit,
                "relative difference from 4/(pi n k)": 2 / greatest_rate / limit - 1,
            }
        )
    return pd.DataFrame(rows)
