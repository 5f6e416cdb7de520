"""Define all quantities that can be computed, each in one place.

The decorators `over_time`, `in_steady_state`, `in_modes`, `in_answer` and `at_steps` declare a
quantity with its name, which is that of the function, its dimensions, its unit, its definition for
users, and the norm in which two of its values are compared. The function computes its value from
what a method provides, as attributes: the state of the punch at its times
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
    dims : names of its dimensions
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
    dims: tuple[str, ...]
    unit: str
    definition: str
    value: Callable[[Any], Array | float]
    norm: Norm = VALUE
    order: int = 1
    in_thin_layers: bool = False
    cells: Literal["", "unresolved", "refined"] = ""
    at: tuple[str, int] | None = None
    remaining: float | None = None

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


# quantities that are computed and compared over time, in modes and in the steady state
QUANTITIES: dict[str, Quantity] = {}
# values at the start and after each step of a march in which contact opens, closes and spreads
STEPS: dict[str, Quantity] = {}
# the answer of a run (`studies/crosscheck/methods/sampling/answers.py`): quantities without time
ANSWER: dict[str, Quantity] = {}

Value = Callable[[Any], Array | float]


def _declare(
    registry: dict[str, Quantity], dims: str, unit: str, definition: str, **more: Any
) -> Callable[[Value], Quantity]:
    def declared(value: Value) -> Quantity:
        name = value.__name__
        registry[name] = Quantity(name, tuple(dims.split()), unit, definition, value, **more)
        return registry[name]

    return declared


def over_time(
    dims: str, unit: str, definition: str, norm: Norm = VALUE, **more: Any
) -> Callable[[Value], Quantity]:
    """Return a decorator for a quantity of a history, with dimensions in addition to the time."""
    return _declare(QUANTITIES, f"time {dims}", unit, definition, norm=norm, **more)


def in_steady_state(
    dims: str, unit: str, definition: str, norm: Norm = VALUE, **more: Any
) -> Callable[[Value], Quantity]:
    """Return a decorator for a quantity of the steady state; its name begins with `steady_`."""
    return _declare(QUANTITIES, dims, unit, definition, norm=norm, **more)


def in_modes(
    unit: str, definition: str, norm: Norm = VALUE, **more: Any
) -> Callable[[Value], Quantity]:
    """Return a decorator for a quantity of relaxation modes."""
    return _declare(QUANTITIES, "mode", unit, definition, norm=norm, **more)


def at_steps(unit: str, definition: str) -> Callable[[Value], Quantity]:
    """Return a decorator for a quantity of the steps of a march, which is not compared."""
    return _declare(STEPS, "step", unit, definition)


def in_answer(
    dims: str, unit: str, definition: str, norm: Norm = VALUE, **more: Any
) -> Callable[[Value], Quantity]:
    """Return a decorator for a number of the answer."""
    return _declare(ANSWER, dims, unit, definition, norm=norm, **more)


def _time_of_running_in(
    name: str, remaining: float, definition: str, cells: Literal["", "unresolved"] = ""
) -> Quantity:
    """Add the time to the answer after which a given part of the running-in remains."""
    ANSWER[name] = Quantity(
        name,
        (),
        "time",
        definition,
        lambda run: run.time_until(remaining),
        order=2,
        cells=cells,
        remaining=remaining,
    )
    return ANSWER[name]


@over_time(
    "radius",
    "pressure",
    "contact pressure p(r, t), never below zero",
    PRESSURE,
    in_thin_layers=True,
    cells="unresolved",
)
def pressure(state: Any) -> Array:
    """Return the contact pressure (T, R)."""
    return state.pressure


@over_time(
    "radius",
    "displacement",
    "worn height f(r, t) of the punch: material removed",
    DEPTH,
    cells="unresolved",
)
def profile(state: Any) -> Array:
    """Return the worn height (T, R), from the plane of the unworn face."""
    return state.shape + state.even_wear[:, None] + state.standoff


@over_time(
    "radius",
    "displacement",
    "displacement u_z = d - f of the half-space under the punch",
    DEPTH,
    cells="unresolved",
)
def displacement(state: Any) -> Array:
    """Return the displacement (T, R) of the half-space."""
    return state.displacement


@over_time(
    "", "displacement", "indentation d(t) of the unworn face plane of the punch", DEPTH, order=2
)
def indentation(state: Any) -> Array:
    """Return the indentation (T,) of the plane of the unworn face."""
    return state.depth + state.even_wear + state.standoff


@over_time(
    "",
    "displacement",
    "u_z at the centre, or at the inner edge of a hollow punch",
    DEPTH,
    cells="unresolved",
)
def displacement_centre(state: Any) -> Array:
    """Return the displacement (T,) at the centre."""
    return state.displacement_centre


@over_time("", "displacement", "greatest u_z under the punch", DEPTH, cells="unresolved")
def displacement_max(state: Any) -> Array:
    """Return the greatest displacement (T,) under the punch."""
    return state.displacement_max


@over_time(
    "",
    "slope",
    "root mean square of df/dr (Eq. 18); gradient_average selects the average",
    SLOPE,
    in_thin_layers=True,
    cells="unresolved",
)
def rms_slope(state: Any) -> Array:
    """Return the root mean square slope (T,) of the face."""
    return state.rms_slope


@over_time(
    "ring",
    "force",
    "normal force on each ring, counted from the centre",
    FORCE,
    order=2,
    cells="refined",
)
def ring_force(state: Any) -> Array:
    """Return the force (T, N) on each ring."""
    return state.ring_forces


@in_modes("time", "relaxation times of the wear modes, slowest first", order=2)
def relaxation_time(modes: Any) -> Array:
    """Return the relaxation times (m,)."""
    return modes.relaxation_times


@over_time("", "force", "normal force on the punch", FORCE, order=2)
def normal_force(state: Any) -> Array:
    """Return the normal force (T,)."""
    return state.ring_forces.sum(axis=1)


@over_time(
    "ring",
    "volume",
    "worn volume of each ring, counted from the centre",
    VOLUME_SO_FAR,
    cells="refined",
)
def ring_worn_volume(state: Any) -> Array:
    """Return the worn volume (T, N) of each ring."""
    return state.worn_volumes


@over_time("", "length", "outermost radius of contact", RADIUS, cells="unresolved")
def contact_radius(state: Any) -> Array:
    """Return the outermost radius (T,) of contact; 0 without contact."""
    return np.nanmax(state.contact_edges, axis=1, initial=0.0)


@over_time(
    "",
    "length",
    "mean radius of the contact, weighted by the pressure: int p r dA / F",
    RADIUS,
    cells="unresolved",
)
def mean_contact_radius(state: Any) -> Array:
    """Return the mean radius (T,) at which the force acts; 0 without a force."""
    force = state.ring_forces.sum(axis=1)
    return np.divide(state.moment, force, out=np.zeros(len(force)), where=force > 0)


@over_time("radius", "number", "1 in contact, 0 outside")
def contact(state: Any) -> Array:
    """Return where (T, R) the punch is in contact."""
    return state.contact


@over_time("edge", "length", "inner and outer radius of each part of the contact in turn")
def contact_edge(state: Any) -> Array:
    """Return the edges (T, E) of the contact."""
    return state.contact_edges


@in_steady_state("radius", "pressure", "contact pressure in the steady state (Eq. 24)", PRESSURE)
def steady_pressure(steady: Any) -> Array:
    """Return the steady pressure (R,)."""
    return steady.pressure


@in_steady_state(
    "radius", "displacement", "limiting profile, its minimum at zero (Eq. 27)", STEADY_DEPTH
)
def steady_profile(steady: Any) -> Array:
    """Return the limiting profile (R,), zero at the point that has worn least."""
    return np.maximum(steady.displacement_max - steady.displacement, 0.0)


@in_steady_state("", "displacement", "greatest u_z in the steady state, u_max of Eq. 27")
def steady_displacement_max(steady: Any) -> Array:
    """Return the greatest steady displacement."""
    return steady.displacement_max


@in_steady_state("", "slope", "root mean square slope of the limiting profile (Eq. 18)")
def steady_rms_slope(steady: Any) -> Array:
    """Return the root mean square slope of the limiting profile."""
    return steady.rms_slope


@in_steady_state("", "wear_rate", "rate at which height is lost, the same on every ring (Eq. 23)")
def steady_wear_rate(steady: Any) -> Array:
    """Return the steady wear rate."""
    return steady.wear_rate


@at_steps("time", "time of each step of the march, the start first")
def step_time(march: Any) -> Array:
    """Return the time (S,) of each step."""
    return march.path[:, 0]


@at_steps("displacement", "indentation at each step")
def step_indentation(march: Any) -> Array:
    """Return the indentation (S,) at each step."""
    return march.path[:, 1] + march.standoff


@at_steps("force", "normal force at each step")
def step_normal_force(march: Any) -> Array:
    """Return the force (S,) at each step."""
    return march.path[:, 2]


@at_steps("number", "contact area at each step, relative to the area of the face")
def step_contact_area(march: Any) -> Array:
    """Return the contact area (S,) at each step."""
    return march.path[:, 3]


@in_answer(
    "",
    "displacement",
    "indentation of the unworn face at the start; F / (2 a E*) for a flat face in full contact",
    order=2,
    at=("indentation", 0),
)
def indentation_start(run: Any) -> float:
    """Return the indentation at the start."""
    return run.indentation_at_start


@in_answer("", "displacement", "depth of the foremost point of the worn punch, u_max of Eq. 27")
def indentation_steady(run: Any) -> float:
    """Return the depth of the foremost point in the steady state."""
    return run.greatest_steady_displacement


@in_answer(
    "",
    "time",
    "slowest relaxation time of the full face: once all of it is in contact, the rest of the "
    "running-in falls to 1/e in this time",
    order=2,
    cells="unresolved",
)
def running_in_time(run: Any) -> float:
    """Return the slowest relaxation time."""
    return run.slowest_time


time_to_90 = _time_of_running_in(
    "time_to_90",
    0.1,
    "time at which 90 % of the running-in is complete, by d(t) minus steady wear",
    cells="unresolved",
)
time_to_99 = _time_of_running_in(
    "time_to_99",
    0.01,
    "time at which 99 % of the running-in is complete, by d(t) minus steady wear",
    cells="unresolved",
)


@in_answer("state ring", "pressure", "least contact pressure on each ring", EACH)
def pressure_min(run: Any) -> Array:
    """Return the least pressure (2, N) on each ring."""
    return run.pressures[0]


@in_answer(
    "state ring",
    "pressure",
    "greatest contact pressure on each ring; infinite at the edges of an unworn flat punch",
    EACH,
)
def pressure_max(run: Any) -> Array:
    """Return the greatest pressure (2, N) on each ring."""
    return run.pressures[1]


@in_answer(
    "state ring", "share", "fraction of the normal force on each ring", SHARE, cells="refined"
)
def force_share(run: Any) -> Array:
    """Return the share of the force (2, N) on each ring."""
    return run.force_shares


@in_answer(
    "ring",
    "volume",
    "worn volume of each ring at the last of the times",
    VOLUME,
    cells="refined",
    at=("ring_worn_volume", -1),
)
def worn_volume(run: Any) -> Array:
    """Return the worn volume (N,) of each ring at the last time."""
    return run.worn_volumes


@in_answer("", "force", "normal force at the start", order=2, at=("normal_force", 0))
def force_start(run: Any) -> float:
    """Return the force at the start."""
    return float(run.forces[0])


@in_answer(
    "",
    "force",
    "normal force at the last of the times",
    FIRST_FORCE,
    order=2,
    at=("normal_force", -1),
)
def force_end(run: Any) -> float:
    """Return the force at the last time."""
    return float(run.forces[1])


time_to_half_force = _time_of_running_in(
    "time_to_half_force",
    0.5,
    "time at which the normal force has fallen to half of that at the start",
)


@in_answer("", "length", "outermost radius of contact at the start", at=("contact_radius", 0))
def contact_radius_start(run: Any) -> float:
    """Return the outermost radius of contact at the start."""
    return run.contact_radius_at_start


@in_answer("", "pressure", "greatest contact pressure at the start, if finite")
def pressure_peak_start(run: Any) -> float:
    """Return the greatest pressure at the start."""
    return run.peak_at_start


@in_answer(
    "",
    "time",
    "time from which all of the face is in contact, to within a step",
    cells="unresolved",
)
def time_to_full_contact(run: Any) -> float:
    """Return the time from which all of the face is in contact."""
    return run.time_to_full_contact


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


SYMBOLS = {
    "t": "time",
    "r": "radius",
    "p": "pressure",
    "contact_pressure": "pressure",
    "u": "displacement",
    "uz": "displacement",
    "u_z": "displacement",
    "f": "profile",
    "worn_profile": "profile",
    "wear": "profile",
    "d": "indentation",
    "depth": "indentation",
    "approach": "indentation",
    "fn": "normal_force",
    "f_n": "normal_force",
    "force": "normal_force",
    "load": "normal_force",
}
"""Our names of quantities and coordinates, by those that other programs and papers use."""


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
