"""What no method can move.

Closed forms and balances that its *reported* results are held to, each method by itself.

They take the dataset that is written, so that what is sampled or derived on the way shows, too, and
what all methods share. Fields over the whole face stand beside it, of which the dataset has some
radii.

A flat start is closed form (Eqs. 10, 11), and so is the steady state (Eqs. 21 to 27). In between
hold, with ``F = 1``,

    F = int p dA, on each ring too           the force
    F v0 t = int f / k dA                    what is worn is what pressure has worn
    d = d0 + int f p0 dA                     reciprocity with the flat punch, u0 = d0
    d = int us p dA + int f ps dA            reciprocity with the steady pressures ps
    d'(2 t) = int k p^2 dA                   power; by the symmetry of compliance and wear
"""

from dataclasses import dataclass

import numpy as np
import xarray

from ...mdr import direct
from ...meshes.radial import Array, ring_of
from ..methods.base import Solution
from ..methods.quantities import ANSWER, FIELDS, QUANTITIES, array, radial_weight
from ..problem.problem import D0, P0
from ..problem.scene import Scene
from ..wear.time_scale import COARSE, FINE, slowest_relaxation_time

# of sums and of closed forms to roundoff, where the accuracy asked for has no say
EXACT = 1e-9
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
    of_method = _Anchors(scene, name, dataset, solution)
    groups = [
        ("ring_force pressure", of_method.hold_forces),
        ("ring_worn_volume", of_method.hold_volume),
        (
            "steady_pressure steady_profile steady_wear_rate steady_displacement_max "
            "steady_rms_slope",
            of_method.hold_steady_state,
        ),
    ]
    if scene.problem.full_contact:
        groups += [
            ("indentation pressure ring_force", of_method.hold_start),
            (
                "indentation profile displacement displacement_centre displacement_max",
                of_method.hold_fields,
            ),
            ("profile rms_slope", of_method.hold_slopes),
        ]
    if scene.problem.full_contact and scene.problem.earliest:
        groups += [
            ("indentation pressure profile", of_method.hold_wear),
            ("indentation pressure profile displacement", of_method.hold_output),
            ("pressure relaxation_time", of_method.hold_modes),
        ]
    given = set(solution.checked) & set(solution.errors)
    for quantities, hold in groups:
        if given.issuperset(quantities.split()):
            hold()
    return of_method.anchors


