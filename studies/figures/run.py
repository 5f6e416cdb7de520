"""Figures of a run that can go into a paper.

Normalised as in the paper: heights by ``d0 = F/(2 a E*)``, pressures by ``p0 = F/(2 pi a^2)``, lengths by `a`.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from ringwear.meshes.radial import Array
from ringwear.studies.crosscheck.operators import OperatorDifference
from ringwear.studies.figures.style import FAINT, broken_at, legend_of, method_curve, new_figure, shade_rings, titled
from ringwear.studies.methods.base import Solution
from ringwear.studies.methods.quantities import array
from ringwear.studies.problem.problem import D0, P0
from ringwear.studies.problem.scene import Scene


def _with(quantity: str, solutions: Mapping[str, Solution]) -> dict[str, xarray.Dataset]:
    """Results of the methods that give a quantity."""
    return {name: one.results for name, one in solutions.items() if quantity in one.results}


def draw_states(scene: Scene, solutions: Mapping[str, Solution], path: Path) -> None:
    """Profiles and pressures at several times, every method over the other (the paper's Fig. 4)."""
    problem, every = scene.problem, _with("profile", solutions)
    if not every:
        return
    count = len(problem.times)
    states = np.unique(np.linspace(0, count - 1, min(count, 6)).round().astype(int))
    figure = new_figure(2.3 * len(states), 4.6)
    panels = figure.subplots(2, len(states), sharex=True, sharey="row", squeeze=False)
    tops = []
    for state, (upper, lower) in zip(states, panels.T, strict=True):
        for name, results in every.items():
            look = method_curve(name, len(problem.radii))
            pressure = array(results, "pressure")[state] / P0
            upper.plot(problem.radii, array(results, "profile")[state] / D0, **look)
            lower.plot(*broken_at(problem.merged.ring_edges, problem.radii, pressure), **look)
            tops.append(np.quantile(pressure, 0.97))
        if problem.profile is None:
            lower.plot(problem.radii, 1 / np.sqrt(1 - np.minimum(problem.radii, 1 - 1e-9) ** 2), **FAINT, label="unworn")
        else:
            upper.plot(problem.radii, problem.profile(problem.radii) / D0, **FAINT, label="unworn")
        upper.set_title(f"$t$ = {scene.wear.times[state]:.4g}", fontsize=9)
        lower.set_xlabel("$r/a$")
        for axes in (upper, lower):
            shade_rings(axes, *problem.rings)
    panels[0, 0].set_ylabel("worn height $f/d_0$")
    panels[0, 0].invert_yaxis()
    panels[1, 0].set_ylabel("pressure $p/p_0$")
    panels[1, 0].set_ylim(0, 1.25 * max(tops))
    legend_of(figure, panels[1, :1])
    figure.suptitle(titled(scene.title, "profiles and pressures; shaded rings wear faster"), fontsize=10)
    figure.savefig(path)


def draw_history(scene: Scene, solutions: Mapping[str, Solution], path: Path) -> None:
    """Displacement and RMS gradient over time (the paper's Fig. 5), with the difference FEM - MDR below."""
    every = _with("indentation", solutions)
    if not every:
        return
    rows = 2 if {"fem", "mdr"} <= set(every) else 1
    figure = new_figure(9, 3.2 + 2.0 * (rows - 1))
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False, height_ratios=[3, 1.6][:rows])
    times = np.array(scene.wear.times)
    labels = {
        "displacement_max": "greatest displacement $u_{z,max}/d_0$",
        "rms_slope": r"RMS gradient $\nabla f\,a/d_0$",
    }
    for (name, label), column in zip(labels.items(), panels.T, strict=True):
        for method, results in every.items():
            look = method_curve(method, 24)
            column[0].plot(times, array(results, name) / D0, **look | ({"marker": "."} if method == "mdr" else {}))
        for results in list(_with(f"steady_{name}", solutions).values())[:1]:
            column[0].axhline(float(array(results, f"steady_{name}")) / D0, **FAINT, label="steady state")
        column[0].set_ylabel(label)
        time_axis(column[0], times)
        if rows == 2:
            difference = array(every["fem"], name) - array(every["mdr"], name)
            column[1].axhline(0, color="0.4", linewidth=0.8)
            column[1].plot(times, difference / D0, color="black", marker="o", markersize=3, linewidth=1)
            column[1].set_ylabel("FEM − MDR")
            column[1].ticklabel_format(axis="y", style="sci", scilimits=(-2, 2))
        column[-1].set_xlabel("time $t$" + (f" ({scene.units})" if scene.units else ""))
    legend_of(figure, panels[0, :1])
    figure.suptitle(titled(scene.title, "displacement and gradient over time"), fontsize=10)
    figure.savefig(path)


