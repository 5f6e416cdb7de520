"""Steps in time: orders of the explicit and the implicit march against the modal one, and where the explicit blows up.

All three march the same compliance, so that their difference is the step's alone. The limit of stability is found by
bisection on whether a march blows up, and stands beside theory: twice the shortest relaxation time, or ``4/(pi n k)``
for the uniform grid of the paper with n springs.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from ringwear.mdr.energy import compliance
from ringwear.mdr.uniform_grid import PaperGrid
from ringwear.meshes.errors import RingwearError
from ringwear.meshes.radial import Array
from ringwear.studies.convergence.levels import (
    VERDICT,
    Sequence,
    Table,
    draw_orders,
    keeping_rows,
    legend_below,
    new_figure,
    style,
    write_markdown,
)
from ringwear.studies.methods.radial import mdr_space
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report
from ringwear.studies.wear.archard import History, Wear
from threadpoolctl import threadpool_limits

TIME = 0.5  # of the errors, in natural units
MODEST = {"degree": 2, "rim_size": 0.02, "ring_size": 0.02, "grading": 0.5}
LEVELS, QUICK_LEVELS = 7, 4
SPRINGS, QUICK_SPRINGS = (50, 100, 200, 400), (25, 50)
STEPS = 1500  # enough for a step 1 % above the limit to grow by 1e13
BLOWN_UP = 1e3  # times the mean pressure
WITHIN = 0.004
SHOWN = 100  # springs of the grid whose unstable march is drawn
SHOWN_STEPS = (0.5, 1.06, 1.15)  # over the limit
FIELDS = ("march", "step", "steps", "d_error", "profile_error", "remark")
ORDER_FIELDS = (
    "refined", "quantity", "expected order", "least squares", "last levels", VERDICT, "between levels", "finest error",
)  # fmt: skip
LIMIT_FIELDS = ("march", "unknowns", "theory", "limit by theory", "limit by bisection", "found over theory")


class Unguarded(Wear):
    """The same march without the check of its step."""

    def stability_limit(self) -> float:
        return np.inf


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Vary the step; writes `march.csv`, `orders.csv`, `limits.csv`, `march.md` and `march.png`."""
    quick = bool(options.quick)
    conclusions: list[str] = []
    table, limits = Table(out / "march.csv", FIELDS), Table(out / "limits.csv", LIMIT_FIELDS)
    orders = Table(out / "orders.csv", ORDER_FIELDS)
    natural = scene.natural
    sequences: list[Sequence] = []
    with threadpool_limits(1):
        wear = Wear(compliance(mdr_space(natural, **MODEST)), natural.phases[1])
        with keeping_rows(conclusions):
            for name in ("explicit", "implicit"):
                sequences += refine_step(wear, name, QUICK_LEVELS if quick else LEVELS, table, report)
            find_limits(wear, natural, QUICK_SPRINGS if quick else SPRINGS, limits, report)
        for sequence in sequences:
            orders.add(**sequence.summary())
        conclusions[:0] = conclude(sequences, limits)
        report("  march  drawing ...")
        draw(natural, sequences, out / "march.png")
    tables = {"Orders in the step": orders, "Limits of stability of the explicit march": limits}
    write_markdown(out / "march.md", "Marching in time", conclusions, tables)
    return [*conclusions, orders.markdown(), limits.markdown()]


def refine_step(wear: Wear, name: str, levels: int, table: Table, report: Report) -> list[Sequence]:
    """Errors at `TIME` by halved steps: of the indentation, and of the profile in the mean square over the area."""
    times = np.array([TIME])
    exact = wear.modal(times)
    mass = wear.compliance.space.mass(np.ones(len(wear.wear_coefficients)))

    def height(profile: Array) -> float:
        return float(np.sqrt(profile @ mass @ profile))

    march = {"explicit": wear.explicit, "implicit": wear.implicit}[name]
    # the first explicit step is stable, the first implicit one far beyond that
    first = 0.5 * wear.stability_limit() if name == "explicit" else TIME / 8
    indentations, profiles = (Sequence(f"{name} march", what, 1.0, 1.0) for what in ("indentation", "profile"))
    for level in range(levels):
        steps = int(np.ceil(TIME / first)) * 2**level
        step = TIME / steps
        report(f"  march  {name}, step {step:.2g} ...")
        try:
            found: History = march(times, step)
        except RingwearError as error:
            table.add(march=name, step=step, steps=steps, remark=f"failed: {error}")
            continue
        d_error = float(found.indentation[0] / exact.indentation[0] - 1)
        profile_error = height(found.profile[0] - exact.profile[0]) / height(exact.profile[0])
        table.add(march=name, step=step, steps=steps, d_error=d_error, profile_error=profile_error)
        indentations.add(step, 1 + d_error)
        profiles.add(step, 1 + profile_error)
    return [sequence for sequence in (indentations, profiles) if len(sequence.sizes)]


def greatest_stable(blows_up: Callable[[float], bool], guess: float) -> float:
    """Greatest step at which a march does not blow up, to `WITHIN`, by bisection around a guess."""
    stable, unstable = guess / 4, guess * 4
    while unstable / stable > 1 + WITHIN:
        middle = float(np.sqrt(stable * unstable))
        if blows_up(middle):
            unstable = middle
        else:
            stable = middle
    return stable


