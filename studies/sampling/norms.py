"""Values of quantities, and relative differences of them in the norms of `problem.quantities`."""

import numpy as np

from ...meshes.radial import Array
from ..problem.face import Face
from ..problem.quantities import ANSWER, LEAST_SLOPE, QUANTITIES

# Quantities by name, non-dimensional, with the dimensions of `QUANTITIES`. Histories also have
# `time`; `pressed` (T,), whether pressures may be infinite; `even_wear` (T,), the depth by which
# the whole face has worn at the steady rate; `depth` (T,), the indentation from the first touch
# less `even_wear`; and `shape` (T, R), the profile from the first touch less `even_wear`.
Results = dict[str, Array]
# Heights that grow without bound with even wear, and the same heights without it.
WITHOUT_EVEN_WEAR = {"profile": "shape", "indentation": "depth"}


def radial_weight(radii: Array, average: str, inner_radius: float) -> Array:
    """Return the weight of an average over the face at some radii.

    The average is over the radius (`line`) or over the area (`area`) of a face from `inner_radius`
    to 1. The weight is 0 in a hole.
    """
    on_face = radii > inner_radius
    if average == "line":
        return on_face / (1 - inner_radius)
    return on_face * 2 * radii / ((1 - inner_radius) * (1 + inner_radius))


def common(*shapes: tuple[int, ...]) -> tuple[slice, ...]:
    """Return slices of the part that arrays of these shapes have in common.

    For example, methods may compute different numbers of relaxation times.
    """
    return tuple(slice(0, min(sizes)) for sizes in zip(*shapes, strict=True))


def differences(results: Results, against: Results, face: Face) -> Results:
    """Return the relative difference of every quantity that both results have, in its norm.

    Parameters
    ----------
    results, against : the results to compare, with fields on the face of the punch; differences are
        relative to `against`
    face : the face
    """
    return {
        name: _difference(name, results, against, face)
        for name in QUANTITIES
        if name in results and name in against
    }


def answer_differences(answers: Results, against: Results) -> Results:
    """Return the relative difference of every number of the answer that both have, in its norm.

    It is NaN if one of them lacks the number; closed forms, for example, do not give the start.
    """
    compared = {}
    for name, quantity in ANSWER.items():
        if name not in answers or name not in against:
            continue
        value, reference = answers[name], against[name]
        # every method has an infinite pressure at the rim of a flat punch: no difference
        same = np.isinf(value) & (value == reference)
        difference = np.abs(np.where(same, 0.0, value) - np.where(same, 0.0, reference))
        scale = np.abs(np.where(same, 1.0, reference))
        if quantity.norm in ("share", "first force"):
            scale = np.ones_like(scale)
        elif quantity.norm == "volume":
            scale = np.broadcast_to(scale.sum(axis=-1, keepdims=True), scale.shape)
        relative = np.divide(difference, scale, out=np.zeros(difference.shape), where=scale > 0)
        relative = np.where(np.isnan(difference), np.nan, relative)
        compared[name] = relative.max(axis=-1) if "ring" in quantity.dims else relative
    return compared


