"""What a method's results are worth, by its own account: finer against coarser computations, and safety factors.

A pair of compliances differs in one thing: the highest pressure bubbles, the degree of the displacement (and a layer of
the mesh), the last far-field pole. The difference that this makes to a quantity, times a safety factor, is one part of its
relative error. Safety factors below one stand where the coarser computation is known to be many times worse than the
finer. `ringwear study estimates` compares true errors with estimates on scenes drawn at random.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray
from numpy.polynomial.legendre import leggauss

from ringwear.meshes.compliance import Compliance
from ringwear.meshes.radial import Array
from ringwear.studies.methods.quantities import QUANTITIES, array, common, relative_difference, with_errors
from ringwear.studies.methods.sampler import Evaluation, radial_weight
from ringwear.studies.problem.problem import Problem
from ringwear.studies.problem.sections import FemAccuracy
from ringwear.studies.wear.contact import steady_state

if TYPE_CHECKING:
    from ringwear.fem.half_space import HalfSpace


class Safety(NamedTuple):
    """Safety factors: of the indentation, which converges twice as fast, and of everything else."""

    indentation: float
    fields: float

    def of(self, quantity: str) -> float:
        return self.indentation if quantity == "indentation" else self.fields


RADIAL = Safety(0.3, 2.0)
# where nothing is left to coarsen, the pair is finer than the result, and the difference the error itself
RADIAL_FINER = Safety(1.5, 2.0)
QUAD_MULTIPLIERS = Safety(0.05, 0.5)
# a degree takes the error down tenfold, but only twofold where elements grow away from much smaller patches
QUADS, QUADS_OF_UNLIKE_RINGS = Safety(0.55, 2.0), Safety(2.5, 2.0)
ALIKE = 10.0  # rings whose widths differ by less
TRIANGLE_MULTIPLIERS, TRIANGLES, TRIANGLES_FINER = Safety(1.2, 5.0), Safety(0.6, 1.0), Safety(1.2, 3.0)
# with half the springs and twice the step, what is of first order doubles; slopes and jumps at ring edges are of half that
GRID = Safety(1.5, 2.5)
# of the square of the slope that a coarser mesh misses, this much is missed by the finer
OF_SLOPE, OF_SLOPE_DIFFERENCE = 0.31, 1.5
# fraction of d0 that the element at the rim costs, over its size and times its degree: it cannot hold a pressure that is
# infinite. Measured for degree 1, 2, 4 and 7: 0.05, 0.023, 0.009 and 0.004
AT_RIM = 0.055


def of_quads(widths: Array) -> Safety:
    """Safety factors of quadrilaterals under rings of given widths."""
    return QUADS if np.ptp(np.log(widths)) <= np.log(ALIKE) else QUADS_OF_UNLIKE_RINGS


def of_triangles(growth: float, safety: Safety) -> Safety:
    """On finer triangles one degree less costs ever more: of a difference in indentation, less remains."""
    return Safety(safety.indentation * min(1.0, (growth / 0.75) ** 3), safety.fields)


def of_truncation(chosen: FemAccuracy, truncation: float) -> Safety:
    """Each pole takes the truncation error down by four orders in a/R (`ringwear study truncation`)."""
    factor = 1.1 if chosen.far_field == "fixed" else 2 / truncation**4
    return Safety(factor, factor)


@dataclass(frozen=True, eq=False)
class Pair:
    """A finer and a coarser computation, whose difference estimates one part of the error.

    Parameters
    ----------
    part : what differs
    finer, coarser : the pair
    safety : factors on their difference
    other_mesh : whether they differ in their meshes, too, and so tell what projections on the pressure space lose
    """

    part: str
    finer: Compliance
    coarser: Compliance
    safety: Safety
    other_mesh: bool = False


def estimated(
    problem: Problem, compliance: Compliance, pairs: tuple[Pair, ...], half_space: "HalfSpace | None" = None
) -> tuple[Evaluation, xarray.Dataset, dict[str, float]]:
    """Evaluate a compliance; its results with errors beside them, and the error of the indentation by part."""
    cache: dict[int, Evaluation] = {}

    def evaluated(one: Compliance) -> Evaluation:
        if id(one) not in cache:
            cache[id(one)] = Evaluation(problem, one)
        return cache[id(one)]

    result = evaluated(compliance)
    errors = {str(name): np.zeros(value.shape) for name, value in result.results.variables.items()}
    parts: dict[str, float] = {}
    for pair in pairs:
        parts[pair.part] = _add_difference(errors, pair, evaluated(pair.finer), evaluated(pair.coarser))
    _no_better_than_fields(errors)
    if len(problem.times):
        # at the flat start the element at the rim alone costs so much, whatever the rest
        rim = AT_RIM / int(compliance.space.degrees[-1]) * float(np.diff(compliance.space.breakpoints)[-1])
        start = problem.times == 0
        errors["indentation"][start] = np.maximum(errors["indentation"][start], rim)
    if len(problem.times) and problem.march != "modal":
        exact = result.sampler.history(result.wear.modal(problem.times))
        for name, value in exact.items():
            errors[name] += relative_difference(name, array(result.results, name), value)
        stepped = array(result.results, "indentation")
        parts["time step"] = float(relative_difference("indentation", stepped, exact["indentation"]).max())
    if problem.steady and not any(pair.other_mesh for pair in pairs):
        errors["steady_rms_slope"] = np.maximum(errors["steady_rms_slope"], _missing_slope(result))
        if half_space is not None:
            _add_projection_loss(errors, result, half_space)
    floor = 1e-14 * max(1, len(compliance.space.breakpoints))
    stated = with_errors(result.results, {name: value + floor for name, value in errors.items()})
    return result, stated, parts


def _add_difference(errors: dict[str, Array], pair: Pair, finer: Evaluation, coarser: Evaluation) -> float:
    """Add a pair's part to the errors; returns that of the indentation."""
    safety = {name: pair.safety.of(name) for name in errors}
    differences = {
        name: relative_difference(name, array(coarser.results, name), array(finer.results, name)) for name in errors
    }
    if "steady_rms_slope" in errors:
        # on one mesh half of the difference counts: a part of its own is added for what the space misses
        safety["steady_rms_slope"] = OF_SLOPE if pair.other_mesh else 0.5 * pair.safety.fields
        if pair.other_mesh:
            # where the slope is smooth, the plain difference is the greater
            plain = OF_SLOPE_DIFFERENCE / OF_SLOPE * differences["steady_rms_slope"]
            differences["steady_rms_slope"] = np.maximum(plain, _missing_in(finer, coarser))
    for name, difference in differences.items():
        # of modes, each may know another number
        known = common(difference.shape, errors[name].shape)
        errors[name][known] += safety[name] * over_neighbours(name, difference[known])
    return pair.safety.indentation * float(np.max(differences.get("indentation", 0.0), initial=0.0))


