"""Study of time steps: orders of the explicit and the implicit march, and the stability limit.

Both marches use the same compliance as the relaxation modes, which are exact in time. Their
difference to the modes is therefore the error of the time steps alone. The explicit march is stable
for steps below 2 / (largest relaxation rate). On the uniform grid of the paper with n springs, this
limit is about ``4/(pi n k)``. The modal march has no time step.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ...mdr.energy import compliance
from ...mdr.uniform_grid import UniformGrid
from ..crosscheck import Problem, RunningIn, Scene, SceneError
from ..crosscheck.methods.spaces import radial_space
from ..study.levels import Family, Record, Theory
from ..study.options import Options
from ..study.study import Study
from ..study.study_orders import study_orders
from ..tables import Row

TIME = 0.5
"""Time at which errors are computed, non-dimensional."""
ERROR = "indentation error"
LIMIT = "limit over 4/(pi n k), less 1"
NO_GRID = (
    "The paper's grid is left out: it needs a full disc with one wear coefficient on each ring."
)
XLABEL = r"step $\Delta t$ over $a/(E^*k_{max}v_0)$"


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Compute the errors of several time steps, and the stability limit of the paper's grid."""
    problem = replace(scene.problem, times=np.array([]))
    # the space is so coarse that the explicit march is stable in a few thousand steps
    space = radial_space(problem, degree=2, rim_size=0.02, ring_size=0.02, grading=0.5)
    wear = RunningIn(compliance(space), problem.merged.wear_coefficients)
    longest = TIME * problem.units.time
    wrong = [step for step in options.steps if not 0 < step <= longest]
    if wrong:
        raise SceneError(f"--steps {wrong[0]:g}: give steps above 0, up to {longest:.3g}")
    requested_counts = [round(longest / step) for step in options.steps]
    factors = 2 ** np.arange(4 if options.quick else 7)
    marches = [
        refine_step(wear, march, requested_counts or (first_count(wear, march) * factors).tolist())
        for march in ("explicit", "implicit")
    ]
    label = f"relative error at $t$ = {TIME:g}"
    if problem.inner_radius or problem.merged.linear:
        study = study_orders(marches, record, "march", scene, label)
        return replace(study, conclusions=(*study.conclusions, NO_GRID))
    springs = (25, 50) if options.quick else (25, 50, 100, 200, 400)
    return study_orders([*marches, refine_grid(problem, springs)], record, "march", scene, label)


def first_count(wear: RunningIn, march: str) -> int:
    """Return the first number of steps: explicit steps are stable, implicit ones are far longer."""
    return int(np.ceil(TIME / (0.5 * wear.stability_limit()))) if march == "explicit" else 8


def refine_step(wear: RunningIn, march: str, counts: Iterable[int]) -> Family:
    """Return numbers of steps up to `TIME`, with the errors of the indentation at that time."""
    times = np.array([TIME])
    exact = wear.modal(times).indentation[0]

    def solve(steps: int) -> Row:
        indentation = wear.history(times, march, TIME / steps).indentation[0]
        return {"unknowns": wear.compliance.space.size, ERROR: float(indentation / exact - 1)}

    sizes = {steps: TIME / steps for steps in counts}
    return Family(f"{march} march", sizes, solve, {ERROR: Theory(1.0)}, XLABEL)


def refine_grid(problem: Problem, springs: tuple[int, ...]) -> Family:
    """Return grids of the paper, with their stability limit relative to that for many springs."""

    def solve(count: int) -> Row:
        ring_edges, (wear_coefficients, _) = problem.merged
        grid = UniformGrid(ring_edges, wear_coefficients, count)
        greatest_rate = np.abs(np.linalg.eigvals(grid.rate_matrix())).max()
        return {"unknowns": count, LIMIT: float(2 / greatest_rate / grid.stability_limit() - 1)}

    sizes = {count: 1 / count for count in springs}
    name = "explicit march on the paper's grid"
    return Family(name, sizes, solve, {LIMIT: Theory()}, "1 / number of springs")
