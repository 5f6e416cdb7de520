"""Predict measurements of a punch whose contact opens, closes or spreads, by marches in time.

A march takes about a second. It is therefore computed only at the points of a lattice, each when it
is first needed, and histories between these points are interpolated. The coordinates of the lattice
are the logarithms on which the non-dimensional history depends. The interpolation is cubic in them,
and uses splines in time. Under a constant load, a common change of wear coefficients, modulus and
speed only stretches the time, so that the lattice has one dimension less: a punch of one material
needs one march for all wear coefficients.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import prod
from typing import TypeAlias

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from ....mdr import energy
from ....meshes import Array, SceneError
from ...crosscheck import LOG, MovingContact, Scene, choose_spaces
from ..measurement import Measurement, Predictor
from ..parameters import Parameter, scene_at
from .flat_predictor import Logs
from .rig import Rig, differences, values_of_ring

# spacing of the lattice in logarithms
SPACING = 0.4
# greatest number of dimensions of the lattice: each one multiplies the number of marches by four
MAX_DIMENSIONS = 2
# number of times per decade at which a march is sampled, and factor by which it begins before and
# ends after the times that are needed
TIMES_PER_DECADE, TIME_SPAN = 12, 4.0
# step of the coordinates in central differences
STEP = 1e-3
# rtol of a march over the rtol of the model, because marches are less smooth than modes
MARCH_RTOL_FACTOR = 0.1
# relative difference of two times below which they are the same
ROUNDOFF = 1e-9
# a function of time
Curve: TypeAlias = Callable[[Array], Array]
# lattice points through which a cubic is laid, relative to the point below
STENCIL = np.array([-1, 0, 1, 2])


@dataclass(frozen=True, eq=False)
class March:
    """A march at one lattice point, interpolated in time.

    Parameters
    ----------
    earliest, latest : range of the times after 0 at which it can be evaluated, in its unit of time
    depths, forces : functions of time
    worn : functions of time by the index of the measurement; a profile is (R,), a volume a number
    """

    earliest: float
    latest: float
    depths: Curve
    forces: Curve
    worn: dict[int, Curve]


@dataclass(frozen=True, eq=False)
class MarchedPredictor:
    """Predict measurements by interpolating among marches.

    Parameters
    ----------
    scene : with the initial values of the parameters
    parameters : m parameters of the fit
    measurements : that are predicted
    rtol : tolerance of the marches
    origin : (m,) coordinates of a lattice point
    """

    scene: Scene
    parameters: tuple[Parameter, ...]
    measurements: tuple[Measurement, ...]
    rtol: float
    origin: Array
    _marches: dict[tuple[int, ...], March] = field(default_factory=dict)

    def for_measurements(self, measurements: tuple[Measurement, ...]) -> "MarchedPredictor":
        """Return the model that predicts other measurements; it shares the marches if possible."""
        kinds = [(each.quantity, each.ring, each.radii is None) for each in measurements]
        own_kinds = [(each.quantity, each.ring, each.radii is None) for each in self.measurements]
        same = kinds == own_kinds and all(
            each.radii is None or other.radii is None or np.array_equal(each.radii, other.radii)
            for each, other in zip(measurements, self.measurements, strict=True)
        )
        return replace(self, measurements=measurements, _marches=self._marches if same else {})

    @cached_property
    def _rig(self) -> Rig:
        return Rig(self.parameters)

    @cached_property
    def _varies(self) -> bool:
        return self.scene.problem.loading.varies

    def _shape(self, scene: Scene) -> Array:
        """Return the logarithms on which the non-dimensional history depends.

        They are the contrasts of wear and the unit of heights, over which the face is given; under
        a load that varies, also the unit of time.
        """
        logs, units = Logs.of(scene), scene.problem.units
        clock = [np.log(units.time)] if self._varies else []
        return np.array([*(logs.wear[1:] - logs.wear[0]), np.log(units.displacement), *clock])

    @cached_property
    def _lattice(self) -> tuple[Array, Array]:
        """Matrices from parameter coordinates to lattice coordinates (K, m), and back (m, K).

        Raises
        ------
        SceneError
            if there are too many dimensions
        """
        columns = [
            self._shape(self._scene(self.origin + shift))
            - self._shape(self._scene(self.origin - shift))
            for shift in STEP * np.eye(len(self.parameters))
        ]
        _, singular, right = np.linalg.svd(
            np.column_stack(columns) / (2 * STEP), full_matrices=False
        )
        rank = int(np.sum(singular > 1e-6))
        if rank > MAX_DIMENSIONS:
            raise SceneError(
                f"a fit of a punch whose contact changes depends on {rank} parameters besides the "
                f"scale of time, and can have at most {MAX_DIMENSIONS}: give fewer in --for"
            )
        return singular[:rank, None] * right[:rank], right[:rank].T / singular[:rank]

    def _scene(self, x: Array) -> Scene:
        return scene_at(self.scene, self.parameters, x)

    def _clock(self, scene: Scene) -> float:
        """Return the unit of time of the marches, in the units of the scene.

        It belongs to the first wear coefficient, so that one march suits all scales of time; under
        a load that varies it is 1.
        """
        units = scene.problem.units
        first = float(np.exp(Logs.of(scene).wear[0]))
        return 1.0 if self._varies else units.time * units.wear_coefficient / first

    def predict(self, x: Array) -> list[Array]:
        """Return the values (n,) of each measurement at coordinates (m,) of the parameters."""
        scene = self._scene(x)
        units, clock = scene.problem.units, self._clock(scene)
        since = [self._rig.since_start(each.times, x) for each in self.measurements]
        positive = np.concatenate(since)
        positive = positive[positive > 0] / clock
        ends = float(positive.min()), float(positive.max())
        predictions = [np.zeros(len(times)) for times in since]
        for weight, march in self._surrounding_marches(x, *ends):
            for number, (each, times) in enumerate(zip(self.measurements, since, strict=True)):
                march_times = times / clock
                if each.quantity == "indentation":
                    depths = march.depths(march_times) * units.displacement
                    forces = march.forces(march_times) * units.force
                    values = self._rig.sensor_reading(depths, forces, x)
                elif each.quantity == "normal_force":
                    values = march.forces(march_times) * units.force
                elif each.radii is not None:
                    values = march.worn[number](march_times[0]) * units.displacement
                else:
                    values = march.worn[number](march_times) * units.volume
                predictions[number] = predictions[number] + weight * values
        return predictions

    def slopes(self, x: Array) -> list[Array]:
        """Return the derivatives (n, m) of each measurement by the coordinates."""
        return differences(self, x, np.full(len(x), STEP))

    def _surrounding_marches(
        self, x: Array, earliest: float, latest: float
    ) -> Iterator[tuple[float, March]]:
        """Yield the lattice points around coordinates (m,): interpolation weight and march.

        The marches can be evaluated between the times `earliest` and `latest`.
        """
        positions = self._lattice[0] @ (x - self.origin) / SPACING
        # at a lattice point, the weights of all other points become exactly 0
        rounded = np.round(positions)
        positions = np.where(np.abs(positions - rounded) < 1e-12, rounded, positions)
        below = np.floor(positions)
        weights = [cubic_weights(float(fraction)) for fraction in positions - below]
        for corner in product(range(len(STENCIL)), repeat=len(positions)):
            weight = prod(each[number] for each, number in zip(weights, corner, strict=True))
            point = tuple(
                int(low + STENCIL[number]) for low, number in zip(below, corner, strict=True)
            )
            if weight:
                yield weight, self._march(point, earliest, latest)

    def _march(self, point: tuple[int, ...], earliest: float, latest: float) -> March:
        """Return the march at a lattice point; an earlier one if it covers the times."""
        stored = self._marches.get(point)
        if stored and stored.earliest <= earliest and latest <= stored.latest:
            return stored
        if stored:
            earliest, latest = min(earliest, stored.earliest), max(latest, stored.latest)
        self._marches[point] = self._compute_march(point, earliest / TIME_SPAN, latest * TIME_SPAN)
        LOG.info("     fit  %d marches ...", len(self._marches))
        return self._marches[point]

    def _compute_march(self, point: tuple[int, ...], earliest: float, latest: float) -> March:
        """Return a new march at a lattice point; times are in the unit of `_clock`."""
        shift = self._lattice[1] @ (SPACING * np.array(point, dtype=float))
        scene = self._scene(self.origin + shift)
        decades = np.log10(latest / earliest)
        times = np.geomspace(earliest, latest, int(np.ceil(TIMES_PER_DECADE * decades)) + 2)
        if self._varies:
            knots = scene.problem.loading.times[1:] * scene.problem.units.time
            # while the load changes, measurements are not interpolated in time
            data_times = np.concatenate([knots, *(each.times for each in self.measurements)])
            in_range = (data_times > earliest) & (data_times < latest)
            times = np.union1d(times, data_times[in_range])
            # times that differ only by the roundoff of units are one time
            times = times[np.diff(times, prepend=0.0) > ROUNDOFF * times]
        times = np.append(0.0, times)
        problem = replace(
            scene.problem,
            times=times * self._clock(scene) / scene.problem.units.time,
            steady=False,
            rtol=self.rtol,
            quantities=None,
            # for other parameters, contact may be lost
            keeps_contact=False,
        )
        compliance = energy.compliance(choose_spaces(problem).fine)
        history = MovingContact(problem, compliance).history
        space, worn = compliance.space, dict[int, Curve]()
        volumes = history.profile @ space.ring_forces(problem.ring_edges).T
        curve = monotone if self._varies else spline_of_root
        for number, each in enumerate(self.measurements):
            if each.radii is not None:
                radii = each.radii / problem.units.length
                heights = history.profile @ space.matrix(radii).T
                worn[number] = curve(times, np.asarray(heights) + problem.profile(radii))
            elif each.quantity == "worn_volume":
                worn[number] = curve(times, values_of_ring(volumes, each.ring))
        depths = history.indentation + problem.profile.standoff
        forces = np.asarray(history.force, dtype=float)
        return March(earliest, latest, curve(times, depths), curve(times, forces), worn)


def spline_of_root(times: Array, values: Array) -> Curve:
    """Return a spline in the fourth root of time.

    From a contact at a point, the contact radius grows approximately with this root.
    """
    spline = CubicSpline(times**0.25, values, axis=0)
    return lambda at_times: np.asarray(spline(at_times**0.25))


def monotone(times: Array, values: Array) -> Curve:
    """Return a curve through values that does not overshoot where the load has a kink."""
    curve = PchipInterpolator(times, values, axis=0)
    return lambda at_times: np.asarray(curve(at_times))


def cubic_weights(position: float) -> tuple[float, ...]:
    """Return the weights of the values at -1, 0, 1 and 2 in the cubic through them, at a position.

    The position is between 0 and 1.
    """
    points = STENCIL.astype(float)
    return tuple(
        float(np.prod([(position - other) / (each - other) for other in points if other != each]))
        for each in points
    )


def marched_predictor(
    scene: Scene,
    parameters: tuple[Parameter, ...],
    measurements: tuple[Measurement, ...],
    rtol: float,
    origin: Array,
) -> Predictor:
    """Return the model of a punch whose contact changes.

    At the origin (m,) it is a march itself; elsewhere it is interpolated between marches.
    """
    return MarchedPredictor(scene, parameters, measurements, MARCH_RTOL_FACTOR * rtol, origin)
