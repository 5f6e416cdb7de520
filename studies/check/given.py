"""Results of another program as a method, which stand beside ours in tables and figures."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from ...meshes.radial import Array
from ..methods.base import Method, Solution
from ..methods.norms import Results
from ..problem.problem import Problem
from ..problem.quantities import FIELDS, QUANTITIES
from ..progress import Stages


@dataclass(frozen=True, eq=False)
class Given(Method):
    """What another program says of a scene; it states no error of its own.

    Parameters
    ----------
    name : as figures and tables call it
    given : its quantities at the times and radii of the scene, NaN where it gives none; in the
        units of the scene
    """

    name: str
    given: Results
    what: str = "results of another program"
    lacks: ClassVar[dict[str, str]] = {"steady state": "its results are over time"}

    @classmethod
    def tabled(cls, name: str, table: pd.DataFrame, times: Array, radii: Array) -> "Given":
        """Return what a table gives (`tables.read`), on the times and radii of a scene."""
        given = {}
        for quantity in table.columns.intersection(list(QUANTITIES)):
            rows = table.dropna(subset=[quantity])
            if quantity in FIELDS:
                grid = rows.pivot(index="time", columns="radius", values=quantity)
                given[quantity] = grid.reindex(index=times, columns=radii).to_numpy()
            else:
                numbers = rows.drop_duplicates("time").set_index("time")[quantity]
                given[quantity] = numbers.reindex(times).to_numpy()
        return cls(name, given)

    def solve_all(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Return what is given, non-dimensional."""

        def results(problem: Problem) -> Results:
            return {
                name: np.asarray(values) / getattr(problem.units, QUANTITIES[name].unit)
                for name, values in self.given.items()
            }

        return [Solution(results(problem), {}, {}, {}) for problem in problems]

    def refusal(self, problem: Problem) -> str:
        """It has solved the problem already."""
        return ""
