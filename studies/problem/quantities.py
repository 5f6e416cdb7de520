"""Define all quantities that can be computed.

Each has dimensions, a unit, a definition, and the norm in which two of its values are compared
(`studies/sampling/norms.py`).
"""

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

# smallest relative accuracy that can be requested
FINEST_RTOL = 1e-9
# description of the error of a quantity, with its name and its norm
ERROR = "relative error of {}, the method's own estimate: {}"
# smallest scale of RMS slopes, over the indentation over the punch radius
LEAST_SLOPE = 1e-3
# number of relaxation times, from the slowest on, that are accurate to rtol and compared
COMPARED_MODES = 8
# quantities that converge with twice the order of fields
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
# quantities of a flat punch that depend on the thin layers near ring edges, in which wear has
# smoothed the pressure
LAYER_QUANTITIES = ("rms_slope", "pressure")


@dataclass(frozen=True)
class Units:
    """Sizes of the non-dimensional units in the units of the scene."""

    length: float = 1.0
    modulus: float = 1.0
    force: float = 1.0
    time: float = 1.0
    wear_coefficient: float = 1.0
    # units of quantities without a unit
    share: float = 1.0
    number: float = 1.0

    @property
    def pressure(self) -> float:
        """The unit of pressures, F / a^2."""
        return self.force / self.length / self.length

    @property
    def displacement(self) -> float:
        """The unit of displacements and worn heights, F / (a E*)."""
        return self.force / self.length / self.modulus

    @property
    def volume(self) -> float:
        """The unit of worn volumes, a^2 times that of heights."""
        return self.displacement * self.length**2

    @property
    def slope(self) -> float:
        """The unit of slopes df/dr, F / (a^2 E*)."""
        return self.displacement / self.length

    @property
    def wear_rate(self) -> float:
        """The unit of wear rates df/dt, that of heights over that of time."""
        return self.displacement / self.time


class Quantity(NamedTuple):
    """A quantity.

    Parameters
    ----------
    dims : tuple of str
        Names of its dimensions.
    unit : str
        Name of its unit, an attribute of `Units`.
    definition : str
        Definition for users.
    norm : str
        Norm of its error, a key of `NORMS`.
    always : bool
        Whether results contain it for every scene.
    """

    dims: tuple[str, ...]
    unit: str
    definition: str
    norm: str = "value"
    always: bool = True

    @property
    def error_dims(self) -> tuple[str, ...]:
        """The dimensions of its error: those except radius and ring, over which norms are taken."""
        return tuple(dim for dim in self.dims if dim not in ("radius", "ring"))


NORMS = {
    "value": "difference, relative to the value",
    "each": "greatest difference of all rings, each relative to its own value",
    "share": "greatest difference of all rings; the shares of all rings sum to 1",
    "first force": "difference, relative to the force on a flat punch at the same indentation",
    "depth": (
        "greatest difference on the face, relative to the greatest depth so far: the indentation "
        "d(t) from the first touch, less the depth by which the whole face has worn evenly; a "
        "difference in that even wear is relative to d(t)"
    ),
    "slope": (
        "difference, relative to the value or to 1/1000 of the greatest depth so far over a, "
        "whichever is greater; the depth is d(t) from the first touch, less the even wear"
    ),
    "steady": "greatest difference on the face, relative to the greatest steady displacement",
    "force": "greatest difference of all rings, relative to the greatest normal force so far",
    "volume": "greatest difference of all rings, relative to the worn volume of all rings",
    "radius": "difference, relative to the radius of the punch",
    "pressure": "square root of int k dp^2 dA, relative to that of int k p^2 dA; at t = 0, when p "
    "is not square integrable, with the weight k (1 - r^2/a^2), times 1 - b/r if there is a hole "
    "of radius b",
}
# quantities that exist only if contact may open, close or spread (with exceptions in `LoadRegime`)
MOVING_CONTACT_QUANTITIES = (
    "normal_force",
    "ring_worn_volume",
    "contact_radius",
    "contact",
    "contact_edge",
)
QUANTITIES = {
    "pressure": Quantity(
        ("time", "radius"), "pressure", "contact pressure p(r, t), never below zero", "pressure"
    ),
    "profile": Quantity(
        ("time", "radius"),
        "displacement",
        "worn height f(r, t) of the punch: material removed",
        "depth",
    ),
    "displacement": Quantity(
        ("time", "radius"),
        "displacement",
        "displacement u_z = d - f of the half-space under the punch",
        "depth",
    ),
    "indentation": Quantity(
        ("time",),
        "displacement",
        "indentation d(t) of the unworn face plane of the punch",
        "depth",
    ),
    "displacement_centre": Quantity(
        ("time",),
        "displacement",
        "u_z at the centre, or at the inner edge of a hollow punch",
        "depth",
    ),
    "displacement_max": Quantity(
        ("time",), "displacement", "greatest u_z under the punch", "depth"
    ),
    "rms_slope": Quantity(
        ("time",),
        "slope",
        "root mean square of df/dr (Eq. 18); gradient_average selects the average",
        "slope",
    ),
    "ring_force": Quantity(
        ("time", "ring"), "force", "normal force on each ring, counted from the centre", "force"
    ),
    "relaxation_time": Quantity(
        ("mode",), "time", "relaxation times of the wear modes, slowest first"
    ),
    "normal_force": Quantity(("time",), "force", "normal force on the punch", "force"),
    "ring_worn_volume": Quantity(
        ("time", "ring"), "volume", "worn volume of each ring, counted from the centre", "volume"
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
        (), "wear_rate", "rate at which height is lost, the same on every ring (Eq. 23)"
    ),
}

