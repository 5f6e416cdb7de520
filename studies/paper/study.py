"""The whole paper again: Figs. 4 to 7, every claim checked, and what it leaves open (`ringwear study paper`).

The punches are the paper's; half-space, load and accuracy are those of the scene.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from ringwear.studies.paper import arrangement, claims, gradient_figures, relaxation
from ringwear.studies.paper import figures as paper_figures
from ringwear.studies.paper.claims_running_in import running_in_claims
from ringwear.studies.paper.claims_wear_ratio import MANY, wear_ratio_claims
from ringwear.studies.paper.claims_width_ratio import width_ratio_claims
from ringwear.studies.paper.gradients import (
    QUICK_RINGS,
    RINGS,
    WEAR_RATIOS,
    WIDTH_RATIOS,
    WIDTH_STUDY_RATIO,
    Curves,
    FemGrams,
    homogeneous,
    many_rings,
    wear_ratio_curves,
    width_ratio_curves,
)
from ringwear.studies.paper.running_in import SHARES, RunningIn, running_in
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report
from threadpoolctl import threadpool_limits

QUICK_MANY = (64, 128)


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Write the figures asked for, or without `--fig` all of them with the tables; returns the conclusions."""
    conclusions: list[str] = []
    if options.bem3d:
        from ringwear.studies.paper import three_dimensions as bem3d

        # first, so that a missing library is told at once
        (out / "bem3d.md").write_text(bem3d.table(report), "utf-8")
        conclusions.append("three-dimensional check: bem3d.md")
    rings = QUICK_RINGS if options.quick else RINGS
    wanted = {options.fig} if options.fig else {4, 5, 6, 7}
    fem = FemGrams(scene, report)
    # small dense matrices, and threads of our own over the width ratios
    with threadpool_limits(1):
        found = running_in(scene, report) if wanted & {4, 5} else None
        if found is not None:
            conclusions += _states(found, wanted, out, report)
        wear = wear_ratio_curves(fem, rings, report) if 6 in wanted else None
        if wear is not None:
            conclusions.append(_wear_ratios(wear, out, report))
        width = width_ratio_curves(fem, rings, report) if 7 in wanted else None
        if width is not None:
            conclusions.append(_width_ratios(width, out, report))
        if found is not None and wear is not None and width is not None:
            conclusions += _beyond(scene, found, wear, width, out, options.quick, report)
    return conclusions


def _states(found: RunningIn, wanted: set[int], out: Path, report: Report) -> list[str]:
    if 4 in wanted:
        report("   Fig. 4  drawing ...")
        _write(out / "fig4.csv", _STATE_COLUMNS, _state_rows(found))
        paper_figures.draw_states(found, out / "fig4.png")
    if 5 in wanted:
        report("   Fig. 5  drawing ...")
        _write(out / "fig5.csv", _HISTORY_COLUMNS, _history_rows(found))
        paper_figures.draw_gradient_history(found, out / "fig5.png")
    seventy = 100 * found.times[SHARES.index(0.7)] / found.stationary
    return [f"Figs. 4, 5: {', '.join(found.states)}; 70 % of the displacement difference after {seventy:.1f} % of t_stat"]


def _wear_ratios(curves: Curves, out: Path, report: Report) -> str:
    report("   Fig. 6  drawing ...")
    _write(out / "fig6.csv", ("rings", "wear_ratio", "method", "line", "area"), curves.rows())
    _write_limit(out / "fig6_many_rings.csv", "wear_ratio", WEAR_RATIOS, many_rings(WEAR_RATIOS, np.array(1.0)))
    gradient_figures.draw_wear_ratios(curves, out / "fig6.png")
    line, area = many_rings(np.array([np.inf]), np.array(1.0))[:, 0]
    return f"Fig. 6: many rings of extreme ratio {line:.3f} (line), {area:.3f} (area); FEM within {curves.difference():.0e}"


