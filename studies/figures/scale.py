"""Units, labels and looks of a scene's figures, and curves over the radius or over time.

Numbers are drawn in the units of the scene and of `results.nc`; SI units have prefixes.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ...mdr import D0, P0
from ...meshes import Array, Indices
from ..crosscheck import Problem, Result, Scene
from .style import (
    Look,
    axis_start,
    broken_at,
    looks_of,
    method_curve,
    set_linear,
    set_logarithmic,
    shade_rings,
)
from .ticks import power_of_ten, short_number

LABELS = {
    "radius": ("radius r", "length"),
    "depth": ("depth z", "length"),
    "time": ("time t", "time"),
    "profile": ("profile Δf", "height"),
    "pressure": ("pressure p", "pressure"),
    "displacement": ("displacement u", "displacement"),
    "steady_profile": ("limiting profile fₛₜₐₜ", "height"),
    "steady_pressure": ("steady pressure p", "pressure"),
    "displacement_max": ("displacement uₘₐₓ", "displacement"),
    "indentation": ("indentation d", "displacement"),
    "rms_slope": ("RMS slope s", "slope"),
    "contact_edge": ("contact (shaded), its edges r", "length"),
    "ring_force": ("force Fₙ", "force"),
    "normal_force": ("force Fₙ", "force"),
    "ring_worn_volume": ("worn volume V", "volume"),
    "von_mises": ("von Mises stress σ", "pressure"),
}
"""Name with symbol, and kind of unit, of each quantity that is drawn."""
# range of numbers, in their unit, that are drawn without an additional power of ten
SMALLEST, LARGEST = 1e-2, 1e4
# ratio of heights above which panels have different scales
FAR_APART = 10.0
# ratio of the height of the whole face to that of its worn part above which the rest is cut off
CUT_BEYOND = 3.0


class Scale:
    """The axes of a scene's figures.

    Attributes
    ----------
    axes : dict of (float, str)
        By the kind of quantity: its unit in figures, expressed in the units of the scene, and the
        name of this unit. It suits typical numbers of the scene, or the drawn values (`suit`).
    looks : dict of Look
        Look of the curve of each method.
    logarithmic : bool
        Whether the time axis is logarithmic, and begins at the first time after the start.
    many_rings : bool
        Whether there are so many rings that curves are thin and without marks, in wider panels.
    """

    def __init__(self, scene: Scene, looks: Mapping[str, Look] | None = None) -> None:
        self.names, self.problem = scene.unit_names, scene.problem
        self.looks = looks or looks_of(scene.methods)
        units, times = self.problem.units, [time for time in scene.wear.times if time] or [0.0]
        # the face may be higher than the indentation; the factor 100 below is for volumes, whose
        # units differ by large factors
        highest = max(self.problem.profile(self.problem.radii).max(), 1.0)
        slid = max(self.problem.distances, default=0.0) or 1.0
        sizes = {
            "length": units.length,
            "time": times[-1],
            "displacement": D0 * units.displacement,
            "height": D0 * units.displacement * highest,
            "pressure": P0 * units.pressure,
            "slope": units.slope,
            "force": units.force,
            "volume": 100 * slid * units.volume,
        }
        self.axes = {kind: self.unit(size, kind) for kind, size in sizes.items()}
        self.axes["time"] = short_numbers(times[-1], *self.names.unit_of_times(times))
        # under varying loads, late times are as interesting as early ones
        self.logarithmic = times[-1] > 30 * times[0] and not self.problem.loading.varies
        self.many_rings = len(self.problem.wear_coefficients) > 24

    @classmethod
    def of(cls, result: Result) -> "Scale":
        """Return the axes of a result, with a look for each of its methods."""
        return cls(result.scene, looks_of(result.coordinates["solver"], result.of_others))

    def suit(self, name: str, values: Any) -> None:
        """Choose the unit of a quantity by the greatest of its drawn values."""
        sizes = np.abs(values)[np.isfinite(values)]
        if sizes.max(initial=0.0) > 0:
            kind = LABELS[name][1]
            self.axes[kind] = self.unit(float(sizes.max()), kind)

    def look(self, method: str, points: int = 0) -> Look:
        """Return the look of the curve of a method."""
        return method_curve(method, points, self.looks[method])

    def unit(self, size: float, kind: str) -> tuple[float, str]:
        """Return the unit for numbers of this size in figures, and its name."""
        kind = "displacement" if kind == "height" else kind
        return short_numbers(size, *self.names.readable(size, kind))

    def shown(self, name: str, values: Any) -> Any:
        """Convert values of a quantity from the units of the scene to those of its axis."""
        return values / self.axes[LABELS[name][1]][0]

    def label(self, name: str) -> str:
        """Return the label of an axis, such as ``pressure p (MPa)``."""
        quantity, kind = LABELS[name]
        if name == "time" and self.names.distances:
            quantity = "sliding distance t"
        _, unit = self.axes[kind]
        return f"{quantity} ({unit})" if unit else quantity

    def plot(
        self, axes: Axes, name: str, abscissa: str, places: Array, heights: Array, **look: Any
    ) -> None:
        """Draw a quantity over the `radius`, broken where pressures jump, or over `time`."""
        if abscissa == "time" and self.logarithmic:
            set_logarithmic(axes, "x")
            places, heights = places[places > 0], heights[places > 0]
        elif abscissa == "time":
            set_linear(axes, "x")
        if "pressure" in name:
            edges = self.problem.merged.ring_edges * self.problem.units.length
            places, heights = broken_at(edges, places, heights)
        axes.plot(self.shown(abscissa, places), self.shown(name, heights), **look)
        axes.set(xlabel=self.label(abscissa), ylabel=self.label(name))

    def plot_radial(self, axes: Axes, name: str, radii: Array, values: dict[str, Array]) -> None:
        """Draw a quantity over the radius by every method that computes it, and shade the rings."""
        for method, curve in values.items():
            finite = ~np.isnan(curve)
            look = self.look(method, int(finite.sum()))
            if self.many_rings:
                look |= {"marker": "", "linewidth": 0.5 * look["linewidth"]}
            self.plot(axes, name, "radius", radii[finite], curve[finite], **look)
        radius = self.shown("radius", self.problem.units.length)
        shade_rings(axes, self.problem.ring_edges, self.problem.wear_coefficients, radius)

    def first_radius(self, last: float) -> float:
        """Return the start of an axis of the radius that ends at `last`, in units of the scene."""
        hole = float(self.problem.ring_edges[0]) * self.problem.units.length
        return float(self.shown("radius", axis_start(hole, last)))

    def when(self, time: float) -> str:
        """Return a time as text, preferably in the unit of the axis.

        If the axis is in hours, 3 days are 72 h, and 710 min are 11.8 h, but 6 min remain.
        """
        unit, name = self.axes["time"]
        number = float(f"{time / unit:.3g}")
        if (number.is_integer() and 2 <= number <= 1000) or 10 <= number <= 1000:
            return f"t = {number:g} {name}".rstrip()
        return f"t = {self.names.write(time, 'time', 3)}"

    def where(self, radius: float) -> str:
        """Return a radius as text, in the unit of the axis."""
        _, unit = self.axes["length"]
        return f"r = {self.shown('radius', radius):.4g} {unit}".rstrip()

    def height(self, value: float) -> str:
        """Return a height of the face as text."""
        unit, name = self.names.readable(value, "displacement")
        return f"{short_number(float(f'{value / unit:.2g}'))} {name}".rstrip()

    @property
    def steady_state(self) -> str:
        """Words for the steady state, with its force (the last one) if the force varies."""
        loading = self.problem.loading
        if not np.ptp(loading.forces):
            return "steady state"
        last = float(loading.forces[-1]) * self.problem.units.force
        return f"steady state at F = {self.names.write(last, 'force', 3)}"


def short_numbers(size: float, unit: float, name: str) -> tuple[float, str]:
    """Return a unit and its name, times a power of ten if numbers are very small or large in it."""
    if not np.isfinite(size) or size <= 0 or SMALLEST <= size / unit < LARGEST:
        return unit, name
    power = float(10.0 ** np.floor(np.log10(size / unit)))
    return power * unit, f"{power_of_ten(power)} {name}".rstrip()


def subtracted_height(problem: Problem, profiles: Array) -> Array:
    """Return the height (...,) that is subtracted from faces to draw them, in the scene's units.

    It is the least worn height or, if all of a face is worn below the deepest recess of the unworn
    face, its least height. Otherwise this recess would take most of the panel.

    Parameters
    ----------
    profiles : (..., R) heights of the faces at the radii of the output, in the scene's units
    """
    unworn = problem.profile(problem.radii) * problem.units.displacement
    least_heights, least_worn = np.nanmin(profiles, axis=-1), np.nanmin(profiles - unworn, axis=-1)
    return np.where(least_heights > unworn.max(), least_heights, least_worn)


def face_depths(heights: Array, unworn: Array, touching: NDArray[np.bool_]) -> Array:
    """Return the height (S,) down to which each face is drawn, in the units of the heights.

    It is the greatest height of the face, unless this is more than `CUT_BEYOND` times that of the
    parts in contact or worn, which would then be hard to see. In that case it is the greatest
    height of these parts. For a face without such heights, that of the other faces counts.

    Parameters
    ----------
    heights : (S, R) heights of the faces
    unworn : (S, R) heights of the unworn face
    touching : (S, R) whether the face is in contact
    """
    worn_heights = heights - unworn
    used = touching | (worn_heights > 0.1 * np.ptp(worn_heights, axis=1, keepdims=True))
    deepest = np.nanmax(heights, axis=1)
    needed = np.nanmax(np.where(used, heights, 0.0), axis=1, initial=0.0)
    needed[needed <= 1e-6 * deepest] = needed.max()
    return np.where((needed > 0) & (CUT_BEYOND * needed < deepest), needed, deepest)


def high_pressure(pressure: Array) -> float:
    """Return the 90 % quantile of the finite pressures (R,) in contact."""
    return float(np.quantile([0.0, *pressure[(pressure > 0) & np.isfinite(pressure)]], 0.9))


def panel_tops(heights: Sequence[float] | Array) -> Array:
    """Return the height to which each panel is scaled.

    It is the greatest height, unless heights differ by more than a factor `FAR_APART`; then each
    panel is scaled to its own height.
    """
    tops = np.where(np.array(heights) > 0, heights, max(heights) or 1.0)
    return np.where(tops.max() > FAR_APART * tops.min(), tops, tops.max())


def shown_times(times: Array, most: int) -> Indices:
    """Choose up to `most` of the times, with the first and the last; return their indices.

    The start is left out if `most` is three or less.
    """
    candidates = np.flatnonzero((times > 0) | (most > 3) | ~times.any())
    positions = (
        np.linspace(0, len(candidates) - 1, min(len(candidates), most)).round().astype(np.int64)
    )
    return candidates[np.unique(positions)]
