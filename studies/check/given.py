"""Results of another program as a method, which stand beside ours in tables and figures."""

from dataclasses import dataclass
from typing import ClassVar

import pandas as pd

from ..methods.base import Method, Solution
from ..problem.problem import Problem
from ..problem.quantities import FIELDS, QUANTITIES
from ..progress import Stages
from ..sampling.norms import Results
from ..scene.scene import Scene


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
    def tabled(cls, name: str, table: pd.DataFrame, scene: Scene) -> "Given":
        """Return what a table gives (`tables.read`), at the times and radii of a scene."""
        given = {}
        for quantity in table.columns.difference(["time", "radius"], sort=False):
            along = ["time", "radius"] if quantity in FIELDS else ["time"]
            values = table.dropna(subset=[quantity]).groupby(along)[quantity].first()
            if quantity in FIELDS:
                values = values.unstack().reindex(columns=scene.output.radii)
            given[quantity] = values.reindex(scene.wear.times).to_numpy()
        return cls(name, given)

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Return what is given, non-dimensional."""
        results = {
            name: values / getattr(problem.units, QUANTITIES[name].unit)
            for name, values in self.given.items()
        }
        return Solution(results, {}, {}, {})

    def refusal(self, problem: Problem) -> str:
        """Return nothing: it has solved the problem already."""
        return ""
