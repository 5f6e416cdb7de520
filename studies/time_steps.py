"""Steps in time.

Orders of the explicit and the implicit march against the modal one, and where the explicit blows
up.

All three march the same compliance, so that their difference is the step's alone. The limit of
stability is bisected on whether a march blows up, and stands beside theory: twice the shortest
relaxation time, or ``4/(pi n k)`` for the uniform grid of the paper with n springs.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.optimize import bisect
from threadpoolctl import threadpool_limits

from ..mdr.energy import compliance
from ..mdr.uniform_grid import UniformGrid
from ..meshes.radial import Array
from .convergence.orders import ORDER_FIELDS, Sequence, draw_orders, verdicts
from .figures.style import curve, legend_below, new_figure
from .methods.mdr import radial_space
from .problem.problem import P0, Problem
from .problem.scene import Scene
from .progress import LOG, progress
from .tables import Table, keeping_rows, write_page
from .wear.full_contact import RunningIn

TIME = 0.5  # of the errors, non-dimensional
STEPS = 1500  # enough of them for a step 1 % above the limit to grow by 1e13
SHOWN = 100  # springs of the grid drawn
LEVEL_FIELDS = ("march", "step", "steps", "indentation error", "profile error")
LIMIT_FIELDS = ("march", "unknowns", "theory", "limit by theory", "by bisection", "ratio")


class Unguarded(RunningIn):
    """The same march without the check of its step."""

    def stability_limit(self) -> float:
        return np.inf


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Vary the step; writes `march.csv`, `orders.csv`, `limits.csv`, `march.md` and `march.png`."""
    problem, conclusions, sequences = scene.problem, list[str](), list[Sequence]()
    levels, limits = Table(out / "march.csv", LEVEL_FIELDS), Table(out / "limits.csv", LIMIT_FIELDS)
    # so coarse that the explicit march is stable in a few thousand steps
    space = radial_space(problem, degree=2, rim_size=0.02, ring_size=0.02, grading=0.5)
    with threadpool_limits(1):
        wear = RunningIn(compliance(space), problem.merged.wear_coefficients)
        with keeping_rows(conclusions):
            for march in ("explicit", "implicit"):
                sequences += refine_step(wear, march, 4 if options.quick else 7, levels)
            find_limits(
                wear, problem, (25, 50) if options.quick else (25, 50, 100, 200, 400), limits
            )
        orders = Table(
            out / "orders.csv", ORDER_FIELDS, (sequence.summary() for sequence in sequences)
        )
        draw(problem, sequences, out / "march.png")
    conclusions[:0] = [f"{verdicts(sequences)} The modal march has no step."]
    for theory in dict.fromkeys(row["theory"] for row in limits.rows):
        ratios = [row["ratio"] for row in limits.rows if row["theory"] == theory]
        conclusions.append(
            f"The explicit march blows up at {min(ratios):.3f} to {max(ratios):.3f} times its "
            f"limit by theory, {theory}."
        )
    tables = {"Orders in the step": orders, "Limits of stability of the explicit march": limits}
    write_page(out / "march.md", "Marching in time", conclusions, tables)
    return [*conclusions, orders.markdown(), limits.markdown()]


def refine_step(wear: RunningIn, march: str, levels: int, table: Table) -> list[Sequence]:
    """Errors at `TIME` by halved steps.

    Of the indentation, and of the profile in the mean square over the area.
    """
    times = np.array([TIME])
    exact = wear.modal(times)
    mass = wear.compliance.space.mass()
    # the first explicit step is stable, the first implicit one far beyond that
    first = int(np.ceil(TIME / (0.5 * wear.stability_limit()))) if march == "explicit" else 8
    sequences = [Sequence(f"{march} march", quantity, 1.0) for quantity in LEVEL_FIELDS[3:]]
    for steps in progress([first * 2**level for level in range(levels)], march):
        history = wear.history(times, march, TIME / steps)
        profile, wrong = exact.profile[0], history.profile[0] - exact.profile[0]
        indentation = float(history.indentation[0] / exact.indentation[0]) - 1
        errors = indentation, float(np.sqrt(wrong @ mass @ wrong / (profile @ mass @ profile)))
        table.add(march, TIME / steps, steps, *errors)
        for sequence, error in zip(sequences, errors, strict=True):
            sequence.add(TIME / steps, error)
    return sequences


