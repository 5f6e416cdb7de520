"""Measurements of a punch whose contact opens, closes or spreads, predicted by marches.

A march takes about a second. So it is done at the points of a lattice in what the non-dimensional
history depends on, each when it is first needed, and what is between them is interpolated: cubic in
that, and by splines in time. Under a constant load wear coefficients, modulus and speed that change
together only stretch the time, and the lattice has one dimension less: one march serves every wear
coefficient of one material.
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
from ....meshes.errors import SceneError
from ....meshes.radial import Array
from ...methods.moving_evaluation import MovingContact
from ...methods.spaces import choose_spaces
from ...progress import LOG
from ...scene.scene import Scene
from ..measurement import Measurement, Predictor
from ..parameters import Parameter, scene_at
from .flat_predictor import Logs
from .rig import Rig, differences, of_ring

# spacing of the lattice in logarithms
SPACING = 0.4
# most dimensions of the lattice: each takes four times as many marches
MOST_DIMENSIONS = 2
# times a decade that a march is watched at, and times by which it goes beyond those that are asked
PER_DECADE, SPAN = 12, 4.0
# step of coordinates for derivatives of what is interpolated
STEP = 1e-3
# accuracy of a march over that which is asked for: it is not as smooth as modes are
SHARPER = 0.1
# part of a time that is roundoff
ROUNDOFF = 1e-9
# values by time
Curve: TypeAlias = Callable[[Array], Array]
# points of the lattice that a cubic goes through, from the one below
STENCIL = np.array([-1, 0, 1, 2])


@dataclass(frozen=True, eq=False)
class Watched:
    """A march at one point of the lattice: values of every measurement at times, as functions.

    Parameters
    ----------
    earliest, latest : times in units of the march that it serves, 0 aside
    depths, forces : of time
    worn : of time, by the number of the measurement; profiles (R,), volumes a number
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
    scene : with the values to start from
    parameters : of the fit
    measurements : to predict
    rtol : accuracy of the marches
    origin : (m,) coordinates at which there is a point of the lattice
    """

    scene: Scene
    parameters: tuple[Parameter, ...]
    measurements: tuple[Measurement, ...]
    rtol: float
    origin: Array
    _marches: dict[tuple[int, ...], Watched] = field(default_factory=dict)

    def measuring(self, measurements: tuple[Measurement, ...]) -> "MarchedPredictor":
        """Return the model of other measurements, with the same marches if these suit them."""
        places = [(each.quantity, each.ring, each.radii is None) for each in measurements]
        own = [(each.quantity, each.ring, each.radii is None) for each in self.measurements]
        same = places == own and all(
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
        """Return the logarithms that the non-dimensional history depends on.

        Contrasts of wear, and the unit of heights, to which the face is compared; under a load that
        varies also the unit of time.
        """
        logs, units = Logs.of(scene), scene.problem.units
        clock = [np.log(units.time)] if self._varies else []
        return np.array([*(logs.wear[1:] - logs.wear[0]), np.log(units.displacement), *clock])

    @cached_property
    def _lattice(self) -> tuple[Array, Array]:
        """Lattice coordinates by those of the parameters (K, m), and back (m, K).

        Raises
        ------
        SceneError
            if there are too many dimensions
        """
        columns = [
            self._shape(self._scene(self.origin + moved))
            - self._shape(self._scene(self.origin - moved))
            for moved in STEP * np.eye(len(self.parameters))
        ]
        _, singular, right = np.linalg.svd(
            np.column_stack(columns) / (2 * STEP), full_matrices=False
        )
        rank = int(np.sum(singular > 1e-6))
        if rank > MOST_DIMENSIONS:
            raise SceneError(
                f"a fit of a punch whose contact changes depends on {rank} parameters beside the "
                f"scale of time, and {MOST_DIMENSIONS} are affordable: give fewer in --for"
            )
        return singular[:rank, None] * right[:rank], right[:rank].T / singular[:rank]

    def _scene(self, x: Array) -> Scene:
        return scene_at(self.scene, self.parameters, x)

    def _clock(self, scene: Scene) -> float:
        """Return the unit of time of the first material: that of all marches of a shape."""
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
        found = [np.zeros(len(times)) for times in since]
        for weight, watched in self._around(x, *ends):
            for number, (each, times) in enumerate(zip(self.measurements, since, strict=True)):
                at = times / clock
                if each.quantity == "indentation":
                    depths = watched.depths(at) * units.displacement
                    part = self._rig.shown(depths, watched.forces(at) * units.force, x)
                elif each.quantity == "normal_force":
                    part = watched.forces(at) * units.force
                elif each.radii is not None:
                    part = watched.worn[number](at[0]) * units.displacement
                else:
                    part = watched.worn[number](at) * units.volume
                found[number] = found[number] + weight * part
        return found

    def slopes(self, x: Array) -> list[Array]:
        """Return the derivatives (n, m) of each measurement by these coordinates."""
        return differences(self, x, np.full(len(x), STEP))

    def _around(self, x: Array, earliest: float, latest: float) -> Iterator[tuple[float, Watched]]:
        """Yield the marches about a place, with their weights in a cubic through them."""
        places = self._lattice[0] @ (x - self.origin) / SPACING
        # a point of the lattice needs no other
        places = np.where(np.abs(places - np.round(places)) < 1e-12, np.round(places), places)
        below = np.floor(places)
        weights = [cubic_weights(float(place)) for place in places - below]
        for corner in product(range(len(STENCIL)), repeat=len(places)):
            weight = prod(each[number] for each, number in zip(weights, corner, strict=True))
            point = tuple(
                int(low + STENCIL[number]) for low, number in zip(below, corner, strict=True)
            )
            if weight:
                yield weight, self._march(point, earliest, latest)

    def _march(self, point: tuple[int, ...], earliest: float, latest: float) -> Watched:
        """Return the march at a point of the lattice, which serves times from 0 on."""
        known = self._marches.get(point)
        if known and known.earliest <= earliest and latest <= known.latest:
            return known
        if known:
            earliest, latest = min(earliest, known.earliest), max(latest, known.latest)
        self._marches[point] = self._marched(point, earliest / SPAN, latest * SPAN)
        LOG.info("     fit  %d marches ...", len(self._marches))
        return self._marches[point]

    def _marched(self, point: tuple[int, ...], earliest: float, latest: float) -> Watched:
        """March a punch through times, in units of the first material's, and watch it."""
        moved = self._lattice[1] @ (SPACING * np.array(point, dtype=float))
        scene = self._scene(self.origin + moved)
        decades = np.log10(latest / earliest)
        times = np.geomspace(earliest, latest, int(np.ceil(PER_DECADE * decades)) + 2)
        if self._varies:
            knots = scene.problem.loading.times[1:] * scene.problem.units.time
            # what is measured while the load changes is not interpolated in time
            exact = np.concatenate([knots, *(each.times for each in self.measurements)])
            times = np.union1d(times, exact[(exact > earliest) & (exact < latest)])
            # knots that units have moved by roundoff are one time
            times = times[np.diff(times, prepend=0.0) > ROUNDOFF * times]
        times = np.append(0.0, times)
        problem = replace(
            scene.problem,
            times=times * self._clock(scene) / scene.problem.units.time,
            steady=False,
            rtol=self.rtol,
            quantities=None,
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
                worn[number] = curve(times, of_ring(volumes, each.ring))
        depths = history.indentation + problem.profile.standoff
        forces = np.asarray(history.force, dtype=float)
        return Watched(earliest, latest, curve(times, depths), curve(times, forces), worn)


def spline_of_root(times: Array, values: Array) -> Curve:
    """Return a spline by the fourth root of time: from a touch, contact grows about with that."""
    spline = CubicSpline(times**0.25, values, axis=0)
    return lambda at: np.asarray(spline(at**0.25))


def monotone(times: Array, values: Array) -> Curve:
    """Return a curve through values that does not overshoot where a load bends."""
    curve = PchipInterpolator(times, values, axis=0)
    return lambda at: np.asarray(curve(at))


def cubic_weights(place: float) -> tuple[float, ...]:
    """Return the weights of values at -1, 0, 1 and 2 in the cubic through them, at a place."""
    points = STENCIL.astype(float)
    return tuple(
        float(np.prod([(place - other) / (own - other) for other in points if other != own]))
        for own in points
    )


def marched_predictor(
    scene: Scene,
    parameters: tuple[Parameter, ...],
    measurements: tuple[Measurement, ...],
    rtol: float,
    origin: Array,
) -> Predictor:
    """Return the model of a punch whose contact changes, at an accuracy.

    At the origin (m,) it is a march itself; elsewhere it is interpolated among marches.
    """
    return MarchedPredictor(scene, parameters, measurements, SHARPER * rtol, origin)