def _difference(name: str, results: Results, against: Results, face: Face) -> Array:
    value, reference = results[name], against[name]
    overlap = common(value.shape, reference.shape)
    value, reference = value[overlap], reference[overlap]
    norm = QUANTITIES[name].norm
    if norm == "pressure":
        weights = face.weights
        if "time" in QUANTITIES[name].dims:
            pressed = against.get("pressed", against["time"] == 0)
            weights = weights * np.where(pressed[:, None], face.edge_weights, 1.0)
        difference, scale = (
            np.sqrt(np.sum(weights * field**2, axis=-1)) for field in (value - reference, reference)
        )
    else:
        unit, depth = np.ones(()), _greatest_depth(against, face)
        if name in WITHOUT_EVEN_WEAR and depth.ndim:
            return _difference_of_heights(name, results, against, depth, face)
        difference = np.abs(value - reference)
        dims = enumerate(QUANTITIES[name].dims)
        axes = tuple(axis for axis, dim in dims if dim in ("radius", "ring"))
        difference = difference.max(axis=axes, initial=0.0)
        # largest force so far, because at a fixed indentation the force decays to zero
        force = np.asarray(against.get("normal_force", unit))
        if force.ndim:
            force = np.maximum.accumulate(force)
        scale = {
            "value": np.abs(reference),
            "depth": depth,
            "steady": against.get("steady_displacement_max", unit),
            "force": force,
            "volume": reference.sum(axis=-1),
            "radius": unit,
            "slope": np.abs(reference),
        }[norm]
        if norm == "slope":
            scale = np.maximum(scale, LEAST_SLOPE * depth)
    relative = np.divide(difference, scale, out=np.zeros(difference.shape), where=scale > 0)
    if norm == "slope":
        # no value: the slope is infinite, which differs by all of it from any finite value
        infinite, other_infinite = np.isnan(value), np.isnan(reference)
        relative = np.where(infinite & other_infinite, 0.0, relative)
        relative = np.where(infinite != other_infinite, 1.0, relative)
    return relative


def _greatest_depth(against: Results, face: Face) -> Array:
    """Return the greatest depth so far (T,), because it decreases under a force that falls.

    Without `depth`, even wear is not known apart. Without an indentation, the unit is returned.
    """
    if "depth" in against:
        return np.maximum.accumulate(against["depth"])
    if "indentation" in against:
        return np.maximum.accumulate(against["indentation"] - face.standoff)
    return np.ones(())


def _difference_of_heights(
    name: str, results: Results, against: Results, depth: Array, face: Face
) -> Array:
    """Return the relative difference (T,) of two profiles, or of two indentations.

    Even wear grows without bound, and the shape of the face does not. Therefore differences of the
    whole heights and of the even wear are relative to the whole height, and the rest of the
    difference is relative to the depth without even wear; the greatest one counts.

    Parameters
    ----------
    name : a key of `WITHOUT_EVEN_WEAR`
    results, against : the results to compare. Those of other programs are heights only; their even
        wear is then that of `against` times the ratio of the mean heights
    depth : (T,) greatest depth so far, by `against`
    face : the face
    """
    whole = results[name] - against[name]
    even_wear = against.get("even_wear", np.zeros(len(depth)))
    if results.keys() & against.keys() >= {"even_wear", WITHOUT_EVEN_WEAR[name]}:
        part = WITHOUT_EVEN_WEAR[name]
        even, rest = results["even_wear"] - even_wear, results[part] - against[part]
        # if contact is already full in one of them only, only the whole heights are comparable
        one_is_full = (results["even_wear"] > 0) != (even_wear > 0)
        rest = (rest.T + np.where(one_is_full, even, 0.0)).T
        even = np.where(one_is_full, 0.0, even)
    else:
        weights = face.areas / face.areas.sum() if whole.ndim > 1 else np.ones(1)
        mean, mean_difference = (
            values.reshape(len(values), -1) @ weights for values in (against[name], whole)
        )
        ratio = np.divide(mean_difference, mean, out=np.zeros_like(mean), where=even_wear > 0)
        even = even_wear * ratio
        rest = (whole.T - even).T
    height = depth + even_wear
    if "indentation" in against:
        height = np.maximum.accumulate(against["indentation"] - face.standoff)
    relative = [
        np.divide(_largest(values), scale, out=np.zeros(len(scale)), where=scale > 0)
        for values, scale in ((rest, depth), (even, height), (whole, height))
    ]
    return np.asarray(np.max(relative, axis=0))


def _largest(values: Array) -> Array:
    """Return the largest absolute value (T,) at each time of values (T, ...)."""
    return np.abs(values.reshape(len(values), -1)).max(axis=1)
