"""What can be computed.

Each quantity with its dimensions, unit, definition, and the norm in which two values are compared
(`studies/sampling/norms.py`).
"""

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

# the finest accuracy that can be asked for
FINEST = 1e-9
ERROR = "relative error of {}, the method's own estimate: {}"
# relaxation times that are promised and compared: the slowest, which last
COMPARED_MODES = 8
# quantities that converge twice as fast as fields do
ENERGIES = (
    "indentation",
    "relaxation_time",
    "ring_force",
    "normal_force",
    "indentation_start",
    "running_in_time",
    "time_to_90",
    "time_to_99",
    "time_to_half_force",
    "force_start",
    "force_end",
)
# quantities of a flat punch that are felt in the thin layers that wear makes beside ring edges
IN_LAYERS = ("rms_slope", "pressure")


@dataclass(frozen=True)
class Units:
    """Sizes of the non-dimensional units in the scene's own."""

    length: float = 1.0
    modulus: float = 1.0
    force: float = 1.0
    time: float = 1.0
    wear_coefficient: float = 1.0
    # of what has none
    share: float = 1.0
    number: float = 1.0

    @property
    def pressure(self) -> float:
        """F / a^2."""
        return self.force / self.length / self.length

    @property
    def displacement(self) -> float:
        """Of displacement and of worn height, F / (a E*)."""
        return self.force / self.length / self.modulus

    @property
    def volume(self) -> float:
        """Of worn volume, a^2 times that of heights."""
        return self.displacement * self.length**2

    @property
    def slope(self) -> float:
        """The unit of slopes df/dr, F / (a^2 E*)."""
        return self.displacement / self.length

    @property
    def wear_rate(self) -> float:
        """Of df/dt."""
        return self.displacement / self.time


class Quantity(NamedTuple):
    """Dimensions, unit (of `Units`), definition, norm of its error, whether every run has it."""

    dims: tuple[str, ...]
    unit: str
    definition: str
    norm: str = "value"
    always: bool = True

    @property
    def error_dims(self) -> tuple[str, ...]:
        """Dimensions of its error: norms are taken over radius and rings."""
        return tuple(dim for dim in self.dims if dim not in ("radius", "ring"))


NORMS = {
    "value": "difference over the value",
    "each": "greatest of all rings, each difference over its own value",
    "share": "greatest difference of all rings, all of which together have 1",
    "first force": "difference over the force of a flat punch that is pressed in as deep",
    "indentation": (
        "greatest difference over the punch, over the indentation d(t) beyond the first touch, the "
        "greatest so far"
    ),
    "slope": "difference over the value, or over d/(1000 a) where that is more",
    "steady": "greatest difference over the punch, over the greatest steady displacement",
    "force": "greatest difference of all rings, over the normal force, the greatest so far",
    "volume": "greatest difference of all rings, over that of all rings together",
    "radius": "difference over the radius of the punch",
    "pressure": "root of int k dp^2 dA over the root of int k p^2 dA; at t = 0, where p is not "
    "square integrable, of weight "
    "k (1 - r^2/a^2), times 1 - b/r with a hole of radius b",
}
# given where contact opens, closes or spreads only
OF_PROFILES = ("normal_force", "ring_worn_volume", "contact_radius", "contact", "contact_edge")
QUANTITIES = {
    "pressure": Quantity(
        ("time", "radius"), "pressure", "contact pressure p(r, t), never below zero", "pressure"
    ),
    "profile": Quantity(
        ("time", "radius"),
        "displacement",
        "worn height f(r, t) of the punch, material gone",
        "indentation",
    ),
    "displacement": Quantity(
        ("time", "radius"),
        "displacement",
        "displacement u_z = d - f of the half-space under the punch",
        "indentation",
    ),
    "indentation": Quantity(
        ("time",),
        "displacement",
        "indentation d(t) of the unworn face plane of the punch",
        "indentation",
    ),
    "displacement_centre": Quantity(
        ("time",),
        "displacement",
        "u_z at the centre, or at the inner edge of a hollow punch",
        "indentation",
    ),
    "displacement_max": Quantity(
        ("time",), "displacement", "greatest u_z under the punch", "indentation"
    ),
    "rms_slope": Quantity(
        ("time",),
        "slope",
        "root mean square of df/dr (Eq. 18), average: see gradient_average",
        "slope",
    ),
    "ring_force": Quantity(
        ("time", "ring"), "force", "normal force on each ring, from the centre", "force"
    ),
    "relaxation_time": Quantity(
        ("mode",), "time", "relaxation times of the wear modes, slowest first"
    ),
    "normal_force": Quantity(("time",), "force", "normal force on the punch", "force"),
    "ring_worn_volume": Quantity(
        ("time", "ring"), "volume", "volume worn off each ring, from the centre", "volume"
    ),
    "contact_radius": Quantity(("time",), "length", "outermost radius of contact", "radius"),
    "contact": Quantity(("time", "radius"), "number", "1 in contact, 0 outside"),
    "contact_edge": Quantity(
        ("time", "edge"), "length", "inner and outer radius of each part of the contact in turn"
    ),
    "steady_pressure": Quantity(
        ("radius",), "pressure", "contact pressure in the steady state (Eq. 24)", "pressure"
    ),
    "steady_profile": Quantity(
        ("radius",), "displacement", "limiting profile, its minimum at zero (Eq. 27)", "steady"
    ),
    "steady_displacement_max": Quantity(
        (), "displacement", "greatest u_z in the steady state, u_max of Eq. 27"
    ),
    "steady_rms_slope": Quantity(
        (), "slope", "root mean square slope of the limiting profile (Eq. 18)"
    ),
    "steady_wear_rate": Quantity(
        (), "wear_rate", "height lost in a time, the same on every ring (Eq. 23)"
    ),
}

