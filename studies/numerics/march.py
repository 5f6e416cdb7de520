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
from ..figures.style import curve, legend_below, new_figure
from ..problem.problem import P0, Problem
from ..problem.scene import Scene
from ..progress import LOG
from ..registry import INTERRUPTED
from ..tables import Row, Table, keeping_rows
from ..wear.archard import RunningIn
from .core import graded_space, run_in
from .sequences import Family, Sequence, Theory, draw_orders, levels, publish, study_orders

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
    draw(problem, sequences, out / "march.png")
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
    """Bisect the greatest step, to 0.1 %, at which a march stays bounded.

    Over steps enough for one 1 % above the limit to grow by 1e13.

    Parameters
    ----------
    march, rate, start : as `wear_rates` takes them
    theories : the limit by each theory
    """
    LOG.info("   march  limit of the explicit one %s, %d unknowns ...", march, len(start) - 1)
    guess = np.log(next(iter(theories.values())))

    def excess(log_step: float) -> float:
        with np.errstate(all="ignore"):
            last = wear_rates(rate, start, np.exp(log_step), 1500)[-1]
        return -1.0 if np.abs(last).max() < 1e3 / np.pi else 1.0

    limit = np.exp(bisect(excess, guess - np.log(4), guess + np.log(4), xtol=1e-3))
    for theory, expected in theories.items():
        limits.add(march, len(start) - 1, theory, expected, limit, limit / expected)


def wear_rates(rate: Array, start: Array, step: float, steps: int) -> Array:
    """Return the wear rates (steps+1, n) of ``x' = rate x`` by an explicit march from `start`."""
    rates = [start]
    for _ in range(steps):
        rates.append(rates[-1] + step * (rate @ rates[-1]))
    return np.array(rates)


def draw(problem: Problem, sequences: list[Sequence], path: Path) -> None:
    """Draw errors against the step, and what steps near the limit do on the paper's grid."""
    figure = new_figure(10, 5.2)
    errors, growth = figure.subplots(1, 2)
    size = r"step $\Delta t$ over $a/(E^*k_{max}v_0)$"
    draw_orders(errors, sequences, xlabel=size, ylabel=f"relative error at $t$ = {TIME:g}")
    errors.set_title("against the modal march on the same compliance", fontsize=9)
    grid = UniformGrid(*problem.merged, 100)
    limit, start = grid.stability_limit(), grid.coefficients * grid.contact(np.zeros(101))[0]
    for number, ratio in enumerate((0.5, 1.06, 1.15)):
        rates = wear_rates(grid.rate_matrix(), start, ratio * limit, int(120 / ratio))
        pressures = np.abs(rates / grid.coefficients / P0)[:, :50].max(axis=1)
        look = curve(number) | {"markevery": 8, "label": rf"$\Delta t$ = {ratio:g} of the limit"}
        growth.semilogy(ratio * np.arange(len(pressures)), pressures, **look)
    growth.set(
        xlabel=r"time over the limit $4a/(\pi n E^* k_{max} v_0)$",
        ylabel="greatest $|p|/p_0$ within $r < a/2$",
    )
    growth.set_title("the paper's grid, $n$ = 100", fontsize=9)
    legend_below(growth)
    figure.savefig(path)
