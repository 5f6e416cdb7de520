"""Define all quantities that can be computed, each in one place.

A quantity is declared with its name, its dimensions, its unit, its definition for users, its value,
and the norm in which two values are compared. A function computes the value from what a method
provides, as attributes: the state of the punch at its times
(`methods.sampling.sampler.SampledState`) or in the steady state (`SampledSteadyState`), its
relaxation modes (`wear.full_contact.RunningIn`), its run as a whole
(`methods.sampling.answers.SteadyRun`), or the steps of a march (`result.table.StepsOfMarch`).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .norms import (
    DEPTH,
    EACH,
    FIRST_FORCE,
    FORCE,
    NORMED,
    PRESSURE,
    RADIUS,
    SHARE,
    SLOPE,
    STEADY_DEPTH,
    VALUE,
    VOLUME,
    VOLUME_SO_FAR,
    Array,
    Norm,
    Results,
    Values,
)
from .suggestions import did_you_mean

if TYPE_CHECKING:
    from .face import Face

# smallest relative accuracy that can be requested
FINEST_RTOL = 1e-9
# description of the error of a quantity, with its name and its norm
ERROR = "relative error of {}, the method's own estimate: {}"
# number of relaxation times, from the slowest on, that are accurate to rtol and compared
COMPARED_MODES = 8
# states at which the answer gives pressures and shares of the force
STATES = ("start", "steady")


Value = Callable[[Any], Array | float]


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


@dataclass(frozen=True, eq=False)
class Quantity:
    """A quantity.

    Parameters
    ----------
    name : its name
    axes : names of its dimensions, in one text
    unit : name of its unit, an attribute of `Units`
    definition : definition for users
    value : computes it from what a method provides
    norm : norm of its error
    order : order of convergence over that of fields: 2 for energies
    in_thin_layers : whether it depends on the thin layers near ring edges in which wear has
        smoothed the pressure of a flat punch
    cells : how cells of the face limit it if the contact has edges within the face: "unresolved" if
        it is only known to a cell, for any `rtol`; "refined" if smaller cells make it more accurate
        although it is not promised; empty if they do not limit it
    at : for a number of the answer: the quantity that it repeats, and the index of the time
    remaining : for a time of the answer: the part of the running-in that remains then
    """

    name: str
    axes: str
    unit: str
    definition: str
    value: Value
    norm: Norm = VALUE
    order: int = 1
    in_thin_layers: bool = False
    cells: Literal["", "unresolved", "refined"] = ""
    at: tuple[str, int] | None = None
    remaining: float | None = None

    @property
    def dims(self) -> tuple[str, ...]:
        """The names of its dimensions."""
        return tuple(self.axes.split())

    @property
    def over_time(self) -> bool:
        """Whether it depends on time."""
        return self.dims[:1] == ("time",)

    @property
    def error_dims(self) -> tuple[str, ...]:
        """The dimensions of its error: those except radius and ring, over which norms are taken."""
        return tuple(dim for dim in self.dims if dim not in NORMED)

    def difference(self, values: Values, reference: Values, face: "Face") -> Array:
        """Return the difference of two results in the norm of the quantity (`Norm.difference`)."""
        return self.norm.difference(self.name, self.dims, values, reference, face)


def _mean_contact_radius(state: Any) -> Array:
    """Return the mean radius (T,) at which the force acts; 0 without a force."""
    force = state.ring_forces.sum(axis=1)
    return np.divide(state.moment, force, out=np.zeros(len(force)), where=force > 0)


def _by_name(*quantities: Quantity) -> dict[str, Quantity]:
    return {quantity.name: quantity for quantity in quantities}


# quantities that are computed and compared over time, in modes and in the steady state
QUANTITIES = _by_name(
    Quantity(
        "pressure",
        "time radius",
        "pressure",
        "contact pressure p(r, t), never below zero",
        lambda state: state.pressure,
        PRESSURE,
        in_thin_layers=True,
        cells="unresolved",
    ),
    Quantity(
        "profile",
        "time radius",
        "displacement",
        "worn height f(r, t) of the punch: material removed",
        lambda state: state.shape + state.even_wear[:, None] + state.standoff,
        DEPTH,
        cells="unresolved",
    ),
    Quantity(
        "displacement",
        "time radius",
        "displacement",
        "displacement u_z = d - f of the half-space under the punch",
        lambda state: state.displacement,
        DEPTH,
        cells="unresolved",
    ),
    Quantity(
        "indentation",
        "time",
        "displacement",
        "indentation d(t) of the unworn face plane of the punch",
        lambda state: state.depth + state.even_wear + state.standoff,
        DEPTH,
        order=2,
    ),
    Quantity(
        "displacement_centre",
        "time",
        "displacement",
        "u_z at the centre, or at the inner edge of a hollow punch",
        lambda state: state.displacement_centre,
        DEPTH,
        cells="unresolved",
    ),
    Quantity(
        "displacement_max",
        "time",
        "displacement",
        "greatest u_z under the punch",
        lambda state: state.displacement_max,
        DEPTH,
        cells="unresolved",
    ),
    Quantity(
        "rms_slope",
        "time",
        "slope",
        "root mean square of df/dr (Eq. 18); gradient_average selects the average",
        lambda state: state.rms_slope,
        SLOPE,
        in_thin_layers=True,
        cells="unresolved",
    ),
    Quantity(
        "ring_force",
        "time ring",
        "force",
        "normal force on each ring, counted from the centre",
        lambda state: state.ring_forces,
        FORCE,
        order=2,
        cells="refined",
    ),
    Quantity(
        "relaxation_time",
        "mode",
        "time",
        "relaxation times of the wear modes, slowest first",
        lambda modes: modes.relaxation_times,
        order=2,
    ),
    Quantity(
        "normal_force",
        "time",
        "force",
        "normal force on the punch",
        lambda state: state.ring_forces.sum(axis=1),
        FORCE,
        order=2,
    ),
    Quantity(
        "ring_worn_volume",
        "time ring",
        "volume",
        "worn volume of each ring, counted from the centre",
        lambda state: state.worn_volumes,
        VOLUME_SO_FAR,
        cells="refined",
    ),
    Quantity(
        "contact_radius",
        "time",
        "length",
        "outermost radius of contact",
        lambda state: np.nanmax(state.contact_edges, axis=1, initial=0.0),
        RADIUS,
        cells="unresolved",
    ),
    Quantity(
        "mean_contact_radius",
        "time",
        "length",
        "mean radius of the contact, weighted by the pressure: int p r dA / F",
        _mean_contact_radius,
        RADIUS,
        cells="unresolved",
    ),
    Quantity(
        "contact",
        "time radius",
        "number",
        "1 in contact, 0 outside",
        lambda state: state.contact,
    ),
    Quantity(
        "contact_edge",
        "time edge",
        "length",
        "inner and outer radius of each part of the contact in turn",
        lambda state: state.contact_edges,
    ),
    Quantity(
        "steady_pressure",
        "radius",
        "pressure",
        "contact pressure in the steady state (Eq. 24)",
        lambda steady: steady.pressure,
        PRESSURE,
    ),
    Quantity(
        "steady_profile",
        "radius",
        "displacement",
        "limiting profile, its minimum at zero (Eq. 27)",
        lambda steady: np.maximum(steady.displacement_max - steady.displacement, 0.0),
        STEADY_DEPTH,
    ),
    Quantity(
        "steady_displacement_max",
        "",
        "displacement",
        "greatest u_z in the steady state, u_max of Eq. 27",
        lambda steady: steady.displacement_max,
    ),
    Quantity(
        "steady_rms_slope",
        "",
        "slope",
        "root mean square slope of the limiting profile (Eq. 18)",
        lambda steady: steady.rms_slope,
    ),
    Quantity(
        "steady_wear_rate",
        "",
        "wear_rate",
        "rate at which height is lost, the same on every ring (Eq. 23)",
        lambda steady: steady.wear_rate,
    ),
)

# values at the start and after each step of a march in which contact opens, closes and spreads
STEPS = _by_name(
    Quantity(
        "step_time",
        "step",
        "time",
        "time of each step of the march, the start first",
        lambda march: march.path[:, 0],
    ),
    Quantity(
        "step_indentation",
        "step",
        "displacement",
        "indentation at each step",
        lambda march: march.path[:, 1] + march.standoff,
    ),
    Quantity(
        "step_normal_force",
        "step",
        "force",
        "normal force at each step",
        lambda march: march.path[:, 2],
    ),
    Quantity(
        "step_contact_area",
        "step",
        "number",
        "contact area at each step, relative to the area of the face",
        lambda march: march.path[:, 3],
    ),
)

# the answer of a run (`studies/crosscheck/methods/sampling/answers.py`): quantities without time
ANSWER = _by_name(
    Quantity(
        "indentation_start",
        "",
        "displacement",
        "indentation of the unworn face at the start; F / (2 a E*) for a flat face in full contact",
        lambda run: run.indentation_at_start,
        order=2,
        at=("indentation", 0),
    ),
    Quantity(
        "indentation_steady",
        "",
        "displacement",
        "depth of the foremost point of the worn punch, u_max of Eq. 27",
        lambda run: run.greatest_steady_displacement,
    ),
    Quantity(
        "running_in_time",
        "",
        "time",
        "slowest relaxation time of the full face: once all of it is in contact, the rest of the "
        "running-in falls to 1/e in this time",
        lambda run: run.slowest_time,
        order=2,
        cells="unresolved",
    ),
    Quantity(
        "time_to_90",
        "",
        "time",
        "time at which 90 % of the running-in is complete, by d(t) minus steady wear",
        lambda run: run.time_until(0.1),
        order=2,
        cells="unresolved",
        remaining=0.1,
    ),
    Quantity(
        "time_to_99",
        "",
        "time",
        "time at which 99 % of the running-in is complete, by d(t) minus steady wear",
        lambda run: run.time_until(0.01),
        order=2,
        cells="unresolved",
        remaining=0.01,
    ),
    Quantity(
        "pressure_min",
        "state ring",
        "pressure",
        "least contact pressure on each ring",
        lambda run: run.pressures[0],
        EACH,
    ),
    Quantity(
        "pressure_max",
        "state ring",
        "pressure",
        "greatest contact pressure on each ring; infinite at the edges of an unworn flat punch",
        lambda run: run.pressures[1],
        EACH,
    ),
    Quantity(
        "force_share",
        "state ring",
        "share",
        "fraction of the normal force on each ring",
        lambda run: run.force_shares,
        SHARE,
        cells="refined",
    ),
    Quantity(
        "worn_volume",
        "ring",
        "volume",
        "worn volume of each ring at the last of the times",
        lambda run: run.worn_volumes,
        VOLUME,
        cells="refined",
        at=("ring_worn_volume", -1),
    ),
    Quantity(
        "force_start",
        "",
        "force",
        "normal force at the start",
        lambda run: float(run.forces[0]),
        order=2,
        at=("normal_force", 0),
    ),
    Quantity(
        "force_end",
        "",
        "force",
        "normal force at the last of the times",
        lambda run: float(run.forces[1]),
        FIRST_FORCE,
        order=2,
        at=("normal_force", -1),
    ),
    Quantity(
        "time_to_half_force",
        "",
        "time",
        "time at which the normal force has fallen to half of that at the start",
        lambda run: run.time_until(0.5),
        order=2,
        remaining=0.5,
    ),
    Quantity(
        "contact_radius_start",
        "",
        "length",
        "outermost radius of contact at the start",
        lambda run: run.contact_radius_at_start,
        at=("contact_radius", 0),
    ),
    Quantity(
        "contact_radius_end",
        "",
        "length",
        "radius of the scar at the last of the times",
        lambda run: run.contact_radius_at_end,
        cells="unresolved",
        at=("contact_radius", -1),
    ),
    Quantity(
        "worn_depth_end",
        "",
        "displacement",
        "depth of the scar at its centre at the last of the times",
        lambda run: run.worn_depth_at_end,
    ),
    Quantity(
        "pressure_peak_start",
        "",
        "pressure",
        "greatest contact pressure at the start, if finite",
        lambda run: run.peak_at_start,
    ),
    Quantity(
        "time_to_full_contact",
        "",
        "time",
        "time from which all of the face is in contact, to within a step",
        lambda run: run.time_to_full_contact,
        cells="unresolved",
    ),
)

# all quantities that are computed and compared, and that have an error estimate
DESCRIBED = QUANTITIES | ANSWER
# quantities that describe the contact and are not compared
NOT_COMPARED = frozenset({"contact", "contact_edge"})
# quantities that converge with twice the order of fields
ENERGIES = frozenset(name for name, quantity in DESCRIBED.items() if quantity.order == 2)
LAYER_QUANTITIES = frozenset(name for name, each in DESCRIBED.items() if each.in_thin_layers)
HISTORIES = frozenset(name for name, quantity in QUANTITIES.items() if quantity.over_time)
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
            otherwise = f"give some of {', '.join(QUANTITIES)}, or the groups {', '.join(GROUPS)}"
            raise ValueError(f"no quantity '{name}'{did_you_mean(name, QUANTITIES, otherwise)}")
        expanded |= GROUPS.get(name, {name})
    return expanded


def differences(values: Values, reference: Values, face: "Face") -> Results:
    """Return the relative difference of every quantity that both results have, in its norm.

    Parameters
    ----------
    values, reference : the results to compare, with fields on the face of the punch; differences
        are relative to `reference`. They are NaN where one of them lacks a number of the answer
    face : the face
    """
    return {
        name: quantity.difference(values, reference, face)
        for name, quantity in DESCRIBED.items()
        if name in values and name in reference
    }


def error_name(name: str) -> str:
    """Name the variable that holds the error estimate of a quantity."""
    return f"{name}_error"
