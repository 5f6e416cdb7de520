"""Measurements of a flat punch, predicted by modes: exactly in time, with exact derivatives."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ....meshes.radial import Array
from ...problem.problem import Problem
from ...scene.scene import Scene
from ..measurement import Measurement, Predictor
from ..parameters import Parameter, scene_at
from .flat_histories import FlatHistories, FlatHistory
from .rig import Rig, differences, first_time, of_ring

# step of coordinates for derivatives of a history under a load that varies, which is smooth
STEP = 1e-4
# states that are kept: values and derivatives at one place are asked for one after the other
KEPT = 2


class Logs(NamedTuple):
    """Logarithms that a history depends on.

    Parameters
    ----------
    wear : (J,) of the wear coefficients
    modulus, load, speed : of the plane strain modulus, of the force or indentation, of the speed
    """

    wear: Array
    modulus: float
    load: float
    speed: float

    @classmethod
    def of(cls, scene: Scene) -> "Logs":
        """Return those of a scene."""
        units = scene.problem.units
        held = scene.problem.indentation is not None
        load = units.displacement if held else units.force
        return cls(
            np.log(wear_coefficients(scene)),
            float(np.log(units.modulus)),
            float(np.log(load)),
            float(np.log(scene.load_.speed_over_time.greatest)),
        )


class At(NamedTuple):
    """A history at some values of the parameters: of which problem, and its derivatives."""

    problem: Problem
    history: FlatHistory


@dataclass(frozen=True, eq=False)
class FlatPredictor:
    """Predict measurements of a flat punch that keeps full contact.

    Under a constant load the derivatives are exact; else they are central differences.

    Parameters
    ----------
    scene : with the values to start from
    parameters : of the fit
    measurements : to predict
    punch : discretised
    rtol : accuracy that it was discretised to
    """

    scene: Scene
    parameters: tuple[Parameter, ...]
    measurements: tuple[Measurement, ...]
    punch: FlatHistories
    rtol: float
    _kept: dict[bytes, At] = field(default_factory=dict)

    def measuring(self, measurements: tuple[Measurement, ...]) -> "FlatPredictor":
        """Return the model of other measurements."""
        return replace(self, measurements=measurements, _kept={})

    @cached_property
    def _rig(self) -> Rig:
        return Rig(self.parameters)

    def _at(self, x: Array) -> At:
        """Return the history at coordinates (m,)."""
        key = x.tobytes()
        if key not in self._kept:
            scene = scene_at(self.scene, self.parameters, x)
            problem = scene.problem
            wear = wear_coefficients(scene) / problem.units.wear_coefficient
            first = first_time(self._rig, self.measurements, x) / problem.units.time
            earliest = float(problem.loading.at(np.array([first])).distance[0])
            while len(self._kept) >= KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[key] = At(problem, self.punch.solve(problem, wear, earliest))
        return self._kept[key]

    def predict(self, x: Array) -> list[Array]:
        """Return the values (n,) of each measurement at coordinates (m,) of the parameters."""
        problem, history = self._at(x)
        units, found = problem.units, list[Array]()
        for each in self.measurements:
            times = self._rig.since_start(each.times, x) / units.time
            pressures, depths, forces = history.states(times)
            if each.quantity == "indentation":
                shown = depths * units.displacement, forces * units.force
                found.append(self._rig.shown(*shown, x))
                continue
            if each.quantity == "normal_force":
                found.append(forces * units.force)
                continue
            found.append(_worn(history, each, pressures, depths, units.length)[0])
            found[-1] *= units.displacement if each.radii is not None else units.volume
        return found

    def slopes(self, x: Array) -> list[Array]:
        """Return the derivatives (n, m) of each measurement by these coordinates."""
        if self.scene.problem.loading.varies:
            return differences(self, x, np.full(len(x), STEP))
        at, by_logs = self._at(x), self._logs_by_coordinates(x)
        return [self._slopes_of(at, each, x, by_logs) for each in self.measurements]

    def _slopes_of(self, at: At, each: Measurement, x: Array, by_logs: Array) -> Array:
        """Return the derivatives (n, m) of one measurement.

        Depths go as ``F/(a E*)`` times a function of ``E* k v t``, forces at a fixed indentation as
        ``a E* d`` times such a one. So the derivatives by wear, whose sum is ``t d'(t)``, give
        those by modulus, load and speed.

        Parameters
        ----------
        by_logs : (J + 3, m) derivatives of the logarithms of wear, modulus, load and speed
        """
        (problem, history), units = at, at.problem.units
        since = self._rig.since_start(each.times, x)
        times, held = since / units.time, problem.indentation is not None
        pressures, depths, forces = history.states(times)
        none = np.zeros((len(times), len(history.coefficients)))
        if each.quantity == "indentation":
            values, unit = depths, units.displacement
            wear = none if held else history.response_slopes(times)
        elif each.quantity == "normal_force":
            values, unit = forces, units.force
            wear = history.response_slopes(times) if held else none
        else:
            values, integrals = _worn(history, each, pressures, depths, units.length)
            unit = units.displacement if each.radii is not None else units.volume
            wear = _worn_slopes(history, each, times, integrals, units.length)
        # of the modulus that the unit has
        power = (0.0 if held else -1.0) + (each.quantity == "normal_force")
        rates = wear.sum(axis=1)
        whole = np.column_stack([wear, power * values + rates, values, rates])
        slopes = unit * (whole @ by_logs)
        return self._rig.with_slopes(slopes, each, since, unit * rates, forces * units.force)

    def _logs_by_coordinates(self, x: Array) -> Array:
        """Return the derivatives (J + 3, m) of the logarithms by the coordinates.

        They are constant unless an elastic punch shares the modulus.
        """
        if self.scene.half_space.punch_youngs_modulus is None:
            return self._logs_at_start
        return self._log_differences(x)

    @cached_property
    def _logs_at_start(self) -> Array:
        return self._log_differences(np.zeros(len(self.parameters)))

    def _log_differences(self, x: Array) -> Array:
        columns = []
        for moved in STEP * np.eye(len(x)):
            above, below = (
                np.hstack(Logs.of(scene_at(self.scene, self.parameters, place)))
                for place in (x + moved, x - moved)
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
    """Return the model of a flat punch at an accuracy, which serves the times of the data.

    It is as good at all coordinates (m,) as at the last argument.
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
    """Return the wear coefficients (J,) of the rings of a scene, or of its table."""
    given = np.array(scene.punch.coefficients)
    return given if scene.punch.table else np.resize(given, len(scene.problem.wear_coefficients))


def _worn(
    history: FlatHistory, each: Measurement, pressures: Array, depths: Array, length: float
) -> tuple[Array, Array]:
    """Return worn heights or volumes (n,), non-dimensional, and integrals of the pressure.

    A profile is of one time, and so is its integral (1, k); those of volumes are (n, k).
    """
    if each.radii is not None:
        integrals = history.pressure_integrals(pressures[:1], depths[:1])
        return history.profiles(integrals, each.radii / length)[0], integrals
    integrals = history.pressure_integrals(pressures, depths)
    return of_ring(history.worn_volumes(integrals), each.ring), integrals


def _worn_slopes(
    history: FlatHistory, each: Measurement, times: Array, integrals: Array, length: float
) -> Array:
    """Return the derivatives (n, J) of worn heights or volumes by wear."""
    if each.radii is not None:
        return history.worn_slopes(float(times[0]), integrals[0], each.radii / length)
    rows = [
        history.worn_slopes(float(time), integral, None)
        for time, integral in zip(times, integrals, strict=True)
    ]
    return of_ring(np.array(rows), each.ring)
