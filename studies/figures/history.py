"""Draw the running-in: greatest displacement and RMS slope over time, and method differences.

These are the quantities of the paper's Fig. 5.
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

# width and height of a label such as "90 %", over those of the panel
LABEL_WIDTH, LABEL_HEIGHT = 0.12, 0.09


def draw_history(result: Outcome) -> Figure:
    """Draw displacement and RMS slope over time, and the differences of methods from the first.

    Values are marked at the times of the scene. The force is drawn instead of the displacement if
    the scene prescribes the indentation, and the indentation if more methods compute it.
    Differences are drawn in panels below, relative to the value.
    """
    scale = Scale.of(result)
    after_start = result.coordinates["time"] > 0
    times = result.coordinates["time"][after_start]
    # results of other programs may contain the indentation only
    candidates = result.scene.problem.load_regime.running_in_quantity, "indentation"
    names = max(candidates, key=lambda name: len(result.by_method(name))), "rms_slope"
    method_between, values_between = result.between
    rows = min(2, len(result.by_method("rms_slope")))
    ratios = [2.2, 1][:rows]
    figure, panels = new_panels(PAGE, 2.6 + 0.6 * rows, rows, 2, sharex=True, height_ratios=ratios)
    for name, (values, *below) in zip(names, panels.T, strict=True):
        methods = result.by_method(name, after_start)
        scale.suit(name, np.array(list(methods.values())))
        for method, heights in methods.items():
            look = scale.look(method)
            if method == method_between:
                look["marker"] = ""
                scale.plot(
                    values, name, "time", values_between["time"], values_between[name], **look
                )
            else:
                # draw marks without a line if another method has a curve
                look = {"marker": "."} | look | ({"linestyle": "none"} if method_between else {})
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

    The labels are to the left and to the right of the two lines; one is above the other if there is
    no space at the end of the panel. They are at the top or bottom, whichever is farther from the
    curve.
    """
    place = axes.transData + axes.transAxes.inverted()
    for percentage, side in ((90, "right"), (99, "left")):
        time = scale.shown("time", float(result.first(f"time_to_{percentage}")))
        start, end = axes.get_xlim()
        if not start < time < end:
            continue
        axes.axvline(time, color="0.6", linewidth=0.6, zorder=0)
        curves = [
            (np.asarray(line.get_xdata()), np.asarray(line.get_ydata())) for line in axes.lines
        ]
        heights = [
            float(place.transform((time, values[np.abs(times - time).argmin()]))[1])
            for times, values in curves
            if len(times) > 2
        ]
        at_bottom = np.mean(heights) > 0.5 if heights else True
        position = float(place.transform((time, axes.get_ylim()[0]))[0])
        # move a label to the other side of its line, and higher, if it would leave the panel
        raised = 0.0
        if side == "right" and position < LABEL_WIDTH:
            side, raised = "left", LABEL_HEIGHT
        elif side == "left" and position > 1 - LABEL_WIDTH:
            side, raised = "right", LABEL_HEIGHT
        height = 0.01 + raised if at_bottom else 0.99 - raised
        axes.text(
            *(time, height, f"{percentage} %"),
            transform=axes.get_xaxis_transform(),
            ha=side,
            va="bottom" if at_bottom else "top",
        )


def _draw_differences(axes: Axes, times: Array, methods: dict[str, Array], scale: Scale) -> None:
    """Draw differences of each method from the first, relative to its value; omit zeros."""
    (first, reference), *others = methods.items()
    # lower bound: without contact, displacements are only roundoff
    reference_size = np.maximum(reference, 1e-9 * np.nanmax(reference))
    for number, (method, heights) in enumerate(others):
        differences = np.abs(heights - reference) / reference_size
        look = curve(number) | {"markersize": 2.5, "linewidth": 0.8}
        label = f"{label_of(method)} from {label_of(first)}"
        shown = np.where(differences > 0, differences, np.nan)
        axes.plot(scale.shown("time", times), shown, **look, label=label)
    set_logarithmic(axes, "y", most=3)
    axes.set(xlabel=scale.label("time"), ylabel="rel. difference")
    # limit the axis to whole decades
    low, high = np.log10(axes.get_ylim())
    axes.set_ylim(10 ** np.floor(low), 10 ** np.ceil(high))
