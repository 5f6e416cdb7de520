"""Steps in time: orders of the explicit and the implicit march, and where the former blows up.

Both march the compliance on which the modes are exact: their difference is the step's alone. The
explicit march is stable below two over the greatest rate of relaxation: on the uniform grid of the
paper with n springs that is about ``4/(pi n k)``. The modal march has no step.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ...mdr.energy import compliance
from ...mdr.uniform_grid import UniformGrid
from ...meshes.errors import SceneError
from ..methods.spaces import radial_space
from ..problem.problem import Problem
from ..scene.scene import Scene
from ..study.levels import Family, Record, Theory
from ..study.options import Options
from ..study.study import Study
from ..study.study_orders import study_orders
from ..tables import Row
from ..wear.full_contact import RunningIn

TIME = 0.5
"""When errors are taken, non-dimensional."""
ERROR = "indentation error"
LIMIT = "limit over 4/(pi n k), less 1"
NO_GRID = (
    "The paper's grid is left out: it knows full discs with one wear coefficient on each ring."
)
XLABEL = r"step $\Delta t$ over $a/(E^*k_{max}v_0)$"


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Test several steps, and springs of the paper's grid."""
    problem = replace(scene.problem, times=np.array([]))
    # so coarse that the explicit march is stable in a few thousand steps
    space = radial_space(problem, degree=2, rim_size=0.02, ring_size=0.02, grading=0.5)
    wear = RunningIn(compliance(space), problem.merged.wear_coefficients)
    given = [round(TIME * problem.units.time / step) for step in options.steps]
    if options.steps and min(given) < 1:
        raise SceneError(f"--steps: give steps up to {TIME * problem.units.time:.3g}")
    halved = 2 ** np.arange(4 if options.quick else 7)
    marches = [
        refine_step(wear, march, given or (first_count(wear, march) * halved).tolist())
        for march in ("explicit", "implicit")
    ]
    label = f"relative error at $t$ = {TIME:g}"
    if problem.inner_radius or problem.merged.linear:
        study = study_orders(marches, record, "march", scene, label)
        return replace(study, conclusions=(*study.conclusions, NO_GRID))
    springs = (25, 50) if options.quick else (25, 50, 100, 200, 400)
    return study_orders([*marches, refine_grid(problem, springs)], record, "march", scene, label)


def first_count(wear: RunningIn, march: str) -> int:
    """Return the number of the first steps: stable explicit ones, implicit ones far beyond that."""
    return int(np.ceil(TIME / (0.5 * wear.stability_limit()))) if march == "explicit" else 8


def refine_step(wear: RunningIn, march: str, counts: Iterable[int]) -> Family:
    """Return numbers of steps up to `TIME`, with errors of the indentation then."""
    times = np.array([TIME])
    exact = wear.modal(times).indentation[0]

    def solve(steps: int) -> Row:
        indentation = wear.history(times, march, TIME / steps).indentation[0]
        return {"unknowns": wear.compliance.space.size, ERROR: float(indentation / exact - 1)}

    sizes = {steps: TIME / steps for steps in counts}
    return Family(f"{march} march", sizes, solve, {ERROR: Theory(1.0)}, XLABEL)


def refine_grid(problem: Problem, springs: tuple[int, ...]) -> Family:
    """Return the paper's grids, with the limit of stability over what it is for many springs."""

    def solve(count: int) -> Row:
        grid = UniformGrid(*problem.merged, count)
        greatest_rate = np.abs(np.linalg.eigvals(grid.rate_matrix())).max()
        return {"unknowns": count, LIMIT: float(2 / greatest_rate / grid.stability_limit() - 1)}

    sizes = {count: 1 / count for count in springs}
    name = "explicit march on the paper's grid"
    return Family(name, sizes, solve, {LIMIT: Theory()}, "1 / number of springs")
