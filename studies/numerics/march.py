"""Steps in time: orders of the explicit and the implicit march, and where the former blows up.

Both march the compliance on which the modes are exact: their difference is the step's alone.
The limit of stability is bisected on whether a march blows up, and stands beside theory: two over
the greatest rate of relaxation, which on the uniform grid of the paper with n springs is about
``4/(pi n k)``.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import bisect

from ...mdr.energy import compliance
from ...mdr.uniform_grid import UniformGrid
from ...meshes.radial import Array
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..progress import LOG
from ..registry import INTERRUPTED
from ..tables import Row, Table, keeping_rows
from ..wear.full_contact import RunningIn
from .core import graded_space, run_in
from .sequences import Family, Theory, draw_orders, levels, publish, study_orders

TIME = 0.5
"""When errors are taken, non-dimensional."""
ERRORS = ("indentation error", "profile error")


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Vary the step; writes `march`, `orders` and `limits`."""
    problem, conclusions = replace(scene.problem, times=np.array([])), list[str]()
    columns = ("march", "unknowns", "theory", "limit by theory", "by bisection", "ratio")
    limits = Table(out / "limits.csv", columns)
    # so coarse that the explicit march is stable in a few thousand steps
    sizes = {"degree": 2, "rim_size": 0.02, "ring_size": 0.02, "grading": 0.5}
    wear = run_in(problem, compliance(graded_space(problem, **sizes)))
    marches = (
        refine_step(wear, march, 4 if options.quick else 7) for march in ("explicit", "implicit")
    )
    sequences, orders = study_orders(marches, out, "march", conclusions)
    springs = (25, 50) if options.quick else (25, 50, 100, 200, 400)
    with keeping_rows(conclusions):
        if INTERRUPTED not in conclusions:
            find_limits(wear, problem, springs, limits)
    panels = {r"step $\Delta t$ over $a/(E^*k_{max}v_0)$": sequences}
    draw_orders(out / "march.png", panels, f"relative error at $t$ = {TIME:g}")
    conclusions[0] += " The modal march has no step."
    for theory in dict.fromkeys(row["theory"] for row in limits.rows):
        ratios = [row["ratio"] for row in limits.rows if row["theory"] == theory]
        conclusions.append(
            f"The explicit march blows up at {min(ratios):.3f} to {max(ratios):.3f} times its "
            f"limit by theory, {theory}."
        )
    tables = {"Orders in the step": orders, "Limits of stability of the explicit march": limits}
    return publish(out / "march.md", "Marching in time", conclusions, tables)


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


def find_limits(wear: RunningIn, problem: Problem, springs: tuple[int, ...], limits: Table) -> None:
    """Tabulate the limits of the explicit march on a compliance, then on the paper's grids."""
    space, wear_coefficients = wear.compliance.space, wear.wear_coefficients
    # wear rates x of which A x' = d' b - K x, b . x = F
    pressures = space.joined(wear_coefficients)
    energy = cho_factor(pressures.T @ wear.compliance.matrix @ pressures)
    mass = pressures.T @ space.mass(wear_coefficients) @ pressures
    weights = pressures.T @ space.weights
    rate, start = -cho_solve(energy, mass.toarray()), cho_solve(energy, weights)
    start /= weights @ start
    rate -= np.outer(start, weights @ rate)
    theories = {"2 tau_min": wear.stability_limit()}
    tabulate_limits(limits, "on a compliance", rate, start, theories)
    for count in springs:
        grid = UniformGrid(*problem.merged, count)
        rate = grid.rate_matrix()
        start = grid.coefficients * grid.contact(np.zeros(count + 1))[0]
        greatest_rate = float(np.abs(np.linalg.eigvals(rate)).max())
        theories = {"4/(pi n k)": grid.stability_limit(), "2 / greatest rate": 2 / greatest_rate}
        tabulate_limits(limits, "on the paper's grid", rate, start, theories)


def tabulate_limits(
    limits: Table, march: str, rate: Array, start: Array, theories: dict[str, float]
) -> None:
    """Bisect the greatest step, to 0.1 %, at which the explicit march ``x' = rate x`` is bounded.

    Parameters
    ----------
    rate : (n, n) of wear rates, which begin at `start` (n,)
    theories : the limit by each theory
    """
    LOG.info("   march  limit of the explicit one %s, %d unknowns ...", march, len(start) - 1)
    # steps enough for one 1 % above the limit to grow by 1e13
    steps, bound, guess = 1500, 1e3 / np.pi, np.log(next(iter(theories.values())))

    def excess(log_step: float) -> float:
        rates, step = start, np.exp(log_step)
        with np.errstate(all="ignore"):
            for _ in range(steps):
                rates = rates + step * (rate @ rates)
            return -1.0 if np.abs(rates).max() < bound else 1.0

    limit = np.exp(bisect(excess, guess - np.log(4), guess + np.log(4), xtol=1e-3))
    for theory, expected in theories.items():
        limits.add(march, len(start) - 1, theory, expected, limit, limit / expected)
