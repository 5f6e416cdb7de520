"""What a method reports of a scene, made non-dimensional by the numbers of the scene itself."""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ...mdr import direct
from ...mdr.flat_punch import FlatPunch, flat_punch
from ...meshes.radial import Array
from ..methods.base import Solution
from ..problem.quantities import DESCRIBED, STEADY
from ..scene.scene import Scene
from .reading import Reading

# tolerance of sums and closed forms that hold to roundoff, whatever accuracy is asked for
EXACT = 1e-9
# forces below this part of the greatest are what rounding leaves of none
ROUNDOFF = 1e-12
# the error of a quadrature or an interpolation on the face is taken to be at most this many times
# the difference to one of a lower degree; tests/physics/test_anchors.py shows that it is enough
DOUBT = 10.0


class Reported:
    """A method's report, and what anchors need to check it.

    Numbers and fields at the radii of the output are those of the table that is written. Fields
    over the whole face stand beside it, because the table has only some radii.

    Parameters
    ----------
    scene : what was asked for
    name : name of the method
    table : what is written of the method, by the names of quantities, in the scene's units
    solution : what the method states of the face, and of its own errors

    Attributes
    ----------
    times, forces, distances, work : (T,)
        The compared times at which something presses, with the force, the sliding distance and the
        integral of the force over it by then.
    """

    def __init__(
        self, scene: Scene, name: str, table: Mapping[str, ArrayLike], solution: Solution
    ) -> None:
        self.scene, self.name, self.table, self.solution = scene, name, table, solution
        self.problem, self.reading = scene.problem, Reading.of(scene)
        self.units, self.rtol = self.reading.units, self.reading.rtol
        self.face, self.average = self.problem.face, self.reading.average
        self.radii = np.asarray(table["radius"]) / self.units.length
        times = np.asarray(table["time"])[self.problem.checked] / self.units.time
        # differences are relative: nothing can be checked while nothing presses, but for roundoff
        forces = self.reading.load(times)[0]
        self.pressing = forces > ROUNDOFF * forces.max(initial=0.0)
        self.checked, self.times = self.problem.checked[self.pressing], times[self.pressing]
        self.forces, self.distances, self.work = self.reading.load(self.times)
        self.later, self.starts = self.work > 0, 0 in self.times
        # the steady state is that of the force and the speed held last, and is checked per unit
        force, speed = (float(of.values[-1]) for of in (self.reading.force, self.reading.speed))
        self._held_last = dict.fromkeys((*STEADY, "indentation_steady"), force)
        self._held_last["steady_wear_rate"] = force * speed
        self._held_force = force

    @property
    def fixed(self) -> bool:
        """Whether the indentation is given, not the force."""
        return self.problem.indentation is not None

    @cached_property
    def inner_radius(self) -> float:
        """The radius of the hole over that of the punch; 0 if there is none."""
        return float(self.reading.edges[0])

    @cached_property
    def flat(self) -> FlatPunch:
        """The flat punch of the force 1 with the same radii and layers."""
        return flat_punch(self.inner_radius, self.reading.ground)

    @property
    def kind_of_punch(self) -> str:
        """Words for a flat punch whose start is not Eq. 10, after the name of a quantity."""
        return "of an annulus" if self.inner_radius else "of a flat punch on layers"

    @cached_property
    def area(self) -> float:
        """Area of the face."""
        return float(np.pi * (1 - self.inner_radius) * (1 + self.inner_radius))

    @cached_property
    def uniform_displacement(self) -> Array:
        """(R,) displacement of the face by the pressure 1 on all of it."""
        edges, pressures = np.array([0.0, 1.0]), np.ones(1)
        if self.inner_radius:
            edges, pressures = np.array([0.0, self.inner_radius, 1.0]), np.array([0.0, 1.0])
        return direct.displacement(edges, pressures, self.face.radii, self.reading.ground)

    @property
    def graded(self) -> bool:
        """Whether the wear coefficient is a table along the radius."""
        return bool(self.reading.table)

    @property
    def times_are_those_solved(self) -> bool:
        """Whether the reported times are those of the problem; if not, anchors of times fail."""
        return np.allclose(self.times, self.problem.times[self.checked], rtol=1e-9, atol=0)

    @property
    def full(self) -> bool:
        """Whether the whole face carries at all times."""
        return self.problem.full_contact

    @cached_property
    def wear(self) -> Array:
        """(R,) wear coefficient at the radii of the face, over the greatest."""
        return self.reading.wear_at(self.face.radii)

    @cached_property
    def steady_wear_rate(self) -> float:
        """The steady wear rate under the force 1, ``w = F / int dA / k`` (Eq. 23)."""
        return float(1 / np.sum(self.face.areas / self.wear))

    @cached_property
    def steady_pressures(self) -> Array:
        """(N,) steady pressures of the rings that are modelled, under the force 1 (Eq. 24)."""
        return np.asarray(self.steady_wear_rate / self.problem.merged.wear_coefficients)

    def steady_displacement(self, radii: Array) -> Array:
        """Return the steady displacement at radii, in closed form (Eq. 21)."""
        edges, ground = self.problem.merged.ring_edges, self.reading.ground
        return direct.displacement(edges, self.steady_pressures, radii, ground)

    def stated(self, name: str) -> float:
        """Return the error that the method states of a number of the answer, 0 if it states none.

        Unlike `tolerance` it may be smaller than the accuracy asked for.
        """
        return float(np.max(self.solution.errors.get(name, 0.0)))

    def given(self, name: str) -> bool:
        """Return whether the table has finite values of a number of the answer."""
        return name in self.table and bool(np.isfinite(np.asarray(self.table[name])).any())

    def take(self, name: str, on_face: bool = True) -> Array:
        """Return a quantity, non-dimensional, at the compared times if it has any.

        Fields over time are those over the face, or those of the table at its radii.
        """
        quantity = DESCRIBED[name]
        # a flat face may stand off its plane, from which heights are counted
        standoff = 0.0
        if self.full and name in ("profile", "indentation", "indentation_start"):
            standoff = self.problem.profile.standoff
        if on_face and quantity.dims == ("time", "radius"):
            return self.solution.checked[name][self.pressing] - standoff
        values = np.asarray(self.table[name]) / getattr(self.units, quantity.unit)
        values = values / self._held_last.get(name, 1.0) - standoff
        return values[self.checked] if "time" in quantity.dims else values

    def take_steady_pressure(self, name: str) -> Array:
        """Return an extreme of the steady pressure on each ring, per unit of the last force."""
        return np.asarray(self.take(name)[1] / self._held_force)

    @property
    def steady_profile_on_face(self) -> Array:
        """(R,) the steady profile over the face, per unit of the last force."""
        return np.asarray(self.solution.checked["steady_profile"] / self._held_force)

    def errors(self, *names: str) -> Array:
        """Return the error (names, ...) that the method states of each quantity."""
        over_time = "time" in DESCRIBED[names[0]].dims
        chosen = self.pressing if over_time else ...
        return np.array([self.solution.checked_error(self.problem, of)[chosen] for of in names])

    def tolerance(self, *names: str) -> Array:
        """Return the accuracy asked for, or what the method states where that is more."""
        return np.fmax(self.errors(*names).max(axis=0), self.rtol)

    def integrate(self, values: Array, weights: Array | float = 1.0) -> tuple[Array, Array]:
        """Return integrals (T,) of values (T, R) over the face, and by how much they may be off."""
        parts = values * weights * self.face.areas
        return parts.sum(axis=1), DOUBT * self.face.integral_error(parts)
