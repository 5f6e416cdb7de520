"""What is computed: each quantity with its dimensions, unit and definition, and how two values of it are compared."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray

from ringwear.meshes.radial import Array


class Quantity(NamedTuple):
    """Dimensions, unit (of `Units`), definition, and whether the verdict on two methods rests on it."""

    dims: tuple[str, ...]
    unit: str
    definition: str
    compared: bool = True

    @property
    def is_field(self) -> bool:
        """Whether it runs over the radius or the rings: its differences count relative to its greatest value."""
        return self.dims[-1:] in (("radius",), ("ring",))


# pointwise pressures are drawn and kept in the results, but at ring edges and the rim they are singular at t = 0: they
# belong in a norm, not in a verdict
QUANTITIES = {
    "pressure": Quantity(("time", "radius"), "pressure", "contact pressure p(r, t)", compared=False),
    "profile": Quantity(("time", "radius"), "displacement", "worn height f(r, t) of the punch, material gone"),
    "displacement": Quantity(
        ("time", "radius"), "displacement", "displacement u_z = d - f of the half-space under the punch", compared=False
    ),
    "indentation": Quantity(("time",), "displacement", "indentation d(t) of the unworn face plane of the punch"),
    "displacement_centre": Quantity(("time",), "displacement", "u_z at the centre"),
    "displacement_max": Quantity(("time",), "displacement", "greatest u_z under the punch"),
    "rms_slope": Quantity(("time",), "slope", "root mean square of df/dr (Eq. 18), average: see gradient_average"),
    "ring_force": Quantity(("time", "ring"), "force", "normal force on each ring, from the centre"),
    "relaxation_time": Quantity(("mode",), "time", "relaxation times of the wear modes, slowest first"),
    "steady_pressure": Quantity(("radius",), "pressure", "contact pressure in the steady state (Eq. 24)", compared=False),
    "steady_profile": Quantity(("radius",), "displacement", "limiting profile, its minimum at zero (Eq. 27)"),
    "steady_displacement_max": Quantity((), "displacement", "greatest u_z in the steady state, u_max of Eq. 27"),
    "steady_rms_slope": Quantity((), "slope", "root mean square slope of the limiting profile (Eq. 18)"),
    "steady_wear_rate": Quantity((), "wear_rate", "df/dt in the steady state (Eq. 23)"),
}


def labelled(values: Mapping[str, Array | float]) -> xarray.Dataset:
    """Values of quantities as an xarray Dataset, non-dimensional."""
    return xarray.Dataset({name: (QUANTITIES[name].dims, value) for name, value in values.items()})


def error_name(name: str) -> str:
    """Name of the variable that holds a quantity's relative error, by the method's own estimate."""
    return f"{name}_error"


def with_errors(results: xarray.Dataset, errors: Mapping[str, Array]) -> xarray.Dataset:
    """Results with the relative error of each quantity beside it."""
    return results.assign({error_name(name): (QUANTITIES[name].dims, error) for name, error in errors.items()})


def array(results: xarray.Dataset, name: str) -> Array:
    """The bare numbers of a variable; empty where there is none."""
    return np.asarray(results.variables[name].values) if name in results.variables else np.empty(0)


def common(one: tuple[int, ...], other: tuple[int, ...]) -> tuple[slice, ...]:
    """The part that arrays of two shapes have in common: of relaxation times each method may know another number."""
    return tuple(slice(0, min(sizes)) for sizes in zip(one, other, strict=True))


def relative_difference(name: str, value: Array, against: Array) -> Array:
    """Relative difference; of fields, the greatest over the greatest value at that time. Of modes, those both have."""
    both = common(value.shape, against.shape)
    value, against = value[both], against[both]
    difference, scale = np.abs(value - against), np.abs(against)
    if QUANTITIES[name].is_field:
        difference, scale = (
            np.broadcast_to(part.max(axis=-1, keepdims=True, initial=0.0), value.shape) for part in (difference, scale)
        )
    return np.divide(difference, scale, out=np.zeros(difference.shape), where=scale > 0)
