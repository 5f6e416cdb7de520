"""The value that a fit returns."""

from base64 import b64encode
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ...meshes.errors import RingwearError
from ...meshes.radial import Array
from ..figures.style import in_style
from ..output.folder import output_folder
from ..output.one_file import make
from ..problem.scene import Scene
from ..tables import write_csv
from .data import Measurement
from .likelihood import Likelihood, Point
from .parameters import Parameter
from .profiles import Profiles
from .residual_tests import LEVEL, combined

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# a parameter that is known to no better than this factor on a side is not identifiable
FACTOR = 2.0
TABLES = ("estimates.csv", "residuals.csv", "tests.csv", "design.csv")
FILES = (*TABLES, "fit.png", "likelihood.png", "design.png", "report.html")


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
class Fit:
    """What measurements say of parameters of a scene; it shows itself in print and in notebooks.

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

    @cached_property
    def conclusions(self) -> tuple[str, ...]:
        """What the measurements say, a sentence each."""
        from .words import conclusions

        return conclusions(self)

    @cached_property
    def figures(self) -> "dict[str, Figure]":
        """The figures, by the name of their file without its ending."""
        from .figures import draw_all

        with in_style():
            return draw_all(self)

    def with_design(self) -> "Fit":
        """Return it with further measurements, by how much they would narrow the intervals."""
        from .design import design_table

        return replace(self, design=design_table(self))

    def __repr__(self) -> str:
        """Return the conclusions."""
        title = f"Fit of {self.scene.title or 'an untitled scene'}"
        return "\n".join([title, *(f"  {line}" for line in self.conclusions)])

    def _repr_html_(self) -> str:
        """Return conclusions, estimates and figures as HTML, for notebooks."""
        parts = [f"<pre>{escape(repr(self))}</pre>"]
        parts.append(self.estimates.to_html(float_format="{:.4g}".format))
        for figure in self.figures.values():
            image = BytesIO()
            with in_style():
                figure.savefig(image, dpi=100)
            picture = b64encode(image.getvalue()).decode()
            parts.append(f'<img src="data:image/png;base64,{picture}">')
        return "".join(parts)

    def save(self, folder: str | Path) -> list[str]:
        """Write what ``ringwear fit --out folder`` does; return the names of the files.

        Raises
        ------
        SceneError
            if the folder cannot be written to, or holds files of others with these names
        RingwearError
            if a figure or the page cannot be made
        """
        with output_folder(Path(folder), "fit", FILES) as out:
            if failures := self.write(out.hidden):
                raise RingwearError("; ".join(failures))
        return out.written

    def write(self, folder: Path) -> list[str]:
        """Write tables, figures and the page to a folder; return what could not be made."""
        tables = {
            "estimates": self.estimates.rename_axis("parameter").reset_index(),
            "residuals": self.residuals,
            "tests": pd.DataFrame({"test": self.tests.keys(), "probability": self.tests.values()}),
            "design": self.design,
        }
        for name, table in tables.items():
            if len(table):
                write_csv(table, folder / f"{name}.csv")
        for name, figure in self.figures.items():
            with in_style():
                figure.savefig(folder / f"{name}.png")
        from ..report.study_page import write_study

        purpose = "What measurements say of wear coefficients, and what they cannot tell."
        write = partial(write_study, "fit", purpose, self.scene, self.conclusions)
        return make(folder / "report.html", write)
