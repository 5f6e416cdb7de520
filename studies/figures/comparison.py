"""Draw two results together: steady profile and pressure, displacement and slope over time."""

import numpy as np
from matplotlib.figure import Figure

from ...meshes import SceneError
from ..crosscheck import Result
from .scale import Scale
from .style import PAGE, complete, curve, new_panels, set_linear, show_values

COMPARED_LOOKS = {name: curve(number) for number, name in enumerate("AB")}


def draw_comparison(a: Result, b: Result) -> Figure:
    """Draw two results in the same panels, each by its first method.

    Raises
    ------
    SceneError
        if there is nothing to draw
    """
    scale, other_scale = Scale.of(a), Scale.of(b)
    other_scale.axes, other_scale.logarithmic = scale.axes, scale.logarithmic
    figure, panels = new_panels(PAGE, 4.6, 2, 2)
    names = ("steady_profile", "steady_pressure", "displacement_max", "rms_slope")
    for name, axes in zip(names, panels.flat, strict=True):
        abscissa, line_look = ("radius", {"marker": ""}) if "steady" in name else ("time", {})
        scale.suit(name, np.hstack([side.first(name).ravel() for side in (a, b)]))
        for number, (result_scale, result) in enumerate(((scale, a), (other_scale, b))):
            if result.by_method(name):
                look = curve(number) | line_look | {"label": "AB"[number]}
                result_scale.plot(
                    axes, name, abscissa, result.coordinates[abscissa], result.first(name), **look
                )
        if not axes.lines:
            figure.delaxes(axes)
        elif abscissa == "time":
            show_values(axes)
        else:
            set_linear(axes, "x")
            set_linear(axes, "y")
    if not figure.axes:
        raise SceneError("neither has a history or a steady state: nothing can be compared")
    panels[0, 0].invert_yaxis()
    return complete(figure, [title(a, b)], figure.axes, down=0.5)


def title(a: Result, b: Result) -> str:
    """Return the titles of both scenes as one title."""
    first, second = (result.scene.title or "untitled" for result in (a, b))
    return f"A is {first}; B is {second}"
