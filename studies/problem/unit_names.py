"""Names of the units of a scene's numbers, and those that people read best.

SI prefixes where the scene says SI.

A scene may state its units as ``SI``, or as those of length, force, pressure and time: ``mm, N,
MPa, s``. Any other text is repeated as it stands.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

YEAR = 365.25 * 86400.0
# units that people read a kind of quantity in, with their sizes in SI units, ascending
SI: dict[str, dict[str, float]] = {
    "length": {"nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "m": 1.0},
    "force": {"µN": 1e-6, "mN": 1e-3, "N": 1.0, "kN": 1e3, "MN": 1e6},
    "pressure": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    "time": {
        "µs": 1e-6,
        "ms": 1e-3,
        "s": 1.0,
        "min": 60.0,
        "h": 3600.0,
        "days": 86400.0,
        "years": YEAR,
    },
    "wear_rate": {
        "nm/year": 1e-9 / YEAR,
        "µm/year": 1e-6 / YEAR,
        "nm/h": 1e-9 / 3600,
        "µm/h": 1e-6 / 3600,
        "mm/h": 1e-3 / 3600,
        "mm/s": 1e-3,
        "m/s": 1.0,
    },
    "volume": {"µm³": 1e-18, "mm³": 1e-9, "cm³": 1e-6, "m³": 1.0},
}
SI["displacement"] = SI["length"]
BASE = ("m", "N", "Pa", "s")
UNSTATED = "the scene's own consistent units"
# kinds of scene keys that have a unit
KINDS = {
    "punch.radius": "length",
    "punch.ring_edges": "length",
    "punch.profile.curvature_radius": "length",
    "punch.profile.flat_radius": "length",
    "punch.profile.coefficient": "length",
    "load.indentation": "length",
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
    base: tuple[str, ...] | None = None

    @classmethod
    def of(cls, stated: str) -> Self:
        """Return the names that a scene's `units` stand for."""
        parts = tuple(part.strip() for part in stated.split(","))
        if stated.strip().upper().startswith("SI"):
            parts = BASE
        return cls(stated, parts if len(parts) == 4 and all(parts) else None)

    @property
    def si(self) -> bool:
        return self.base == BASE

    def name(self, kind: str) -> str:
        """Return the unit that a kind of quantity is stored in; empty if nobody has named it."""
        if kind in ("slope", "share", "number"):
            return "1"
        if self.base is None:
            return ""
        length, force, pressure, time = self.base
        names = {"length": length, "displacement": length, "force": force, "pressure": pressure}
        names |= {"time": time, "wear_rate": f"{length}/{time}", "volume": f"{length}^3"}
        return (names | {"wear_coefficient": f"1/{pressure}"})[kind]

    def readable(self, size: float, kind: str) -> tuple[float, str]:
        """Return a unit that numbers of this size are best read in.

        How much of the stored unit it is, and its name.
        """
        choices = SI.get(kind) if self.si else None
        if choices is None or not np.isfinite(size) or size == 0:
            name = self.name(kind)
            return 1.0, "" if name == "1" else name.replace("^3", "³")
        name, unit = next(iter(choices.items()))
        # so much smaller than the smallest that a power of ten is plainer
        if abs(size) < 1e-3 * unit:
            return 1.0, self.name(kind)
        for larger, its_size in choices.items():
            if abs(size) >= 0.9995 * its_size:
                name, unit = larger, its_size
        return unit, name

    def write(self, value: float, kind: str, digits: int = 4) -> str:
        """Return a value with its unit, for people."""
        if not np.isfinite(value):
            return "infinite" if np.isinf(value) else "not computed"
        unit, name = self.readable(value, kind)
        number = f"{value / unit:.{digits}g}"
        # 190, not 1.9e+02
        if 1 <= abs(value / unit) < 1e4:
            number = f"{float(number):g}"
        return f"{number} {name}".rstrip()
