"""What a scene's figures are drawn in, and its quantities over the radius or over time.

SI units with their prefixes, or over a, d0 and p0 as in the paper: ``d0 = F/(2 a E*)`` is the
indentation of the unworn punch and ``p0 = F/(2 pi a^2)`` its least pressure; a figure that uses
them says so.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...meshes.radial import Array, Indices
from ..problem.problem import D0, P0, Problem
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames
from .style import broken_at, method_curve, set_logarithmic, shade_rings

LABELS = {
    "radius": ("radius", "r", "length"),
    "depth": ("depth", "z", "length"),
    "time": ("time", "t", "time"),
    "profile": ("profile", "Δf", "height"),
    "pressure": ("pressure", "p", "pressure"),
    "steady_profile": ("limiting profile", "fₛₜₐₜ", "height"),
    "steady_pressure": ("steady pressure", "p", "pressure"),
    "displacement_max": ("greatest displacement", "uₘₐₓ", "displacement"),
    "indentation": ("indentation", "d", "displacement"),
    "rms_slope": ("RMS slope", "s", "slope"),
    "contact_edge": ("contact (shaded), its edges", "r", "length"),
    "ring_force": ("force", "Fₙ", "force"),
    "normal_force": ("force", "Fₙ", "force"),
    "ring_worn_volume": ("worn volume", "V", "volume"),
    "von_mises": ("von Mises stress", "σ", "pressure"),
}
"""What is drawn: its name, symbol and kind of unit."""
MANY = 24
"""Rings from which on curves are thin and without marks, over the whole width of a page."""


class Axis(NamedTuple):
    """What a kind of quantity is drawn in.

    Parameters
    ----------
    unit : float
        Of the axis, in the units of the scene.
    name : str
        Of the unit, in SI.
    over : str
        Symbol of what values are divided by, where they are not in SI.
    """

    unit: float
    name: str
    over: str = ""


class Scale:
    """The axes of a scene's figures.

    Attributes
    ----------
    axes : dict of Axis
        By the kind of quantity.
    logarithmic : bool
        Whether times span so much that they are drawn from the first after the start.
    """

    def __init__(self, scene: Scene) -> None:
        self.names, self.problem = UnitNames.of(scene.units), scene.problem
        units = scene.problem.units
        slid = max(scene.problem.distances, default=0.0) or 1.0
        unworn = scene.problem.profile(scene.problem.radii)
        self.axes = {}
        for kind, size, symbol in (
            ("length", 1.0, "a"),
            ("displacement", D0, "d₀"),
            ("height", D0, "d₀"),
            ("pressure", P0, "p₀"),
            ("slope", D0, "(d₀/a)"),
            ("force", 1.0, "F"),
            ("volume", 1.0, "(Fa/E*)"),
        ):
            of = "displacement" if kind == "height" else kind
            stored = size * getattr(units, of)
            # units of volume are far apart, and a face is higher than it is pressed in
            taller = {"volume": 100 * slid, "height": max(unworn.max(), 1.0)}
            unit, name = self.names.readable(stored * taller.get(kind, 1.0), of)
            self.axes[kind] = Axis(unit, name) if self.names.base else Axis(stored, "", symbol)
        later = [time for time in scene.wear.times if time] or [0.0]
        self.axes["time"] = Axis(*self.names.readable(float(np.sqrt(later[0] * later[-1])), "time"))
        # where loads vary, late times have as much to show as early ones
        self.logarithmic = later[-1] > 30 * later[0] and not scene.problem.loading.varies

    def shown(self, name: str, values: Any) -> Any:
        """Return values of a quantity, in the units of the scene, as they are drawn."""
        return values / self.axes[LABELS[name][2]].unit

    def label(self, name: str) -> str:
        """Return the label of an axis, as ``pressure p (MPa)`` or ``pressure p/p₀``."""
        what, symbol, kind = LABELS[name]
        _, unit, over = self.axes[kind]
        return f"{what} {symbol}{f'/{over}' if over else ''}" + (f" ({unit})" if unit else "")

    def plot(
        self, axes: Any, name: str, over: str, places: Array, heights: Array, **look: Any
    ) -> None:
        """Draw a quantity over the `radius`, broken where pressures jump, or over `time`."""
        if over == "time" and self.logarithmic:
            set_logarithmic(axes, "x")
            places, heights = places[places > 0], heights[places > 0]
        if "pressure" in name:
            edges = self.problem.merged.ring_edges * self.problem.units.length
            places, heights = broken_at(edges, places, heights)
        axes.plot(self.shown(over, places), self.shown(name, heights), **look)
        axes.set(xlabel=self.label(over), ylabel=self.label(name))

    def plot_radial(self, axes: Any, name: str, radii: Array, values: dict[str, Array]) -> None:
        """Draw a quantity over the radius by every method that gives it, and shade the rings."""
        rings = self.problem.rings
        for method, curve in values.items():
            given = ~np.isnan(curve)
            look = method_curve(method, int(given.sum()))
            if len(rings.wear_coefficients) > MANY:
                look |= {"marker": "", "linewidth": 0.5 * look["linewidth"]}
            self.plot(axes, name, "radius", radii[given], curve[given], **look)
        shade_rings(axes, *rings, self.shown("radius", self.problem.units.length))

    def when(self, time: float) -> str:
        """Return a time in the scene's numbers, for people."""
        return f"t = {self.names.write(time, 'time', 3)}"

    def worn(self, height: float) -> str:
        """Return a height, for people."""
        if self.names.base:
            return self.names.write(height, "displacement", 2)
        return f"{self.shown('profile', height):.2g} d₀"

    @property
    def note(self) -> str:
        """What the axes are over."""
        if self.names.base:
            return ""
        units, write = self.problem.units, self.names.write
        force = "F" if self.problem.indentation is None else "F = 2aE*d"
        return (
            f"a = {write(units.length, 'length', 3)}, {force} = {write(units.force, 'force', 3)}, "
            f"d₀ = F/(2aE*) = {write(D0 * units.displacement, 'displacement', 3)}, "
            f"p₀ = F/(2πa²) = {write(P0 * units.pressure, 'pressure', 3)}"
        )


def least_wear(problem: Problem, profiles: Array) -> Any:
    """Return what has worn off everywhere, of (..., R) profiles at the radii of the output, in the
    scene's units.
    """
    unworn = problem.profile(problem.radii) * problem.units.displacement
    return np.nanmin(profiles - unworn, axis=-1)


def high_pressure(pressure: Array) -> float:
    """Return a pressure that a tenth of those (R,) in contact are above: some may be infinite."""
    return float(np.quantile([0.0, *pressure[pressure > 0]], 0.9))


def panel_tops(heights: Sequence[float]) -> Array:
    """Return heights that panels are scaled to: all to the greatest, unless they differ by more
    than a factor of ten.
    """
    tops = np.where(np.array(heights) > 0, heights, max(heights) or 1.0)
    return np.where(tops.max() > 10 * tops.min(), tops, tops.max())


def shown_times(times: Array, most: int) -> Indices:
    """Choose some of the times, first and last among them; of few, none is spent on the start."""
    chosen = np.flatnonzero((times > 0) | (most > 3) | ~times.any())
    places = np.linspace(0, len(chosen) - 1, min(len(chosen), most)).round().astype(np.int64)
    return chosen[np.unique(places)]