# values at the start and after each step of a march in which contact opens, closes and spreads
STEPS = {
    "step_time": Quantity(("step",), "time", "time of each step of the march, the start first"),
    "step_indentation": Quantity(("step",), "displacement", "indentation at each step"),
    "step_normal_force": Quantity(("step",), "force", "normal force at each step"),
    "step_contact_area": Quantity(
        ("step",), "number", "contact area at each step, relative to the area of the face"
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
        "slowest relaxation time of the full face: once all of it is in contact, the rest of the "
        "running-in falls to 1/e in this time",
    ),
    "time_to_90": Quantity(
        (),
        "time",
        "time at which 90 % of the running-in is complete, by d(t) minus steady wear",
    ),
    "time_to_99": Quantity(
        (),
        "time",
        "time at which 99 % of the running-in is complete, by d(t) minus steady wear",
    ),
    "pressure_min": Quantity(
        ("state", "ring"), "pressure", "least contact pressure on each ring", "each"
    ),
    "pressure_max": Quantity(
        ("state", "ring"),
        "pressure",
        "greatest contact pressure on each ring; infinite at the edges of an unworn flat punch",
        "each",
    ),
    "force_share": Quantity(
        ("state", "ring"), "share", "fraction of the normal force on each ring", "share"
    ),
    "worn_volume": Quantity(
        ("ring",), "volume", "worn volume of each ring at the last of the times", "volume"
    ),
    "force_start": Quantity(
        (), "force", "normal force at the start, if the indentation is given", always=False
    ),
    "force_end": Quantity(
        (),
        "force",
        "normal force at the last of the times, if the indentation is given",
        "first force",
        always=False,
    ),
    "time_to_half_force": Quantity(
        (),
        "time",
        "time at which the normal force has fallen to half of that at the start",
        always=False,
    ),
    "contact_radius_start": Quantity(
        (), "length", "outermost radius of contact at the start", always=False
    ),
    "pressure_peak_start": Quantity(
        (), "pressure", "greatest contact pressure at the start, if finite", always=False
    ),
    "time_to_full_contact": Quantity(
        (),
        "time",
        "time from which all of the face is in contact, to within a step",
        always=False,
    ),
}


# all quantities that are computed and compared, and that have an error estimate
DESCRIBED = QUANTITIES | ANSWER


HISTORIES = frozenset(name for name, quantity in QUANTITIES.items() if "time" in quantity.dims)
FIELDS = frozenset(name for name, quantity in QUANTITIES.items() if "radius" in quantity.dims)
STEADY = frozenset(name for name in QUANTITIES if name.startswith("steady_"))
# groups of quantities that can be requested by one name
GROUPS = {
    "history": HISTORIES - FIELDS | {"relaxation_time"},
    "fields": HISTORIES & FIELDS,
    "steady": STEADY,
    "all": frozenset(QUANTITIES),
}


def expand(names: Iterable[str]) -> frozenset[str]:
    """Return the quantities for names of quantities and of groups.

    Raises
    ------
    ValueError
        if a name is neither a quantity nor a group
    """
    expanded = frozenset[str]()
    for name in names:
        if name not in GROUPS and name not in QUANTITIES:
            matches = difflib.get_close_matches(name.lower(), QUANTITIES, 1)
            meant = f": did you mean '{matches[0]}'? Else" if matches else ";"
            raise ValueError(
                f"no quantity '{name}'{meant} give some of {', '.join(QUANTITIES)}, or the groups "
                f"{', '.join(GROUPS)}"
            )
        expanded |= GROUPS.get(name, {name})
    return expanded


def error_name(name: str) -> str:
    """Name the variable that holds the error estimate of a quantity."""
    return f"{name}_error"
