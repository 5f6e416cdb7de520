"""What no method can move.

Closed forms and balances that its *reported* results are held to, each method by itself.

They take the dataset that is written, made non-dimensional by the numbers of the scene itself, so
that what is scaled, sampled or derived on the way shows, too, and what all methods share. Fields
over the whole face stand beside it, of which the dataset has some radii.

A flat start is closed form (Eqs. 10, 11), and so is the steady state (Eqs. 21 to 27). In between
hold, with ``F = 1``,

    F = int p dA, on each ring too           the force
    F v0 t = int f / k dA                    what is worn is what pressure has worn
    d = d0 + int f p0 dA                     reciprocity with the flat punch, u0 = d0
    d = int us p dA + int f ps dA            reciprocity with the steady pressures ps
    d'(2 t) = int k p^2 dA                   power; by the symmetry of compliance and wear
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray

from ...mdr import direct
from ...meshes.radial import Array, ring_of
from ..methods.base import Solution
from ..methods.quantities import ANSWER, FIELDS, QUANTITIES, array, radial_weight
from ..problem.problem import D0, P0, Units
from ..problem.scene import Scene
from ..wear.time_scale import COARSE, FINE, slowest_relaxation_time
from .known import energy_of_rings, steady_state

if TYPE_CHECKING:
    from ..wear.full_contact import RunningIn

# of sums and of closed forms to roundoff, where the accuracy asked for has no say
EXACT = 1e-9
# step that d is differentiated by, over the time
POWER_STEP = 0.005
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


def natural_units(scene: Scene) -> Units:
    """Return the natural units by the scene itself, so that what is scaled wrongly shows."""
    load, solid, punch = scene.load_, scene.half_space, scene.punch
    if load.indentation is not None:
        return scene.problem.units
    force = load.normal_force or (load.mean_pressure or 0.0) * np.pi * punch.radius**2
    modulus = solid.plane_strain_modulus
    modulus = modulus or (solid.youngs_modulus or 0.0) / (1 - solid.poisson_ratio**2)
    greatest = max(punch.coefficients[: punch.rings or len(punch.ring_edges or [])])
    time = punch.radius / (modulus * greatest * load.sliding_speed)
    return Units(punch.radius, modulus, force, time, greatest)


def anchors(scene: Scene, name: str, dataset: xarray.Dataset, solution: Solution) -> list[Anchor]:
    """Hold a method to all that applies to what it reports.

    Parameters
    ----------
    scene : what was asked for
    name : of the method
    dataset : what is written of it, in the scene's units
    solution : what the method said of the face, and of its own errors
    """
    full, history = scene.problem.full_contact, len(scene.problem.times) > 0
    of_method = _Anchors(scene, name, dataset, solution)
    later, wear = (of_method.checked_times > 0).any(), solution.wear
    given = set(solution.checked) & set(solution.errors)
    groups: list[tuple[object, str, Callable[[], None]]] = [
        (history, "ring_force pressure", of_method.hold_forces),
        (history and full, "indentation pressure ring_force", of_method.hold_start),
        (later and full, "indentation pressure profile", of_method.hold_wear),
        (later and not full, "ring_worn_volume", of_method.hold_volume),
        (
            history and full,
            "indentation profile displacement displacement_centre displacement_max",
            of_method.hold_fields,
        ),
        (history and full, "profile rms_slope", of_method.hold_slopes),
        (later and full, "pressure profile displacement", of_method.hold_output),
        (later and full and wear, "pressure relaxation_time", of_method.hold_modes),
        (
            True,
            "steady_pressure steady_profile steady_wear_rate steady_displacement_max "
            "steady_rms_slope",
            of_method.hold_steady_state,
        ),
        (full and wear, "", of_method.hold_compliance),
    ]
    for applies, quantities, hold in groups:
        if applies and given.issuperset(quantities.split()):
            hold()
    return of_method.anchors


class _Anchors:
    """The anchors of one method."""

    def __init__(
        self, scene: Scene, name: str, dataset: xarray.Dataset, solution: Solution
    ) -> None:
        self.name, self.solution, self._dataset = name, solution, dataset
        self.problem, self._units = scene.problem, natural_units(scene)
        self.face, self.anchors = self.problem.face, list[Anchor]()
        self.rtol = self.problem.rtol
        self.times = dataset["time"].values / self._units.time
        self.radii = dataset["radius"].values / self._units.length
        self.checked_times = self.times[self.problem.checked]

    def hold(
        self,
        name: str,
        value: Array | float,
        reference: Array | float,
        tolerance: Array | float,
        scale: Array | float | None = None,
    ) -> None:
        """Add an anchor where the difference to a reference is the greatest part of what is
        tolerated.

        It is relative to the reference, or to a scale. Scale and tolerance may leave out last axes
        of the values. What is no number holds to nothing, and what may be infinitely wrong is no
        anchor.
        """
        differences = np.atleast_1d(value - reference)
        scales, tolerances = (
            np.reshape(part, np.shape(part) + (1,) * (differences.ndim - np.ndim(part)))
            for part in (reference if scale is None else scale, tolerance)
        )
        differences = np.abs(differences / scales)
        # JSON cannot hold what is no number
        differences = np.where(np.isnan(differences), 1e99, differences)
        tolerances = np.broadcast_to(tolerances, differences.shape)
        worst = np.unravel_index(np.argmax(differences / tolerances), differences.shape)
        if np.isfinite(tolerances[worst]):
            numbers = float(differences[worst]), float(tolerances[worst])
            self.anchors.append(Anchor(name, self.name, *numbers))

    def _reported(self, name: str) -> Array:
        """Return a variable of the dataset, non-dimensional."""
        kind = (QUANTITIES | ANSWER)[name].unit
        return np.asarray(self._dataset[name].values / getattr(self._units, kind))

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
        error = self.solution.checked_error(self.problem, name)
        return np.where(error > self.rtol, np.inf, self.rtol)

    def _doubt(self, parts: Array) -> Array:
        """Return what a sum over the face may differ from its integral."""
        return DOUBT * self.face.integral_doubt(parts)

    def hold_forces(self) -> None:
        forces, parts = self._checked("ring_force"), self.face.areas * self._checked("pressure")
        whole, sums = forces.sum(axis=1), self.face.ring_sums(parts)
        if self.problem.indentation is None:
            error = self.solution.checked_error(self.problem, "ring_force")
            self.hold("ring forces add up to F", whole, 1.0, np.maximum(error, EXACT))
        tolerance = self._tolerated("pressure") * whole + self._doubt(parts)
        self.hold("ring forces are integrals of the pressure", sums, forces, tolerance, 1.0)

    def hold_volume(self) -> None:
        """Hold what is worn where contact opens, closes and spreads."""
        if self.problem.indentation is None:
            later = self.checked_times > 0
            worn = self._checked("ring_worn_volume")[later] @ (1 / self.problem.wear_coefficients)
            self.hold("worn volume over k, F v0 t", worn, self.checked_times[later], EXACT)

    def hold_start(self) -> None:
        edges, inside = self.problem.ring_edges, self.radii < 1
        flat = _flat_pressure(edges[:-1])
        depth, pressure, force = (
            self._tolerated(name) for name in ("indentation", "pressure", "ring_force")
        )
        if self.times[0] == 0:
            start = self._reported("indentation")[0]
            self.hold("flat start, d = F / (2 a E*)", start, D0, depth[0])
            name, reported = "flat start, p = p0 / sqrt(1 - r^2/a^2)", self._reported("pressure")
            if inside.any():
                reference = _flat_pressure(self.radii[inside])
                self.hold(name, reported[0, inside], reference, pressure[0])
            forces = -np.diff(np.sqrt((1 - edges) * (1 + edges)))
            reported = self._reported("ring_force")[0]
            self.hold("flat start, forces of the rings", reported, forces, force[0], 1.0)
        if self.solution.wear is not None:
            start = self._reported("indentation_start")
            self.hold("flat start of the answer", start, D0, depth.max())
            least, greatest = self._reported("pressure_min")[0], self._reported("pressure_max")[0]
            by_rings, reference = np.append(least, greatest[:-1]), np.append(flat, flat[1:])
            name = "flat start of the answer, pressures"
            self.hold(name, by_rings, reference, pressure.max())

    def hold_wear(self) -> None:
        """Hold what is worn, over all of the face."""
        times, face, later = self.checked_times, self.face, self.checked_times > 0
        profile, depth = self._checked("profile"), self._checked("indentation")
        pressure, steady = self._checked("pressure"), steady_state(self.problem)
        by_wear = face.areas / face.wear
        # the profile is promised relative to the indentation
        lost = self._tolerated("profile") * depth * by_wear.sum() + self._doubt(profile * by_wear)
        tolerance = np.maximum(lost[later] / times[later], self.rtol)
        self.hold("worn volume over k, F v0 t", profile[later] @ by_wear, times[later], tolerance)
        worn = self._reported("worn_volume") / self.problem.wear_coefficients
        if np.isfinite(worn).all():
            name = "worn volume of the answer over k, F v0 t"
            self.hold(name, worn.sum(), self.times[-1], tolerance[-1])
        flat, moved = _flat_pressure(face.radii) * face.areas, steady.displacement * face.areas
        tolerance = np.maximum(self._tolerated("indentation"), self._tolerated("profile"))
        doubt = self._doubt(profile * flat) / depth
        self.hold("reciprocity with the flat punch", D0 + profile @ flat, depth, tolerance + doubt)
        by_steady = pressure @ moved + profile @ (steady.pressure * face.areas)
        tolerance = np.maximum(tolerance, self._tolerated("pressure"))
        doubt = self._doubt(pressure * moved) / depth
        self.hold("reciprocity with the steady state", by_steady, depth, tolerance + doubt)

    def hold_fields(self) -> None:
        """Hold the numbers that are read off fields."""
        depth, moved = self._checked("indentation"), self._checked("displacement")
        whole = moved + self._checked("profile")
        self.hold("displacement, u = d - f", whole, depth[:, None], self.rtol, depth)
        centre, doubt = self.face.interpolate(moved, np.zeros(1))
        greatest, spread = _greatest(moved)
        for what, name, value, allowance in (
            (
                "displacement at the centre",
                "displacement_centre",
                centre[:, 0],
                DOUBT * doubt[:, 0],
            ),
            ("greatest displacement", "displacement_max", greatest, spread),
        ):
            tolerance = self._tolerated(name) + allowance / depth
            self.hold(what, self._checked(name), value, tolerance, depth)

    def hold_slopes(self) -> None:
        slope, face = self._checked("rms_slope"), self.face
        resolved = np.isfinite(self._tolerated("rms_slope")) & (slope > 0)
        if not resolved.any():
            return
        weights = radial_weight(face.radii, self.problem.gradient_average) * face.lengths
        both = face.slopes(self._checked("profile")[resolved])
        slopes, fewer = (np.sqrt(values**2 @ weights) for values in both)
        # it crosses zero now and then in time
        doubt = DOUBT * np.max(np.abs(slopes - fewer) / slope[resolved])
        # slopes on the face that are as doubtful tell nothing
        if doubt <= 0.1:
            self.hold("RMS slope of the profile", slopes, slope[resolved], self.rtol + doubt)

    def hold_output(self) -> None:
        """Hold the fields at the radii of the output to those over the face."""
        # not at the rim, where pressures of the start are infinite
        inside, later = self.radii < self.face.breakpoints[-2], self.checked_times > 0
        if not inside.any():
            return
        for name in ("pressure", "profile", "displacement"):
            values = self._checked(name)[later]
            size = self._checked("indentation")[later]
            if name == "pressure":
                size = np.abs(values).max(axis=1)
            interpolated, doubt = self.face.interpolate(values, self.radii[inside])
            reported = self._reported(name)[self.problem.checked][later][:, inside]
            # in the mean: pressures of elements have kinks of their own
            wrong, doubt = (
                np.sqrt((part**2).mean(axis=1)) / size for part in (interpolated - reported, doubt)
            )
            tolerance = self._tolerated(name)[later] + DOUBT * doubt
            self.hold(f"{name} at the radii reported", wrong, 0.0, tolerance, 1.0)

    def hold_modes(self) -> None:
        """Hold what the law of wear asks of the running-in."""
        wear, problem, times = self.solution.wear, self.problem, self.checked_times
        assert wear is not None
        slowest = self._reported("relaxation_time")[0]
        coarse, fine = (slowest_relaxation_time(problem.rings, sizes) for sizes in (COARSE, FINE))
        self.hold(
            "slowest relaxation time, by a small problem of its own",
            slowest,
            fine,
            self._tolerated("relaxation_time")[0] + DOUBT * abs(coarse / fine - 1),
        )
        self.hold("modes add up to the flat start", wear.share_of_modes, 1.0, EXACT)
        tolerated = self._tolerated("pressure")
        later = np.flatnonzero((times > 0) & np.isfinite(tolerated))
        if problem.march != "modal" or not len(later):
            return
        some = later[np.unique(np.linspace(0, len(later) - 1, 6).round().astype(int))]
        pressure = self._checked("pressure")[some]
        self._hold_power("power, F d'(2t) = int k p^2 dA", times[some], pressure, tolerated[some])
        # what is left of the running-in is then most of it the slowest mode, and is looked at alone
        half = np.array([max(slowest / 2, problem.earliest)])
        if half[0] > 5 * slowest:  # nothing is left of it
            return
        pressure = (wear.compliance.space.matrix(self.face.radii) @ wear.modal(half).pressure.T).T
        name = "power of the slowest mode"
        self._hold_power(name, half, pressure, tolerated[some[-1:]], alone=True)

    def _hold_power(
        self, name: str, times: Array, pressure: Array, tolerated: Array, alone: bool = False
    ) -> None:
        """Hold the balance of power at times, of all of it or of what is not yet steady alone."""
        wear, steady = self.solution.wear, steady_state(self.problem)
        assert wear is not None
        parts = (pressure - steady.pressure) ** 2 * self.face.weights
        spent = parts.sum(axis=1)
        whole = spent + steady.wear_rate
        scale = spent if alone else whole
        risen = _differentiate(wear, 2 * times) - steady.wear_rate
        tolerance = self.rtol + 2 * tolerated * np.sqrt(whole * spent) / scale
        # differences of d over short times have its roundoff
        tolerance += (self._doubt(parts) + 1e-14 / POWER_STEP / times) / scale
        self.hold(name, risen, spent, tolerance, scale)

    def hold_steady_state(self) -> None:
        steady, problem = steady_state(self.problem), self.problem
        at_radii = steady.ring_pressures[ring_of(problem.ring_edges, self.radii)]
        pressure, profile = self._reported("steady_pressure"), self._reported("steady_profile")
        self.hold("steady pressures of Eq. 24", pressure, at_radii, self.rtol)
        by_rings = [self._reported(name)[1] for name in ("pressure_min", "pressure_max")]
        reference = np.tile(steady.ring_pressures, 2)
        name = "steady pressures of the answer"
        self.hold(name, np.concatenate(by_rings), reference, self.rtol)
        for name, value in (
            ("steady_wear_rate", steady.wear_rate),
            ("steady_displacement_max", steady.greatest),
            ("steady_rms_slope", steady.slope),
        ):
            tolerance = EXACT if name == "steady_wear_rate" else self._tolerated(name)
            self.hold(f"{name} in closed form", self._reported(name), value, tolerance)
        edges, name = problem.merged.ring_edges, "steady_profile"
        limit = steady.greatest - direct.displacement(edges, steady.merged_pressures, self.radii)
        tolerance = self._tolerated(name)
        self.hold(f"{name} in closed form", profile, limit, tolerance, steady.greatest)

    def hold_compliance(self) -> None:
        wear, edges = self.solution.wear, self.problem.merged.ring_edges
        assert wear is not None
        beyond = self.solution.beyond(self.rtol)
        if self.solution.error_estimate > self.rtol or "steady_rms_slope" in beyond:
            return
        steady = direct.steady_pressures(*self.problem.merged)
        uniform = np.where(wear.compliance.space.order == 1, 1.0, 0.0)
        for what, pressures, coefficients in (
            ("steady pressures", steady, wear.steady.pressure),
            ("uniform pressure", np.ones_like(steady), uniform),
        ):
            energy = np.sum((wear.compliance.factor @ coefficients) ** 2)
            reference = energy_of_rings(edges, pressures)
            self.hold(f"energy of {what} in closed form", energy, reference, self.rtol)


def _flat_pressure(radii: Array) -> Array:
    """Return Eq. 10, whose square root is taken without cancellation."""
    return P0 / np.sqrt((1 - radii) * (1 + radii))


def _differentiate(wear: "RunningIn", times: Array) -> Array:
    """Return d' at times (T,) by differences of fourth order."""
    steps = np.array([-2.0, -1.0, 1.0, 2.0])
    depths = wear.modal((times[:, None] * (1 + POWER_STEP * steps)).ravel()).indentation
    return depths.reshape(-1, 4) @ np.array([1.0, -8.0, 8.0, -1.0]) / (12 * POWER_STEP * times)


def _greatest(values: Array) -> tuple[Array, Array]:
    """Return the greatest of each row, and by how much the neighbours of it are less."""
    rows, at = np.arange(len(values)), values.argmax(axis=1)
    beside = [values[rows, np.clip(at + way, 0, values.shape[1] - 1)] for way in (-1, 1)]
    return values[rows, at], values[rows, at] - np.minimum(*beside)