def _width_ratios(curves: Curves, out: Path, report: Report) -> str:
    report("   Fig. 7  drawing ...")
    limit = many_rings(np.array(WIDTH_STUDY_RATIO), WIDTH_RATIOS)
    _write(out / "fig7.csv", ("rings", "width_ratio", "method", "line", "area"), curves.rows())
    _write_limit(out / "fig7_many_rings.csv", "width_ratio", WIDTH_RATIOS, limit)
    gradient_figures.draw_width_ratios(curves, out / "fig7.png")
    ends = f"{limit[0, 0]:.3f} (line) at h2/h1 = 0.1, {limit[0, -1]:.3f} at 10"
    return f"Fig. 7: many rings {ends}; FEM within {curves.difference():.0e}"


def _beyond(
    scene: Scene, found: RunningIn, wear: Curves, width: Curves, out: Path, quick: bool, report: Report
) -> list[str]:
    """The relaxation spectrum, the best arrangements, and the table of claims."""
    spectrum = relaxation.spectrum(scene, relaxation.QUICK_RINGS if quick else relaxation.RINGS, report)
    _write(out / "relaxation.csv", ("rings", "wear_ratio", "mode", "over_slower", "over_first"), spectrum.rows())
    relaxation.draw_spectrum(spectrum, out / "relaxation.png")
    best = arrangement.table(arrangement.QUICK_RINGS if quick else arrangement.RINGS, report)
    (out / "arrangements.md").write_text(best, "utf-8")
    report(" claims  checking ...")
    checked = running_in_claims(found, spectrum)
    checked += wear_ratio_claims(wear, QUICK_MANY if quick else MANY)
    checked += width_ratio_claims(wear, width, found.reference)
    (out / "claims.md").write_text(claims.document(checked, _definitions(found)), "utf-8")
    refuted = [f"does not hold: {claim.says}: {claim.value}" for claim in checked if not claim.holds]
    return [claims.tally(checked), *refuted]


def _definitions(found: RunningIn) -> list[str]:
    line, area = homogeneous()
    return [
        "`p0 = F/(2 pi a^2)`, `d0 = F/(2 a E*)`; `t_stat` is the time to "
        f"{100 * found.reference.share(np.array([found.stationary]))[0]:.1f} % of the displacement difference; `line` is an "
        "average over the radius, `area` over the area, and gradients are `line` where nothing is said; the "
        "homogeneous punch has "
        f"the gradient g0 times mean pressure over E*, g0 = {line:.8f} (line), {area:.8f} = 4/pi (area).",
    ]


_STATE_COLUMNS = ("method", "state_percent", "time", "time_over_t_stat", "displacement_share", "least_wear_over_d0",
                  "r_over_a", "f_over_d0", "g_over_d0", "p_over_p0")  # fmt: skip


def _state_rows(found: RunningIn) -> Iterable[tuple[Any, ...]]:
    """Rows of Fig. 4; `f` and `g` are counted from the least worn point."""
    natural = found.reference.natural
    for method, states in found.states.items():
        for state, share in enumerate(SHARES):
            time = found.times[state]
            about = (time * natural.time, time / found.stationary, states.share[state], states.least_wear[state])
            fields = (states.profile[state], states.line_profile[state], states.pressure[state])
            for values in zip(natural.radii, *fields, strict=True):
                yield method, round(100 * share), *map(float, chain(about, values))


_HISTORY_COLUMNS = ("method", "time", "time_over_t_stat", "line_over_stationary", "area_over_stationary",
                    "line_over_homogeneous", "area_over_homogeneous")  # fmt: skip


def _history_rows(found: RunningIn) -> Iterable[tuple[Any, ...]]:
    natural = found.reference.natural
    for method, curves in found.curves.items():
        steady = found.evolutions[method].steady
        stationary = np.array([steady["steady_rms_slope"][0], steady["steady_rms_slope_area"][0]])
        scale = stationary * np.pi / homogeneous()
        for time, line, area in zip(found.curve_times, curves["line"], curves["area"], strict=True):
            values = (time * natural.time, time / found.stationary, line, area, line * scale[0], area * scale[1])
            yield method, *map(float, values)


def _write_limit(path: Path, ratio: str, ratios: Any, values: Any) -> None:
    _write(path, (ratio, "line", "area"), (tuple(map(float, row)) for row in zip(ratios, *values, strict=True)))


def _write(path: Path, columns: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)
