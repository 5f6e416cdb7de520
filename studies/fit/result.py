"""The result of a fit: estimates, intervals, correlations and residuals, shown and saved."""

import re
from dataclasses import dataclass
from functools import cached_property, partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from lmfit import Minimizer, Parameters, fit_report

from ...meshes import Array, RingwearError
from ..crosscheck import AnswersGuesses, Scene, make, output_folder
from ..estimate.estimator import Likelihood, Point
from ..estimate.measurement import Measurement
from ..estimate.parameter import Parameter
from ..estimate.profiles import Profiles
from ..report.template import write_study
from ..tables.writing import write_csv
from .residual_tests import LEVEL, combined
from .words import conclusions_of_fit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABLES = ("estimates.csv", "residuals.csv", "tests.csv")
FILES = (*TABLES, "fit.png", "likelihood.png", "report.html")
# a parameter is identifiable if both ends of its interval are within this factor of the estimate
MAX_FACTOR = 2.0


@dataclass(frozen=True)
class Estimate:
    """The estimate of one parameter, in its coordinate, which usually is a logarithm.

    Parameters
    ----------
    parameter : that is estimated
    best : most likely coordinate
    low, high : ends of the 95 % interval, infinite where it is open
    deviation : standard error of the coordinate, by the curvature; NaN if it is not fitted
    numerical : change of the coordinate by the numerical error of the model
    by_profile : whether the interval follows from the profile of the likelihood, not its curvature
    """

    parameter: Parameter
    best: float
    low: float
    high: float
    deviation: float
    numerical: float
    by_profile: bool

    @property
    def identifiable(self) -> bool:
        """Whether the interval is bounded: to a factor of two on each side if it is positive.

        An interval that does not contain the estimate says nothing: the search has ended beyond the
        range of values that are tried.
        """
        if not self.low <= self.best <= self.high:
            return False
        widest = max(self.best - self.low, self.high - self.best)
        return bool(widest < (np.log(MAX_FACTOR) if self.parameter.logarithmic else np.inf))

    @property
    def value(self) -> float:
        """The most likely value, in the units of the scene."""
        return self.parameter.at(self.best)

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of the interval, in the units of the scene; 0 or infinite where it is open."""
        return self.parameter.at(self.low), self.parameter.at(self.high)

    @property
    def standard_error(self) -> float:
        """The standard error of the value by the curvature; NaN if the parameter is not fitted."""
        scale = abs(self.value) if self.parameter.logarithmic else self.parameter.scale
        return scale * self.deviation


@dataclass(frozen=True, eq=False, repr=False)
class Fit(AnswersGuesses):
    """The result of a fit, which is shown in print and in notebooks, and saved to a folder.

    n is the number of values, f that of free parameters.

    Parameters
    ----------
    scene : with the initial values of the parameters
    likelihood : of the measurements, with a model that is accurate enough for their noise
    best : the most likely point
    found : the estimate of each parameter
    profiles : of the likelihood, for parameters whose likelihood is not nearly quadratic
    combinations : indices of the parameters in each combination without effect; the last parameter
        is held at its value in the scene
    tests : probabilities of the residuals, by the names of the tests
    rtol : tolerance of the model
    model_error : greatest numerical error of the model, over the noise, by the difference to a
        model with a finer tolerance
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

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        """The measurements with their noise."""
        return self.likelihood.measurements

    @cached_property
    def estimates(self) -> pd.DataFrame:
        """By parameter: value, standard error, 95 % interval (low, high), whether identifiable.

        Further columns: `numerical`, the relative error of the estimate by the numerical error of
        the model (absolute if the parameter is not positive), and `profile`, whether the interval
        follows from the profile of the likelihood.
        """
        rows = {
            each.parameter.name: {
                "value": each.value,
                "stderr": each.standard_error,
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
        """The sum of the squared residuals, each over its noise."""
        return self.best.chi_square

    @property
    def degrees_of_freedom(self) -> int:
        """The expected value of chi-square, if the noise is as given."""
        return self.likelihood.degrees_of_freedom

    @property
    def reduced_chi_square(self) -> float:
        """Chi-square over its expected value; NaN if there are as many parameters as values."""
        freedom = self.degrees_of_freedom
        return self.chi_square / freedom if freedom > 0 else float("nan")

    def report(self) -> str:
        """Return statistics, parameters and correlations as lmfit's `fit_report`, and intervals."""
        likelihood, names = self.likelihood, [each.parameter.name for each in self.found]
        known = Parameters()
        for number, each in enumerate(self.found):
            known.add(f"x{number}", each.best, number in likelihood.free)

        def coordinates(values: Parameters) -> Array:
            return np.array([*values.valuesdict().values()])

        minimizer = Minimizer(
            lambda values: likelihood.residuals(coordinates(values)),
            known,
            scale_covar=False,
            Dfun=lambda values: -likelihood.slopes(coordinates(values)),
        )
        shown = known
        if likelihood.free:
            shown = minimizer.least_squares()
            shown.redchi, known = self.reduced_chi_square, shown.params
        for each, value in zip(self.found, known.values(), strict=True):
            value.set(value=each.value)
            value.init_value = each.parameter.value
            value.stderr = each.standard_error if value.vary else None
        lines = [fit_report(shown), "[[95 % Intervals]]"]
        lines += [
            f"    {name}: {each.ends[0]:.7g} to {each.ends[1]:.7g}"
            for name, each in zip(names, self.found, strict=True)
        ]
        return re.sub(r"\bx(\d+)\b", lambda found: names[int(found[1])], "\n".join(lines))

    @cached_property
    def correlations(self) -> pd.DataFrame:
        """Correlations of the free parameters, by the curvature."""
        deviations = np.sqrt(np.diag(self.profiles.covariance))
        names = [self.likelihood.parameters[number].name for number in self.likelihood.free]
        scaled = self.profiles.covariance / np.outer(deviations, deviations)
        return pd.DataFrame(scaled, index=names, columns=names)

    @property
    def fits(self) -> bool:
        """Whether the tests of the residuals do not reject the model."""
        return combined(self.tests) >= LEVEL

    @cached_property
    def bands(self) -> Array:
        """(n,) half widths of the 95 % band of the fitted values, in the units of the scene."""
        slopes = self.likelihood.slopes(self.best.x)
        variances = np.einsum("ni,ij,nj->n", slopes, self.profiles.covariance, slopes)
        return np.sqrt(variances * self.profiles.threshold) * self.likelihood.noise

    @cached_property
    def residuals(self) -> pd.DataFrame:
        """Measured and fitted values, and residuals over the noise, of all measurements."""
        likelihood, tables = self.likelihood, []
        predicted = likelihood.predictor.predict(self.best.x)
        residuals = likelihood.split(likelihood.residuals(self.best.x))
        for each, values, residual in zip(self.measurements, predicted, residuals, strict=True):
            # the unknown offset of a profile is estimated by the weighted mean of its residuals
            weights = 1 / each.noise**2
            offset = np.average(each.values - values, weights=weights) if each.has_offset else 0.0
            columns = {
                "quantity": each.label,
                "time": each.times,
                "radius": np.nan if each.radii is None else each.radii,
                "measured": each.values,
                "fitted": values + offset,
                "noise": each.noise,
                "residual": residual,
            }
            tables.append(pd.DataFrame(columns))
        return pd.concat(tables, ignore_index=True).dropna(axis="columns", how="all")

    @cached_property
    def conclusions(self) -> tuple[str, ...]:
        """The conclusions in sentences."""
        return conclusions_of_fit(self)

    @cached_property
    def figures(self) -> "dict[str, Figure]":
        """The figures, by the name of their file without its ending."""
        from ..figures.style import in_style
        from .figures import draw_all

        with in_style():
            return draw_all(self)

    def __repr__(self) -> str:
        """Return the conclusions."""
        title = f"Fit of {self.scene.title or 'an untitled scene'}"
        return "\n".join([title, *(f"  {line}" for line in self.conclusions)])

    def _repr_html_(self) -> str:
        """Return conclusions, estimates and figures as HTML, for notebooks."""
        from ..figures.style import html_of

        blocks = [f"<pre>{escape(repr(self))}</pre>"]
        blocks.append(self.estimates.to_html(float_format="{:.4g}".format))
        blocks += map(html_of, self.figures.values())
        return "".join(blocks)

    def save(self, folder: str | Path) -> list[str]:
        """Write the files of ``ringwear fit --out folder``, and return their names.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or contains other files with these names
        RingwearError
            if a figure or the page cannot be made
        """
        with output_folder(folder, "fit", FILES) as out:
            if failures := self.write(out.hidden):
                raise RingwearError("; ".join(failures))
        return out.written

    def write(self, folder: Path) -> list[str]:
        """Write tables, figures and the page to a folder; return messages on what failed."""
        from ..figures.style import in_style

        tables = {
            "estimates": self.estimates.rename_axis("parameter").reset_index(),
            "residuals": self.residuals,
            "tests": pd.DataFrame({"test": self.tests.keys(), "probability": self.tests.values()}),
        }
        for name, table in tables.items():
            if len(table):
                write_csv(table, folder / f"{name}.csv")
        for name, figure in self.figures.items():
            with in_style():
                figure.savefig(folder / f"{name}.png")
        title = f"Fit of {self.scene.title or 'an untitled scene'}"
        purpose = "Parameters that measurements determine, their intervals, and what is unknown."
        write = partial(write_study, title, purpose, self.scene, self.conclusions, tables.items())
        return make(folder / "report.html", write)
