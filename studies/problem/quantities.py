"""What can be computed.

Each quantity with its dimensions, unit, definition, and the norm in which two values are compared
(`studies/methods/norms.py`).
"""

from collections.abc import Iterable
from typing import NamedTuple

# times the accuracy asked for that the uncertainty of two methods may be, each of which is to be
# that accurate
A_FEW = 4.0
# part of the accuracy asked for that energies, and everything else, are not known better than:
# where two computations differ by less, it may be by chance
CHANCE_OF_ENERGIES, CHANCE = 1e-5, 0.01
# the finest accuracy that can be asked for
FINEST = 1e-9
ERROR = "relative error of {}, the method's own estimate: {}"
# relaxation times that are promised and compared: the slowest, which last
COMPARED_MODES = 3
# quantities that converge twice as fast as fields do
ENERGIES = ("indentation", "relaxation_time", "ring_force", "normal_force")


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
    "indentation": (
        "greatest difference over the punch, over the indentation d(t) beyond the first touch, the "
        "greatest so far"
    ),
    "slope": "difference over the value, or over d/(1000 a) where that is more",
    "steady": "greatest difference over the punch, over the greatest steady displacement",
    "force": "greatest difference of all rings, over the normal force",
    "volume": "greatest difference of all rings, over that of all rings together",
    "radius": "difference over the radius of the punch",
    "pressure": "root of int k dp^2 dA over the root of int k p^2 dA; at t = 0, where p is not "
    "square integrable, of weight "
    "k (1 - r^2/a^2)",
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
    "displacement_centre": Quantity(("time",), "displacement", "u_z at the centre", "indentation"),
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
    "normal_force": Quantity(("time",), "force", "normal force on the punch"),
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
# the answer of a run (`studies/crosscheck/answer.py`), without errors of its own
STATES = ("start", "steady")
ANSWER = {
    "indentation_start": Quantity(
        (),
        "displacement",
        "indentation of the unworn face plane at the start; of a flat punch F / (2 a E*)",
    ),
    "indentation_steady": Quantity(
        (),
        "displacement",
        "depth of the foremost point of the worn punch in the half-space, u_max of Eq. 27; at the "
        "start it is the indentation",
    ),
    "running_in_time": Quantity(
        (),
        "time",
        "slowest relaxation time of the full face, in which what is left of running-in falls to "
        "1/e: to compare punches by; to plan a test take time_to_99",
    ),
    "time_to_90": Quantity(
        (),
        "time",
        "90 % of running-in are over: of the way of the approach d(t), less steady wear, to its "
        "steady value, from the start or where it is farthest from it",
    ),
    "time_to_99": Quantity((), "time", "as time_to_90, for 99 %: running-in is over"),
    "pressure_min": Quantity(("state", "ring"), "pressure", "least contact pressure on each ring"),
    "pressure_max": Quantity(
        ("state", "ring"),
        "pressure",
        "greatest contact pressure on each ring; infinite at a flat punch's rim",
    ),
    "force_share": Quantity(
        ("state", "ring"), "share", "part of the normal force that each ring carries"
    ),
    "worn_volume": Quantity(
        ("ring",), "volume", "volume worn off each ring by the last of the times"
    ),
    "force_start": Quantity(
        (), "force", "normal force at the start, of a given indentation", always=False
    ),
    "force_end": Quantity((), "force", "the same at the last of the times", always=False),
    "time_to_half_force": Quantity(
        (), "time", "time by which that force has fallen to half of the first", always=False
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
            raise ValueError(
                f"no quantity '{name}'; give some of {', '.join(QUANTITIES)}, or the groups "
                f"{', '.join(GROUPS)}"
            )
        wanted |= GROUPS.get(name, {name})
    return wanted


def error_name(name: str) -> str:
    """Name of the variable that holds a quantity's relative error, by the method's own estimate."""
    return f"{name}_error"
