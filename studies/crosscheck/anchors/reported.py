"""A method's report on a scene, made non-dimensional with the second reading of the scene."""

from collections.abc import Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from ....mdr import direct
from ....mdr.flat_punch import FlatPunch, flat_punch_of
from ....meshes.radial import Array
from ..methods.base import Solution
from ..problem.face import POINTS, radial_weight
from ..problem.norms import greatest_depth
from ..problem.quantities import DESCRIBED, STEADY
from ..scene.scene import Scene
from ..sizes.cells import tolerance_range
from ..wear.unilateral import Mask
from .reading import Reading

# relative tolerance of sums and closed forms that hold to roundoff, independent of `rtol`
ROUNDOFF_TOLERANCE = 1e-9
# roundoff of a height over that height, a few units of the last digit
HEIGHT_ROUNDOFF = 1e-15
# error of an integral of the pressure over the face, over the largest contribution of one radius:
# contact ends between two radii
EDGE_QUADRATURE_FACTOR = 4.0
# largest error estimate that enters the balances of whole fields of a moving contact, over rtol or
# over the smallest tolerance that cell sizes respond to
LARGEST_STATED_FACTOR = 4.0
# least number of radii of the face in contact for an integral over it
FEWEST_CONTACT_RADII = 20
# forces below this part of the greatest force count as zero
ROUNDOFF = 1e-12
# bound on the error of a reference that is computed here (a quadrature or an interpolation on the
# face, a small problem), over its difference to a less accurate one: all anchors of correct results
# hold with it (physics/test_random_scenes.py), and faults are noticed (physics/test_faults.py)
REFERENCE_ERROR_FACTOR = 10.0


class KnownPressure(NamedTuple):
    """A pressure on the face whose displacement is known.

    Parameters
    ----------
    name : its name in that of the anchor
    pressure : (R,) pressure
    displacement : (R,) displacement, or the one number of a flat punch
    """

    name: str
    pressure: Array
    displacement: Array | float


