"""Predict measurements of a flat punch by relaxation modes: exact in time, exact derivatives."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....meshes import Array
from ...crosscheck import Problem, Scene
from ..measurement import Measurement, Predictor
from ..parameters import Parameter, scene_at
from .flat_histories import FlatHistories, FlatHistory
from .rig import Rig, differences, first_time, values_of_ring

# step of the coordinates in central differences; the history is smooth in them
STEP = 1e-4
# number of histories that are stored, because values and derivatives at the same coordinates are
# often computed one after the other
STORED_HISTORIES = 2


class Logs(NamedTuple):
    """Logarithms of the scene's values on which a history depends.

    Parameters
    ----------
    wear : (J,) of the wear coefficients
    modulus : of the plane strain modulus
    load : of the force or of the indentation, whichever is prescribed
    speed : of the greatest sliding speed
    """

    wear: Array
    modulus: float
    load: float
    speed: float

    @classmethod
    def of(cls, scene: Scene) -> "Logs":
        """Return the logarithms of a scene."""
        units = scene.problem.units
        indentation_prescribed = scene.problem.indentation is not None
        load = units.displacement if indentation_prescribed else units.force
        return cls(
            np.log(wear_coefficients(scene)),
            float(np.log(units.modulus)),
            float(np.log(load)),
            float(np.log(scene.load_.speed_over_time.greatest)),
        )


class ParameterPoint(NamedTuple):
    """The problem, and its history, at some values of the parameters."""

    problem: Problem
    history: FlatHistory


@dataclass(frozen=True, eq=False)
class FlatPredictor:
    """Predict measurements of a flat punch that keeps full contact.

    Under a constant load the derivatives are exact; otherwise they are central differences.

    Parameters
    ----------
    scene : with the initial values of the parameters
    parameters : m parameters of the fit
    measurements : that are predicted
    punch : the discretised punch
    rtol : tolerance of the discretisation
    """

    scene: Scene
    parameters: tuple[Parameter, ...]
    measurements: tuple[Measurement, ...]
    punch: FlatHistories
    rtol: float
    _stored: dict[bytes, ParameterPoint] = field(default_factory=dict)

    def for_measurements(self, measurements: tuple[Measurement, ...]) -> "FlatPredictor":
        """Return the model that predicts other measurements."""
        return replace(self, measurements=measurements, _stored={})

    @cached_property
    def _rig(self) -> Rig:
        return Rig(self.parameters)

    def _point(self, x: Array) -> ParameterPoint:
        """Return the problem and its history at coordinates (m,)."""
        key = x.tobytes()
        if key not in self._stored:
            scene = scene_at(self.scene, self.parameters, x)
            problem = scene.problem
            wear = wear_coefficients(scene) / problem.units.wear_coefficient
            first = first_time(self._rig, self.measurements, x) / problem.units.time
            earliest = float(problem.loading.at(np.array([first])).distance[0])
            while len(self._stored) >= STORED_HISTORIES:
                del self._stored[next(iter(self._stored))]
            self._stored[key] = ParameterPoint(problem, self.punch.solve(problem, wear, earliest))
        return self._stored[key]

    def predict(self, x: Array) -> list[Array]:
        """Return the values (n,) of each measurement at coordinates (m,) of the parameters."""
        problem, history = self._point(x)
        units, predictions = problem.units, list[Array]()
        for each in self.measurements:
            times = self._rig.since_start(each.times, x) / units.time
            pressures, depths, forces = history.states(times)
            if each.quantity == "indentation":
                scene_values = depths * units.displacement, forces * units.force
                predictions.append(self._rig.sensor_reading(*scene_values, x))
                continue
            if each.quantity == "normal_force":
                predictions.append(forces * units.force)
                continue
            predictions.append(_worn(history, each, pressures, depths, units.length)[0])
            predictions[-1] *= units.displacement if each.radii is not None else units.volume
        return predictions

    def slopes(self, x: Array) -> list[Array]:
        """Return the derivatives (n, m) of each measurement by the coordinates."""
        if self.scene.problem.loading.varies:
            return differences(self, x, np.full(len(x), STEP))
        point, by_coordinates = self._point(x), self._logs_by_coordinates(x)
        return [self._slopes_of(point, each, x, by_coordinates) for each in self.measurements]

    def _slopes_of(
        self, point: ParameterPoint, each: Measurement, x: Array, by_coordinates: Array
    ) -> Array:
        """Return the derivatives (n, m) of one measurement.

        Depths are ``F/(a E*)`` times a function of ``E* k v t``; forces at a fixed indentation are
        ``a E* d`` times such a function. Therefore the derivatives by the logarithms of the wear
        coefficients, whose sum is ``t d'(t)``, yield those by modulus, load and speed.

        Parameters
        ----------
        by_coordinates : (J + 3, m) derivatives of the logarithms of wear, modulus, load and speed
        """
        (problem, history), units = point, point.problem.units
        since = self._rig.since_start(each.times, x)
        times, indentation_prescribed = since / units.time, problem.indentation is not None
        pressures, depths, forces = history.states(times)
        zeros = np.zeros((len(times), len(history.coefficients)))
        if each.quantity == "indentation":
            values, unit = depths, units.displacement
            wear = zeros if indentation_prescribed else history.response_slopes(times)
        elif each.quantity == "normal_force":
            values, unit = forces, units.force
            wear = history.response_slopes(times) if indentation_prescribed else zeros
        else:
            values, integrals = _worn(history, each, pressures, depths, units.length)
            unit = units.displacement if each.radii is not None else units.volume
            wear = _worn_slopes(history, each, times, integrals, units.length)
        # exponent of the modulus in the unit of the quantity
        power = (0.0 if indentation_prescribed else -1.0) + (each.quantity == "normal_force")
        rates = wear.sum(axis=1)
        by_logs = np.column_stack([wear, power * values + rates, values, rates])
        slopes = unit * (by_logs @ by_coordinates)
        return self._rig.with_slopes(slopes, each, since, unit * rates, forces * units.force)

    def _logs_by_coordinates(self, x: Array) -> Array:
        """Return the derivatives (J + 3, m) of the logarithms by the coordinates.

        They are constant, unless the punch is elastic, because its modulus then enters E*, too.
        """
        if self.scene.half_space.punch_youngs_modulus is None:
            return self._logs_at_start
        return self._log_differences(x)

    @cached_property
    def _logs_at_start(self) -> Array:
        return self._log_differences(np.zeros(len(self.parameters)))

    def _log_differences(self, x: Array) -> Array:
        columns = []
        for shift in STEP * np.eye(len(x)):
            above, below = (
                np.hstack(Logs.of(scene_at(self.scene, self.parameters, coordinates)))
                for coordinates in (x + shift, x - shift)
            )
            columns.append((above - below) / (2 * STEP))
        return np.column_stack(columns)


def flat_predictor(
    scene: Scene,
    parameters: tuple[Parameter, ...],
    measurements: tuple[Measurement, ...],
    rtol: float,
    _origin: Array,
) -> Predictor:
    """Return the model of a flat punch, discretised for the times of the data.

    The last argument, the coordinates (m,) at which a model is most accurate, has no effect,
    because this model is equally accurate at all coordinates.
    """
    problem = replace(scene.problem, rtol=rtol)
    times = np.concatenate([each.times for each in measurements]) / problem.units.time
    distances = problem.loading.at(times).distance
    distances = distances[distances > 0]
    fields = any(each.quantity in ("profile", "worn_volume") for each in measurements)
    table = scene.punch.table
    radii = np.array(table.radii) / problem.units.length if table else None
    ends = float(distances.min()), float(distances.max())
    punch = FlatHistories.discretise(problem, *ends, fields, radii)
    return FlatPredictor(scene, parameters, measurements, punch, rtol)


def wear_coefficients(scene: Scene) -> Array:
    """Return the wear coefficients (J,) of the rings of a scene, or the values of its table."""
    values = np.array(scene.punch.coefficients)
    return values if scene.punch.table else np.resize(values, len(scene.problem.wear_coefficients))


def _worn(
    history: FlatHistory, each: Measurement, pressures: Array, depths: Array, length: float
) -> tuple[Array, Array]:
    """Return worn heights or volumes (n,), non-dimensional, and integrals of the pressure.

    For a profile, which has one time, the integrals are (1, k), for volumes (n, k).

    Parameters
    ----------
    pressures, depths : (n, k) and (n,) at the times of the measurement
    length : punch radius, in the units of the scene
    """
    if each.radii is not None:
        integrals = history.pressure_integrals(pressures[:1], depths[:1])
        return history.profiles(integrals, each.radii / length)[0], integrals
    integrals = history.pressure_integrals(pressures, depths)
    return values_of_ring(history.worn_volumes(integrals), each.ring), integrals


def _worn_slopes(
    history: FlatHistory, each: Measurement, times: Array, integrals: Array, length: float
) -> Array:
    """Return the derivatives (n, J) of worn heights or volumes by the logarithms of wear."""
    if each.radii is not None:
        return history.worn_slopes(float(times[0]), integrals[0], each.radii / length)
    rows = [
        history.worn_slopes(float(time), integral, None)
        for time, integral in zip(times, integrals, strict=True)
    ]
    return values_of_ring(np.array(rows), each.ring)
