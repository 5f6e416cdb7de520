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
    new_panels,
    set_logarithmic,
    show_values,
)

# parts of a panel that a label such as 90 % takes
LABEL_WIDTH, LABEL_HEIGHT = 0.12, 0.09


def draw_history(result: Outcome) -> Figure:
    """Draw displacement and RMS slope over time, and by how much methods differ from the first.

    Values are marked at the times of the scene. In place of the displacement, the force is drawn if
    the indentation is given, and the indentation if more methods give it. Differences are drawn in
    panels below, relative to the value.
    """
    scale = Scale.of(result)
    worn = result.coordinates["time"] > 0
    times = result.coordinates["time"][worn]
    # results of others may tell no more than how deep the punch is
    rising = result.scene.problem.load_regime.running_in_quantity, "indentation"
    names = max(rising, key=lambda name: len(result.by_method(name))), "rms_slope"
    first, between = result.between
    rows = min(2, len(result.by_method("rms_slope")))
    ratios = [2.2, 1][:rows]
    figure, panels = new_panels(PAGE, 2.6 + 0.6 * rows, rows, 2, sharex=True, height_ratios=ratios)
    for name, (values, *below) in zip(names, panels.T, strict=True):
        methods = result.by_method(name, worn)
        scale.suit(name, np.array(list(methods.values())))
        for method, heights in methods.items():
            look = scale.look(method)
            if method == first:
                look["marker"] = ""
                scale.plot(values, name, "time", between["time"], between[name], **look)
            else:
                # marks alone beside a curve
                look = {"marker": "."} | look | ({"linestyle": "none"} if first else {})
                scale.plot(values, name, "time", times, heights, **look)
        steady = scale.shown(name, result.first(f"steady_{name}"))
        if np.isfinite(steady):
            values.axhline(steady, **FAINT, label=scale.steady_state)
        show_values(values)
        _mark_running_in(values, result, scale)
        for axes in below:
            _draw_differences(axes, times, methods, scale)
            values.set_xlabel("")
    titles = result.scene.title, "running-in"
    return complete(figure, titles, panels[:, 0])


def _mark_running_in(axes: Axes, result: Outcome, scale: Scale) -> None:
    """Mark the times at which 90 % and 99 % of the running-in are complete.

    The labels are on both sides of the two lines, where the panel ends one above the other, and at
    the end of the panel that is farther from the curve.
    """
    place = axes.transData + axes.transAxes.inverted()
    for part, side in ((90, "right"), (99, "left")):
        time = scale.shown("time", float(result.first(f"time_to_{part}")))
        start, end = axes.get_xlim()
        if not start < time < end:
            continue
        axes.axvline(time, color="0.6", linewidth=0.6, zorder=0)
        drawn = [
            (np.asarray(line.get_xdata()), np.asarray(line.get_ydata())) for line in axes.lines
        ]
        heights = [
            float(place.transform((time, values[np.abs(times - time).argmin()]))[1])
            for times, values in drawn
            if len(times) > 2
        ]
        low = np.mean(heights) > 0.5 if heights else True
        across = float(place.transform((time, axes.get_ylim()[0]))[0])
        # a label is as wide as a ninth of a panel, and as high as a twelfth
        raised = 0.0
        if side == "right" and across < LABEL_WIDTH:
            side, raised = "left", LABEL_HEIGHT
        elif side == "left" and across > 1 - LABEL_WIDTH:
            side, raised = "right", LABEL_HEIGHT
        height = 0.01 + raised if low else 0.99 - raised
        axes.text(
            *(time, height, f"{part} %"),
            transform=axes.get_xaxis_transform(),
            ha=side,
            va="bottom" if low else "top",
        )


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
    set_logarithmic(axes, "y", most=3)
    axes.set(xlabel=scale.label("time"), ylabel="rel. difference")
    # whole decades
    low, high = np.log10(axes.get_ylim())
    axes.set_ylim(10 ** np.floor(low), 10 ** np.ceil(high))
