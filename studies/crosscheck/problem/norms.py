"""Norms: how the difference of two values of a quantity is measured, and relative to what.

Results are non-dimensional arrays by the names of quantities. Fields are at the radii of a face.
Histories also have `time`; `pressed` (T,), whether pressures may be infinite; `even_wear` (T,), the
depth by which the whole face has worn at the steady rate; `depth` (T,), the indentation from the
first touch less `even_wear`; and `shape` (T, R), the profile from the first touch less `even_wear`.
What the results of other programs lack of these, norms do without.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .face import Face

Array = NDArray[np.floating]
Results = dict[str, Array]
"""Values by the names of quantities."""
Values = Mapping[str, Array]
"""The same, or a report of another program."""


# heights that grow without bound with even wear, and the same heights without it
WITHOUT_EVEN_WEAR = {"profile": "shape", "indentation": "depth"}
# smallest scale of RMS slopes, over the indentation over the punch radius
LEAST_SLOPE = 1e-3
# smallest scale of worn volumes, over the indentation times the area of the face
LEAST_VOLUME = 1e-3
# dimensions over which norms are taken
NORMED = ("radius", "ring")


def common(*shapes: tuple[int, ...]) -> tuple[slice, ...]:
    """Return slices of the part that arrays of these shapes have in common.

    For example, methods may compute different numbers of relaxation times.
    """
    return tuple(slice(0, min(sizes)) for sizes in zip(*shapes, strict=True))


def greatest_depth(reference: Values, face: "Face") -> Array:
    """Return the greatest depth so far (T,), because it decreases under a force that falls.

    Without `depth`, even wear is not known apart. Without an indentation, the unit is returned.
    """
    if "depth" in reference:
        return np.maximum.accumulate(reference["depth"])
    if "indentation" in reference:
        return np.maximum.accumulate(reference["indentation"] - face.standoff)
    return np.ones(())


Scale = Callable[[Array, Values, "Face"], Array]
"""A function that returns the scale of differences, which broadcasts with the reference value."""


@dataclass(frozen=True, eq=False)
class Norm:
    """The greatest absolute difference over radii or rings, relative to a scale.

    Parameters
    ----------
    definition : the norm in words
    scale : returns the scale of differences, from the value of the reference, all its results and
        the face
    """

    definition: str
    scale: Scale

    def gaps(self, name: str, values: Values, reference: Values, face: "Face") -> Array:
        """Return the absolute differences of a quantity, with its dimensions.

        They are 0 where both values are infinite, and NaN where one of them is NaN.
        """
        value, other = _common_values(name, values, reference)
        # every method has an infinite pressure at the rim of a flat punch: no difference
        same = np.isinf(value) & (value == other)
        return np.abs(np.where(same, 0.0, value) - np.where(same, 0.0, other))

    def size(self, name: str, reference: Values, face: "Face") -> Array:
        """Return the size to which differences are relative, which broadcasts with the gaps."""
        size = np.asarray(self.scale(reference[name], reference, face))
        return size.reshape(size.shape + (1,) * (np.ndim(reference[name]) - size.ndim))

    def difference(
        self, name: str, dims: tuple[str, ...], values: Values, reference: Values, face: "Face"
    ) -> Array:
        """Return the difference of a quantity of two results in this norm.

        It is 0 where its size is.

        Parameters
        ----------
        name, dims : name and dimensions of the quantity
        values, reference : the results to compare; differences are relative to `reference`
        face : the face at whose radii fields are
        """
        gaps = self.gaps(name, values, reference, face)
        own = reference[name][tuple(map(slice, gaps.shape))]
        size = np.broadcast_to(self.size(name, {**reference, name: own}, face), gaps.shape)
        relative = np.divide(gaps, size, out=np.zeros(gaps.shape), where=size > 0)
        relative = np.where(np.isnan(gaps), np.nan, relative)
        axes = tuple(axis for axis, dim in enumerate(dims) if dim in NORMED)
        return np.asarray(relative.max(axis=axes, initial=0.0)) if axes else relative


class PressureNorm(Norm):
    """The root mean square of the difference over the face, relative to that of the pressure."""

    def gaps(self, name: str, values: Values, reference: Values, face: "Face") -> Array:
        """Return the absolute differences, times the root of the weight at times without wear."""
        value, other = _common_values(name, values, reference)
        return np.abs(value - other) * np.sqrt(_edge_factors(other, reference, face))

    def size(self, name: str, reference: Values, face: "Face") -> Array:
        """Return the root mean square of the pressure, times the root of that weight."""
        weights = face.weights * _edge_factors(reference[name], reference, face)
        squares = np.sum(weights * reference[name] ** 2, axis=-1, keepdims=True)
        return np.sqrt(squares / face.weights.sum())

    def difference(
        self, name: str, dims: tuple[str, ...], values: Values, reference: Values, face: "Face"
    ) -> Array:
        """Return the difference of a quantity of two results in this norm."""
        value, other = _common_values(name, values, reference)
        weights = face.weights * _edge_factors(other, reference, face)
        size, scale = (
            np.sqrt(np.sum(weights * field**2, axis=-1)) for field in (value - other, other)
        )
        return np.divide(size, scale, out=np.zeros(size.shape), where=scale > 0)


class SlopeNorm(Norm):
    """A norm of slopes that may be infinite, which have no value."""

    def difference(
        self, name: str, dims: tuple[str, ...], values: Values, reference: Values, face: "Face"
    ) -> Array:
        """Return the difference; an infinite slope differs by all of it from any finite one."""
        infinite, other_infinite = map(np.isnan, _common_values(name, values, reference))
        relative = super().difference(name, dims, values, reference, face)
        relative = np.where(infinite & other_infinite, 0.0, relative)
        return np.where(infinite != other_infinite, 1.0, relative)


class HeightNorm(Norm):
    """A norm of heights, some of which grow without bound with even wear.

    The shape of the face does not. Therefore differences of the whole heights and of the even wear
    are relative to the whole height, and the rest of the difference is relative to the depth
    without even wear; the greatest one counts.
    """

    def gaps(self, name: str, values: Values, reference: Values, face: "Face") -> Array:
        """Return the absolute differences, without those of even wear."""
        if not _grows(name, reference, face):
            return super().gaps(name, values, reference, face)
        return np.abs(_parts(name, values, reference, face)[1])

    def difference(
        self, name: str, dims: tuple[str, ...], values: Values, reference: Values, face: "Face"
    ) -> Array:
        """Return the difference of heights, with that of even wear apart."""
        rest = super().difference(name, dims, values, reference, face)
        if not _grows(name, reference, face):
            return rest
        whole, (even, _) = (
            values[name] - reference[name],
            _parts(name, values, reference, face),
        )
        height = greatest_depth(reference, face) + reference.get("even_wear", np.zeros(len(whole)))
        if "indentation" in reference:
            height = np.maximum.accumulate(reference["indentation"] - face.standoff)
        relative = [
            np.divide(_largest(gaps), height, out=np.zeros(len(height)), where=height > 0)
            for gaps in (even, whole)
        ]
        return np.max([rest, *relative], axis=0)


def _grows(name: str, reference: Values, face: "Face") -> bool:
    """Return whether a height has a part of even wear that is known."""
    return name in WITHOUT_EVEN_WEAR and bool(greatest_depth(reference, face).ndim)


def _parts(name: str, values: Values, reference: Values, face: "Face") -> tuple[Array, Array]:
    """Return the difference (T,) of even wear, and the rest (T, ...) of that of heights.

    Results of other programs are heights only; their even wear is then that of the reference times
    the ratio of the mean heights from the first touch.
    """
    whole = values[name] - reference[name]
    even_wear = reference.get("even_wear", np.zeros(len(whole)))
    if values.keys() & reference.keys() >= {"even_wear", WITHOUT_EVEN_WEAR[name]}:
        part = WITHOUT_EVEN_WEAR[name]
        even, rest = values["even_wear"] - even_wear, values[part] - reference[part]
        # if contact is already full in one of them only, only the whole heights are comparable
        one_is_full = (values["even_wear"] > 0) != (even_wear > 0)
        rest = (rest.T + np.where(one_is_full, even, 0.0)).T
        return np.where(one_is_full, 0.0, even), rest
    weights = face.areas / face.areas.sum() if whole.ndim > 1 else np.ones(1)
    mean, mean_difference = (
        each.reshape(len(each), -1) @ weights for each in (reference[name] - face.standoff, whole)
    )
    ratio = np.divide(mean_difference, mean, out=np.zeros_like(mean), where=even_wear > 0)
    proportional = even_wear * ratio
    return proportional, (whole.T - proportional).T


def _common_values(name: str, values: Values, reference: Values) -> tuple[Array, Array]:
    value, other = values[name], reference[name]
    overlap = common(value.shape, other.shape)
    return value[overlap], other[overlap]


def _edge_factors(value: Array, reference: Values, face: "Face") -> Array:
    """Return the factors (T, R) of weights at times at which the pressure may be infinite; else 1.

    A pressure (R,) without times is that of the steady state, which is finite.
    """
    if value.ndim == 1:
        return np.ones(len(value))
    pressed = reference.get("pressed", reference["time"] == 0)
    return np.where(pressed[:, None], face.edge_weights, 1.0)


def _largest(values: Array) -> Array:
    """Return the largest absolute value (T,) at each time of values (T, ...)."""
    return np.abs(values.reshape(len(values), -1)).max(axis=1)


def _own(value: Array, *_: object) -> Array:
    return np.abs(value)


def _unit(*_: object) -> Array:
    return np.ones(())


def _depth(_: Array, reference: Values, face: "Face") -> Array:
    return greatest_depth(reference, face)


def _slope(value: Array, reference: Values, face: "Face") -> Array:
    return np.maximum(np.abs(value), LEAST_SLOPE * greatest_depth(reference, face))


def _steady_depth(_: Array, reference: Values, __: object) -> Array:
    return reference.get("steady_displacement_max", np.ones(()))


def _force(_: Array, reference: Values, __: object) -> Array:
    """Return the largest force so far, because at a fixed indentation the force decays to zero."""
    force = np.asarray(reference.get("normal_force", np.ones(())))
    return np.maximum.accumulate(force) if force.ndim else force


def _all_rings(value: Array, *_: object) -> Array:
    return np.abs(value).sum(axis=-1, keepdims=True)


def _all_rings_or_depth(value: Array, reference: Values, face: "Face") -> Array:
    """Return the worn volume of all rings; early volumes are small differences of depths."""
    least = LEAST_VOLUME * greatest_depth(reference, face) * face.areas.sum()
    return np.maximum(_all_rings(value), least.reshape(least.shape + (1,) * least.ndim))


VALUE = Norm("difference, relative to the value", _own)
EACH = Norm("greatest difference of all rings, each relative to its own value", _own)
SHARE = Norm("greatest difference of all rings; the shares of all rings sum to 1", _unit)
FIRST_FORCE = Norm(
    "difference, relative to the force on a flat punch at the same indentation", _unit
)
DEPTH = HeightNorm(
    "greatest difference on the face, relative to the greatest depth so far: the indentation d(t) "
    "from the first touch, less the depth by which the whole face has worn evenly; a difference in "
    "that even wear is relative to d(t)",
    _depth,
)
SLOPE = SlopeNorm(
    "difference, relative to the value or to 1/1000 of the greatest depth so far over a, whichever "
    "is greater; the depth is d(t) from the first touch, less the even wear",
    _slope,
)
STEADY_DEPTH = Norm(
    "greatest difference on the face, relative to the greatest steady displacement", _steady_depth
)
FORCE = Norm(
    "greatest difference of all rings, relative to the greatest normal force so far", _force
)
VOLUME = Norm(
    "greatest difference of all rings, relative to the worn volume of all rings", _all_rings
)
VOLUME_SO_FAR = Norm(
    "greatest difference of all rings, relative to the worn volume of all rings or to 1/1000 of "
    "the greatest depth so far times the area of the face, whichever is greater",
    _all_rings_or_depth,
)
RADIUS = Norm("difference, relative to the radius of the punch", _unit)
PRESSURE = PressureNorm(
    "square root of int k dp^2 dA, relative to that of int k p^2 dA; at t = 0, when p is not "
    "square integrable, with the weight k (1 - r^2/a^2), times 1 - b/r if there is a hole of "
    "radius b",
    _unit,
)
