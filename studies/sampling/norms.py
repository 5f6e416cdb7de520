"""Values of quantities, and their differences in the norms that these have."""

import numpy as np

from ...meshes.radial import Array
from ..problem.face import Face
from ..problem.quantities import ANSWER, QUANTITIES

# quantities by name, with `time` where there is one; non-dimensional, dimensions as in `QUANTITIES`
Results = dict[str, Array]


def radial_weight(radii: Array, average: str, inner_radius: float) -> Array:
    """Return the weight of a radial average at radii: over the radius, or over the area.

    Of a face from an inner radius to 1; in a hole it is 0.
    """
    on_face = radii > inner_radius
    if average == "line":
        return on_face / (1 - inner_radius)
    return on_face * 2 * radii / ((1 - inner_radius) * (1 + inner_radius))


def common(*shapes: tuple[int, ...]) -> tuple[slice, ...]:
    """Return the part that arrays of these shapes have in common.

    Of relaxation times each method may know another number.
    """
    return tuple(slice(0, min(sizes)) for sizes in zip(*shapes, strict=True))


def differences(results: Results, against: Results, face: Face) -> Results:
    """Return the relative difference of every quantity that both have, in its norm.

    Fields are those on the face of the punch.
    """
    return {
        name: _difference(name, results, against, face)
        for name in QUANTITIES
        if name in results and name in against
    }


def answer_differences(answers: Results, against: Results) -> Results:
    """Return the relative difference of every number of the answer that both have, in its norm.

    It is NaN where one of them does not give a number, as closed forms do not give the start.
    """
    compared = {}
    for name, quantity in ANSWER.items():
        if name not in answers or name not in against:
            continue
        value, reference = answers[name], against[name]
        # the rim of a flat punch has an infinite pressure by every method
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
    both = common(value.shape, reference.shape)
    value, reference = value[both], reference[both]
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
        difference = np.abs(value - reference)
        dims = enumerate(QUANTITIES[name].dims)
        over = tuple(axis for axis, dim in dims if dim in ("radius", "ring"))
        difference = difference.max(axis=over, initial=0.0)
        unit = np.ones(())
        # the greatest so far: under a force that falls it comes back
        beyond_touch = np.asarray(against.get("indentation", unit)) - face.standoff
        if beyond_touch.ndim:
            beyond_touch = np.maximum.accumulate(beyond_touch)
        # at a fixed indentation it vanishes: what it was says how much little of it is
        force = np.asarray(against.get("normal_force", unit))
        if force.ndim:
            force = np.maximum.accumulate(force)
        scale = {
            "value": np.abs(reference),
            "indentation": beyond_touch,
            "steady": against.get("steady_displacement_max", unit),
            "force": force,
            "volume": reference.sum(axis=-1),
            "radius": unit,
            "slope": np.abs(reference),
        }[norm]
        if norm == "slope":
            scale = np.maximum(scale, 1e-3 * beyond_touch)
    return np.divide(difference, scale, out=np.zeros(difference.shape), where=scale > 0)
