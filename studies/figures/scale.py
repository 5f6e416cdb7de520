"""What the axes of a scene's figures are in.

SI units with their prefixes, or over a, d0 and p0 as in the paper.

``d0 = F/(2 a E*)`` is the indentation of the unworn punch and ``p0 = F/(2 pi a^2)`` its least
pressure; a figure that uses them says so.
"""

from dataclasses import dataclass

import numpy as np

from ..problem.problem import D0, P0
from ..problem.scene import Scene
from ..problem.unit_names import UnitNames


@dataclass(frozen=True)
class Axis:
    """Non-dimensional values times `factor` are shown; `unit` is their unit, or what they
    are over.
    """

    factor: float
    unit: str
    over: bool

    def label(self, what: str, symbol: str) -> str:
        """The label of an axis, as ``pressure $p$ (MPa)`` or ``pressure $p/p_0$``."""
        if self.over:
            return f"{what} ${symbol}/{self.unit}$"
        return f"{what} ${symbol}$ ({self.unit})" if self.unit else f"{what} ${symbol}$"


class Scale:
    """The axes of a scene: its radii, heights, pressures, slopes and times."""

    def __init__(self, scene: Scene) -> None:
        self.names, self.units = UnitNames.of(scene.units), scene.problem.units
        self._worn = self.names.readable(D0 * self.units.displacement, "displacement")
        self.radius = self._axis(
            "length", 1.0, "a", self.names.readable(self.units.length, "length")
        )
        self.height = self._axis("displacement", D0, "d_0", self._worn)
        self.pressure = self._axis(
            "pressure", P0, "p_0", self.names.readable(2 * P0 * self.units.pressure, "pressure")
        )
        self.slope = Axis(self.units.slope, "", False) if self.names.si else Axis(1 / D0, "", False)
        later = [time for time in scene.wear.times if time] or [0.0]
        unit, name = self.names.readable(float(np.sqrt(later[0] * later[-1])), "time")
        self.time = Axis(self.units.time / unit, name, False)

    def _axis(self, kind: str, over: float, symbol: str, readable: tuple[float, str]) -> Axis:
        if not self.names.si:
            return Axis(1 / over, symbol, True)
        unit, name = readable
        return Axis(getattr(self.units, kind) / unit, name, False)

    def when(self, time: float) -> str:
        """A time in the scene's numbers, for people."""
        return f"t = {self.names.write(time, 'time', 3)}"

    def worn(self, height: float) -> str:
        """A non-dimensional height, for people."""
        if self.names.si:
            return self.names.write(height * self.units.displacement, "displacement", 2)
        return f"{height / D0:.2g} d₀"

    @property
    def slope_label(self) -> str:
        return "RMS slope" if self.names.si else "RMS slope times $a/d_0$"

    @property
    def note(self) -> str:
        """What the axes are over."""
        if self.names.si:
            return ""
        d0 = self.names.write(D0 * self.units.displacement, "displacement", 3)
        p0 = self.names.write(P0 * self.units.pressure, "pressure", 3)
        radius = self.names.write(self.units.length, "length", 3)
        return f"a = {radius}, d₀ = F/(2aE*) = {d0}, p₀ = F/(2πa²) = {p0}"
