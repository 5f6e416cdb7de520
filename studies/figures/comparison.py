"""Two results drawn together: steady profiles and pressures, displacement and slope over time."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from ..problem.scene import Scene
from .scale import Scale
from .style import Margins, broken_at, curve, footing, heading, page, powers, save, styled

# quantity: kind of its axis and its label
OVER_RADIUS = {
    "steady_profile": ("height", "limiting profile", "f_{stat}"),
    "steady_pressure": ("pressure", "steady pressure", "p"),
}
OVER_TIME = {
    "displacement_max": ("height", "greatest displacement", "u_{max}"),
    "rms_slope": ("slope", "RMS slope", ""),
}
# beyond this ratio of the last time to the first, time is logarithmic
DECADES = 30.0


@styled
def draw_comparison(
    scenes: tuple[Scene, Scene],
    curves: Mapping[str, tuple[xarray.DataArray | None, ...]],
    path: Path,
) -> None:
    """What both give, in the units of the first; a quantity that neither gives has no panel.

    Parameters
    ----------
    scenes : A and B
    curves : by quantity, that of A and of B, in the scenes' units
    """
    given = {name: pair for name, pair in curves.items() if any(one is not None for one in pair)}
    scale = Scale(scenes[0])
    columns = min(2, len(given))
    figure, panels = page(
        -(-len(given) // columns),
        columns,
        1.6,
        Margins(left=0.6, across=0.65, down=0.45, top=0.3, bottom=0.8),
    )
    for axes in panels.ravel()[len(given) :]:
        axes.set_visible(False)
    for (name, pair), axes in zip(given.items(), panels.ravel(), strict=False):
        kind, what, symbol = (OVER_RADIUS | OVER_TIME)[name]
        axis, base = getattr(scale, kind), {"height": "displacement"}.get(kind, kind)
        factor = axis.factor / getattr(scale.units, base)
        across = scale.radius if name in OVER_RADIUS else scale.time
        unit = scale.units.length if name in OVER_RADIUS else scale.units.time
        for number, (scene, one) in enumerate(zip(scenes, pair, strict=True)):
            if one is not None:
                _draw(axes, number, scene, one, (across.factor / unit, factor))
        axes.set_ylabel(axis.label(what, symbol) if symbol else scale.slope_label)
        axes.set_xlabel(
            scale.radius.label("radius", "r")
            if name in OVER_RADIUS
            else scale.time.label("time", "t")
        )
        if name == "steady_profile":
            axes.invert_yaxis()
    if any(name in OVER_TIME for name in given):
        _time_axes(
            [axes for name, axes in zip(given, panels.ravel(), strict=False) if name in OVER_TIME],
            scenes,
        )
    a, b = (scene.title or "untitled" for scene in scenes)
    note = f"{scale.note} of A" if scale.note else ""
    footing(figure, [panels[0, 0]], note)
    heading(figure, f"A: {a}; B: {b}")
    save(figure, path)


def _draw(
    axes: Any, number: int, scene: Scene, one: xarray.DataArray, factors: tuple[float, float]
) -> None:
    places, values = one[one.dims[0]].values, one.values
    look = curve(number) | {"label": "AB"[number]}
    if one.name == "steady_pressure":
        places, values = broken_at(
            scene.problem.merged.ring_edges * scene.problem.units.length, places, values
        )
    if one.dims[0] == "radius":
        look["marker"] = ""
    later = places > 0 if one.dims[0] == "time" else np.ones(len(places), bool)
    axes.plot(places[later] * factors[0], values[later] * factors[1], **look)


def _time_axes(panels: list[Any], scenes: tuple[Scene, Scene]) -> None:
    times = [time for scene in scenes for time in scene.wear.times if time > 0]
    for axes in panels:
        if times and max(times) / min(times) > DECADES:
            axes.set_xscale("log")
            powers(axes.xaxis)