class _Anchors:
    """The anchors of one method."""

    def __init__(
        self, scene: Scene, name: str, dataset: xarray.Dataset, solution: Solution
    ) -> None:
        self.name, self.solution, self.dataset = name, solution, dataset
        self.problem, self.units = scene.problem, scene.problem.units
        self.face, self.rtol, self.anchors = self.problem.face, self.problem.rtol, list[Anchor]()
        self.radii = dataset["radius"].values / self.units.length
        times = dataset["time"].values / self.units.time
        self.times, self.starts = times[self.problem.checked], (times == 0).any()
        self.later = self.times > 0
        self.steady_pressures = direct.steady_pressures(*self.problem.merged)
        self.wear_rate = self.steady_pressures[0] * self.problem.merged.wear_coefficients[0]

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

        It is relative to the reference, or to a scale. What is no number holds to nothing, and what
        may be infinitely wrong is no anchor.
        """
        difference = np.abs((value - reference) / (reference if scale is None else scale))
        # JSON cannot hold what is no number
        difference = np.nan_to_num(difference, nan=1e99)
        differences, tolerances = np.broadcast_arrays(np.atleast_1d(difference), tolerance)
        if (bound := np.isfinite(tolerances)).any():
            differences, tolerances = differences[bound], tolerances[bound]
            worst = np.argmax(differences / tolerances)
            numbers = float(differences[worst]), float(tolerances[worst])
            self.anchors.append(Anchor(name, self.name, *numbers))

    def _read(self, name: str) -> Array:
        """Return a variable of the dataset, non-dimensional."""
        unit = getattr(self.units, (QUANTITIES | ANSWER)[name].unit)
        return np.asarray(self.dataset[name].values / unit)

    def _check(self, name: str) -> Array:
        """Return a quantity at the times that are checked.

        Fields over the face, numbers as they are reported.
        """
        if name in FIELDS:
            return array(self.solution.checked, name)
        return self._read(name)[self.problem.checked]

    def _tolerate(self, *names: str) -> Array:
        """Return the accuracy asked for.

        Infinity where the method states more of a quantity, and is held to nothing.
        """
        errors = [self.solution.checked_error(self.problem, name) for name in names]
        return np.where(np.max(errors, axis=0) > self.rtol, np.inf, self.rtol)

    def _integrate(self, values: Array, weights: Array) -> tuple[Array, Array]:
        """Return integrals (T,) of (T, R) values over the face, and what they may be off."""
        parts = values * weights * self.face.areas
        return parts.sum(axis=1), DOUBT * self.face.integral_doubt(parts)

    def hold_forces(self) -> None:
        forces, parts = self._check("ring_force"), self.face.areas * self._check("pressure")
        whole = forces.sum(axis=1)
        if self.problem.indentation is None:
            error = self.solution.checked_error(self.problem, "ring_force")
            self.hold("ring forces add up to F", whole, 1.0, np.maximum(error, EXACT))
        doubt = DOUBT * self.face.integral_doubt(parts)
        tolerance = (self._tolerate("pressure") * whole + doubt)[:, None]
        sums = self.face.ring_sums(parts)
        self.hold("ring forces are integrals of the pressure", sums, forces, tolerance, 1.0)

    def hold_volume(self) -> None:
        """Hold what is worn where contact opens, closes and spreads."""
        if self.problem.indentation is None:
            worn = self._check("ring_worn_volume")[self.later] / self.problem.wear_coefficients
            self.hold("worn volume over k, F v0 t", worn.sum(1), self.times[self.later], EXACT)

    def hold_start(self) -> None:
        edges, inside = self.problem.ring_edges, self.radii < 1
        depth, pressure, force = (
            self._tolerate(name) for name in ("indentation", "pressure", "ring_force")
        )
        if self.starts:
            value = self._read("indentation")[0]
            self.hold("flat start, d = F / (2 a E*)", value, D0, depth[0])
            value, reference = self._read("pressure")[0, inside], P0 / _root(self.radii[inside])
            self.hold("flat start, p = p0 / sqrt(1 - r^2/a^2)", value, reference, pressure[0])
            value, reference = self._read("ring_force")[0], -np.diff(_root(edges))
            self.hold("flat start, forces of the rings", value, reference, force[0], 1.0)
        if self.solution.wear is not None:
            value = self._read("indentation_start")
            self.hold("flat start of the answer", value, D0, depth.max())
            least, greatest = self._read("pressure_min")[0], self._read("pressure_max")[0]
            value, reference = np.append(least, greatest[:-1]), P0 / _root(edges[:-1])
            reference = np.append(reference, reference[1:])
            self.hold("flat start of the answer, pressures", value, reference, pressure.max())

    def hold_wear(self) -> None:
        """Hold what is worn, over all of the face."""
        times, face, later = self.times, self.face, self.later
        profile, depth = self._check("profile"), self._check("indentation")
        worn, doubt = self._integrate(profile, 1 / face.wear)
        # the profile is promised relative to the indentation
        doubt += self._tolerate("profile") * depth * (face.areas / face.wear).sum()
        tolerance = np.maximum(doubt[later] / times[later], self.rtol)
        self.hold("worn volume over k, F v0 t", worn[later], times[later], tolerance)
        worn = self._read("worn_volume") / self.problem.wear_coefficients
        if np.isfinite(worn).all():
            name = "worn volume of the answer over k, F v0 t"
            self.hold(name, worn.sum(), times[-1], tolerance[-1])
        tolerance = self._tolerate("indentation", "profile")
        lost, doubt = self._integrate(profile, P0 / _root(face.radii))
        name = "reciprocity with the flat punch"
        self.hold(name, D0 + lost, depth, tolerance + doubt / depth)
        tolerance = self._tolerate("indentation", "profile", "pressure")
        lost, _ = self._integrate(profile, self.wear_rate / face.wear)
        moved, doubt = self._integrate(
            self._check("pressure"), self._displace(self.problem.face.radii)
        )
        name = "reciprocity with the steady state"
        self.hold(name, moved + lost, depth, tolerance + doubt / depth)

    def hold_fields(self) -> None:
        """Hold the numbers that are read off fields."""
        depth, moved = self._check("indentation"), self._check("displacement")
        sum_of_both, each = moved + self._check("profile"), depth[:, None]
        self.hold("displacement, u = d - f", sum_of_both, each, self.rtol, each)
        centre, doubt = (part[:, 0] for part in self.face.interpolate(moved, np.zeros(1)))
        tolerance = self._tolerate("displacement_centre") + DOUBT * doubt / depth
        value = self._check("displacement_centre")
        self.hold("displacement at the centre", value, centre, tolerance, depth)
        # between the greatest and its neighbours there may be a greater one
        near = np.clip(moved.argmax(axis=1)[:, None] + [-1, 0, 1], 0, moved.shape[1] - 1)
        near = np.take_along_axis(moved, near, axis=1)
        tolerance = self._tolerate("displacement_max") + np.ptp(near, axis=1) / depth
        value = self._check("displacement_max")
        self.hold("greatest displacement", value, near.max(axis=1), tolerance, depth)

    def hold_slopes(self) -> None:
        slope, face = self._check("rms_slope"), self.face
        resolved = np.isfinite(self._tolerate("rms_slope")) & (slope > 0)
        weights = radial_weight(face.radii, self.problem.gradient_average) * face.lengths
        slopes, fewer = (
            np.sqrt(values[resolved] ** 2 @ weights) / slope[resolved]
            for values in face.slopes(self._check("profile"))
        )
        # it crosses zero now and then in time
        doubt = DOUBT * np.max(np.abs(slopes - fewer), initial=0.0)
        # slopes on the face that are as doubtful tell nothing
        if doubt <= 0.1:
            self.hold("RMS slope of the profile", slopes, 1.0, self.rtol + doubt)

    def hold_output(self) -> None:
        """Hold the fields at the radii of the output to those over the face."""
        # not at the rim, where pressures of the start are infinite
        inside, later = self.radii < self.face.breakpoints[-2], self.later
        if not inside.any():
            return
        for name in ("pressure", "profile", "displacement"):
            values, size = self._check(name)[later], self._check("indentation")[later]
            if name == "pressure":
                size = np.abs(values).max(axis=1)
            reference, doubt = self.face.interpolate(values, self.radii[inside])
            reported = self._read(name)[self.problem.checked][later][:, inside]
            # in the mean: pressures of elements have kinks of their own
            wrong, doubt = (
                np.sqrt((part**2).mean(axis=1)) / size for part in (reported - reference, doubt)
            )
            tolerance = self._tolerate(name)[later] + DOUBT * doubt
            self.hold(f"{name} at the radii reported", wrong, 0.0, tolerance, 1.0)

    def hold_modes(self) -> None:
        """Hold what the law of wear asks of the running-in."""
        wear, times, step = self.solution.wear, self.times, 0.005
        if wear is None:
            return
        coarse, fine = (
            slowest_relaxation_time(self.problem.rings, size) for size in (COARSE, FINE)
        )
        tolerance = self._tolerate("relaxation_time")[0] + DOUBT * abs(coarse / fine - 1)
        name = "slowest relaxation time, by a small problem of its own"
        self.hold(name, self._read("relaxation_time")[0], fine, tolerance)
        self.hold("modes add up to the flat start", wear.share_of_modes, 1.0, EXACT)
        tolerated = self._tolerate("pressure")
        later = np.flatnonzero(self.later & np.isfinite(tolerated))
        if self.problem.march != "modal" or not len(later):
            return
        some = later[np.linspace(0, len(later) - 1, min(len(later), 6)).round().astype(int)]
        # d'(2t) by differences of fourth order, with the roundoff of d over short times
        twice = 2 * times[some]
        depths = wear.modal(np.outer(twice, 1 + step * np.array([-2, -1, 1, 2])).ravel())
        rates = depths.indentation.reshape(-1, 4) @ [1, -8, 8, -1] / (12 * step * twice)
        # of what is not yet steady, to which the steady rate is added: their product integrates to 0
        pressure = self._check("pressure")[some] - self.wear_rate / self.face.wear
        spent, doubt = self._integrate(pressure**2, self.face.wear)
        power = spent + self.wear_rate
        tolerance = self.rtol + 2 * tolerated[some] * np.sqrt(spent / power)
        tolerance += (doubt + 2e-14 / step / twice) / power
        self.hold("power, F d'(2t) = int k p^2 dA", rates, power, tolerance)

    def hold_steady_state(self) -> None:
        problem, merged = self.problem, (self.problem.merged.ring_edges, self.steady_pressures)
        by_rings = self.wear_rate / problem.wear_coefficients
        pressures = by_rings[ring_of(problem.ring_edges, self.radii)]
        self.hold("steady pressures of Eq. 24", self._read("steady_pressure"), pressures, self.rtol)
        reported = np.array([self._read(name)[1] for name in ("pressure_min", "pressure_max")])
        self.hold("steady pressures of the answer", reported, by_rings, self.rtol)
        greatest = direct.greatest_displacement(*merged)
        limit = greatest - self._displace(self.radii)
        for name, reference, scale in (
            ("steady_displacement_max", greatest, None),
            ("steady_rms_slope", direct.rms_slope(*merged, problem.gradient_average), None),
            ("steady_profile", limit, greatest),
        ):
            tolerance = self._tolerate(name)
            self.hold(f"{name} in closed form", self._read(name), reference, tolerance, scale)
        name = "steady_wear_rate"
        self.hold(f"{name} in closed form", self._read(name), self.wear_rate, EXACT)

    def _displace(self, radii: Array) -> Array:
        """Return the steady displacement at radii."""
        return direct.displacement(self.problem.merged.ring_edges, self.steady_pressures, radii)


def _root(radii: Array) -> Array:
    """Return ``sqrt(1 - r^2)``, p0 over which is Eq. 10, without cancellation."""
    return np.asarray(np.sqrt((1 - radii) * (1 + radii)))
