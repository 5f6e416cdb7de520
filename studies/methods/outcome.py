"""What a method says of a scene: sampled results with their own error estimates. Natural units."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.meshes.radial import Array
from ringwear.studies.methods.model import Model
from ringwear.studies.methods.radial import edge_weight
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.wear.archard import History, Wear
from ringwear.studies.wear.contact import steady_state

if TYPE_CHECKING:
    from ringwear.fem.half_space import HalfSpace


@dataclass(frozen=True, eq=False)
class Outcome:
    """Sampled results of one method; arrays are empty where the scene or the method gives none.

    Histories run over (time), (time, radius) or (time, ring); the steady state over (radius).
    """

    pressure: Array
    profile: Array
    displacement: Array
    indentation: Array
    displacement_centre: Array
    displacement_max: Array
    rms_slope: Array
    ring_force: Array
    relaxation_time: Array
    steady_pressure: Array
    steady_profile: Array
    steady_displacement_max: Array
    steady_rms_slope: Array
    steady_wear_rate: Array


NONE = np.empty(0)
# of the square of the slope that a twin on a coarser mesh misses, this much is missed here: measured on random scenes, 0.03
# to 0.06 where the degree limits the slope, and 0.15 where the element at the rim does
SLOPE_SHARE = 0.31
FIELDS = ("pressure", "profile", "displacement", "ring_force", "steady_pressure", "steady_profile")


class Sampler:
    """Turns coefficients on a pressure space into the results that a scene asks for."""

    def __init__(self, natural: NaturalScene, space: PressureSpace) -> None:
        self.natural, self.space = natural, space
        self._at_radii = space.matrix(natural.radii)
        self._at_centre = space.matrix(np.zeros(1)).toarray()[0]
        self._samples = _extreme_radii(space)
        self._everywhere = space.matrix(self._samples)
        self._slope_everywhere = space.matrix(self._samples, derivative=True)
        self._ring_forces = space.ring_forces(natural.edges)
        self.slopes = space.slope_gram(edge_weight(space, natural.scene.output.gradient_average))

    def _greatest(self, functions: Array) -> Array:
        """(T,) greatest value over the punch of (T, size) functions: the top of a cubic between two samples."""
        samples, slopes = (self._everywhere @ functions.T).T, (self._slope_everywhere @ functions.T).T
        row = np.arange(len(samples))
        best = samples.argmax(axis=1)
        left = np.clip(np.where(slopes[row, best] > 0, best, best - 1), 0, samples.shape[1] - 2)
        width = self._samples[left + 1] - self._samples[left]
        start, rise = samples[row, left], samples[row, left + 1] - samples[row, left]
        first, last = width * slopes[row, left], width * slopes[row, left + 1]
        # start + first t + b t^2 + c t^3 with the end's value and slope; its top where the slope changes sign
        b, c = 3 * rise - 2 * first - last, first + last - 2 * rise
        inside = (first > 0) & (last < 0)
        root = np.sqrt(np.where(inside, b * b - 3 * c * first, 1.0))
        top = np.divide(first, root - b, out=np.zeros(len(row)), where=inside)
        return np.maximum(samples[row, best], start + top * (first + top * (b + top * c)))

    def _rms_slope(self, profile: Array) -> Array:
        # a constant has no slope, but one much greater than the rest would leave its roundoff
        profile = profile - profile[:, :1] * (self.space.order == 1)
        return np.sqrt(np.maximum(np.einsum("ti,ti->t", profile @ self.slopes, profile), 0.0))

    def history(self, history: History) -> dict[str, Array]:
        """The part of an outcome that runs over time."""
        pressure, profile, indentation = history.pressure, history.profile, history.indentation
        worn = (self._at_radii @ profile.T).T
        return {
            "pressure": (self._at_radii @ pressure.T).T,
            "profile": worn,
            "displacement": indentation[:, None] - worn,
            "indentation": indentation,
            "displacement_centre": indentation - profile @ self._at_centre,
            "displacement_max": indentation + self._greatest(-profile),
            "rms_slope": self._rms_slope(profile),
            "ring_force": pressure @ self._ring_forces.T,
        }

    def steady(self, wear: Wear) -> dict[str, Array]:
        """The part of an outcome that belongs to the steady state."""
        state = wear.steady
        greatest = self._greatest(state.displacement[None])
        return {
            "steady_pressure": self._at_radii @ state.pressure,
            "steady_profile": np.maximum(greatest - self._at_radii @ state.displacement, 0.0),
            "steady_displacement_max": greatest,
            "steady_rms_slope": self._rms_slope(state.displacement[None]),
            "steady_wear_rate": np.array([state.wear_rate]),
        }


def _extreme_radii(space: PressureSpace) -> Array:
    """Radii to look for extremes at: enough in each element that a cubic finds the top between them."""
    within = (1 - np.cos(np.pi * np.arange(12) / 12)) / 2
    return np.append((space.breakpoints[:-1, None] + np.diff(space.breakpoints)[:, None] * within).ravel(), 1.0)


class Evaluation:
    """One compliance worn and sampled: everything that the scene asks of it."""

    def __init__(self, natural: NaturalScene, compliance: Compliance) -> None:
        self.wear = Wear(compliance, natural.phases[1], natural.earliest)
        self.sampler = Sampler(natural, compliance.space)
        asked = natural.scene.wear
        parts: dict[str, Array] = {}
        if asked.times:
            parts |= self.sampler.history(self.wear.history(natural.times, asked.march, natural.step))
            parts["relaxation_time"] = self.wear.relaxation_times
        if asked.steady:
            parts |= self.sampler.steady(self.wear)
        self.outcome = outcome(parts)

    def missing_slope(self) -> float:
        """Share of the steady RMS slope that the space misses, from what the space one degree lower misses.

        Projections miss slopes at right angles to what they hold, so the share is half the square of the missing slope:
        unlike a difference of two RMS values it does not cross zero. At ring edges, where slopes have logarithmic
        poles, one degree more helps little: twice the difference of two degrees remains.
        """
        space = self.sampler.space
        lower = steady_state(self.wear.compliance.coarser(), self.wear.wear_coefficients).displacement
        own = self.wear.steady.displacement
        missing = own.copy()
        missing[space.order < np.maximum(space.degree_of_function, 2)] -= lower
        return float(missing @ self.sampler.slopes @ missing / (own @ self.sampler.slopes @ own))

    def missing_in(self, coarser: Evaluation) -> float:
        """Square of the steady slope that another evaluation, on a coarser mesh, misses: over the square of the slope.

        Unlike the difference of two RMS values it does not cross zero.
        """
        space, natural = self.sampler.space, self.sampler.natural
        radii, weights, _ = space.quadrature
        weights = weights * edge_weight(space, natural.scene.output.gradient_average)
        own, other = (
            one.sampler.space.matrix(radii.ravel(), derivative=True) @ one.wear.steady.displacement
            for one in (self, coarser)
        )
        return float(weights.ravel() @ (own - other) ** 2 / (weights.ravel() @ own**2))


def outcome(parts: dict[str, Array]) -> Outcome:
    """An outcome of the given parts, empty elsewhere."""
    return Outcome(**{field.name: parts.get(field.name, NONE) for field in fields(Outcome)})


def from_direct_integration(natural: NaturalScene) -> tuple[Outcome, Outcome]:
    """The steady state in closed form, and its relative error estimates: roundoff, and quadrature of the gradient."""
    from ringwear.mdr import direct

    edges, wear = natural.phases
    pressures = direct.steady_pressures(edges, wear)
    radii = natural.radii
    ring = np.clip(np.searchsorted(edges, radii, side="right") - 1, 0, len(wear) - 1)
    average = natural.scene.output.gradient_average
    greatest = direct.greatest_displacement(edges, pressures)
    gradient = direct.rms_slope(edges, pressures, average)
    parts = {
        "steady_pressure": pressures[ring],
        "steady_profile": np.maximum(greatest - direct.displacement(edges, pressures, radii), 0.0),
        "steady_displacement_max": np.array([greatest]),
        "steady_rms_slope": np.array([gradient]),
        "steady_wear_rate": wear[:1] * pressures[:1],
    }
    # a narrow ring of high pressure is the small difference of two discs
    steps = np.abs(direct.pressure_steps(pressures))
    roundoff = 1e-12 + 4 * np.finfo(float).eps * float(steps @ edges[1:]) / greatest
    return outcome(parts), outcome({name: np.full_like(value, roundoff) for name, value in parts.items()})


def estimated(natural: NaturalScene, model: Model) -> tuple[Outcome, Outcome, dict[str, float], Wear]:
    """Outcome of a model, the relative error estimate of each number, of the indentation by part, and the wear."""
    cache: dict[int, Evaluation] = {}

    def evaluate(compliance: Compliance) -> Evaluation:
        if id(compliance) not in cache:
            cache[id(compliance)] = Evaluation(natural, compliance)
        return cache[id(compliance)]

    result = evaluate(model.compliance)
    errors = {field.name: np.zeros_like(getattr(result.outcome, field.name)) for field in fields(Outcome)}
    by_part = {}
    for twin in model.twins:
        finer, coarser = evaluate(twin.finer), evaluate(twin.coarser)
        differences = {
            name: relative_difference(name, getattr(coarser.outcome, name), getattr(finer.outcome, name)) for name in errors
        }
        if natural.scene.wear.steady and twin.other_mesh:
            # where the slope is smooth, the plain difference is the greater
            plain = 1.5 / SLOPE_SHARE * differences["steady_rms_slope"]
            differences["steady_rms_slope"] = np.maximum(plain, finer.missing_in(coarser))
        # on one mesh half of the difference counts for slopes of the steady state, which have an estimate of their own below
        of_slope = SLOPE_SHARE if twin.other_mesh else 0.5 * twin.field_share
        for name, difference in differences.items():
            share = {"indentation": twin.share, "steady_rms_slope": of_slope}.get(name, twin.field_share)
            # of modes, each may know another number
            known = tuple(slice(0, min(sizes)) for sizes in zip(difference.shape, errors[name].shape, strict=True))
            errors[name][known] += share * _over_neighbours(name, difference[known])
        by_part[twin.part] = twin.share * float(differences["indentation"].max(initial=0.0))
    _no_better_than_fields(errors)
    if natural.scene.wear.times:
        # the first element at the rim cannot hold the singular pressure of the flat start, whatever its degree
        start = natural.times == 0
        errors["indentation"][start] = np.maximum(errors["indentation"][start], model.rim_cost)
    if natural.scene.wear.march != "modal" and natural.scene.wear.times:
        exact = result.sampler.history(result.wear.modal(natural.times))
        for name, value in exact.items():
            errors[name] += relative_difference(name, getattr(result.outcome, name), value)
        by_part["time step"] = float(
            relative_difference("indentation", result.outcome.indentation, exact["indentation"]).max()
        )
    other_mesh = any(twin.other_mesh for twin in model.twins)
    if natural.scene.wear.steady and not other_mesh:
        errors["steady_rms_slope"] = np.maximum(errors["steady_rms_slope"], result.missing_slope())
    if natural.scene.wear.steady and model.half_space is not None and not other_mesh:
        _projection_loss(errors, result, model.half_space, natural.scene.output.gradient_average)
    floor = 1e-14 * max(1, len(model.compliance.space.breakpoints))
    return result.outcome, Outcome(**{name: value + floor for name, value in errors.items()}), by_part, result.wear


def _no_better_than_fields(errors: dict[str, Array]) -> None:
    """A displacement at one place may agree by chance: its error is at least a tenth of that of the whole field."""
    for single, whole in (
        ("displacement_centre", "displacement"),
        ("displacement_max", "displacement"),
        ("steady_displacement_max", "steady_profile"),
    ):
        if errors[single].size and errors[whole].size:
            errors[single] = np.maximum(errors[single], 0.1 * errors[whole].max(axis=-1))


def _projection_loss(errors: dict[str, Array], result: Evaluation, half_space: HalfSpace, average: str) -> None:
    """Add what the pressure space loses of the contact displacement that the elements found, and of its slope."""
    steady, space = result.wear.steady, result.sampler.space
    ends = np.linspace(0, 1, space.top + 2)
    radii, found, _ = half_space.contact_displacement(steady.pressure, ends)
    held = (space.on_elements(2 * ends - 1) @ steady.displacement).reshape(radii.shape)
    lost = np.abs(found - held).max() / found.max()
    errors["steady_displacement_max"] = errors["steady_displacement_max"] + lost
    local, weight = leggauss(space.top + 2)
    radii, _, slopes = half_space.contact_displacement(steady.pressure, (1 + local) / 2)
    weights = np.diff(space.breakpoints)[:, None] * weight / 2 * (1.0 if average == "line" else 2 * radii)
    trace = np.sqrt(np.sum(weights * slopes**2))
    errors["steady_rms_slope"] = errors["steady_rms_slope"] + np.abs(trace / result.outcome.steady_rms_slope - 1)


def _over_neighbours(name: str, difference: Array) -> Array:
    """Histories: the greatest of each time and its neighbours, at least a third of the greatest of all.

    The difference of two histories crosses zero now and then, where it says nothing about the error.
    """
    if name.startswith("steady") or name == "relaxation_time" or not len(difference):
        return difference
    padded = np.concatenate([difference[:1], difference, difference[-1:]])
    near = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    return np.maximum(near, difference.max(axis=0) / 3)


def relative_difference(name: str, value: Array, against: Array) -> Array:
    """Relative difference; of fields over the radius or the rings, the greatest over the greatest value at that time."""
    common = tuple(slice(0, min(a, b)) for a, b in zip(value.shape, against.shape, strict=True))
    value, against = value[common], against[common]
    difference = np.abs(value - against)
    scale = np.abs(against)
    if name in FIELDS:
        difference = np.broadcast_to(difference.max(axis=-1, keepdims=True, initial=0.0), difference.shape)
        scale = np.broadcast_to(scale.max(axis=-1, keepdims=True, initial=0.0), scale.shape)
    return np.divide(difference, scale, out=np.zeros(difference.shape), where=scale > 0)
