"""Steps in time: orders of the explicit and the implicit march, and where the former blows up.

Both march the compliance on which the modes are exact: their difference is the step's alone. There
the explicit march is stable below two over the greatest rate of relaxation. On the uniform grid of
the paper with n springs that is about ``4/(pi n k)``: the limit is bisected on whether a march
blows up, and stands beside this theory.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import bisect

from ...mdr.energy import compliance
from ...mdr.uniform_grid import UniformGrid
from ..methods.spaces import radial_space
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..tables import Row
from ..wear.full_contact import RunningIn
from .sequences import Family, Theory, draw_orders, levels, study_orders

TIME = 0.5
"""When errors are taken, non-dimensional."""
ERRORS = ("indentation error", "profile error")
LIMIT = "limit of the explicit march over 4/(pi n k), less 1"


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Vary the step, and the springs of the paper's grid; writes `march` and `orders`."""
    problem, conclusions = replace(scene.problem, times=np.array([])), list[str]()
    # so coarse that the explicit march is stable in a few thousand steps
    space = radial_space(problem, degree=2, rim_size=0.02, ring_size=0.02, grading=0.5)
    wear = RunningIn(compliance(space), problem.merged.wear_coefficients)
    halvings = 4 if options.quick else 7
    springs = (25, 50) if options.quick else (25, 50, 100, 200, 400)
    families = [refine_step(wear, march, halvings) for march in ("explicit", "implicit")]
    sequences = study_orders([*families, refine_grid(problem, springs)], out, "march", conclusions)
    marches = [sequence for sequence in sequences if sequence.quantity in ERRORS]
    panels = {r"step $\Delta t$ over $a/(E^*k_{max}v_0)$": marches}
    draw_orders(out / "march.png", panels, f"relative error at $t$ = {TIME:g}")
    conclusions[0] += " The modal march has no step."
    for limits in sequences[len(marches) :]:
        beyond = 1 + limits.signed
        conclusions.append(
            f"On the paper's grid the explicit march blows up at {beyond.min():.3f} to "
            f"{beyond.max():.3f} times 4/(pi n k), the limit by theory for many springs."
        )
    return conclusions


def refine_step(wear: RunningIn, march: str, count: int) -> Family:
    """Return halved steps, with errors at `TIME` of the indentation, and of the profile in the mean
    square over the area.
    """
    times, mass = np.array([TIME]), wear.compliance.space.mass()
    exact = wear.modal(times)
    profile = exact.profile[0]
    # the first explicit step is stable, the first implicit one far beyond that
    first = int(np.ceil(TIME / (0.5 * wear.stability_limit()))) if march == "explicit" else 8

    def solve(steps: int) -> Row:
        history = wear.history(times, march, TIME / steps)
        wrong = history.profile[0] - profile
        errors = (
            float(history.indentation[0] / exact.indentation[0]) - 1,
            float(np.sqrt(wrong @ mass @ wrong / (profile @ mass @ profile))),
        )
        return {"unknowns": wear.compliance.space.size} | dict(zip(ERRORS, errors, strict=True))

    sizes = {steps: TIME / steps for steps in first * 2 ** np.arange(count)}
    return Family(f"{march} march", levels(sizes, solve), dict.fromkeys(ERRORS, Theory(1.0)))


def refine_grid(problem: Problem, springs: tuple[int, ...]) -> Family:
    """Return the paper's grids, with the greatest step at which the explicit march is bounded, to
    0.1 %.
    """
    # steps enough for one 1 % above the limit to grow by 1e13
    steps, bound = 1500, 1e3 / np.pi

    def solve(count: int) -> Row:
        grid = UniformGrid(*problem.merged, count)
        rate, expected = grid.rate_matrix(), grid.stability_limit()
        start = grid.coefficients * grid.contact(np.zeros(count + 1))[0]

        def excess(log_ratio: float) -> float:
            rates, step = start, expected * np.exp(log_ratio)
            with np.errstate(all="ignore"):
                for _ in range(steps):
                    rates = rates + step * (rate @ rates)
                return -1.0 if np.abs(rates).max() < bound else 1.0

        log_ratio = bisect(excess, -np.log(4), np.log(4), xtol=1e-3)
        return {"unknowns": count, LIMIT: np.expm1(log_ratio)}

    sizes = {count: 1 / count for count in springs}
    return Family("springs of the paper's grid", levels(sizes, solve), {LIMIT: Theory()})
