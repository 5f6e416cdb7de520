"""Two results drawn together: steady profiles and pressures, displacement and slope over time."""

from collections.abc import Sequence

import numpy as np
import xarray
from matplotlib.figure import Figure

from ...meshes.errors import SceneError
from ..problem.scene import Scene
from .scale import Scale
from .style import PAGE, complete, curve, new_panels


def draw_comparison(scenes: Sequence[Scene], datasets: Sequence[xarray.Dataset]) -> Figure:
    """Draw what both give, each by its first method, in the units of the first.

    Parameters
    ----------
    scenes, datasets
        Of A and of B.

    Raises
    ------
    SceneError
        if there is nothing to draw
    """
    scale, other = (Scale(scene) for scene in scenes)
    other.axes, other.logarithmic = scale.axes, scale.logarithmic
    figure, panels = new_panels(PAGE, 4.6, 2, 2)
    names = ("steady_profile", "steady_pressure", "displacement_max", "rms_slope")
    for name, axes in zip(names, panels.flat, strict=True):
        over, marks = ("radius", {"marker": ""}) if "steady" in name else ("time", {})
        for number, (drawn, data) in enumerate(zip((scale, other), datasets, strict=True)):
            given = (values for values in data[name].values if not np.isnan(values).all())
            for values in list(given)[:1]:
                look = curve(number) | marks | {"label": "AB"[number]}
                drawn.plot(axes, name, over, data[over].values, values, **look)
        if not axes.lines:
            figure.delaxes(axes)
    if not figure.axes:
        raise SceneError("neither has a history or a steady state: nothing can be compared")
    panels[0, 0].invert_yaxis()
    a, b = (scene.title or "untitled" for scene in scenes)
    note = f"{scale.note} of A" if scale.note else ""
    titles = "A", f"{a}; B: {b}"
    return complete(figure, titles, figure.axes, note, across=0.56, down=0.5)