def find_limits(wear: RunningIn, problem: Problem, springs: tuple[int, ...], limits: Table) -> None:
    """The explicit march on the compliance, then on uniform grids."""
    unguarded, expected = Unguarded(wear.compliance, wear.wear_coefficients), wear.stability_limit()

    def on_compliance(step: float) -> Array:
        return unguarded.explicit(np.array([STEPS * step]), step).pressure

    LOG.info("   march  limit of the explicit one on the compliance ...")
    limit = greatest_stable(on_compliance, expected)
    limits.add(
        "on a compliance",
        len(wear.relaxation_times) + 1,
        "2 tau_min",
        expected,
        limit,
        limit / expected,
    )
    for count in springs:
        LOG.info("   march  limit of the explicit one on the paper's grid, %d springs ...", count)
        grid = UniformGrid(*problem.merged, count)
        limit = greatest_stable(partial(grid_pressures, grid, STEPS), grid.stability_limit())
        greatest_rate = float(np.abs(np.linalg.eigvals(grid.rate_matrix())).max())
        for name, expected in (
            ("4/(pi n k)", grid.stability_limit()),
            ("2 / greatest rate", 2 / greatest_rate),
        ):
            limits.add("on the paper's grid", count, name, expected, limit, limit / expected)


def greatest_stable(pressures: Callable[[float], Array], guess: float) -> float:
    """Greatest step at which a march stays below 1000 mean pressures, to 0.1 %.

    `pressures` of a step are rows over time.
    """

    def stable(log_step: float) -> float:
        with np.errstate(all="ignore"):
            return (
                1.0 if np.abs(pressures(float(np.exp(log_step)))[-1]).max() < 1e3 / np.pi else -1.0
            )

    return float(np.exp(bisect(stable, np.log(guess / 4), np.log(guess * 4), xtol=1e-3)))


def grid_pressures(grid: UniformGrid, steps: int, step: float) -> Array:
    """(steps+1, n+1) pressures after every explicit step, blown up or not."""
    profile, pressures = np.zeros(grid.count + 1), []
    for _ in range(steps + 1):
        pressures.append(grid.contact(profile)[0])
        profile = profile + step * grid.coefficients * pressures[-1]
    return np.array(pressures)


def draw(problem: Problem, sequences: list[Sequence], path: Path) -> None:
    """Errors against the step, and what a step near the limit looks like on the paper's grid."""
    figure = new_figure(13, 5.2)
    errors, growth, pattern = figure.subplots(1, 3)
    named = [
        replace(sequence, name=f"{sequence.name}, {sequence.quantity}") for sequence in sequences
    ]
    labels = r"step $\Delta t$ over $a/(E^*k_{max}v_0)$", f"relative error at $t$ = {TIME:g}"
    draw_orders(errors, named, *labels, "against the modal march on the same compliance")
    grid = UniformGrid(*problem.merged, SHOWN)
    for number, ratio in enumerate((0.5, 1.06, 1.15)):
        # to 120 times the limit
        pressures = grid_pressures(grid, int(120 / ratio), ratio * grid.stability_limit()) / P0
        look = curve(number) | {"markevery": 8, "label": rf"$\Delta t$ = {ratio:g} of the limit"}
        growth.semilogy(
            ratio * np.arange(len(pressures)),
            np.abs(pressures[:, : SHOWN // 2]).max(axis=1),
            **look,
        )
        pattern.plot(grid.radii[:-2], pressures[len(pressures) // 2, :-2], **look)
    growth.set(
        xlabel=r"time over the limit $4a/(\pi n E^* k_{max} v_0)$",
        ylabel="greatest $|p|/p_0$ within $r < a/2$",
    )
    growth.set_title(f"the paper's grid, $n$ = {SHOWN}", fontsize=9)
    pattern.set(xlabel="radius $r/a$", ylabel="pressure $p/p_0$", ylim=(-6, 10))
    pattern.set_title("its pressure halfway", fontsize=9)
    legend_below(growth)
    legend_below(pattern)
    figure.savefig(path)