class Reported:
    """A method's report, with the reference numbers that anchors need to check it.

    Numbers and fields at the radii of the output are read from the table in `results.nc`. Fields
    over the whole face are taken from the solution, because the table has only some radii.

    Parameters
    ----------
    scene : the scene that was solved
    reading : the second reading of the scene
    name : name of the method
    table, answers : the method's values in `results.nc`, and the numbers of its answer, by the
        names of quantities, in the scene's units
    solution : the method's fields over the face and its error estimates

    Attributes
    ----------
    times, forces, work : (T,)
        The compared times at which the force is not zero, with the force and the integral of the
        force over the sliding distance up to then; non-dimensional.
    has_slid : (T,)
        Whether the force has done work by a time.
    includes_start : bool
        Whether the time 0 is among these times.
    """

    def __init__(
        self,
        scene: Scene,
        reading: Reading,
        name: str,
        table: Mapping[str, ArrayLike],
        answers: Mapping[str, ArrayLike],
        solution: Solution,
    ) -> None:
        self.scene, self.name, self.solution = scene, name, solution
        self.table, self.answers = table, answers
        self.problem, self.reading = scene.problem, reading
        self.units, self.rtol = self.reading.units, self.reading.rtol
        self.face, self.average = self.problem.face, self.reading.average
        self.radii = np.asarray(table["radius"]) / self.units.length
        times = np.asarray(table["time"])[self.problem.compared_rows] / self.units.time
        # differences are relative, so that times without a force cannot be checked
        forces = self.reading.load(times)[0]
        self.in_contact = forces > ROUNDOFF * forces.max(initial=0.0)
        self.compared_rows, self.times = (
            self.problem.compared_rows[self.in_contact],
            times[self.in_contact],
        )
        self.forces, _, self.work = self.reading.load(self.times)
        self.has_slid, self.includes_start = self.work > 0, 0 in self.times
        # the steady state belongs to the last force and speed, and is checked for unit values
        force, speed = (
            float(values[-1] / values.max())
            for _, values in (self.reading.force, self.reading.speed)
        )
        self._load_factors = dict.fromkeys((*STEADY, "indentation_steady"), force)
        self._load_factors["steady_wear_rate"] = force * speed
        self._last_force = force

    @property
    def fixed_indentation(self) -> bool:
        """Whether the scene prescribes the indentation instead of the force."""
        return self.problem.indentation is not None

    @cached_property
    def inner_radius(self) -> float:
        """The radius of the hole over that of the punch; 0 if there is none."""
        return float(self.reading.edges[0])

    @cached_property
    def flat(self) -> FlatPunch:
        """The flat punch under the force 1 with the same radii and layers."""
        return flat_punch_of(self.inner_radius, self.reading.ground)

    @cached_property
    def even_wear(self) -> Array:
        """(T,) depth by which the whole face has worn at the steady rate, by the method."""
        return self.solution.compared["even_wear"][self.in_contact]

    @cached_property
    def shape(self) -> Array:
        """(T, R) profile over the face, from the first touch, less the even wear."""
        return self.solution.compared["shape"][self.in_contact]

    @property
    def first_touch(self) -> float:
        """Indentation at the first touch, from which depths and shapes are measured.

        `take` subtracts it from the heights of a flat face, so that it is 0 in full contact.
        """
        return 0.0 if self.full_contact else self.problem.profile.standoff

    @cached_property
    def depth(self) -> Array:
        """(T,) reported indentation, from the first touch, less the even wear."""
        return self.take("indentation") - self.first_touch - self.even_wear

    @cached_property
    def depth_scale(self) -> Array:
        """(T,) scale of errors of heights: the greatest depth so far, as in the norms."""
        depth = greatest_depth(self.solution.compared, self.face)[self.in_contact]
        return np.maximum(depth, np.finfo(float).tiny)

    @cached_property
    def depth_roundoff(self) -> Array:
        """(T,) roundoff of reported indentations and profiles, over the scale of depths.

        They are reported with the even wear, which may be much greater than the depth.
        """
        return HEIGHT_ROUNDOFF * (1 + self.even_wear / self.depth_scale)

    def name_of_start(self, symbol: str, closed_form: str) -> str:
        """Return the name of an anchor of the flat start; Eqs. 10 and 11 are those of a disc."""
        if self.inner_radius:
            return f"flat start, {symbol} of an annulus"
        if self.reading.ground.layered:
            return f"flat start, {symbol} of a flat punch on layers"
        return f"flat start, {symbol} = {closed_form}"

    @cached_property
    def contact(self) -> Mask:
        """(T, R) whether the radii of the face are in contact."""
        if self.full_contact:
            return np.ones(self.shape.shape, dtype=bool)
        return self.take("pressure") > 0

    @cached_property
    def force(self) -> Array:
        """(T,) the force that is given; or the reported one, at a fixed indentation."""
        if self.full_contact and not self.fixed_indentation:
            return self.forces
        return self.take("normal_force")

    @cached_property
    def scale(self) -> Array:
        """(T,) the force as a scale of errors."""
        return np.maximum(self.force, np.finfo(float).tiny)

    @cached_property
    def too_few_radii(self) -> Array:
        """(T,) infinity at times with too few radii in contact for an integral, else 0."""
        return np.where(self.contact.sum(axis=1) < FEWEST_CONTACT_RADII, np.inf, 0.0)

    @cached_property
    def edge_error(self) -> Array:
        """(T,) error of an integral of the pressure because contact ends between two radii."""
        if self.full_contact:
            return np.zeros(len(self.times))
        largest = (self.take("pressure") * self.face.areas).max(axis=1)
        return EDGE_QUADRATURE_FACTOR * largest + self.too_few_radii

    @cached_property
    def uniform_displacement(self) -> Array:
        """(R,) displacement of the face under the pressure 1 on all of it."""
        edges = np.array([self.inner_radius, 1.0])
        return direct.displacement(edges, np.ones(1), self.face.radii, self.reading.ground)

    @cached_property
    def known_pressures(self) -> list[KnownPressure]:
        """Pressures whose displacements are known: of the flat punch, and a uniform one."""
        flat, ones = self.flat, np.ones(len(self.face.radii))
        return [
            KnownPressure("the flat punch", flat.pressure_at(self.face.radii), flat.indentation),
            KnownPressure("a uniform pressure", ones, self.uniform_displacement),
        ]

    @property
    def graded(self) -> bool:
        """Whether the wear coefficient varies along the radius (a table in the scene)."""
        return self.problem.graded is not None

    @property
    def full_contact(self) -> bool:
        """Whether the whole face is in contact at all times."""
        return self.problem.full_contact

    @cached_property
    def wear(self) -> Array:
        """(R,) wear coefficient at the radii of the face, over the greatest."""
        return self.reading.wear_at(self.face.radii)

    @cached_property
    def steady_wear_rate(self) -> float:
        """The steady wear rate under the force 1, ``w = F / int dA / k`` (Eq. 23)."""
        return float(1 / self.reading.inverse_wear.sum())

    @cached_property
    def steady_pressures(self) -> Array:
        """(N,) steady pressures of the rings that are modelled, under the force 1 (Eq. 24)."""
        return self.steady_wear_rate / self.problem.merged.wear_coefficients[0]

    def steady_displacement(self, radii: Array) -> Array:
        """Return the steady displacement at radii, in closed form (Eq. 21)."""
        edges, ground = self.problem.merged.ring_edges, self.reading.ground
        return direct.displacement(edges, self.steady_pressures, radii, ground)

    @property
    def has_steady_displacement(self) -> bool:
        """Whether the steady displacement has a closed form, or else was asked for."""
        return not self.graded or (
            self.has("steady_displacement_max") and self.has("steady_profile")
        )

    @cached_property
    def steady_displacement_on_face(self) -> Array:
        """Steady displacement on the face under the force 1: in closed form if k is by rings."""
        if not self.graded:
            return self.steady_displacement(self.face.radii)
        greatest = float(self.take("steady_displacement_max"))
        return greatest - self.solution.compared["steady_profile"] / self._last_force

    def stated_error(self, name: str) -> float:
        """Return the method's error estimate of a number of the answer, 0 if there is none.

        Unlike `tolerance` it may be smaller than `rtol`.
        """
        return float(np.max(self.solution.errors.get(name, 0.0)))

    def has(self, name: str) -> bool:
        """Return whether the table has finite values for a number of the answer."""
        return name in self.table and bool(np.isfinite(np.asarray(self.table[name])).any())

    def take(self, name: str, on_face: bool = True) -> Array:
        """Return a quantity, non-dimensional, at the compared times if it depends on time.

        Fields over time are taken over the face, or from the table if not `on_face`. Quantities of
        the steady state are divided by the last force and speed.
        """
        quantity = DESCRIBED[name]
        # heights are measured from a plane, from which a flat face may have a constant distance
        standoff = 0.0
        if self.full_contact and name in ("profile", "indentation", "indentation_start"):
            standoff = self.problem.profile.standoff
        if on_face and quantity.dims == ("time", "radius"):
            return self.solution.compared[name][self.in_contact] - standoff
        values = np.asarray(self.table[name]) / getattr(self.units, quantity.unit)
        values = values / self._load_factors.get(name, 1.0) - standoff
        return values[self.compared_rows] if "time" in quantity.dims else values

    def take_steady_pressure(self, name: str) -> Array:
        """Return an extreme of the steady pressure on each ring, per unit of the last force."""
        return self.take(name)[1] / self._last_force

    def errors(self, *names: str) -> Array:
        """Return the method's error estimates (names, ...) of some quantities."""
        over_time = "time" in DESCRIBED[names[0]].dims
        rows = self.in_contact if over_time else ...
        return np.array([self.solution.compared_error(self.problem, name)[rows] for name in names])

    def tolerance(self, *names: str) -> Array:
        """Return `rtol`, or the method's largest error estimate if that is larger."""
        return np.fmax(self.errors(*names).max(axis=0), self.rtol)

    def allowed(self, *names: str) -> Array:
        """Return `rtol` plus the sum of the method's error estimates (...) of some quantities."""
        return self.rtol + self.errors(*names).sum(axis=0)

    def allowed_in_balances(self, *names: str) -> Array:
        """Return what is allowed in balances of whole fields of a moving contact, or `allowed`.

        While edges of the contact move, an error estimate far above `rtol` belongs to the radii
        near an edge only.
        """
        allowed = self.allowed(*names)
        if self.full_contact:
            return allowed
        finest = max(self.rtol, tolerance_range(self.problem, 0)[0])
        return np.minimum(allowed, self.rtol + LARGEST_STATED_FACTOR * finest)

    def mean_square_slopes(self, profiles: Array) -> tuple[Array, Array]:
        """Return mean square slopes (T,) of profiles (T, R), and bounds (T,) on their errors.

        Differences to less accurate slopes may cancel in the sum over the elements of the face, so
        that the sum of their sizes is a bound, too.
        """
        face = self.face
        weights = face.lengths * radial_weight(face.radii, self.average, self.inner_radius)
        squares, less_accurate = (
            (slopes**2 * weights).reshape(len(profiles), len(weights) // POINTS, POINTS).sum(axis=2)
            for slopes in face.slopes(profiles)
        )
        differences = squares - less_accurate
        sizes, size = np.abs(differences).sum(axis=1), np.abs(differences.sum(axis=1))
        return squares.sum(axis=1), np.maximum(REFERENCE_ERROR_FACTOR * size, sizes)

    def integrate(self, values: Array, weights: Array | float = 1.0) -> tuple[Array, Array]:
        """Return integrals (T,) of values (T, R) over the face, and bounds (T,) on their errors."""
        parts = values * weights * self.face.areas
        return parts.sum(axis=1), REFERENCE_ERROR_FACTOR * self.face.integral_error(parts)


def holds_around(mask: Mask, reach: int) -> Mask:
    """Return where a mask (T, n) is true, also at `reach` neighbours on each side."""
    padded = np.pad(mask, ((0, 0), (reach, reach)), mode="edge")
    around = np.asarray(sliding_window_view(padded, 2 * reach + 1, axis=1))
    return np.asarray(around.all(axis=2))
