"""How a punch runs in.

Greatest displacement and RMS slope over time (the paper's Fig. 5), and how far methods differ.

Curves are smooth whatever the times asked for, for relaxation modes give the state at any time;
marks are at these times.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...meshes.radial import Array
from ..methods.base import Solution
from ..methods.quantities import array
from ..methods.sampler import Sampler
from ..problem.problem import Problem
from ..problem.scene import Scene
from .scale import Scale
from .states import given
from .style import (
    DECADES,
    FAINT,
    GREYS,
    Margins,
    footing,
    heading,
    method_curve,
    page,
    powers,
    save,
    styled,
    time_axis,
    titled,
)

SMOOTH = 80
QUANTITIES = {"displacement_max": "height", "rms_slope": "slope"}


def smooth_times(problem: Problem) -> Array:
    """Many times from the earliest to the last: logarithmic where the times asked for are."""
    first, last = problem.earliest, float(problem.times[-1])
    if last / first > DECADES:
        return np.geomspace(first, last, SMOOTH)
    return np.linspace(first, last, SMOOTH)


def smooth(problem: Problem, solutions: Mapping[str, Solution]) -> tuple[str, Any] | None:
    """The first method that knows every time, by name, and its quantities at `smooth_times`."""
    for name, solution in solutions.items():
        if solution.wear is not None and problem.march == "modal":
            sampler = Sampler(problem, solution.wear.compliance.space)
            return name, sampler.history(solution.wear.modal(smooth_times(problem)))
    return None


@styled
def draw_history(scene: Scene, solutions: Mapping[str, Solution], path: Path) -> None:
    """Displacement and RMS slope over time, and below them by how much of the value methods differ
    from the first.
    """
    problem, scale, every = scene.problem, Scale(scene), given("indentation", solutions)
    rows = 2 if len(every) > 1 else 1
    ratios: dict[str, Any] = {"height_ratios": [2.2, 1]} if rows == 2 else {}
    figure, panels = page(
        rows,
        2,
        1.9 if rows == 1 else 1.35,
        Margins(left=0.55, across=0.6, top=0.3, bottom=0.68),
        sharex=True,
        **ratios,
    )
    labels = (scale.height.label("greatest displacement", "u_{max}"), scale.slope_label)
    dense = smooth(problem, solutions)
    for (name, kind), label, column in zip(QUANTITIES.items(), labels, panels.T, strict=True):
        factor = getattr(scale, kind).factor
        _draw_values(column[0], name, factor, scale, every, dense)
        steady = given(f"steady_{name}", solutions)
        for results in list(steady.values())[:1]:
            column[0].axhline(
                float(array(results, f"steady_{name}")) * factor, **FAINT, label="steady state"
            )
        column[0].set_ylabel(label)
        column[0].ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
        if rows == 2:
            _draw_differences(column[1], name, scale, every)
        time_axis(column[-1], problem.times * scale.time.factor)
        column[-1].set_xlabel(scale.time.label("time", "t"))
    _mark_running_in(panels[0], scale, solutions)
    footing(figure, [*panels[0, :1], *panels[1:, 0]], scale.note)
    heading(figure, titled(scene.title, "running-in"))
    save(figure, path)


def _draw_values(
    axes: Any, name: str, factor: float, scale: Scale, every: Mapping[str, Any], dense: Any
) -> None:
    for method, results in every.items():
        later = array(results, "time") > 0
        times, values = (
            array(results, "time")[later] * scale.time.factor,
            array(results, name)[later] * factor,
        )
        look = method_curve(method, 0)
        if dense is not None:
            look = look | {
                "linestyle": "none",
                "marker": look.get("marker", "."),
                "markersize": look.get("markersize", 4),
            }
            if method == dense[0]:
                line = {
                    key: value
                    for key, value in method_curve(method, 0).items()
                    if not key.startswith("mark")
                }
                axes.plot(
                    array(dense[1], "time") * scale.time.factor,
                    array(dense[1], name) * factor,
                    **line,
                )
                look["label"] = "_its marks"
        axes.plot(times, values, **look)


def _draw_differences(axes: Any, name: str, scale: Scale, every: Mapping[str, Any]) -> None:
    """Of each method but the first from the first, over its value, where there is one."""
    (first, reference), *others = every.items()
    known = array(reference, name)
    for number, (method, results) in enumerate(others):
        difference = np.divide(
            np.abs(array(results, name) - known), known, out=np.zeros_like(known), where=known > 0
        )
        seen = (difference > 0) & (array(results, "time") > 0)
        look = {
            "color": GREYS[number],
            "marker": "os^D"[number % 4],
            "markersize": 2.5,
            "linewidth": 0.8,
        }
        label = f"{method.upper()} from {first.upper()}"
        axes.plot(
            array(results, "time")[seen] * scale.time.factor, difference[seen], **look, label=label
        )
    axes.set_yscale("log")
    powers(axes.yaxis)
    low, high = axes.get_ylim()
    # a decade at the least
    axes.set_ylim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))
    axes.set_ylabel("rel. difference")


def _mark_running_in(panels: Any, scale: Scale, solutions: Mapping[str, Solution]) -> None:
    """Where 90 % and 99 % are reached."""
    wears = [solution.wear for solution in solutions.values() if solution.wear is not None]
    for share in (0.9, 0.99) if wears else ():
        time = wears[0].time_to(share) * scale.time.factor
        for axes in panels:
            if axes.get_xlim()[0] < time < axes.get_xlim()[1]:
                axes.axvline(time, color="0.6", linewidth=0.6, zorder=0)
                place: dict[str, Any] = {
                    "transform": axes.get_xaxis_transform(),
                    "fontsize": 6,
                    "color": "0.35",
                }
                axes.text(
                    time,
                    0.02,
                    f"{100 * share:.0f} %",
                    rotation=90,
                    ha="right",
                    va="bottom",
                    **place,
                )
