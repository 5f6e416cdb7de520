"""How a punch runs in.

Greatest displacement and RMS slope over time (the paper's Fig. 5), and how far methods differ.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...meshes.radial import Array
from ..outcome.outcome import Outcome
from .scale import Scale
from .style import (
    FAINT,
    PAGE,
    complete,
    curve,
    label_of,
    method_curve,
    new_panels,
    set_logarithmic,
    show_values,
)


def draw_history(result: Outcome) -> Figure:
    """Draw displacement and RMS slope over time, and by how much methods differ from the first.

    Values are marked at the times of the scene. In place of the displacement, the force is drawn if
    the indentation is given, and the indentation if more methods give it. Differences are drawn in
    panels below, relative to the value.
    """
    scale = Scale(result.scene)
    worn = result.coordinates["time"] > 0
    times = result.coordinates["time"][worn]
    # results of others may tell no more than how deep the punch is
    rising = result.scene.problem.load_regime.shows_running_in, "indentation"
    names = max(rising, key=lambda name: len(result.by_method(name))), "rms_slope"
    first, between = result.between
    rows = min(2, len(result.by_method("rms_slope")))
    ratios = [2.2, 1][:rows]
    figure, panels = new_panels(PAGE, 2.6 + 0.6 * rows, rows, 2, sharex=True, height_ratios=ratios)
    for name, (values, *below) in zip(names, panels.T, strict=True):
        methods = result.by_method(name, worn)
        for method, heights in methods.items():
            look = method_curve(method)
            if method == first:
                look["marker"] = ""
                scale.plot(values, name, "time", between["time"], between[name], **look)
            else:
                # marks alone beside a curve
                look = {"marker": "."} | look | ({"linestyle": "none"} if first else {})
                scale.plot(values, name, "time", times, heights, **look)
        steady = scale.shown(name, result.first(f"steady_{name}"))
        if np.isfinite(steady):
            values.axhline(steady, **FAINT, label="steady state")
        show_values(values)
        start, end = values.get_xlim()
        for part in (90, 99):
            time = scale.shown("time", float(result.first(f"time_to_{part}")))
            if start < time < end:
                values.axvline(time, color="0.6", linewidth=0.6, zorder=0)
                values.text(time, values.get_ylim()[0], f"{part} %", ha="right", va="bottom")
        for axes in below:
            _draw_differences(axes, times, methods, scale)
            values.set_xlabel("")
    titles = result.scene.title, "running-in"
    return complete(figure, titles, panels[:, 0])


def _draw_differences(axes: Axes, times: Array, methods: dict[str, Array], scale: Scale) -> None:
    """Draw differences of each method from the first, over its value, where there are any."""
    (first, reference), *others = methods.items()
    # no more than roundoff is left of displacements where nothing presses
    reference_size = np.maximum(reference, 1e-9 * np.nanmax(reference))
    for number, (method, heights) in enumerate(others):
        differences = np.abs(heights - reference) / reference_size
        look = curve(number) | {"markersize": 2.5, "linewidth": 0.8}
        label = f"{label_of(method)} from {label_of(first)}"
        shown = np.where(differences > 0, differences, np.nan)
        axes.plot(scale.shown("time", times), shown, **look, label=label)
    set_logarithmic(axes, "y")
    axes.set(xlabel=scale.label("time"), ylabel="rel. difference")
    # whole decades
    low, high = np.log10(axes.get_ylim())
    axes.set_ylim(10 ** np.floor(low), 10 ** np.ceil(high))
