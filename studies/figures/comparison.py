"""Two results drawn together: steady profiles and pressures, displacement and slope over time."""

from collections.abc import Mapping

import numpy as np
import xarray
from matplotlib.figure import Figure

from ..problem.scene import Scene
from .scale import Scale
from .style import broken_at, complete, curve, page, time_axis

COMPARED = {
    "steady_profile": ("height", "limiting profile", "f_{stat}"),
    "steady_pressure": ("pressure", "steady pressure", "p"),
    "displacement_max": ("height", "greatest displacement", "u_{max}"),
    "rms_slope": ("slope", "RMS slope", "s"),
}
"""Quantities that are drawn: axis of `Scale`, what they are, and symbol."""


def draw_comparison(
    scenes: tuple[Scene, Scene], curves: Mapping[str, tuple[xarray.DataArray | None, ...]]
) -> Figure:
    """Draw what both give, in the units of the first.

    Parameters
    ----------
    scenes
        A and B.
    curves
        By the quantity, that of A and of B, in the scenes' units; one of them may be None.
    """
    scale, columns = Scale(scenes[0]), min(2, len(curves))
    rows = -(-len(curves) // columns)
    figure, panels = page(rows, columns, 1.6, left=0.6, top=0.45, across=0.65, down=0.45)
    for axes in panels.ravel()[len(curves) :]:
        axes.set_visible(False)
    for (name, pair), axes in zip(curves.items(), panels.ravel(), strict=False):
        kind, what, symbol = COMPARED[name]
        upright = getattr(scale, kind)
        over_time = "steady" not in name
        across = scale.time if over_time else scale.radius
        for number, (scene, values) in enumerate(zip(scenes, pair, strict=True)):
            if values is None:
                continue
            places, heights = values[values.dims[0]].values, values.values
            if name == "steady_pressure":
                edges = scene.problem.merged.ring_edges * scale.radius.stored
                places, heights = broken_at(edges, places, heights)
            axes.plot(
                places * across.factor / across.stored,
                heights * upright.factor / upright.stored,
                **curve(number) | ({} if over_time else {"marker": ""}),
                label="AB"[number],
            )
        if over_time:
            times = np.union1d(*(scene.wear.times for scene in scenes))
            time_axis(axes, times * across.factor / across.stored)
        axes.set_xlabel(across.label("time", "t") if over_time else across.label("radius", "r"))
        axes.set_ylabel(upright.label(what, symbol))
        if name == "steady_profile":
            axes.invert_yaxis()
    a, b = (scene.title or "untitled" for scene in scenes)
    note = f"{scale.note} of A" if scale.note else ""
    return complete(figure, f"A: {a}; B: {b}", [panels[0, 0]], note)
