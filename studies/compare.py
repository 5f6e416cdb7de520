"""All methods over one scene on one page: profiles and pressures with their differences, ring forces, and operators.

Differences are from the MDR, over the median at that time. Every method joins, asked for by the scene or not.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from ringwear.meshes.radial import Array
from ringwear.studies.convergence.levels import Table, keeping_rows, new_figure, style, write_markdown
from ringwear.studies.crosscheck.operators import OperatorDifference
from ringwear.studies.crosscheck.run import Result, run
from ringwear.studies.figures.run import D0, P0, STYLES, shade_rings
from ringwear.studies.methods.outcome import Outcome
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import Report
from ringwear.studies.wear.archard import Wear

FIELDS = ("quantity", "methods", "difference", "uncertainty", "agrees")
OPERATOR_FIELDS = ("methods", "steady states", "along the history", "whole space", "stability", "residual")
QUICK = {"accuracy__rtol": 1e-3}
STATES = 4
LEAST = 1e-16  # a difference drawn where there is none


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Run the scene by every method; writes `compare.csv`, `operators.csv`, `compare.md` and `compare.png`."""
    methods = [*scene.methods, *(name for name in ("mdr", "direct", "fem", "bem") if name not in scene.methods)]
    scene = scene.changed(methods=methods, **(QUICK if options.quick else {}))
    conclusions: list[str] = []
    table, operators = Table(out / "compare.csv", FIELDS), Table(out / "operators.csv", OPERATOR_FIELDS)
    with keeping_rows(conclusions):
        result = run(scene, report)
        for row in result.agreement:
            table.add(
                quantity=row.quantity, methods=" - ".join(row.methods), difference=row.difference,
                uncertainty=row.uncertainty, agrees=row.agrees,
            )  # fmt: skip
        for pair in result.operators:
            values = (" - ".join(pair.methods), pair.rings, pair.history, pair.space, pair.stability, pair.residual)
            operators.add(**dict(zip(OPERATOR_FIELDS, values, strict=True)))
        conclusions += conclude(table, result.operators)
        report("compare  drawing ...")
        draw(result, out / "compare.png")
    tables = {"Greatest differences, relative": table, "As operators, relative": operators}
    write_markdown(out / "compare.md", f"The methods side by side: {scene.title}", conclusions, tables)
    return [*conclusions, table.markdown(), operators.markdown()]


def conclude(table: Table, pairs: tuple[OperatorDifference, ...]) -> list[str]:
    """The greatest difference of each pair of methods, and whether all agree."""
    lines = []
    for methods in dict.fromkeys(row["methods"] for row in table.rows):
        rows = [row for row in table.rows if row["methods"] == methods]
        worst = max(rows, key=lambda row: float(row["difference"]))
        verdict = "within" if all(row["agrees"] for row in rows) else "BEYOND"
        verdict += " their stated uncertainty"
        lines.append(f"{methods}: differ by at most {worst['difference']:.1e} ({worst['quantity']}), {verdict}.")
    lines += [
        f"{' - '.join(pair.methods)} as operators: {pair.rings:.1e} over all steady states, "
        f"{pair.history:.1e} along the history."
        for pair in pairs
    ]
    return lines


def draw(result: Result, path: Path) -> None:
    """One page: states above their differences, then ring forces, operators and relaxation times."""
    natural, outcomes = result.scene.natural, result.outcomes
    figure = new_figure(13, 13)
    parts: Any = figure.subfigures(2, 1, height_ratios=[2.3, 1])
    upper, lower = parts
    if natural.times.size:
        _draw_states(upper, natural, outcomes)
    left, middle, right = lower.subplots(1, 3)
    if natural.times.size:
        _draw_ring_forces(left, natural, outcomes)
    _draw_operators(middle, natural, result.operators)
    _draw_relaxation(right, result, outcomes)
    title = f"{result.scene.title}: " if result.scene.title else ""
    figure.suptitle(title + "the methods side by side; shaded rings wear faster", fontsize=11)
    figure.savefig(path)


def _states(times: Array) -> Array:
    return np.unique(np.linspace(0, len(times) - 1, min(len(times), STATES)).round().astype(int))


