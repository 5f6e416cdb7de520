"""What a method says of a scene: sampled results with their own error estimates. Natural units."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from meshes.compliance import Compliance
from meshes.radial import Array, PressureSpace

from .methods import Model, edge_weight
from .scene import NaturalScene
from .wear import History, Wear


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
CONVERGE_TWICE_AS_FAST = ("indentation", "relaxation_time", "steady_displacement_max")
HEADLINE = ("indentation", "steady_displacement_max")
FIELDS = ("pressure", "profile", "displacement", "ring_force", "steady_pressure", "steady_profile")


class Sampler:
    """Turns coefficients on a pressure space into the results that a scene asks for."""

    def __init__(self, natural: NaturalScene, space: PressureSpace) -> None:
        self.natural, self.space = natural, space
        self._at_radii = space.matrix(natural.radii)
        self._at_centre = space.matrix(np.zeros(1))[0]
        # extremes of a profile: its vertices, and points inside each element
        inside = space.breakpoints[:-1, None] + np.diff(space.breakpoints)[:, None] * np.array([0.0, 0.25, 0.5, 0.75])
        self._everywhere = space.matrix(np.append(inside.ravel(), 1.0))
        self._ring_forces = space.ring_forces(natural.edges)
        self._slopes = space.slope_gram(edge_weight(space, natural.scene.output.gradient_average))

    def _rms_slope(self, profile: Array) -> Array:
        return np.sqrt(np.maximum(np.einsum("ti,ti->t", profile @ self._slopes, profile), 0.0))

    def history(self, history: History) -> dict[str, Array]:
        """The part of an outcome that runs over time."""
        pressure, profile, indentation = history.pressure, history.profile, history.indentation
        worn = profile @ self._at_radii.T
        return {
            "pressure": pressure @ self._at_radii.T,
            "profile": worn,
            "displacement": indentation[:, None] - worn,
            "indentation": indentation,
            "displacement_centre": indentation - profile @ self._at_centre,
            "displacement_max": indentation - (profile @ self._everywhere.T).min(axis=1),
            "rms_slope": self._rms_slope(profile),
            "ring_force": pressure @ self._ring_forces.T,
        }

    def steady(self, wear: Wear) -> dict[str, Array]:
        """The part of an outcome that belongs to the steady state."""
        state = wear.steady
        greatest = (self._everywhere @ state.displacement).max()
        return {
            "steady_pressure": self._at_radii @ state.pressure,
            "steady_profile": np.maximum(greatest - self._at_radii @ state.displacement, 0.0),
            "steady_displacement_max": np.array([greatest]),
            "steady_rms_slope": self._rms_slope(state.displacement[None]),
            "steady_wear_rate": np.array([state.wear_rate]),
        }


def from_compliance(natural: NaturalScene, compliance: Compliance) -> Outcome:
    """Everything that the scene asks of one compliance."""
    wear = Wear(compliance, natural.phases[1])
    sampler = Sampler(natural, compliance.space)
    asked = natural.scene.wear
    parts: dict[str, Array] = {}
    if asked.times:
        parts |= sampler.history(wear.history(natural.times, asked.march, natural.step))
        parts["relaxation_time"] = wear.relaxation_times
    if asked.steady:
        parts |= sampler.steady(wear)
    return outcome(parts)


def outcome(parts: dict[str, Array]) -> Outcome:
    """An outcome of the given parts, empty elsewhere."""
    return Outcome(**{field.name: parts.get(field.name, NONE) for field in fields(Outcome)})


def from_direct_integration(natural: NaturalScene) -> tuple[Outcome, Outcome]:
    """The steady state in closed form, and its relative error estimates: roundoff, and quadrature of the gradient."""
    from mdr import direct

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
    roundoff = 1e-12
    return outcome(parts), outcome({name: np.full_like(value, roundoff) for name, value in parts.items()})


def estimated(natural: NaturalScene, model: Model) -> tuple[Outcome, Outcome, dict[str, float]]:
    """Outcome of a model, the relative error estimate of each of its numbers, and of the indentation by part."""
    cache: dict[int, Outcome] = {}

    def evaluate(compliance: Compliance) -> Outcome:
        if id(compliance) not in cache:
            cache[id(compliance)] = from_compliance(natural, compliance)
        return cache[id(compliance)]

    result = evaluate(model.compliance)
    errors = {field.name: np.zeros_like(getattr(result, field.name)) for field in fields(Outcome)}
    by_part = {}
    for twin in model.twins:
        finer, coarser = evaluate(twin.finer), evaluate(twin.coarser)
        differences = {name: relative_difference(name, getattr(coarser, name), getattr(finer, name)) for name in errors}
        for name, difference in differences.items():
            share = twin.share if name in CONVERGE_TWICE_AS_FAST else twin.field_share
            errors[name][tuple(slice(0, size) for size in difference.shape)] += share * _over_neighbours(name, difference)
        by_part[twin.part] = twin.share * max(float(differences[name].max(initial=0.0)) for name in HEADLINE)
    floor = 1e-14 * max(1, len(model.compliance.space.breakpoints))
    return result, Outcome(**{name: value + floor for name, value in errors.items()}), by_part


def _over_neighbours(name: str, difference: Array) -> Array:
    """Histories: the greatest of each time and its neighbours, at least a tenth of the greatest of all.

    The difference of two histories crosses zero now and then, where it says nothing about the error.
    """
    if name.startswith("steady") or name == "relaxation_time" or not len(difference):
        return difference
    padded = np.concatenate([difference[:1], difference, difference[-1:]])
    near = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    return np.maximum(near, 0.1 * difference.max(axis=0))


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
