"""Synthetic experiments: how often intervals contain the truth and wrong laws are detected.

The true parameters are drawn around the values of the scene, and the data come from a model with a
finer tolerance than that of the fits.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ringwear import Scene
from ringwear.meshes import Array
from ringwear.studies.estimate.measurement import Measurement
from ringwear.studies.estimate.model import Model
from ringwear.studies.estimate.parameter import Parameter
from ringwear.studies.fit.fit import fit_measurements
from ringwear.studies.fit.parameters import find_parameters
from ringwear.studies.fit.result import Fit

# standard deviations of the logarithms of true parameters, by section of the scene: wear
# coefficients, and moduli
SCATTER = {"punch": 0.3, "half_space": 0.1}
# tolerance of the model from which the data come: of modes, and of marches
DATA_RTOL, DATA_RTOL_MARCH = 1e-4, 1e-2


@dataclass(frozen=True, eq=False)
class Experiments:
    """Experiments of one kind.

    Parameters
    ----------
    scene : with the values around which the true parameters are drawn
    names : of the parameters that are fitted
    columns : the measurements: quantity, times, radii or None, noise, and ring or None. The noise
        of an indentation is absolute, that of a profile relative to its range, any other relative
        to the values
    noise_known : whether the noise is given to the fits
    law : for data by another law than Archard's: a function from the times of the clock to the
        times at which Archard's law yields the same wear
    """

    scene: Scene
    names: tuple[str, ...]
    columns: tuple[tuple[str, Array, Array | None, float, int | None], ...]
    noise_known: bool = True
    law: Callable[[Array], Array] | None = None

    @cached_property
    def _prepared(self) -> tuple[Scene, tuple[Parameter, ...], tuple[Measurement, ...]]:
        times = np.unique(np.concatenate([column[1] for column in self.columns]))
        scene = self.scene.changed(wear__times=times.tolist())
        scene, parameters = find_parameters(scene, self.names)
        parameters = tuple(
            each if each.logarithmic else replace(each, scale=0.1) for each in parameters
        )
        empty = tuple(
            Measurement(
                quantity,
                quantity,
                times,
                np.ones(len(times)),
                np.ones(len(times)),
                self.noise_known,
                radii,
                ring,
            )
            for quantity, times, radii, _, ring in self.columns
        )
        return scene, parameters, empty

    @cached_property
    def sharp(self) -> Model:
        """The model from which the data come."""
        scene, parameters, empty = self._prepared
        if self.law is not None:
            empty = tuple(replace(each, times=self.law(each.times)) for each in empty)
        rtol = DATA_RTOL if scene.problem.full_contact else DATA_RTOL_MARCH
        return Model.of(scene, parameters, empty, rtol, np.zeros(len(parameters)))

    @cached_property
    def _models(self) -> dict[float, Any]:
        return {}

    def _model(
        self,
        scene: Scene,
        parameters: tuple[Parameter, ...],
        measurements: tuple[Measurement, ...],
        rtol: float,
        origin: Array,
    ) -> Model:
        """Return a model that shares its discretisation or marches with all experiments."""
        if rtol not in self._models:
            zeros = np.zeros(len(parameters))
            self._models[rtol] = Model.of(scene, parameters, measurements, rtol, zeros)
        predictor: Model = self._models[rtol].for_measurements(measurements)
        return predictor

    def conduct(self, seed: int) -> tuple[Array, Fit]:
        """Return the coordinates (m,) of the true parameters of one experiment, and its fit."""
        scene, parameters, empty = self._prepared
        random = np.random.default_rng(seed)
        scatter = [SCATTER.get(each.name.partition(".")[0], 0.0) for each in parameters]
        truth = random.normal(0.0, scatter)
        truth += np.array([0.0 if each.logarithmic else 0.2 for each in parameters])
        measurements = []
        for column, each, exact in zip(self.columns, empty, self.sharp.predict(truth), strict=True):
            spread = np.ptp(exact) if each.quantity == "profile" else np.abs(exact)
            noise = column[3] * (spread if each.quantity != "indentation" else 1.0)
            noise = noise * np.ones(len(exact))
            values = exact + noise * random.normal(size=len(exact))
            measurements.append(replace(each, values=values, noise=noise))
        with threadpool_limits(1):
            return truth, fit_measurements(scene, parameters, tuple(measurements), self._model)


TIMES = np.geomspace(1e-3, 5.0, 40)
RADII = np.linspace(0.005, 0.995, 60)
INDENTATION = ("indentation", TIMES, None, 1e-3, None)
EARLY_PROFILE = ("profile", np.full(60, 0.1), RADII, 0.01, None)
WEAR = "punch.wear_coefficients"


def falls_by_30_percent(times: Array) -> Array:
    """Return the times of equal wear at constant k, if k falls linearly by 30 % over the test."""
    return np.asarray(times - 0.15 * times**2 / times.max())


def cases() -> dict[str, Experiments]:
    """Return kinds of experiments by name."""
    two_materials = Scene.load("five_rings")
    five_rings = two_materials.changed({WEAR: [1.0, 10.0, 1.0, 10.0, 1.0]})
    ball = Scene.load("sphere").changed({WEAR: [1.0]})
    weighings = np.array([0.1, 0.3, 1.0, 3.0, 10.0])
    flat_on_layer = Scene(
        punch={"radius": 1.0, "wear_coefficient": 1e-9},
        half_space={
            "youngs_modulus": 2.0,
            "poisson_ratio": 0.3,
            "layers": [{"thickness": 0.3, "youngs_modulus": 1.0, "poisson_ratio": 0.3}],
        },
        load={"normal_force": {"times": [0.0, 1.0], "values": [3e-4, 0.15]}, "sliding_speed": 1.0},
    )
    return {
        "layer under a flat punch": Experiments(
            flat_on_layer,
            ("half_space.layers[0].thickness", "half_space.layers[0].youngs_modulus"),
            (
                ("indentation", np.array([0.0]), None, 1e-6, None),
                ("indentation", np.array([1.0]), None, 5e-4, None),
            ),
        ),
        "two": Experiments(two_materials, (WEAR,), (INDENTATION,)),
        "five": Experiments(five_rings, (WEAR,), (INDENTATION, EARLY_PROFILE)),
        "ball": Experiments(ball, (WEAR,), (("worn_volume", weighings, None, 0.02, None),)),
        "k falls": Experiments(two_materials, (WEAR,), (INDENTATION,), law=falls_by_30_percent),
    }
