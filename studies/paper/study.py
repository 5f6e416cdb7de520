"""The whole paper again.

Figs. 4 to 7, every claim checked, and what it leaves open (`ringwear study paper`).

The punches are the paper's; half-space and accuracy are those of the scene.
"""

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ...meshes.radial import Array
from ..problem.scene import Scene
from ..tables import Table, keeping_rows, write_page
from . import claims, figures, gradients, running_in

MANY, QUICK_MANY = (256, 512, 1024), (64, 128)  # rings at which the limit of many rings is checked


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Write the figures asked for, or without `--fig` all of them, and what goes beyond them."""
    problem, quick = scene.problem, options.quick
    wanted = {options.fig} if options.fig else {4, 5, 6, 7}
    conclusions: list[str] = []
    about, tables = list[str](), dict[str, Table]()
    # the matrices are small: threads would only wait on each other
    with threadpool_limits(1), keeping_rows(conclusions):
        if wanted & {4, 5}:
            five = running_in.five_rings(problem)
            conclusions.append(draw_running_in(five, wanted, out))
        curves = {}
        for number in sorted(wanted & {6, 7}):
            counts = gradients.QUICK_RINGS if quick else gradients.RINGS
            curves[number] = gradients.curves(number, problem, counts)
            conclusions.append(draw_gradients(number, curves[number], out))
        if not options.fig:
            times = running_in.relaxation_times(
                problem, running_in.QUICK_COUNTS if quick else running_in.COUNTS
            )
            draw_relaxation(times, out)
            checked = claims.about_running_in(five, times)
            checked += claims.about_gradients(curves[6], curves[7], QUICK_MANY if quick else MANY)
            tables["The paper's claims"] = Table(out / "claims.csv", claims.FIELDS, checked)
            conclusions += claims.conclude(checked)
            about.append(claims.definitions())
    write_page(out / "paper.md", "The paper again", [*conclusions, *about], tables)
    return conclusions


def draw_running_in(five: running_in.FiveRings, wanted: set[int], out: Path) -> str:
    """Figs. 4 and 5 and their data."""
    relative = five.times / five.stationary
    if 4 in wanted:
        figures.draw_states(five, out / "fig4.png")
        columns = (
            "method state_percent time_over_t_stat least_wear_over_d0 r_over_a f_over_d0 "
            "g_over_d0 p_over_p0"
        )
        write_rows(
            out / "fig4.csv",
            columns,
            (
                (name, round(100 * share), relative[state], states.least_wear[state], *row)
                for name, states in five.states.items()
                for state, share in enumerate(running_in.SHARES)
                for row in zip(
                    five.reference.problem.radii,
                    states.profile[state],
                    states.line_profile[state],
                    states.pressure[state],
                    strict=True,
                )
            ),
        )
    if 5 in wanted:
        figures.draw_history(five, out / "fig5.png")
        write_rows(
            out / "fig5.csv",
            "method time_over_t_stat line_over_stationary area_over_stationary",
            (
                (name, *row)
                for name, states in five.curves.items()
                for row in zip(running_in.CURVE, *states.gradients.T, strict=True)
            ),
        )
    seventy = 100 * relative[running_in.SHARES.index(0.7)]
    return (
        f"Figs. 4, 5: {', '.join(five.states)}; 70 % of the displacement difference after "
        f"{seventy:.1f} % of t_stat"
    )


def draw_gradients(number: int, curves: gradients.Curves, out: Path) -> str:
    """Fig. 6 or 7 and its data."""
    figures.draw_gradients(number, curves, out / f"fig{number}.png")
    by_method: dict[str, dict[Any, Any]] = {
        "direct": curves.direct,
        "fem": curves.fem,
        "limit": {np.inf: curves.limit},
    }
    write_rows(
        out / f"fig{number}.csv",
        "rings wear_ratio width_ratio method line area",
        (
            (count, curves.wear_ratios[at], curves.width_ratios[at], method, *values[:, at])
            for method, by_count in by_method.items()
            for count, values in by_count.items()
            for at in np.flatnonzero(np.isfinite(values[0]))
        ),
    )
    line, area = curves.limit[:, [0, -1]]
    return (
        f"Fig. {number}: many rings {line[0]:.3f} (line), {area[0]:.3f} (area) at the ratio "
        f"{curves.ratios[0]:g}, "
        f"{line[1]:.3f}, {area[1]:.3f} at {curves.ratios[-1]:g}; FEM within {curves.difference:.0e}"
    )


def draw_relaxation(times: dict[int, Array], out: Path) -> None:
    """Relaxation times and their data."""
    figures.draw_relaxation(times, out / "relaxation.png")
    write_rows(
        out / "relaxation.csv",
        "rings wear_ratio mode over_slower",
        (
            (count, ratio, mode, time)
            for count, values in times.items()
            for ratio, row in zip(running_in.WEAR_RATIOS, values, strict=True)
            for mode, time in enumerate(row, 1)
        ),
    )


def write_rows(path: Path, columns: str, rows: Iterable[tuple[Any, ...]]) -> None:
    Table(path, columns.split(), rows)
