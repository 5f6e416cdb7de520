"""The rig around the punch, and what models of the punch have in common when they predict."""

from dataclasses import dataclass

import numpy as np

from ....meshes.radial import Array
from ..measurement import Measurement, Predictor
from ..parameters import Parameter


@dataclass(frozen=True)
class Rig:
    """What is unknown of the rig: the start of time, the sensor's offset, the machine's compliance.

    Parameters
    ----------
    parameters : of the fit, those of the rig among them
    """

    parameters: tuple[Parameter, ...]

    def value(self, name: str, x: Array) -> float:
        """Return the value of an unknown at coordinates (m,); 0 if it is not fitted."""
        number = self.number(name)
        return 0.0 if number is None else self.parameters[number].at(float(x[number]))

    def number(self, name: str) -> int | None:
        """Return the number of an unknown among the parameters; None if it is not fitted."""
        names = [parameter.name for parameter in self.parameters]
        return names.index(name) if name in names else None

    def since_start(self, times: Array, x: Array) -> Array:
        """Return times (n,) since sliding began."""
        return np.maximum(times - self.value("start_time", x), 0.0)

    def shown(self, depths: Array, forces: Array, x: Array) -> Array:
        """Return what a displacement sensor shows (n,) at indentations and forces."""
        given = forces * self.value("machine_compliance", x)
        return np.asarray(depths + self.value("sensor_offset", x) + given)

    def with_slopes(
        self, slopes: Array, measurement: Measurement, since: Array, rates: Array, forces: Array
    ) -> Array:
        """Return derivatives (n, m) with those by the unknowns of the rig.

        Parameters
        ----------
        slopes : (n, m), 0 by these unknowns
        measurement : whose they are
        since : (n,) times since sliding began
        rates : (n,) the time times the derivative by it of what is measured
        forces : (n,) of the punch
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
    """Return the first time after the start of anything that is measured."""
    times = np.concatenate([rig.since_start(each.times, x) for each in measurements])
    return float(min(times[times > 0], default=1.0))


def differences(predictor: Predictor, x: Array, steps: Array) -> list[Array]:
    """Return central differences (n, m) of what is predicted, by steps (m,) of the coordinates."""
    columns = []
    for number, step in enumerate(steps):
        moved = np.zeros(len(x))
        moved[number] = step
        above, below = predictor.predict(x + moved), predictor.predict(x - moved)
        columns.append([(a - b) / (2 * step) for a, b in zip(above, below, strict=True)])
    return [np.column_stack(of_one) for of_one in zip(*columns, strict=True)]


def of_ring(values: Array, ring: int | None) -> Array:
    """Return those (n,) of a ring from values (n, rings) or (n, rings, ...), or of all together."""
    return np.asarray(values.sum(axis=1) if ring is None else values[:, ring])
