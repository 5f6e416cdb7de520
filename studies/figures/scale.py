"""What a scene's figures are drawn in, and its quantities over the radius or over time.

Numbers are those of the scene and of `results.nc`. Of a scene in SI units they have prefixes.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ...mdr.flat_punch import D0, P0
from ...meshes.radial import Array, Indices
from ..problem.problem import Problem
from ..problem.unit_names import UnitNames
from ..scene.scene import Scene
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
"""What is drawn: its name with its symbol, and its kind of unit."""
# numbers, in their unit, that are drawn as they are
SHORTEST, LONGEST = 1e-2, 1e4
# ratio of heights from which on panels have scales of their own
FAR_APART = 10.0
# ratio from which on parts of the face that are further back than those that wear are cut off
CUT_BEYOND = 3.0


class Drawn(Protocol):
    """A result, as far as its figures need it: a scene, methods, and other programs among them."""

    @property
    def scene(self) -> Scene:
        """What was asked for."""
        ...

    @property
    def coordinates(self) -> dict[str, Array]:
        """Names of methods, times and radii, by their names in the table."""
        ...

    @property
    def of_others(self) -> tuple[str, ...]:
        """Names of other programs."""
        ...


class Scale:
    """The axes of a scene's figures.

    Attributes
    ----------
    axes : dict of (float, str)
        By the kind of quantity: the unit that it is drawn in, in the units of the scene, and its
        name. It suits a scene's typical numbers, or what is drawn (`suit`).
    looks : dict of Look
        How the curve of each method is drawn.
    logarithmic : bool
        Whether times span so much that they are drawn from the first after the start.
    many_rings : bool
        Whether there are so many rings that panels are wide, and curves thin and without marks.
    """

    def __init__(self, scene: Scene, looks: Mapping[str, Look] | None = None) -> None:
        self.names, self.problem = UnitNames.of(scene.units), scene.problem
        self.looks = looks or looks_of(scene.methods)
        units, times = self.problem.units, [time for time in scene.wear.times if time] or [0.0]
        # a face is higher than it is pressed in, and units of volume are far apart
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
        self.logarithmic = times[-1] > 30 * times[0] and self.problem.load_regime.logarithmic_times
        if self.logarithmic:
            # ticks are powers of ten already
            self.axes["time"] = self.names.readable(float(np.sqrt(times[0] * times[-1])), "time")
        self.many_rings = len(self.problem.wear_coefficients) > 24

    @classmethod
    def of(cls, result: Drawn) -> "Scale":
        """Return the axes of a result, with a look for each of its methods."""
        return cls(result.scene, looks_of(result.coordinates["solver"], result.of_others))

    def suit(self, name: str, values: Any) -> None:
        """Choose the unit of a quantity by the greatest of the values that are drawn of it."""
        sizes = np.abs(values)[np.isfinite(values)]
        if sizes.max(initial=0.0) > 0:
            kind = LABELS[name][1]
            self.axes[kind] = self.unit(float(sizes.max()), kind)

    def look(self, method: str, points: int = 0) -> Look:
        """Return how the curve of a method is drawn."""
        return method_curve(method, points, self.looks[method])

    def unit(self, size: float, kind: str) -> tuple[float, str]:
        """Return the unit that numbers of this size are drawn in, and its name.

        Numbers that are small or large in their unit are drawn in a power of ten of it, so that
        numbers at an axis stay short.
        """
        unit, name = self.names.readable(size, "displacement" if kind == "height" else kind)
        if not np.isfinite(size) or size <= 0 or SHORTEST <= size / unit < LONGEST:
            return unit, name
        power = float(10.0 ** np.floor(np.log10(size / unit)))
        return power * unit, f"{power_of_ten(power)} {name}".rstrip()

    def shown(self, name: str, values: Any) -> Any:
        """Return values of a quantity, in the units of the scene, as they are drawn."""
        return values / self.axes[LABELS[name][1]][0]

    def label(self, name: str) -> str:
        """Return the label of an axis, as ``pressure p (MPa)``."""
        what, kind = LABELS[name]
        _, unit = self.axes[kind]
        return f"{what} ({unit})" if unit else what

    def plot(
        self, axes: Axes, name: str, over: str, places: Array, heights: Array, **look: Any
    ) -> None:
        """Draw a quantity over the `radius`, broken where pressures jump, or over `time`."""
        if over == "time" and self.logarithmic:
            set_logarithmic(axes, "x")
            places, heights = places[places > 0], heights[places > 0]
        elif over == "time":
            set_linear(axes, "x")
        if "pressure" in name:
            edges = self.problem.merged.ring_edges * self.problem.units.length
            places, heights = broken_at(edges, places, heights)
        axes.plot(self.shown(over, places), self.shown(name, heights), **look)
        axes.set(xlabel=self.label(over), ylabel=self.label(name))

    def plot_radial(self, axes: Axes, name: str, radii: Array, values: dict[str, Array]) -> None:
        """Draw a quantity over the radius by every method that gives it, and shade the rings."""
        for method, curve in values.items():
            given = ~np.isnan(curve)
            look = self.look(method, int(given.sum()))
            if self.many_rings:
                look |= {"marker": "", "linewidth": 0.5 * look["linewidth"]}
            self.plot(axes, name, "radius", radii[given], curve[given], **look)
        shade_rings(axes, *self.problem.rings, self.shown("radius", self.problem.units.length))

    def first_radius(self, last: float) -> float:
        """Return where the axis of the radius begins that ends at a radius of the scene."""
        hole = float(self.problem.ring_edges[0]) * self.problem.units.length
        return float(self.shown("radius", axis_start(hole, last)))

    def when(self, time: float) -> str:
        """Return a time, for people."""
        return f"t = {self.names.write(time, 'time', 3)}"

    def height(self, value: float) -> str:
        """Return a height of the face, for people."""
        unit, name = self.names.readable(value, "displacement")
        return f"{short_number(float(f'{value / unit:.2g}'))} {name}".rstrip()

    @property
    def steady_state(self) -> str:
        """What the steady state is called: with its load where loads vary, that of their last."""
        loading = self.problem.loading
        if not np.ptp(loading.forces):
            return "steady state"
        last = float(loading.forces[-1]) * self.problem.units.force
        return f"steady state at F = {self.names.write(last, 'force', 3)}"


def least_wear(problem: Problem, profiles: Array) -> Any:
    """Return the least worn height over the radii of the output, in the scene's units.

    All of the face has worn by at least this height. `profiles` are (..., R) heights of the face at
    these radii, in the scene's units, too.
    """
    unworn = problem.profile(problem.radii) * problem.units.displacement
    return np.nanmin(profiles - unworn, axis=-1)


def face_depths(heights: Array, unworn: Array, touching: NDArray[np.bool_]) -> Array:
    """Return the height down to which each of (S, R) faces is drawn, in the units of the heights.

    It is the greatest height, unless parts of the face are so far behind those that touch or have
    worn that they would hide the wear. Then it is the greatest height of the latter. A face that
    has not worn is drawn as the others.

    Parameters
    ----------
    unworn : (S, R) heights of the unworn face
    touching : (S, R) whether the face touches
    """
    worn = heights - unworn
    used = touching | (worn > 0.1 * np.ptp(worn, axis=1, keepdims=True))
    deepest = np.nanmax(heights, axis=1)
    needed = np.nanmax(np.where(used, heights, 0.0), axis=1, initial=0.0)
    needed[needed <= 1e-6 * deepest] = needed.max()
    return np.where((needed > 0) & (CUT_BEYOND * needed < deepest), needed, deepest)


def high_pressure(pressure: Array) -> float:
    """Return a pressure that a tenth of those (R,) in contact are above: some may be infinite."""
    return float(np.quantile([0.0, *pressure[pressure > 0]], 0.9))


def panel_tops(heights: Sequence[float] | Array) -> Array:
    """Return the height that each panel is scaled to.

    It is the greatest height for all panels, unless heights differ by more than `FAR_APART`; then
    each panel is scaled to its own height.
    """
    tops = np.where(np.array(heights) > 0, heights, max(heights) or 1.0)
    return np.where(tops.max() > FAR_APART * tops.min(), tops, tops.max())


def shown_times(times: Array, most: int) -> Indices:
    """Choose some of the times, first and last among them; of few, none is spent on the start."""
    chosen = np.flatnonzero((times > 0) | (most > 3) | ~times.any())
    places = np.linspace(0, len(chosen) - 1, min(len(chosen), most)).round().astype(np.int64)
    return chosen[np.unique(places)]
