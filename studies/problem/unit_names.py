"""Names of the units of a scene's numbers, and those that people read best.

SI prefixes where the scene says SI.

A scene may state its units as ``SI``, or as those of length, force, pressure and time: ``mm, N,
MPa, s``. Any other text is repeated as it stands.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

YEAR = 365.25 * 86400.0
# kinds of quantities: sizes in SI units, ascending, with their names
SI: dict[str, tuple[tuple[float, str], ...]] = {
    "length": ((1e-9, "nm"), (1e-6, "µm"), (1e-3, "mm"), (1.0, "m")),
    "force": ((1e-6, "µN"), (1e-3, "mN"), (1.0, "N"), (1e3, "kN"), (1e6, "MN")),
    "pressure": ((1.0, "Pa"), (1e3, "kPa"), (1e6, "MPa"), (1e9, "GPa")),
    "time": (
        (1e-6, "µs"),
        (1e-3, "ms"),
        (1.0, "s"),
        (60.0, "min"),
        (3600.0, "h"),
        (86400.0, "days"),
        (YEAR, "years"),
    ),
    "wear_rate": (
        (1e-9 / YEAR, "nm/year"),
        (1e-6 / YEAR, "µm/year"),
        (1e-9 / 3600, "nm/h"),
        (1e-6 / 3600, "µm/h"),
        (1e-3 / 3600, "mm/h"),
        (1e-3, "mm/s"),
        (1.0, "m/s"),
    ),
    "volume": ((1e-18, "µm³"), (1e-9, "mm³"), (1e-6, "cm³"), (1.0, "m³")),
}
BASE = ("m", "N", "Pa", "s")
UNSTATED = "the scene's own consistent units"
# kinds of scene keys that have a unit
KINDS = {
    "punch.radius": "length",
    "punch.ring_edges": "length",
    "output.radii": "length",
    "punch.wear_coefficient": "wear_coefficient",
    "punch.wear_coefficients": "wear_coefficient",
    "half_space.plane_strain_modulus": "pressure",
    "half_space.youngs_modulus": "pressure",
    "load.normal_force": "force",
    "load.mean_pressure": "pressure",
    "load.sliding_speed": "wear_rate",
    "wear.times": "time",
    "wear.step": "time",
    "accuracy.mdr.step": "time",
    "output.field_times": "time",
}


@dataclass(frozen=True)
class UnitNames:
    """What the numbers of a scene are in.

    Parameters
    ----------
    stated : by the scene
    base : units of length, force, pressure and time; None if the scene does not name them one by
        one
    """

    stated: str
    base: tuple[str, str, str, str] | None = None

    @classmethod
    def of(cls, stated: str) -> Self:
        """The names that a scene's `units` stand for."""
        if stated.strip().upper().startswith("SI"):
            return cls(stated, BASE)
        parts = [part.strip() for part in stated.split(",")]
        if len(parts) == 4 and all(parts):
            length, force, pressure, time = parts
            return cls(stated, (length, force, pressure, time))
        return cls(stated)

    @property
    def si(self) -> bool:
        return self.base == BASE

    def name(self, kind: str) -> str:
        """The unit of a kind of quantity, as the numbers are stored; empty if nobody has
        named it.
        """
        if kind in ("slope", "share", "number"):
            return "1"
        if self.base is None:
            return ""
        length, force, pressure, time = self.base
        return {
            "length": length,
            "displacement": length,
            "force": force,
            "pressure": pressure,
            "time": time,
            "wear_rate": f"{length}/{time}",
            "volume": f"{length}^3",
            "wear_coefficient": f"1/{pressure}",
        }[kind]

    def readable(self, size: float, kind: str) -> tuple[float, str]:
        """A unit that numbers of this size are best read in.

        How much of the stored unit it is, and its name.
        """
        choices = SI.get({"displacement": "length"}.get(kind, kind))
        if not (self.si and choices) or not (np.isfinite(size) and size):
            name = self.name(kind)
            return 1.0, "" if name == "1" else name.replace("^3", "³")
        # so much smaller than the smallest that a power of ten is plainer
        if abs(size) < 1e-3 * choices[0][0]:
            return 1.0, self.name(kind)
        return next(
            (choice for choice in reversed(choices) if abs(size) >= 0.9995 * choice[0]), choices[0]
        )

    def write(self, value: float, kind: str, digits: int = 4) -> str:
        """A value with its unit, for people."""
        if not np.isfinite(value):
            return "infinite" if np.isinf(value) else "not computed"
        unit, name = self.readable(value, kind)
        number = f"{value / unit:.{digits}g}"
        # 190, not 1.9e+02
        if 1 <= abs(value / unit) < 1e4:
            number = f"{float(number):g}"
        return f"{number} {name}".rstrip()