# of the march of a contact that opens, closes and spreads, at its start and after each of its steps
STEPS = {
    "step_time": Quantity(("step",), "time", "time of each step of the march, the start first"),
    "step_indentation": Quantity(("step",), "displacement", "indentation at each step"),
    "step_normal_force": Quantity(("step",), "force", "normal force at each step"),
    "step_contact_area": Quantity(
        ("step",), "number", "area of contact at each step, over that of the face"
    ),
}
# the answer of a run (`studies/sampling/answers.py`)
STATES = ("start", "steady")
ANSWER = {
    "indentation_start": Quantity(
        (),
        "displacement",
        "indentation of the unworn face at the start; F / (2 a E*) if flat and full",
    ),
    "indentation_steady": Quantity(
        (),
        "displacement",
        "depth of the foremost point of the worn punch, u_max of Eq. 27",
    ),
    "running_in_time": Quantity(
        (),
        "time",
        "slowest relaxation time, in which what is left of running-in falls to 1/e",
    ),
    "time_to_90": Quantity(
        (),
        "time",
        "time at which 90 % of the running-in is complete, by d(t) minus steady wear",
    ),
    "time_to_99": Quantity((), "time", "the same for 99 %: the running-in is over"),
    "pressure_min": Quantity(
        ("state", "ring"), "pressure", "least contact pressure on each ring", "each"
    ),
    "pressure_max": Quantity(
        ("state", "ring"),
        "pressure",
        "greatest contact pressure on each ring; infinite at the edges of a flat punch",
        "each",
    ),
    "force_share": Quantity(
        ("state", "ring"), "share", "part of the normal force that each ring carries", "share"
    ),
    "worn_volume": Quantity(
        ("ring",), "volume", "volume worn off each ring by the last of the times", "volume"
    ),
    "force_start": Quantity(
        (), "force", "normal force at the start, of a given indentation", always=False
    ),
    "force_end": Quantity(
        (), "force", "the same at the last of the times", "first force", always=False
    ),
    "time_to_half_force": Quantity(
        (), "time", "time at which that force has fallen to half of the first", always=False
    ),
    "contact_radius_start": Quantity(
        (), "length", "outermost radius of contact at the start", always=False
    ),
    "pressure_peak_start": Quantity(
        (), "pressure", "greatest contact pressure at the start, if finite", always=False
    ),
    "time_to_full_contact": Quantity(
        (), "time", "time from which all of the face carries, to a step", always=False
    ),
}


# everything that is computed, compared and has an error estimate
DESCRIBED = QUANTITIES | ANSWER


HISTORIES = frozenset(name for name, quantity in QUANTITIES.items() if "time" in quantity.dims)
FIELDS = frozenset(name for name, quantity in QUANTITIES.items() if "radius" in quantity.dims)
STEADY = frozenset(name for name in QUANTITIES if name.startswith("steady_"))
# what can be asked for by one word
GROUPS = {
    "history": HISTORIES - FIELDS | {"relaxation_time"},
    "fields": HISTORIES & FIELDS,
    "steady": STEADY,
    "all": frozenset(QUANTITIES),
}


def expand(names: Iterable[str]) -> frozenset[str]:
    """Return the quantities that names of quantities and of groups stand for.

    Raises
    ------
    ValueError
        if a name is of neither
    """
    wanted = frozenset[str]()
    for name in names:
        if name not in GROUPS and name not in QUANTITIES:
            near = difflib.get_close_matches(name.lower(), QUANTITIES, 1)
            meant = f": did you mean '{near[0]}'? Else" if near else ";"
            raise ValueError(
                f"no quantity '{name}'{meant} give some of {', '.join(QUANTITIES)}, or the groups "
                f"{', '.join(GROUPS)}"
            )
        wanted |= GROUPS.get(name, {name})
    return wanted


def error_name(name: str) -> str:
    """Name of the variable that holds a quantity's relative error, by the method's own estimate."""
    return f"{name}_error"
