"""What no method can move.

Closed forms and balances that its *reported* results are held to, each method by itself.

They take the table that is written, made non-dimensional by the numbers of the scene itself, so
that what is scaled, sampled or derived on the way shows, too, and what all methods share. Fields
over the whole face stand beside it, of which the table has some radii.

A flat start is closed form (Eqs. 10, 11), and so is the steady state (Eqs. 21 to 27). In between
hold, with the greatest force 1,

    F = int p dA, on each ring too           the force
    int F v0 dt = int f / k dA               what is worn is what pressure has worn
    d = F d0 + int f p0 dA                   reciprocity with the flat punch, u0 = d0
    d = int us p dA + int f ps dA            reciprocity with the steady pressures ps
    d'(2 t) = int k p^2 dA                   power; by the symmetry of compliance and wear, at F = 1

and at a fixed indentation, with ``d0 F`` for d0 and ``-d0 F'`` for d' in the third and the last,

    F(t2) dt <= int df / k dA <= F(t1) dt    what wears from t1 to t2 = t1 + dt, for F decays
    pi d = int (f + m + u1 p - gap) dA       reciprocity with a uniform pressure; m unworn
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ...mdr import direct
from ...meshes.radial import Array
from ..methods.base import Solution
from ..methods.norms import radial_weight
from ..problem.face import POINTS
from ..problem.problem import D0, P0, Units
from ..problem.quantities import ANSWER, HISTORIES, QUANTITIES, STEADY
from ..problem.scene import Scene
from ..wear.time_scale import COARSE, FINE, slowest_relaxation_time
from .anchor import Anchor, judge

Rows = Iterator[tuple[Any, ...]]

# of sums and of closed forms to roundoff, where the accuracy asked for has no say
EXACT = 1e-9
# times the doubt of a quadrature or an interpolation on the face that its error may be
DOUBT = 10.0


def anchors(scene: Scene, name: str, table: Mapping[str, Any], solution: Solution) -> list[Anchor]:
    """Hold a method to all that applies to what it reports.

    Parameters
    ----------
    scene : what was asked for
    name : of the method
    table : what is written of it, by the names of quantities, in the scene's units
    solution : what the method said of the face, and of its own errors
    """
    problem, reported = scene.problem, _Reported(scene, table, solution)
    full, fixed = problem.full_contact, reported.fixed
    later, forces = full and reported.later.any(), "normal_force" if fixed else ""
    moved = "indentation profile displacement displacement_centre displacement_max"
    balanced = "normal_force pressure profile displacement ring_worn_volume"
    checks = (
        (True, " ".join(STEADY), reported.check_steady_state),
        (True, "ring_force pressure", reported.check_forces),
        (True, "ring_worn_volume", reported.check_volume),
        (fixed, "normal_force ring_worn_volume", reported.check_decay),
        (fixed, balanced, reported.check_balance),
        (full, "relaxation_time", reported.check_modes),
        (full, "indentation", reported.check_start),
        (full, "pressure ring_force", reported.check_start_pressures),
        (full, moved, reported.check_fields),
        (full, "profile rms_slope", reported.check_slopes),
        (later, f"indentation pressure profile {forces}", reported.check_wear),
        (later, "indentation pressure profile displacement", reported.check_output),
        (later, "pressure", reported.check_power),
    )
    given = set(filter(problem.wants, solution.checked.keys() & solution.errors.keys()))
    if not reported.times.size:
        given -= HISTORIES
    return [
        anchor
        for applies, quantities, rows in checks
        if applies and given.issuperset(quantities.split())
        for label, *numbers in rows()
        for anchor in judge(label, name, *numbers)
    ]


def natural_units(scene: Scene) -> Units:
    """Return the natural units by the scene itself, so that what is scaled wrongly shows."""
    load, solid, punch = scene.load_, scene.half_space, scene.punch
    if load.indentation is not None:
        return scene.problem.units
    force = load.greatest_force(punch.radius)
    modulus = solid.plane_strain_modulus
    modulus = modulus or (solid.youngs_modulus or 0.0) / (1 - solid.poisson_ratio**2)
    count = None if punch.table else punch.rings or len(punch.ring_edges or [])
    greatest = max(punch.coefficients[:count])
    time = punch.radius / (modulus * greatest * load.sliding.greatest)
    return Units(punch.radius, modulus, force, time, greatest)


class _Reported:
    """What a method reports, non-dimensional, and the anchors that it is held to.

    Each is a row: its name, value, reference and tolerance, and a scale if the difference is not
    relative to the reference.
    """

    def __init__(self, scene: Scene, table: Mapping[str, Any], solution: Solution) -> None:
        self.solution, self.table = solution, table
        self.problem, self.units = scene.problem, natural_units(scene)
        self.face, self.rtol = self.problem.face, self.problem.rtol
        self.radii = np.asarray(table["radius"]) / self.units.length
        times = np.asarray(table["time"])[self.problem.checked] / self.units.time
        # differences are relative: nothing is held to while nothing presses
        self.pressing = self.problem.loading.at(times).force > 0
        self.checked, self.times = self.problem.checked[self.pressing], times[self.pressing]
        self.forces, self.distances, self.work, *_ = self.problem.loading.at(self.times)
        self.later, self.starts = self.work > 0, 0 in self.times
        self.fixed = self.problem.indentation is not None
        self.graded = self.problem.merged.linear
        # F = w int dA / k
        self.wear_rate = 1 / np.sum(self.face.areas / self.face.wear)
        self.steady_pressures = self.wear_rate / self.problem.merged.wear_coefficients

    def _take(self, name: str, on_face: bool = True) -> Array:
        """Return a quantity, non-dimensional, at the times that are checked if it has any.

        Fields are those over the face, or at the radii that they are reported at.
        """
        quantity = (QUANTITIES | ANSWER)[name]
        if on_face and quantity.dims == ("time", "radius"):
            return self.solution.checked[name][self.pressing]
        values = np.asarray(self.table[name]) / getattr(self.units, quantity.unit)
        return values[self.checked] if "time" in quantity.dims else values

    def _errors(self, *names: str) -> Array:
        """Return what the method states of each quantity."""
        over_time = "time" in QUANTITIES[names[0]].dims
        chosen = self.pressing if over_time else ...
        return np.array([self.solution.checked_error(self.problem, of)[chosen] for of in names])

    def _tolerate(self, *names: str) -> Array:
        """Return the accuracy asked for.

        Infinity where the method states more of a quantity, and is held to nothing.
        """
        return np.where(self._errors(*names).max(axis=0) > self.rtol, np.inf, self.rtol)

    def _integrate(self, values: Array, weights: Array | float) -> tuple[Array, Array]:
        """Return integrals (T,) of (T, R) values over the face, and what they may be off."""
        parts = values * weights * self.face.areas
        return parts.sum(axis=1), DOUBT * self.face.integral_doubt(parts)

    def check_forces(self) -> Rows:
        forces, parts = self._take("ring_force"), self.face.areas * self._take("pressure")
        whole = forces.sum(axis=1)
        if not self.fixed:
            error = np.maximum(self._errors("ring_force")[0], EXACT)
            yield "ring forces add up to F", whole, self.forces, error
        doubt = DOUBT * self.face.integral_doubt(parts)
        # contact may lie between the radii of the face
        doubt[(parts > 0).sum(axis=1) < POINTS] = np.inf
        doubt += self._tolerate("pressure") * np.maximum(whole, np.finfo(float).tiny)
        sums = self.face.ring_sums(parts)
        yield "ring forces are integrals of the pressure", sums, forces, doubt[:, None], 1.0

    def check_volume(self) -> Rows:
        """Hold what is worn where contact opens, closes and spreads."""
        # of k that varies on a ring no volume tells what pressure has worn
        if not (self.fixed or self.graded):
            worn = self._take("ring_worn_volume")[self.later] / self.problem.wear_coefficients
            yield "worn volume over k, F v0 t", worn.sum(1), self.work[self.later], EXACT

    def check_decay(self) -> Rows:
        """Hold the force at a fixed indentation, which decays, to what it wears."""
        force = self._take("normal_force")
        if self.problem.full_contact and self.starts:
            yield "flat start, F = 2 a E* d", force[0], 1.0, self._tolerate("normal_force")[0]
        if self.graded:
            return
        worn = (self._take("ring_worn_volume") / self.problem.wear_coefficients).sum(axis=1)
        errors = self._errors("normal_force", "ring_worn_volume") * [force, worn]
        # at a stop nothing changes
        distances, at = np.unique(self.distances, return_index=True)
        passed, force, worn, errors = np.diff(distances), force[at], worn[at], errors[:, at]
        error, lost = errors[:, 1:] + errors[:, :-1]
        doubt = EXACT * force[0] + error + lost / passed
        rates, scale = np.diff(worn) / passed, np.maximum(force[:-1], np.finfo(float).tiny)
        between = np.clip(rates, force[1:], force[:-1])
        yield "worn volume over k, between F v0 t", rates, between, doubt / scale, scale

    def check_balance(self) -> Rows:
        """Hold what is worn, and what is still pressed in, to what the face overlaps."""
        depth, unworn = self._take("indentation"), self.problem.profile
        uniform = direct.displacement(np.array([0.0, 1.0]), np.ones(1), self.face.radii)
        heights = self._take("pressure") * uniform + unworn(self.face.radii) + unworn.standoff
        gap = self._take("displacement") + self._take("profile") - depth[:, None]
        parts, doubt = self._integrate(heights - gap, 1.0)
        unseen = self._take("normal_force") - self._integrate(self._take("pressure"), 1.0)[0]
        doubt += np.abs(unseen) * uniform.max()
        stated = self._errors("pressure", "profile", "displacement").sum(axis=0)
        tolerance = self.rtol + stated + doubt / depth
        value = self._take("ring_worn_volume").sum(axis=1) + parts
        yield "worn, unworn and pressed in, pi a^2 d", value, np.pi * depth, tolerance, depth

    def check_start(self) -> Rows:
        depth = self._tolerate("indentation")
        if self.starts:
            value = self._take("indentation")[0]
            yield "flat start, d = F / (2 a E*)", value, D0 * self.forces[0], depth[0]
        if self.solution.wear is not None:
            value = self._take("indentation_start")
            yield "flat start of the answer", value, D0, depth.max()

    def check_start_pressures(self) -> Rows:
        edges, radii = self.problem.ring_edges, self.radii[self.radii < 1]
        pressure, force = (self._tolerate(name) for name in ("pressure", "ring_force"))
        if self.starts:
            value = self._take("pressure", on_face=False)[0, self.radii < 1] / self.forces[0]
            reference = P0 / _root(radii)
            yield "flat start, p = p0 / sqrt(1 - r^2/a^2)", value, reference, pressure[0]
            value, reference = self._take("ring_force")[0] / self.forces[0], -np.diff(_root(edges))
            yield "flat start, forces of the rings", value, reference, force[0], 1.0
        if self.solution.wear is not None:
            # infinite at the rim
            least, greatest = self._take("pressure_min")[0], self._take("pressure_max")[0, :-1]
            reference = P0 / _root(np.append(edges[:-1], edges[1:-1]))
            value = np.append(least, greatest)
            yield "flat start of the answer, pressures", value, reference, pressure.max()

    def check_wear(self) -> Rows:
        """Hold what is worn, over all of the face."""
        work, face, later = self.work, self.face, self.later
        profile, depth = self._take("profile"), self._take("indentation")
        force = self._take("normal_force") if self.fixed else self.forces
        if not self.fixed:
            worn, doubt = self._integrate(profile, 1 / face.wear)
            # the profile is promised relative to the indentation
            doubt += self._tolerate("profile") * depth * (face.areas / face.wear).sum()
            tolerance = np.maximum(doubt[later] / work[later], self.rtol)
            yield "worn volume over k, F v0 t", worn[later], work[later], tolerance
            worn = self._take("worn_volume") / self.problem.wear_coefficients
            if np.isfinite(worn).all() and not self.graded:
                name = "worn volume of the answer over k, F v0 t"
                yield name, worn.sum(), work[-1], tolerance[-1]
        tolerance = self._tolerate("indentation", "profile")
        lost, doubt = self._integrate(profile, P0 / _root(face.radii))
        yield "reciprocity with the flat punch", D0 * force + lost, depth, tolerance + doubt / depth
        if self.graded:
            return
        tolerance = self._tolerate("indentation", "profile", "pressure")
        lost, _ = self._integrate(profile, self.wear_rate / face.wear)
        moved, doubt = self._integrate(self._take("pressure"), self._displace(face.radii))
        yield "reciprocity with the steady state", moved + lost, depth, tolerance + doubt / depth

    def check_fields(self) -> Rows:
        """Hold the numbers that are read off fields."""
        depth, moved = self._take("indentation"), self._take("displacement")
        sum_of_both, each = moved + self._take("profile"), depth[:, None]
        yield "displacement, u = d - f", sum_of_both, each, self.rtol, each
        centre, doubt = (part[:, 0] for part in self.face.interpolate(moved, np.zeros(1)))
        tolerance = self._tolerate("displacement_centre") + DOUBT * doubt / depth
        value = self._take("displacement_centre")
        yield "displacement at the centre", value, centre, tolerance, depth
        # between the greatest and its neighbours there may be a greater one
        near = np.clip(moved.argmax(axis=1)[:, None] + [-1, 0, 1], 0, moved.shape[1] - 1)
        near = np.take_along_axis(moved, near, axis=1)
        tolerance = self._tolerate("displacement_max") + np.ptp(near, axis=1) / depth
        value = self._take("displacement_max")
        yield "greatest displacement", value, near.max(axis=1), tolerance, depth

    def check_slopes(self) -> Rows:
        slope, face = self._take("rms_slope"), self.face
        resolved = np.isfinite(self._tolerate("rms_slope")) & (slope > 0)
        weights = radial_weight(face.radii, self.problem.gradient_average) * face.lengths
        slopes, fewer = (
            np.sqrt(values[resolved] ** 2 @ weights) / slope[resolved]
            for values in face.slopes(self._take("profile"))
        )
        # it crosses zero now and then in time
        doubt = DOUBT * np.max(np.abs(slopes - fewer), initial=0.0)
        # slopes on the face that are as doubtful tell nothing
        if doubt <= 0.1:
            yield "RMS slope of the profile", slopes, 1.0, self.rtol + doubt

    def check_output(self) -> Rows:
        """Hold the fields at the radii of the output to those over the face."""
        # not at the rim, where pressures of the start are infinite
        inside, later = self.radii < self.face.breakpoints[-2], self.later
        if not inside.any():
            return
        for name in ("pressure", "profile", "displacement"):
            values, size = self._take(name)[later], self._take("indentation")[later]
            if name == "pressure":
                size = np.abs(values).max(axis=1)
            reference, doubt = self.face.interpolate(values, self.radii[inside])
            reported = self._take(name, on_face=False)[later][:, inside]
            # in the mean: pressures of elements have kinks of their own
            wrong, doubt = (
                np.sqrt((part**2).mean(axis=1)) / size for part in (reported - reference, doubt)
            )
            tolerance = self._tolerate(name)[later] + DOUBT * doubt
            yield f"{name} at the radii reported", wrong, 0.0, tolerance, 1.0

    def check_modes(self) -> Rows:
        """Hold how fast the running-in is."""
        if (wear := self.solution.wear) is None:
            return
        coarse, fine = (
            slowest_relaxation_time(self.problem.merged, self.fixed, size)
            for size in (COARSE, FINE)
        )
        tolerance = self._tolerate("relaxation_time")[0] + DOUBT * abs(coarse / fine - 1)
        name = "slowest relaxation time, by a small problem of its own"
        yield name, self._take("relaxation_time")[0], fine, tolerance
        if self.later.any():
            yield "modes add up to the flat start", wear.share_of_modes, 1.0, EXACT

    def check_power(self) -> Rows:
        """Hold the balance of power that the law of wear asks for."""
        wear, times, step = self.solution.wear, self.times, 0.005
        tolerated = self._tolerate("pressure")
        some = self.later & np.isfinite(tolerated)
        marched = self.problem.march != "modal" or self.problem.loading.varies
        if wear is None or marched or not some.any():
            return
        # d'(2t) by differences of fourth order, with the roundoff of d over short times
        twice = 2 * times[some]
        near = wear.modal(np.outer(twice, 1 + step * np.array([-2, -1, 1, 2])).ravel())
        depths = -D0 * near.force if self.fixed else near.indentation
        steady = 0.0 if self.fixed else self.wear_rate
        rates = depths.reshape(-1, 4) @ [1, -8, 8, -1] / (12 * step * twice)
        # of what is not yet steady; its product with what is steady integrates to 0
        pressure = self._take("pressure")[some] - steady / self.face.wear
        spent, doubt = self._integrate(pressure**2, self.face.wear)
        power = spent + steady
        tolerance = self.rtol + 2 * tolerated[some] * np.sqrt(spent / power)
        tolerance += (doubt + 2e-14 / step / twice) / power
        yield "power, F d'(2t) = int k p^2 dA", rates, power, tolerance

    def check_steady_state(self) -> Rows:
        problem, pressures = self.problem, self.wear_rate / self.problem.merged.at(self.radii)
        name = "steady_wear_rate"
        exact = max(EXACT, self.graded * self.rtol)
        yield f"{name} in closed form", self._take(name), self.wear_rate, exact
        yield "steady pressures of Eq. 24", self._take("steady_pressure"), pressures, self.rtol
        if self.graded:
            return
        merged = problem.merged.ring_edges, self.steady_pressures
        by_rings = self.wear_rate / problem.wear_coefficients
        reported = np.array([self._take(name)[1] for name in ("pressure_min", "pressure_max")])
        yield "steady pressures of the answer", reported, by_rings, self.rtol
        greatest = direct.greatest_displacement(*merged)
        limit = greatest - self._displace(self.radii)
        for name, reference, scale in (
            ("steady_displacement_max", greatest, None),
            ("steady_rms_slope", direct.rms_slope(*merged, problem.gradient_average), None),
            ("steady_profile", limit, greatest),
        ):
            tolerance = self._tolerate(name)
            yield f"{name} in closed form", self._take(name), reference, tolerance, scale

    def _displace(self, radii: Array) -> Array:
        """Return the steady displacement at radii."""
        return direct.displacement(self.problem.merged.ring_edges, self.steady_pressures, radii)


def _root(radii: Array) -> Array:
    """Return ``sqrt(1 - r^2)``, p0 over which is Eq. 10, without cancellation."""
    return np.asarray(np.sqrt((1 - radii) * (1 + radii)))