def find_limits(wear: Wear, natural: NaturalScene, springs: tuple[int, ...], limits: Table, report: Report) -> None:
    """The explicit march on the compliance, then on uniform grids."""
    unguarded = Unguarded(wear.compliance, wear.wear_coefficients)

    def on_compliance(step: float) -> bool:
        with np.errstate(all="ignore"):
            pressure = unguarded.explicit(np.array([STEPS * step]), step).pressure
        return not np.abs(pressure).max() < BLOWN_UP / np.pi

    def add(march: str, unknowns: int, theory: str, limit: float, found: float) -> None:
        values = (march, unknowns, theory, limit, found, found / limit)
        limits.add(**dict(zip(LIMIT_FIELDS, values, strict=True)))

    report("  march  limit of the explicit march by bisection ...")
    limit = wear.stability_limit()
    found = greatest_stable(on_compliance, limit)
    add("on a compliance", len(wear.relaxation_times) + 1, "2 tau_min", limit, found)
    for count in springs:
        report(f"  march  limit of the paper's grid, n = {count} ...")
        grid = PaperGrid(*natural.phases, count)

        def on_grid(step: float, grid: PaperGrid = grid) -> bool:
            return not np.abs(grid_march(grid, step, STEPS)[0][-1]).max() < BLOWN_UP / np.pi

        found = greatest_stable(on_grid, grid.stability_limit())
        add("the paper's grid", count, "4/(pi n k)", grid.stability_limit(), found)
        greatest = 2 / float(np.abs(np.linalg.eigvals(grid.rate_matrix())).max())
        add("the paper's grid", count, "2 / greatest rate", greatest, found)


def grid_march(grid: PaperGrid, step: float, steps: int) -> tuple[Array, Array]:
    """Pressures (steps+1, n+1) and indentations after every explicit step, blown up or not; stops at overflow."""
    profile = np.zeros(grid.count + 1)
    pressures, indentations = [], []
    for _ in range(steps + 1):
        pressure, indentation = grid.contact(profile)
        pressures.append(pressure)
        indentations.append(indentation)
        if not np.abs(pressure).max() < 1e12:
            break
        profile = profile + step * grid.wear * pressure
    return np.array(pressures), np.array(indentations)


def conclude(sequences: list[Sequence], limits: Table) -> list[str]:
    """Orders in a line, limits in another."""
    orders = ", ".join(f"{s.name} {s.order:.2f} ({s.quantity})" for s in sequences)
    lines = [f"Observed order in the step: {orders}; theory 1. The modal march has no step."]
    for march in dict.fromkeys(str(row["march"]) for row in limits.rows):
        ratios = [row["found over theory"] for row in limits.rows if row["march"] == march]
        lines.append(
            f"Explicit march, {march}: blows up at {min(ratios):.3f} to {max(ratios):.3f} times the limit by theory."
        )
    return lines


def draw(natural: NaturalScene, sequences: list[Sequence], path: Path) -> None:
    """Errors against the step, and what a step near the limit looks like on the paper's grid."""
    figure = new_figure(13, 5.2)
    left, middle, right = figure.subplots(1, 3)
    named = [Sequence(f"{s.name}, {s.quantity}", "", s.expected, s.exact, 0.0, s.sizes, s.values) for s in sequences]
    draw_orders(left, named, r"step $\Delta t$ over $a/(E^*k_{max}v_0)$", f"relative error at $t$ = {TIME:g}")
    left.set_title("against the modal march on the same compliance", fontsize=9)
    grid = PaperGrid(*natural.phases, SHOWN)
    steps = 120
    for number, ratio in enumerate(SHOWN_STEPS):
        step = ratio * grid.stability_limit()
        pressure, _ = grid_march(grid, step, steps * 20)
        time = step * np.arange(len(pressure))
        inner = np.abs(pressure[:, : SHOWN // 2]).max(axis=1) * 2 * np.pi
        shown = time < steps * grid.stability_limit()
        curve = style(number) | {"markevery": 8, "label": rf"$\Delta t$ = {ratio:g} of the limit"}
        middle.semilogy(time[shown] / grid.stability_limit(), inner[shown], **curve)
        state = min(int(np.searchsorted(time, steps / 2 * grid.stability_limit())), len(pressure) - 1)
        right.plot(grid.radii[:-2], pressure[state, :-2] * 2 * np.pi, **curve)
    middle.set(xlabel="time over the limit $4a/(\\pi n E^* k_{max} v_0)$", ylabel="greatest $|p|/p_0$ within $r < a/2$")
    middle.set_title(f"the paper's grid, $n$ = {SHOWN}", fontsize=9)
    right.set(xlabel="radius $r/a$", ylabel="pressure $p/p_0$", ylim=(-6, 10))
    right.set_title(f"pressure at the time of {steps // 2} limits", fontsize=9)
    for axes in (middle, right):
        legend_below(axes)
    figure.savefig(path)
