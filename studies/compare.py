"""All methods over one scene on one page: profiles and pressures with their differences, ring forces, and operators.

Differences are from the MDR, over the median at that time. Every method joins that can solve the scene, asked for or not.
"""

import argparse
from collections import Counter
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from ringwear.meshes.radial import Array
from ringwear.studies.crosscheck.run import Result, run
from ringwear.studies.figures.style import curve, legend_of, method_curve, new_figure, shade_rings, titled
from ringwear.studies.methods.base import method
from ringwear.studies.methods.quantities import array
from ringwear.studies.problem.problem import D0, P0
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import LOG
from ringwear.studies.registry import METHODS
from ringwear.studies.tables import Table, write_page

FIELDS = ("quantity", "methods", "difference", "uncertainty", "verdict", "remark")
OPERATOR_FIELDS = ("methods", "rings", "history", "space", "stability", "residual")
LEAST = 1e-16  # a difference drawn where there is none


def conduct(scene: Scene, out: Path, options: argparse.Namespace) -> list[str]:
    """Run the scene by every method; writes `compare.csv`, `operators.csv`, `compare.md` and `compare.png`."""
    quick = {"accuracy__rtol": 1e-3, "accuracy__mdr__grid": 100} if options.quick else {}
    others = [name for name in METHODS if name not in scene.methods and not method(name).refusal(scene.problem)]
    scene = scene.changed(methods=[*scene.methods, *others], **quick)
    LOG.info(" compare  %s ...", ", ".join(scene.methods))
    result = run(scene)
    agreement = [vars(row) | {"methods": " - ".join(row.methods)} for row in result.agreement]
    operators = [vars(pair) | {"methods": " - ".join(pair.methods)} for pair in result.operators]
    tables = {
        "Greatest differences, relative": Table(out / "compare.csv", FIELDS, agreement),
        "As operators, relative": Table(out / "operators.csv", OPERATOR_FIELDS, operators),
    }
    conclusions = []
    for methods, group in groupby(agreement, key=itemgetter("methods")):
        rows = list(group)
        worst = max(rows, key=itemgetter("difference"))
        difference = f"{worst['difference']:.1e} ({worst['quantity']})"
        counts = Counter(row["verdict"] for row in rows)
        listed = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
        conclusions.append(f"{methods}: differ by at most {difference}; of {len(rows)} quantities {listed}.")
    write_page(out / "compare.md", f"The methods side by side: {scene.title}", conclusions, tables)
    draw(result, out / "compare.png")
    return [*conclusions, *(table.markdown() for table in tables.values())]


def draw(result: Result, path: Path) -> None:
    """One page: states above their differences, then ring forces, operators and relaxation times."""
    figure = new_figure(13, 13)
    parts: Any = figure.subfigures(2, 1, height_ratios=[2.3, 1])
    legend_of(figure, draw_states(result, parts[0]))
    forces, operators, relaxation = parts[1].subplots(1, 3)
    draw_ring_forces(result, forces)
    for number, pair in enumerate(result.operators):
        label = f"{pair.methods[0].upper()} against {pair.methods[1].upper()}"
        look = curve(number) | {"linestyle": "none", "markersize": 3, "label": label}
        wavelengths = pair.wavelengths / result.scene.problem.units.length
        operators.loglog(wavelengths, np.maximum(pair.differences, LEAST), **look)
    operators.set(xlabel="wavelength of the pressure over $a$", ylabel=r"relative difference of energy $|\lambda - 1|$")
    operators.legend(frameon=False, fontsize=8)
    for name, solution in result.solutions.items():
        if solution.wear is not None:
            times = solution.wear.relaxation_times
            relaxation.loglog(np.arange(1, len(times) + 1), times, **method_curve(name, len(times)))
    relaxation.set(xlabel="mode, slowest first", ylabel=r"relaxation time $\tau$ over $a/(E^*k_{max}v_0)$")
    figure.suptitle(titled(result.scene.title, "the methods side by side; shaded rings wear faster"), fontsize=11)
    figure.savefig(path)


def draw_states(result: Result, figure: Any) -> Array:
    """Profiles and pressures at some times and in the steady state, below each the differences; returns the panels."""
    problem, radii = result.scene.problem, result.scene.problem.radii
    count, every = len(problem.times), max(len(radii) // 24, len(result.solutions))
    shown = np.linspace(0, count - 1, min(count, 4), dtype=int)
    states: list[tuple[str, str, Any]] = [(f"$t$ = {result.scene.wear.times[time]:.4g}", "", time) for time in shown]
    if problem.steady:
        states.append(("steady state", "steady_", ...))
    panels = figure.subplots(4, len(states), sharex=True, sharey="row", squeeze=False, height_ratios=[1.2, 0.8, 1.2, 0.8])
    top = 0.0
    for (state, prefix, time), column in zip(states, panels.T, strict=True):
        column[0].set_title(state, fontsize=9)
        column[3].set_xlabel("radius $r/a$")
        for values, differences, quantity, unit in ((*column[:2], "profile", D0), (*column[2:], "pressure", P0)):
            reference = array(result.solutions["mdr"].results, prefix + quantity)[time]
            for number, (name, solution) in enumerate(result.solutions.items()):
                if prefix + quantity not in solution.results:
                    continue
                # marks of one method between those of another, or the last would hide the first
                look = method_curve(name) | {"markevery": (number * every // len(result.solutions), every)}
                value = array(solution.results, prefix + quantity)[time]
                values.plot(radii, value / unit, **look)
                if name != "mdr":
                    difference = np.abs(value - reference) / max(float(np.median(np.abs(reference))), LEAST)
                    differences.semilogy(radii, np.maximum(difference, LEAST), **look)
        top = max(top, float(np.quantile(reference / P0, 0.97)))
        for axes in column:
            shade_rings(axes, *problem.rings)
    labels = ("worn height $f/d_0$", "$|f - f_{MDR}|$\n/ median $f$", "pressure $p/p_0$", "$|p - p_{MDR}|$\n/ median $p$")
    for axes, label in zip(panels[:, 0], labels, strict=True):
        axes.set_ylabel(label)
    panels[0, 0].invert_yaxis()
    panels[2, 0].set_ylim(0, 1.25 * top)
    return panels[2]


def draw_ring_forces(result: Result, axes: Any) -> None:
    """Force on each ring over time by every method."""
    problem, times = result.scene.problem, result.scene.wear.times
    count = len(problem.wear_coefficients)
    rings = np.linspace(0, count - 1, min(count, 5), dtype=int)
    for name, solution in result.solutions.items():
        if "ring_force" in solution.results:
            forces = array(solution.results, "ring_force")[:, rings]
            axes.plot(times, forces, **method_curve(name))
            if name == "mdr":
                for ring, force in zip(rings, forces[0], strict=True):
                    axes.text(times[0], force, f"{ring + 1}", va="bottom")
    if problem.earliest:
        axes.set_xscale("symlog", linthresh=problem.earliest * problem.units.time, linscale=0.4)
    axes.set(xlabel="time $t$ (scene units)", ylabel="force on a ring over $F$ (ring numbers from the centre)")
