"""What a fit has found, in numbers: estimates, intervals, correlations, residuals."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd

from ...meshes.radial import Array
from ..scene.scene import Scene
from .measurement import Measurement
from .parameters import Parameter
from .statistics.likelihood import Likelihood, Point
from .statistics.profiles import Profiles
from .statistics.residual_tests import LEVEL, combined

# a parameter that is known to no better than this factor on a side is not identifiable
FACTOR = 2.0


@dataclass(frozen=True)
class Estimate:
    """What the measurements say of one parameter, in its coordinate (a logarithm, mostly).

    Parameters
    ----------
    parameter : which
    best : most likely
    low, high : ends of the 95 % interval, infinite where it has none
    numerical : by how much the error of the model moves it
    by_profile : whether the interval is from the profile of the likelihood, not its curvature
    """

    parameter: Parameter
    best: float
    low: float
    high: float
    numerical: float
    by_profile: bool

    @property
    def identifiable(self) -> bool:
        """Whether both sides end, of what is positive within a factor of two."""
        widest = max(self.best - self.low, self.high - self.best)
        return bool(widest < (np.log(FACTOR) if self.parameter.logarithmic else np.inf))

    @property
    def value(self) -> float:
        """The most likely value, in the units of the scene."""
        return self.parameter.at(self.best)

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of the interval, in the units of the scene; 0 and infinite where it has none."""
        return self.parameter.at(self.low), self.parameter.at(self.high)


@dataclass(frozen=True, eq=False, repr=False)
class Outcome:
    """What measurements say of parameters of a scene, in numbers.

    Parameters
    ----------
    scene : with the values that the search began at
    likelihood : of the measurements, at the accuracy that they ask for
    best : the most likely point
    found : what is said of each parameter
    profiles : of the likelihood, where curvature was not enough
    combinations : numbers of the parameters whose combination has no effect; the last is held
    tests : probabilities of the residuals, by the names of the tests
    rtol : accuracy of the model
    model_error : its greatest error over the noise, by the difference to a sharper one
    design : further measurements with the widest interval that they would leave, best first; empty
        if it was not asked for
    """

    scene: Scene
    likelihood: Likelihood
    best: Point
    found: tuple[Estimate, ...]
    profiles: Profiles
    combinations: tuple[tuple[int, ...], ...]
    tests: dict[str, float]
    rtol: float
    model_error: float
    design: pd.DataFrame = field(default_factory=pd.DataFrame)

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """What was measured, with its noise."""
        return self.likelihood.measurements

    @cached_property
    def estimates(self) -> pd.DataFrame:
        """By parameter: value, low and high end of the 95 % interval, and whether identifiable.

        Further columns: `numerical`, the relative error that the model's accuracy brings (absolute
        where the parameter is not positive), and whether the interval is that of the `profile`.
        """
        rows = {
            each.parameter.name: {
                "value": each.value,
                "low": each.ends[0],
                "high": each.ends[1],
                "identifiable": each.identifiable,
                "numerical": each.numerical * each.parameter.scale,
                "profile": each.by_profile,
            }
            for each in self.found
        }
        return pd.DataFrame.from_dict(rows, orient="index")

    @property
    def chi_square(self) -> float:
        """The sum of the squared residuals, over the noise."""
        return self.best.chi_square

    @property
    def degrees_of_freedom(self) -> int:
        """What chi-square should be about, if the noise is as given."""
        return self.likelihood.degrees_of_freedom

    @cached_property
    def covariance(self) -> Array:
        """(f, f) of the coordinates of what was sought, by curvature."""
        return self.profiles.covariance

    @cached_property
    def correlations(self) -> pd.DataFrame:
        """Correlations of the parameters that were sought, by curvature."""
        deviations = np.sqrt(np.diag(self.covariance))
        names = [self.likelihood.parameters[number].name for number in self.likelihood.free]
        scaled = self.covariance / np.outer(deviations, deviations)
        return pd.DataFrame(scaled, index=names, columns=names)

    @property
    def fits(self) -> bool:
        """Whether the residuals do not speak against the model."""
        return combined(self.tests) >= LEVEL

    @cached_property
    def bands(self) -> Array:
        """(n,) half widths of the 95 % band of what is fitted, in the units of the data."""
        slopes = self.likelihood.slopes(self.best.x)
        variances = np.einsum("ni,ij,nj->n", slopes, self.covariance, slopes)
        return np.asarray(np.sqrt(variances * self.profiles.threshold) * self.likelihood.noise)

    def own_point(self, number: int) -> tuple[float, float]:
        """Return the best value of a parameter with its chi-square, as profiles have them."""
        return float(self.best.x[number]), self.best.chi_square

    @cached_property
    def residuals(self) -> pd.DataFrame:
        """What was measured, predicted, and left over the noise, by source."""
        predicted = self.likelihood.predictor.predict(self.best.x)
        left, row, tables = self.likelihood.residuals(self.best.x), 0, []
        for each, values in zip(self.measurements, predicted, strict=True):
            # the offset of a profile is the weighted mean of what it leaves
            weights = 1 / each.noise**2
            offset = np.average(each.values - values, weights=weights) if each.has_offset else 0.0
            columns = {
                "quantity": each.label,
                "time": each.times,
                "radius": np.nan if each.radii is None else each.radii,
                "measured": each.values,
                "fitted": values + offset,
                "noise": each.noise,
                "residual": left[row : row + len(values)],
            }
            tables.append(pd.DataFrame(columns))
            row += len(values)
        return pd.concat(tables, ignore_index=True).dropna(axis="columns", how="all")