def _missing_slope(result: Evaluation) -> float:
    """Fraction of the steady RMS slope that the space misses, from what the space one degree lower misses.

    Projections miss slopes at right angles to what they hold, so the fraction is half the square of the missing slope:
    unlike a difference of two RMS values it does not cross zero. At ring edges, where slopes have logarithmic
    poles, one degree more helps little: twice the difference of two degrees remains.
    """
    space, gram = result.sampler.space, result.sampler.slopes
    lower = steady_state(result.wear.compliance.coarser(), result.wear.wear_coefficients).displacement
    own = result.wear.steady.displacement
    missing = own.copy()
    missing[space.order < np.maximum(space.degree_of_function, 2)] -= lower
    return float(missing @ gram @ missing / (own @ gram @ own))


def _missing_in(finer: Evaluation, coarser: Evaluation) -> float:
    """Square of the steady slope that a computation on a coarser mesh misses, over the square of the slope.

    Unlike the difference of two RMS values it does not cross zero.
    """
    space = finer.sampler.space
    radii, weights, _ = space.quadrature
    weights = weights * radial_weight(radii, finer.problem.gradient_average)
    own, other = (
        one.sampler.space.matrix(radii.ravel(), derivative=True) @ one.wear.steady.displacement for one in (finer, coarser)
    )
    return float(weights.ravel() @ (own - other) ** 2 / (weights.ravel() @ own**2))


def _no_better_than_fields(errors: dict[str, Array]) -> None:
    """A displacement at one place may agree by chance: its error is at least a tenth of that of the whole field."""
    for single, whole in (
        ("displacement_centre", "displacement"),
        ("displacement_max", "displacement"),
        ("steady_displacement_max", "steady_profile"),
    ):
        if single in errors:
            errors[single] = np.maximum(errors[single], 0.1 * errors[whole].max(axis=-1))


def _add_projection_loss(errors: dict[str, Array], result: Evaluation, half_space: "HalfSpace") -> None:
    """Add what the pressure space loses of the elements' contact displacement, and of its slope."""
    steady, space = result.wear.steady, result.sampler.space
    ends = np.linspace(0, 1, space.top + 2)
    radii, displacement, _ = half_space.contact_displacement(steady.pressure, ends)
    held = (space.on_elements(2 * ends - 1) @ steady.displacement).reshape(radii.shape)
    lost = np.abs(displacement - held).max() / displacement.max()
    errors["steady_displacement_max"] = errors["steady_displacement_max"] + lost
    local, weight = leggauss(space.top + 2)
    radii, _, slopes = half_space.contact_displacement(steady.pressure, (1 + local) / 2)
    weights = np.diff(space.breakpoints)[:, None] * weight / 2 * radial_weight(radii, result.problem.gradient_average)
    trace = np.sqrt(np.sum(weights * slopes**2))
    slope = float(array(result.results, "steady_rms_slope"))
    errors["steady_rms_slope"] = errors["steady_rms_slope"] + abs(trace / slope - 1)


def over_neighbours(name: str, difference: Array) -> Array:
    """Histories: the greatest of each time and its neighbours, at least a third of the greatest of all.

    The difference of two histories crosses zero now and then, where it says nothing about the error.
    """
    if QUANTITIES[name].dims[:1] != ("time",) or not len(difference):
        return difference
    padded = np.concatenate([difference[:1], difference, difference[-1:]])
    near = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    return np.maximum(near, difference.max(axis=0) / 3)
