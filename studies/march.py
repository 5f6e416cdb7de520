"""March: which time step a history needs, at the times of a scene and in its units.

Steps and relaxation modes use the same coarse space. The modes are exact in time, so that the
difference is the error of the time steps alone. The explicit march is stable for steps below
2 / (greatest relaxation rate). This limit is lower on finer elements: on the uniform grid of the
paper with n springs, it is about ``4/(pi n k)``.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..meshes import SceneError
from .crosscheck import Problem, Source
from .study.declared import Declared, conduct
from .study.own import Quantities, accept, read_quantities, steps_of, with_times
from .study.record import Record
from .study.reference import Reference, solution_as_reference
from .study.study import Study
from .study.way import Case
from .study.ways import runs

PARTS = tuple(0.5 / 2**n for n in range(1, 9))
"""Steps of the implicit march whose order is fitted, over the earliest time after the start."""
LONG_FACTOR, QUICK_LONG_FACTOR, MOST_LONG = 2.0, 4.0, 2000.0
"""Ratio of longer steps, and the longest one over the earliest time."""
EXPLICIT = tuple(0.5 / 2**n for n in range(7))
"""Steps of the explicit march, over the greatest stable one."""
QUICK_LEVELS = 4
QUANTITIES = ("indentation", "normal_force", "pressure", "ring_force", "profile")


def march(
    scene: Source = "five_rings",
    *,
    steps: Sequence[float] = (),
    quantities: Quantities = None,
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Tell which time step a history needs, by both Euler marches.

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
    scene = with_times(accept("march", scene))
    names, functions = read_quantities(quantities, QUANTITIES)
    if scene.problem.loading.varies:
        raise SceneError("study march is about a constant load: give load.normal_force one number")
    case, last = Case.of(scene), slice(QUICK_LEVELS if quick else None)
    problem, given, words = case.problem, steps_of(scene, steps), scene.unit_names
    limit, earliest = runs.coarse_stability_limit(problem), problem.earliest
    stable = [step for step in given if step <= limit]
    explicit = stable if given else [min(part * limit, earliest) for part in EXPLICIT[last]]
    implicit = given or [part * earliest for part in PARTS[last]]
    ways = [runs.steps("implicit", implicit, problem)]
    if not given:
        longer = longer_steps(problem, QUICK_LONG_FACTOR if quick else LONG_FACTOR)
        # longer steps have no order
        ways[0] = replace(ways[0], levels=[*longer, *implicit], largest=implicit[0])
    if explicit:
        ways.append(runs.steps("explicit", sorted(set(explicit))[::-1], problem))

    def exact(case: Case) -> Reference:
        return solution_as_reference(runs.on_coarse_space(case.problem))

    unit = words.name("time")
    written = words.write(limit * problem.units.time, "time", 3)
    unstable = ", ".join(f"{step * problem.units.time:.4g}" for step in given if step > limit)
    left_out = f"; the explicit march leaves out the steps {unstable}" if unstable else ""
    stability = f"Explicit steps are stable below {written} on the coarse elements of this study"
    declared = Declared(
        *("march", "which time step does a history need?", scene, [case], lambda _: ways),
        *(QUANTITIES, exact, "step", names or ("indentation", "pressure", "ring_force", "profile")),
        functions=functions,
        labels={"step": "time step" + f" ({unit})" * (unit != "1")},
        remarks=[f"{stability}{left_out}."],
    )
    return conduct(declared, record, quick)


def longer_steps(problem: Problem, factor: float) -> list[float]:
    """Return steps from the last time, or `MOST_LONG` earliest ones, down to the earliest."""
    longest = min(float(problem.distances[-1]), MOST_LONG * problem.earliest)
    count = 1 + int(np.ceil(np.log(longest / problem.earliest) / np.log(factor)))
    return np.geomspace(longest, problem.earliest, max(count, 1)).tolist()
