"""How a punch runs in.

Greatest displacement and RMS slope over time (the paper's Fig. 5), and how far methods differ.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray
from matplotlib.figure import Figure

from ...meshes.radial import Array
from ..crosscheck.dataset import Result
from ..methods.quantities import array
from ..methods.sampler import Sampler
from .scale import Scale
from .style import (
    FAINT,
    complete,
    curve,
    method_curve,
    page,
    powers,
    spans_decades,
    time_axis,
    titled,
    without_marks,
)


def at_any_time(result: Result) -> tuple[str, xarray.Dataset] | None:
    """Return the first method whose modes give the state at any time, and its quantities at many
    times between the earliest and the last.
    """
    problem = result.scene.problem
    space = np.geomspace if spans_decades(problem.times) else np.linspace
    for name, solution in result.solutions.items():
        if solution.wear is not None and problem.march == "modal":
            times = space(problem.earliest, float(problem.times[-1]), 80)
            sampler = Sampler(problem, solution.wear.compliance.space)
            return name, sampler.history(solution.wear.modal(times))
    return None


def draw_history(result: Result) -> Figure:
    """Draw displacement and RMS slope over time, marked at the times of the scene, and below them
    by how much of the value methods differ from the first.
    """
    scale, methods = Scale(result.scene), result.given("indentation")
    times = result.scene.problem.times * scale.time.factor
    smooth = at_any_time(result)
    if len(methods) > 1:
        figure, panels = page(
            2, 2, 1.35, left=0.55, across=0.6, sharex=True, height_ratios=[2.2, 1]
        )
    else:
        figure, panels = page(1, 2, 1.9, left=0.55, across=0.6)
    for name, axis, what, symbol, column in (
        ("displacement_max", scale.height, "greatest displacement", "u_{max}", panels[:, 0]),
        ("rms_slope", scale.slope, "RMS slope", "s", panels[:, 1]),
    ):
        values, later = column[0], times > 0
        for method, results in methods.items():
            look = method_curve(method)
            if smooth is None:
                values.plot(times[later], array(results, name)[later] * axis.factor, **look)
            elif method == smooth[0]:
                seconds = array(smooth[1], "time") * scale.time.factor
                values.plot(seconds, array(smooth[1], name) * axis.factor, **without_marks(look))
            else:
                look = {"marker": "."} | look | {"linestyle": "none"}
                values.plot(times[later], array(results, name)[later] * axis.factor, **look)
        for results in list(result.given(f"steady_{name}").values())[:1]:
            steady = float(array(results, f"steady_{name}")) * axis.factor
            values.axhline(steady, **FAINT, label="steady state")
        values.set_ylabel(axis.label(what, symbol))
        values.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
        time_axis(values, times)
        _mark_running_in(values, result, scale)
        if len(methods) > 1:
            _draw_differences(column[1], name, times, methods)
        column[-1].set_xlabel(scale.time.label("time", "t"))
    return complete(figure, titled(result.scene, "running-in"), panels[:, 0], scale.note)


def _draw_differences(
    axes: Any, name: str, times: Array, methods: Mapping[str, xarray.Dataset]
) -> None:
    """Draw differences of each method from the first, over its value, where there are any."""
    (first, reference), *others = methods.items()
    for number, (method, results) in enumerate(others):
        value = array(reference, name)
        difference = np.abs(array(results, name) - value)
        shown = (difference > 0) & (value > 0) & (times > 0)
        look = curve(number) | {"markersize": 2.5, "linewidth": 0.8}
        label = f"{method.upper()} from {first.upper()}"
        axes.plot(times[shown], difference[shown] / value[shown], **look, label=label)
    axes.set_yscale("log")
    powers(axes.yaxis)
    # whole decades
    low, high = np.log10(axes.get_ylim())
    axes.set_ylim(10 ** np.floor(low), 10 ** np.ceil(high))
    axes.set_ylabel("rel. difference")


def _mark_running_in(axes: Any, result: Result, scale: Scale) -> None:
    """Mark where 90 % and 99 % of running-in are over, by the first method that knows."""
    first, last = axes.get_xlim()
    for part, place in (("90 %", "time_to_90"), ("99 %", "time_to_99")):
        time = float(result.first_answer(place)) / scale.time.stored * scale.time.factor
        if first < time < last:
            axes.axvline(time, color="0.6", linewidth=0.6, zorder=0)
            axes.annotate(
                part,
                (time, 0.02),
                xycoords=axes.get_xaxis_transform(),
                rotation=90,
                ha="right",
                fontsize=6,
                color="0.35",
            )
