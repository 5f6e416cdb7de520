"""The rig around the punch, and functions that all predictors share."""

from dataclasses import dataclass

import numpy as np

from ....meshes import Array
from ..measurement import Measurement, Predictor
from ..parameters import Parameter


@dataclass(frozen=True)
class Rig:
    """Unknowns of the rig: start time, offset of the sensor, compliance of the machine.

    Parameters
    ----------
    parameters : the m parameters of the fit, those of the rig among them
    """

    parameters: tuple[Parameter, ...]

    def value(self, name: str, x: Array) -> float:
        """Return the value of an unknown at coordinates (m,); 0 if it is not fitted."""
        number = self.number(name)
        return 0.0 if number is None else self.parameters[number].at(float(x[number]))

    def number(self, name: str) -> int | None:
        """Return the index of an unknown among the parameters; None if it is not fitted."""
        names = [parameter.name for parameter in self.parameters]
        return names.index(name) if name in names else None

    def since_start(self, times: Array, x: Array) -> Array:
        """Return the times (n,) since sliding began, from times (n,) by the clock of the data."""
        return np.maximum(times - self.value("start_time", x), 0.0)

    def sensor_reading(self, depths: Array, forces: Array, x: Array) -> Array:
        """Return the readings (n,) of a displacement sensor at indentations and forces (n,)."""
        machine_displacement = forces * self.value("machine_compliance", x)
        return np.asarray(depths + self.value("sensor_offset", x) + machine_displacement)

    def with_slopes(
        self, slopes: Array, measurement: Measurement, since: Array, rates: Array, forces: Array
    ) -> Array:
        """Return the derivatives (n, m) completed by those with respect to unknowns of the rig.

        Parameters
        ----------
        slopes : (n, m) derivatives, 0 in the columns of these unknowns
        measurement : whose derivatives they are
        since : (n,) times t since sliding began
        rates : (n,) t d/dt of the predicted values
        forces : (n,) on the punch
        """
        slopes = slopes.copy()
        if (number := self.number("start_time")) is not None:
            slopes[:, number] -= self.parameters[number].scale * np.divide(
                rates, since, out=np.zeros(len(since)), where=since > 0
            )
        if measurement.quantity == "indentation":
            for name, slope in (("sensor_offset", 1.0), ("machine_compliance", forces)):
                if (number := self.number(name)) is not None:
                    slopes[:, number] = slope * self.parameters[number].scale
        return slopes


def first_time(rig: Rig, measurements: tuple[Measurement, ...], x: Array) -> float:
    """Return the earliest time after the start of all measurements; 1 if there is none."""
    times = np.concatenate([rig.since_start(each.times, x) for each in measurements])
    return float(min(times[times > 0], default=1.0))


def differences(predictor: Predictor, x: Array, steps: Array) -> list[Array]:
    """Return central differences (n, m) of each measurement, by steps (m,) of the coordinates."""
    columns = []
    for number, step in enumerate(steps):
        shift = np.zeros(len(x))
        shift[number] = step
        above, below = predictor.predict(x + shift), predictor.predict(x - shift)
        columns.append([(a - b) / (2 * step) for a, b in zip(above, below, strict=True)])
    return [np.column_stack(by_parameter) for by_parameter in zip(*columns, strict=True)]


def values_of_ring(values: Array, ring: int | None) -> Array:
    """Return the values of one ring, or the sum over all rings if the ring is None.

    Parameters
    ----------
    values : (n, rings) or (n, rings, ...)
    """
    return np.asarray(values.sum(axis=1) if ring is None else values[:, ring])