def _draw_states(figure: Any, natural: NaturalScene, outcomes: dict[str, Outcome]) -> None:
    states = _states(natural.times)
    panels = figure.subplots(4, len(states), sharex=True, sharey="row", squeeze=False, height_ratios=[1.2, 0.8, 1.2, 0.8])
    histories = {name: outcome for name, outcome in outcomes.items() if outcome.profile.size}
    tops = []
    for column, state in enumerate(states):
        panels[0, column].set_title(f"$t$ = {natural.scene.wear.times[state]:.4g}", fontsize=9)
        panels[3, column].set_xlabel("radius $r/a$")
        for row, (quantity, unit) in enumerate((("profile", D0), ("pressure", P0))):
            for number, (method, outcome) in enumerate(histories.items()):
                # marks of one method between those of another, or the last would hide the first
                every = max(len(histories), len(natural.radii) // 24)
                look = dict(STYLES[method]) | {
                    "markevery": (number * every // len(histories), every),
                    "label": method.upper(),
                }
                values = getattr(outcome, quantity)[state]
                panels[2 * row, column].plot(natural.radii, values / unit, **look)
                if quantity == "pressure":
                    tops.append(np.quantile(values / unit, 0.97))
                if method != "mdr" and "mdr" in histories:
                    other = getattr(histories["mdr"], quantity)[state]
                    gap = np.abs(values - other) / max(float(np.median(np.abs(other))), LEAST)
                    panels[2 * row + 1, column].semilogy(natural.radii, np.maximum(gap, LEAST), **look)
        for axes in panels[:, column]:
            shade_rings(axes, natural.edges, natural.wear)
    labels = ("worn height $f/d_0$", "$|f - f_{MDR}|$\n/ median $f$", "pressure $p/p_0$", "$|p - p_{MDR}|$\n/ median $p$")
    for axes, label in zip(panels[:, 0], labels, strict=True):
        axes.set_ylabel(label)
    panels[0, 0].invert_yaxis()
    panels[2, 0].set_ylim(0, 1.25 * max(tops))
    handles, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper right", ncols=len(names), frameon=False, fontsize=9)


def _draw_ring_forces(axes: Any, natural: NaturalScene, outcomes: dict[str, Outcome]) -> None:
    """Force on each ring over time: lines by the MDR (or the first method), marks by the others."""
    times = np.array(natural.scene.wear.times)
    histories = {name: outcome.ring_force for name, outcome in outcomes.items() if outcome.ring_force.size}
    rings = next(iter(histories.values())).shape[1]
    shown = np.unique(np.linspace(0, rings - 1, min(rings, 5)).round().astype(int))
    for number, (method, forces) in enumerate(histories.items()):
        for ring in shown:
            look = style(int(ring)) if number == 0 else style(number) | {"linestyle": "none", "color": "0.3"}
            axes.plot(times, forces[:, ring], **(look | ({"marker": ""} if number == 0 else {})))
            if number == 0:
                place = {"xytext": (0, 4), "textcoords": "offset points", "ha": "center", "va": "bottom"}
                axes.annotate(f"{ring + 1}", (times[0], forces[0, ring]), fontsize=8, **place)
        axes.plot(
            [], [], label=method.upper(), **(style(number) | ({"marker": ""} if number == 0 else {"linestyle": "none"}))
        )
    positive = times[times > 0]
    if len(positive) > 2 and positive[-1] / positive[0] > 50:
        axes.set_xscale("symlog", linthresh=positive[0], linscale=0.4)
    axes.set(xlabel="time $t$ (scene units)", ylabel="force on a ring over $F$ (ring numbers from the centre)")
    axes.set_title("ring forces", fontsize=9)
    axes.legend(frameon=False, fontsize=8)


def _draw_operators(axes: Any, natural: NaturalScene, pairs: tuple[OperatorDifference, ...]) -> None:
    for number, pair in enumerate(pairs):
        label = f"{pair.methods[0].upper()} against {pair.methods[1].upper()}"
        look = style(number) | {"linestyle": "none", "markersize": 3, "label": label}
        axes.loglog(pair.wavelengths / natural.length, np.maximum(pair.differences, LEAST), **look)
    axes.set(xlabel="wavelength of the pressure over $a$", ylabel=r"relative difference of energy $|\lambda - 1|$")
    axes.set_title("as operators", fontsize=9)
    if pairs:
        axes.legend(frameon=False, fontsize=8)


def _draw_relaxation(axes: Any, result: Result, outcomes: dict[str, Outcome]) -> None:
    """Relaxation times of every method, on its own pressure space, the slowest first."""
    natural = result.scene.natural
    spectra = {name: outcome.relaxation_time for name, outcome in outcomes.items() if outcome.relaxation_time.size}
    if not spectra and "mdr" in result.models:
        spectra = {"mdr": Wear(result.models["mdr"].compliance, natural.phases[1]).relaxation_times}
    for number, (method, times) in enumerate(spectra.items()):
        look = style(number) | {"linestyle": "none", "markersize": 3, "label": method.upper()}
        axes.loglog(np.arange(1, len(times) + 1), times, **look)
    axes.set(xlabel="mode, slowest first", ylabel=r"relaxation time $\tau$ over $a/(E^*k_{max}v_0)$")
    axes.set_title("relaxation spectrum", fontsize=9)
    axes.legend(frameon=False, fontsize=8)
