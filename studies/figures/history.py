"""How a punch runs in.

Greatest displacement and RMS slope over time (the paper's Fig. 5), and how far methods differ.
"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...meshes.radial import Array
from ..crosscheck.dataset import Result
from .scale import Scale
from .style import FAINT, PAGE, complete, curve, method_curve, new_panels, set_logarithmic


def draw_history(result: Result) -> Figure:
    """Draw displacement, or the force that a given indentation takes, and RMS slope over time,
    marked at the times of the scene, and below them by how much of the value methods differ from
    the first.
    """
    scale, problem = Scale(result.scene), result.scene.problem
    worn = result.coordinates["time"] > 0
    worn_times = result.coordinates["time"][worn]
    rising = "displacement_max" if problem.indentation is None else "normal_force"
    # results of others may tell no more than how deep the punch is
    if result.gives("indentation") and len(result.by_method("indentation")) > len(
        result.by_method(rising)
    ):
        rising = "indentation"
    names = (rising, "rms_slope")
    curves = {name: result.by_method(name, worn) for name in names}
    first, between = result.between
    rows = min(2, len(curves["rms_slope"]))
    ratios = [2.2, 1][:rows]
    figure, panels = new_panels(PAGE, 2.6 + 0.6 * rows, rows, 2, sharex=True, height_ratios=ratios)
    for (name, methods), (values, *below) in zip(curves.items(), panels.T, strict=True):
        for method, heights in methods.items():
            look, times = method_curve(method), worn_times
            if first:
                if method == first:
                    times, heights = between["time"], between[name]
                    look["marker"] = ""
                else:
                    look = {"marker": "."} | look | {"linestyle": "none"}
            scale.plot(values, name, "time", times, heights, **look)
        if result.gives(f"steady_{name}"):
            steady = next(iter(result.by_method(f"steady_{name}").values()))
            values.axhline(scale.shown(name, steady), **FAINT, label="steady state")
        values.ticklabel_format(axis="y", style="sci", scilimits=(-2, 4))
        _mark_running_in(values, result, scale)
        for axes in below:
            _draw_differences(axes, worn_times, methods, scale)
            values.set_xlabel("")
    titles = result.scene.title, "running-in"
    return complete(figure, titles, panels[:, 0], scale.note, across=0.6)


def _draw_differences(axes: Any, times: Array, methods: dict[str, Array], scale: Scale) -> None:
    """Draw differences of each method from the first, over its value, where there are any."""
    (first, reference), *others = methods.items()
    for number, (method, heights) in enumerate(others):
        # no more than roundoff is left of displacements where nothing presses
        least = 1e-9 * np.nanmax(reference)
        differences = np.abs(heights - reference) / np.maximum(reference, least)
        look = curve(number) | {"markersize": 2.5, "linewidth": 0.8}
        label = f"{method.upper()} from {first.upper()}"
        shown = np.where(differences > 0, differences, np.nan)
        axes.plot(scale.shown("time", times), shown, **look, label=label)
    set_logarithmic(axes, "y")
    axes.set(xlabel=scale.label("time"), ylabel="rel. difference")
    # whole decades
    low, high = np.log10(axes.get_ylim())
    axes.set_ylim(10 ** np.floor(low), 10 ** np.ceil(high))


def _mark_running_in(axes: Any, result: Result, scale: Scale) -> None:
    """Mark where 90 % and 99 % of running-in are over, by the first method that knows."""
    first, last = axes.get_xlim()
    for part, name in (("90 %", "time_to_90"), ("99 %", "time_to_99")):
        time = scale.shown("time", float(result.first(name)))
        if first < time < last:
            axes.axvline(time, color="0.6", linewidth=0.6, zorder=0)
            place = {"transform": axes.get_xaxis_transform(), "rotation": 90, "ha": "right"}
            axes.text(time, 0.02, part, **place, fontsize=6, color="0.35")