def time_axis(axes: Any, times: Array) -> None:
    """Logarithmic over several decades, with room for zero."""
    positive = times[times > 0]
    if len(positive) > 2 and positive[-1] / positive[0] > 50:
        axes.set_xscale("symlog", linthresh=positive[0], linscale=0.4)
    axes.set_xlim(0, times[-1] * 1.05 if times[-1] > 0 else 1)


def draw_steady(scene: Scene, solutions: Mapping[str, Solution], path: Path) -> None:
    """Limiting profile and steady pressure, every method over the other."""
    problem, every = scene.problem, _with("steady_profile", solutions)
    if not (every and problem.steady):
        return
    figure = new_figure(9, 3.6)
    left, right = figure.subplots(1, 2)
    for name, results in every.items():
        look = method_curve(name, len(problem.radii))
        left.plot(problem.radii, array(results, "steady_profile") / D0, **look)
        pressure = array(results, "steady_pressure") / P0
        right.plot(*broken_at(problem.merged.ring_edges, problem.radii, pressure), **look)
    left.invert_yaxis()
    left.set_ylabel("limiting profile $f_{stat}/d_0$")
    right.set_ylabel("steady pressure $p/p_0$")
    right.set_ylim(bottom=0)
    for axes in (left, right):
        axes.set_xlabel("$r/a$")
        shade_rings(axes, *problem.rings)
    legend_of(figure, [left])
    figure.suptitle(titled(scene.title, "steady state; shaded rings wear faster"), fontsize=10)
    figure.savefig(path)


def draw_operators(scene: Scene, operators: Iterable[OperatorDifference], path: Path) -> None:
    """Relative difference of two methods against the wavelength of the pressure."""
    figure = new_figure(6.5, 4.2)
    axes = figure.subplots()
    for pair, marker in zip(operators, "ox^s", strict=False):
        label = f"{pair.methods[0].upper()} against {pair.methods[1].upper()}"
        wavelengths, shown = pair.wavelengths / scene.punch.radius, np.maximum(pair.differences, 1e-16)
        axes.loglog(wavelengths, shown, marker, markersize=3, markerfacecolor="none", label=label)
        axes.axhline(pair.rings, linewidth=0.8, color="0.4", linestyle="--")
        place: dict[str, Any] = {"ha": "right", "va": "bottom", "fontsize": 8, "transform": axes.get_yaxis_transform()}
        axes.text(0.99, pair.rings, "all steady states ", **place)
    shortest = 2 * float(scene.problem.rings.widths.min())
    axes.axvline(shortest, linewidth=0.8, color="0.4", linestyle=":")
    axes.text(shortest, 0.01, " two rings", fontsize=8, transform=axes.get_xaxis_transform())
    axes.set_xlabel("wavelength of the pressure over $a$")
    axes.set_ylabel(r"relative difference of energy $|\lambda - 1|$")
    axes.legend(frameon=False, fontsize=9)
    figure.suptitle(titled(scene.title, "the methods as operators"), fontsize=10)
    figure.savefig(path)
