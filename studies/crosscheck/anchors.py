"""What no method can move.

Closed forms and balances that its *reported* results are held to, each method by itself.

They take the dataset that is written, made non-dimensional by the numbers of the scene itself, so
that what is scaled, sampled or derived on the way shows, too, and what all methods share. Fields
over the whole face stand beside it, of which the dataset has some radii.

A flat start is closed form (Eqs. 10, 11), and so is the steady state (Eqs. 21 to 27). In between
hold, with ``F = 1``,

    F = int p dA                                     and the same on each ring F v0 t = int f / k dA
    what is worn is what pressure has worn d = d0 + int f p0 dA
    reciprocity with the flat punch, u0 = d0 d = int us p dA + int f ps dA
    reciprocity with the steady pressures ps, of closed-form us d'(2 t) = int k p^2 dA
    power; by the symmetry of compliance and wear, from a flat start
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray

from ...mdr import direct
from ...meshes.radial import Array, ring_of
from ..methods.base import Solution
from ..methods.quantities import ANSWER, FIELDS, QUANTITIES, array, radial_weight
from ..problem.problem import D0, P0, Problem
from ..problem.scene import Scene
from ..wear.time_scale import COARSE, FINE, slowest_relaxation_time
from .known import energy_of_rings, natural_units, steady_state

if TYPE_CHECKING:
    from ..problem.face import Face
    from ..wear.full_contact import History

# of sums and of closed forms to roundoff, where the accuracy asked for has no say
EXACT = 1e-9
# times at which the balance of power is looked at, and the step that d is differentiated by, over
# the time
POWER_TIMES, POWER_STEP = 6, 0.005
# roundoff of d, which differences of it over short times have
ROUNDOFF_OF_D = 1e-14
# the difference of what is no number, which JSON cannot hold
NO_NUMBER = 1e99
# doubt of slopes on the face beyond which they tell nothing
UNTOLD = 0.1
# times the doubt of a quadrature or an interpolation on the face that its error may be
DOUBT = 10.0


@dataclass(frozen=True)
class Anchor:
    """A closed form or a balance that a method is held to.

    Relative difference and what is tolerated.
    """

    name: str
    method: str
    difference: float
    tolerance: float

    @property
    def holds(self) -> bool:
        return bool(self.difference <= self.tolerance)


def anchors(scene: Scene, name: str, dataset: xarray.Dataset, solution: Solution) -> list[Anchor]:
    """Hold a method to all that applies to what it reports.

    Parameters
    ----------
    scene : what was asked for
    name : of the method
    dataset : what is written of it, in the scene's units
    solution : what the method said of the face, and of its own errors
    """
    held = _Anchors(scene, dataset, solution)
    return [Anchor(what, name, *worst) for what, worst in held.all() if np.isfinite(worst[1])]


Worst = tuple[str, tuple[float, float]]


class _Anchors:
    """The anchors of one method.

    Pairs of a name, and the difference and the tolerance where it is worst.
    """

    def __init__(self, scene: Scene, dataset: xarray.Dataset, solution: Solution) -> None:
        self.solution = solution
        self.problem: Problem = scene.problem
        self.face: Face = self.problem.face
        units = natural_units(scene)
        self.times = dataset["time"].values / units.time
        self.radii = dataset["radius"].values / units.length
        self._dataset, self._units = dataset, units

    def _reported(self, name: str) -> Array:
        """Return a variable of the dataset, non-dimensional."""
        kind = (QUANTITIES | ANSWER)[name].unit
        return np.asarray(self._dataset[name].values / getattr(self._units, kind))

    def _gives(self, *names: str) -> bool:
        return all(name in self.solution.checked for name in names)

    def _checked(self, name: str) -> Array:
        """Return a quantity at the times that are checked.

        Fields over the face, numbers as they are reported.
        """
        if name in FIELDS:
            return array(self.solution.checked, name)
        return self._reported(name)[self.problem.checked]

    def _tolerated(self, name: str) -> Array:
        """Return the accuracy asked for.

        Infinity where the method states more, and is held to nothing.
        """
        rtol = max(self.problem.rtol, EXACT)
        return np.where(self.solution.checked_error(self.problem, name) > rtol, np.inf, rtol)

    def all(self) -> Iterator[Worst]:
        history = len(self.times) > 0 and self._gives("indentation")
        if history:
            yield from self._of_forces()
        if not self.problem.full_contact:
            yield from self._of_profile() if history else ()
        elif history:
            yield from self._of_start()
            yield from self._of_wear()
            yield from self._of_fields()
            yield from self._of_modes()
        if self._gives("steady_wear_rate"):
            yield from self._of_steady_state()
        if self.solution.wear is not None and self.problem.full_contact:
            yield from self._of_compliance()

    def _of_forces(self) -> Iterator[Worst]:
        forces, pressure = self._checked("ring_force"), self._checked("pressure")
        whole = forces.sum(axis=1)
        if self.problem.indentation is None:
            tolerance = np.maximum(self.solution.checked_error(self.problem, "ring_force"), EXACT)
            yield "ring forces add up to F", _worst(np.abs(whole - 1), tolerance)
        rings = self.face.ring_sums(self.face.areas * pressure)
        tolerance = self._tolerated("pressure") * whole + self._doubt(self.face.areas * pressure)
        wrong = np.abs(rings - forces).max(axis=1)
        yield "ring forces are integrals of the pressure", _worst(wrong, tolerance)

    def _doubt(self, parts: Array) -> Array:
        """Return what a sum over the face may differ from its integral."""
        return DOUBT * self.face.integral_doubt(parts)

    def _of_profile(self) -> Iterator[Worst]:
        """Return what holds while contact opens, closes and spreads."""
        later = self.times[self.problem.checked] > 0
        if self.problem.indentation is None and later.any():
            worn = self._checked("ring_worn_volume")[later] @ (1 / self.problem.wear_coefficients)
            wrong = np.abs(worn / self.times[self.problem.checked][later] - 1)
            yield "worn volume over k, F v0 t", _worst(wrong, np.full(len(wrong), EXACT))

    def _of_start(self) -> Iterator[Worst]:
        edges = self.problem.ring_edges
        if self.times[0] == 0:
            tolerance = self._tolerated("indentation")[:1]
            wrong = np.abs(self._reported("indentation")[:1] / D0 - 1)
            yield "flat start, d = F / (2 a E*)", _worst(wrong, tolerance)
            tolerance = self._tolerated("pressure")[:1]
            inside = self.radii < 1
            known = _flat_pressure(self.radii[inside])
            wrong = np.abs(self._reported("pressure")[0, inside] / known - 1).max(initial=0.0)
            yield "flat start, p = p0 / sqrt(1 - r^2/a^2)", _worst(wrong, tolerance)
            known = -np.diff(np.sqrt((1 - edges) * (1 + edges)))
            wrong = np.abs(self._reported("ring_force")[0] - known).max()
            tolerance = self._tolerated("ring_force")[:1]
            yield "flat start, forces of the rings", _worst(wrong, tolerance)
        if self.solution.wear is None:
            return
        wrong = np.abs(self._reported("indentation_start") / D0 - 1)
        yield "flat start of the answer", _worst(wrong, self._tolerated("indentation").max())
        known = _flat_pressure(edges[:-1])
        wrong = np.abs(self._reported("pressure_min")[0] / known - 1).max()
        wrong = np.maximum(
            wrong, np.abs(self._reported("pressure_max")[0, :-1] / known[1:] - 1).max(initial=0.0)
        )
        yield (
            "flat start of the answer, pressures",
            _worst(wrong, self._tolerated("pressure").max()),
        )

    def _of_wear(self) -> Iterator[Worst]:
        """Return what is worn, over all of the face."""
        times, face = self.times[self.problem.checked], self.face
        profile, depth = self._checked("profile"), self._checked("indentation")
        later = times > 0
        if not later.any():
            return
        by_wear = face.areas / face.wear
        wrong = np.abs(profile[later] @ by_wear / times[later] - 1)
        # the profile is promised relative to the indentation
        lost = (self._tolerated("profile") * depth)[later] * by_wear.sum()
        lost += self._doubt(profile[later] * by_wear)
        tolerance = np.maximum(lost / times[later], self.problem.rtol)
        yield "worn volume over k, F v0 t", _worst(wrong, tolerance)
        if np.isfinite(worn := self._reported("worn_volume")).all():
            wrong = np.abs((worn / self.problem.wear_coefficients).sum() / self.times[-1] - 1)
            yield "worn volume of the answer over k, F v0 t", _worst(wrong, tolerance[-1:])
        flat = _flat_pressure(face.radii) * face.areas
        steady = steady_state(self.problem)
        by_flat = D0 + profile @ flat
        stated = np.maximum(self._tolerated("indentation"), self._tolerated("profile"))
        tolerance = stated + self._doubt(profile * flat) / depth
        yield "reciprocity with the flat punch", _worst(np.abs(by_flat / depth - 1), tolerance)
        pressure = self._checked("pressure")
        moved = steady.displacement * face.areas
        by_steady = pressure @ moved + profile @ (steady.pressure * face.areas)
        tolerance = np.maximum(stated, self._tolerated("pressure"))
        tolerance = tolerance + self._doubt(pressure * moved) / depth
        yield "reciprocity with the steady state", _worst(np.abs(by_steady / depth - 1), tolerance)

    def _of_fields(self) -> Iterator[Worst]:
        """Return what is read off fields."""
        face, depth = self.face, self._checked("indentation")
        profile, moved = self._checked("profile"), self._checked("displacement")
        wrong = np.abs(moved + profile - depth[:, None]).max(axis=1) / depth
        yield (
            "displacement, u = d - f",
            _worst(wrong, np.full(len(wrong), max(self.problem.rtol, EXACT))),
        )
        centre, doubt = face.interpolate(moved, np.zeros(1))
        wrong = np.abs(self._checked("displacement_centre") - centre[:, 0]) / depth
        tolerance = self._tolerated("displacement_centre") + DOUBT * doubt[:, 0] / depth
        yield "displacement at the centre", _worst(wrong, tolerance)
        greatest, spread = _greatest(moved)
        wrong = np.abs(self._checked("displacement_max") - greatest) / depth
        tolerance = self._tolerated("displacement_max") + spread / depth
        yield "greatest displacement", _worst(wrong, tolerance)
        yield from self._of_slopes(profile)
        # not at the rim, where pressures of the start are infinite
        inside = self.radii < self.face.breakpoints[-2]
        later = self.times[self.problem.checked] > 0
        for name in ("pressure", "profile", "displacement"):
            values = self._checked(name)[later]
            if not values.size:
                continue
            size = np.abs(values).max(axis=1) if name == "pressure" else depth[later]
            found, doubt = face.interpolate(values, self.radii[inside])
            reported = self._reported(name)[self.problem.checked][later][:, inside]
            # in the mean: pressures of elements have kinks of their own
            wrong, doubt = (
                np.sqrt((one**2).mean(axis=1)) / size for one in (found - reported, doubt)
            )
            tolerance = self._tolerated(name)[later] + DOUBT * doubt
            yield f"{name} at the radii reported", _worst(wrong, tolerance)

    def _of_slopes(self, profile: Array) -> Iterator[Worst]:
        known = np.isfinite(self._tolerated("rms_slope")) & (self._checked("rms_slope") > 0)
        if not known.any():
            return
        weights = radial_weight(self.face.radii, self.problem.gradient_average) * self.face.lengths
        slopes, fewer = (np.sqrt(one**2 @ weights) for one in self.face.slopes(profile[known]))
        reported = self._checked("rms_slope")[known]
        # it crosses zero now and then in time
        doubt = DOUBT * np.max(np.abs(slopes - fewer) / reported)
        if doubt > UNTOLD:
            return
        wrong = np.abs(slopes / reported - 1)
        yield "RMS slope of the profile", _worst(wrong, self.problem.rtol + doubt)

    def _of_modes(self) -> Iterator[Worst]:
        """Return what the law of wear asks of the running-in."""
        wear, problem = self.solution.wear, self.problem
        times = self.times[problem.checked]
        later = np.flatnonzero(times > 0)
        if wear is None or not len(later):
            return
        slowest = self._reported("relaxation_time")[0]
        coarse, known = (slowest_relaxation_time(problem.rings, sizes) for sizes in (COARSE, FINE))
        tolerance = self._tolerated("relaxation_time")[0] + DOUBT * abs(coarse / known - 1)
        yield (
            "slowest relaxation time, by a small problem of its own",
            _worst(abs(slowest / known - 1), tolerance),
        )
        yield "modes add up to the flat start", _worst(abs(wear.share_of_modes - 1), EXACT)
        if problem.march != "modal":
            return
        later = later[np.isfinite(self._tolerated("pressure")[later])]
        if not len(later):
            return
        chosen = later[np.unique(np.linspace(0, len(later) - 1, POWER_TIMES).round().astype(int))]
        pressure, stated = self._checked("pressure")[chosen], self._tolerated("pressure")[chosen]
        yield "power, F d'(2t) = int k p^2 dA", self._power(times[chosen], pressure, stated, False)
        # what is left of the running-in is then most of it the slowest mode, and is looked at alone
        half = np.array([max(slowest / 2, problem.earliest)])
        of_slowest = self._power(half, self._at(half), stated[-1:], True)
        yield "power of the slowest mode", of_slowest

    def _power(
        self, times: Array, pressure: Array, stated: Array, alone: bool
    ) -> tuple[float, float]:
        """Return how far power is out of balance at times, over all of it or over what is not yet
        steady alone.
        """
        wear, steady, face = self.solution.wear, steady_state(self.problem), self.face
        assert wear is not None
        parts = (pressure - steady.pressure) ** 2 * face.weights
        spent = parts.sum(axis=1)
        scale = spent if alone else spent + steady.wear_rate
        risen = _slopes_of(wear.modal, 2 * times) - steady.wear_rate
        tolerance = (
            self.problem.rtol + 2 * stated * np.sqrt((spent + steady.wear_rate) * spent) / scale
        )
        tolerance += (self._doubt(parts) + ROUNDOFF_OF_D / POWER_STEP / times) / scale
        return _worst(np.abs(risen - spent) / scale, tolerance)

    def _at(self, times: Array) -> Array:
        """Return the pressure over the face at times."""
        wear = self.solution.wear
        assert wear is not None
        at_radii = wear.compliance.space.matrix(self.face.radii)
        return (at_radii @ wear.modal(times).pressure.T).T

    def _of_steady_state(self) -> Iterator[Worst]:
        known, rtol = steady_state(self.problem), self.problem.rtol
        ring = ring_of(self.problem.ring_edges, self.radii)
        wrong = np.abs(self._reported("steady_pressure") / known.ring_pressures[ring] - 1).max()
        yield "steady pressures of Eq. 24", _worst(wrong, max(rtol, EXACT))
        by_rings = np.concatenate(
            [self._reported(name)[1] for name in ("pressure_min", "pressure_max")]
        )
        wrong = np.abs(by_rings / np.tile(known.ring_pressures, 2) - 1).max()
        yield "steady pressures of the answer", _worst(wrong, max(rtol, EXACT))
        for name, value in (
            ("steady_wear_rate", known.wear_rate),
            ("steady_displacement_max", known.greatest),
            ("steady_rms_slope", known.slope),
        ):
            wrong = np.abs(self._reported(name) / value - 1)
            tolerance = EXACT if name == "steady_wear_rate" else self._tolerated(name)
            yield f"{name} in closed form", _worst(wrong, tolerance)
        edges = self.problem.merged.ring_edges
        profile = known.greatest - direct.displacement(edges, known.merged_pressures, self.radii)
        wrong = np.abs(self._reported("steady_profile") - profile).max() / known.greatest
        yield "steady_profile in closed form", _worst(wrong, self._tolerated("steady_profile"))

    def _of_compliance(self) -> Iterator[Worst]:
        wear = self.solution.wear
        assert wear is not None
        tolerated = max(self.problem.rtol, EXACT)
        if self.solution.error_estimate > tolerated:
            return
        space, edges = wear.compliance.space, self.problem.merged.ring_edges
        steady = direct.steady_pressures(*self.problem.merged)
        for what, pressures, own in (
            ("steady pressures", steady, wear.steady.pressure),
            ("uniform pressure", np.ones_like(steady), np.where(space.order == 1, 1.0, 0.0)),
        ):
            energy = float(np.sum((wear.compliance.factor @ own) ** 2))
            wrong = abs(energy / energy_of_rings(edges, pressures) - 1)
            yield f"energy of {what} in closed form", _worst(wrong, tolerated)


def _flat_pressure(radii: Array) -> Array:
    """Return Eq. 10, whose square root is taken without cancellation."""
    return P0 / np.sqrt((1 - radii) * (1 + radii))


def _slopes_of(modal: "Callable[[Array], History]", times: Array) -> Array:
    """Return d' at times (T,) by differences of fourth order."""
    steps = np.array([-2.0, -1.0, 1.0, 2.0])
    depths = modal((times[:, None] * (1 + POWER_STEP * steps)).ravel()).indentation
    return depths.reshape(-1, 4) @ np.array([1.0, -8.0, 8.0, -1.0]) / (12 * POWER_STEP * times)


def _greatest(values: Array) -> tuple[Array, Array]:
    """Return the greatest of each row, and by how much the neighbours of it are less."""
    rows, at = np.arange(len(values)), values.argmax(axis=1)
    beside = [values[rows, np.clip(at + way, 0, values.shape[1] - 1)] for way in (-1, 1)]
    greatest = values[rows, at]
    return greatest, greatest - np.minimum(*beside)


def _worst(difference: "Array | float", tolerance: "Array | float") -> tuple[float, float]:
    """Return both where the difference is the greatest part of what is tolerated."""
    difference, tolerance = np.broadcast_arrays(np.atleast_1d(difference), np.atleast_1d(tolerance))
    # what is no number holds to nothing
    difference = np.where(np.isnan(difference), NO_NUMBER, difference)
    worst = int(np.argmax(difference / tolerance))
    return float(difference[worst]), float(tolerance[worst])
