"""What the axes of a scene's figures are in.

SI units with their prefixes, or over a, d0 and p0 as in the paper.

``d0 = F/(2 a E*)`` is the indentation of the unworn punch and ``p0 = F/(2 pi a^2)`` its least
pressure; a figure that uses them says so.
"""

from dataclasses import dataclass

import numpy as np

from ...meshes.radial import Indices
from ..problem.problem import D0, P0, Problem
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames


@dataclass(frozen=True)
class Axis:
    """One axis of a figure.

    Parameters
    ----------
    factor : float
        Non-dimensional values times it are shown.
    stored : float
        Non-dimensional values times it are those of the scene's units.
    unit : str
        Of the values shown, or what they are over.
    """

    factor: float
    stored: float
    unit: str
    over: bool = False

    def label(self, what: str, symbol: str) -> str:
        """Return the label of the axis, as ``pressure $p$ (MPa)`` or ``pressure $p/p_0$``."""
        if self.over:
            return f"{what} ${symbol}/{self.unit}$"
        return f"{what} ${symbol}$ ({self.unit})" if self.unit else f"{what} ${symbol}$"


class Scale:
    """The axes of a scene: its radii, heights, pressures, slopes and times."""

    def __init__(self, scene: Scene) -> None:
        self.names, self.units = UnitNames.of(scene.units), scene.problem.units
        self.radius = self._axis("length", 1.0, "a")
        self.height = self._axis("displacement", D0, "d_0")
        self.pressure = self._axis("pressure", P0, "p_0", typical=2 * P0)
        self.slope = self._axis("slope", D0, "(d_0/a)")
        later = [time for time in scene.wear.times if time] or [0.0]
        unit, name = self.names.readable(float(np.sqrt(later[0] * later[-1])), "time")
        self.time = Axis(self.units.time / unit, self.units.time, name)

    def _axis(self, kind: str, over: float, symbol: str, typical: float = 0.0) -> Axis:
        stored = getattr(self.units, kind)
        if not self.names.si:
            return Axis(1 / over, stored, symbol, over=True)
        unit, name = self.names.readable((typical or over) * stored, kind)
        return Axis(stored / unit, stored, name)

    def when(self, time: float) -> str:
        """Return a time in the scene's numbers, for people."""
        return f"t = {self.names.write(time, 'time', 3)}"

    def worn(self, height: float) -> str:
        """Return a non-dimensional height, for people."""
        if self.names.si:
            return self.names.write(height * self.units.displacement, "displacement", 2)
        return f"{height / D0:.2g} d₀"

    @property
    def note(self) -> str:
        """What the axes are over."""
        if self.names.si:
            return ""
        units, write = self.units, self.names.write
        return (
            f"a = {write(units.length, 'length', 3)}, "
            f"d₀ = F/(2aE*) = {write(D0 * units.displacement, 'displacement', 3)}, "
            f"p₀ = F/(2πa²) = {write(P0 * units.pressure, 'pressure', 3)}"
        )


def shown_times(problem: Problem, most: int) -> Indices:
    """Choose some of the times, first and last among them; of few, none is spent on the start."""
    times = np.arange(len(problem.times))
    if problem.earliest and most < 4:
        times = np.flatnonzero(problem.times > 0)
    places = np.linspace(0, len(times) - 1, min(len(times), most)).round().astype(np.int64)
    return times[np.unique(places)]
