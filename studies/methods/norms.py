"""Values of quantities, and their differences in the norms that these have."""

import numpy as np

from ...meshes.radial import Array
from ..problem.face import Face
from ..problem.quantities import QUANTITIES

# quantities by name, with `time` where there is one; non-dimensional, dimensions as in `QUANTITIES`
Results = dict[str, Array]


def radial_weight(radii: Array, average: str) -> Array:
    """Weight of a radial average at radii: over the radius, or over the area."""
    return np.ones_like(radii) if average == "line" else 2 * radii


def common(*shapes: tuple[int, ...]) -> tuple[slice, ...]:
    """The part that arrays of these shapes have in common.

    Of relaxation times each method may know another number.
    """
    return tuple(slice(0, min(sizes)) for sizes in zip(*shapes, strict=True))


def differences(results: Results, against: Results, face: Face) -> Results:
    """Relative difference of every quantity that both have, in its norm.

    Fields are those on the face of the punch.
    """
    return {
        name: _difference(name, results, against, face)
        for name in QUANTITIES
        if name in results and name in against
    }


def _difference(name: str, results: Results, against: Results, face: Face) -> Array:
    value, reference = results[name], against[name]
    both = common(value.shape, reference.shape)
    value, reference = value[both], reference[both]
    norm = QUANTITIES[name].norm
    if norm == "pressure":
        weights = face.weights
        if "time" in QUANTITIES[name].dims:
            pressed = against.get("pressed", against["time"] == 0)
            weights = weights * np.where(pressed[:, None], (1 - face.radii) * (1 + face.radii), 1.0)
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
        scale = {
            "value": np.abs(reference),
            "indentation": beyond_touch,
            "steady": against.get("steady_displacement_max", unit),
            "force": against.get("normal_force", unit),
            "volume": reference.sum(axis=-1),
            "radius": unit,
            "slope": np.abs(reference),
        }[norm]
        if norm == "slope":
            scale = np.maximum(scale, 1e-3 * beyond_touch)
    return np.divide(difference, scale, out=np.zeros(difference.shape), where=scale > 0)
