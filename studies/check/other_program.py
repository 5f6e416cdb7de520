"""Results of another program as a method, so that tables and figures show them beside ours."""

from dataclasses import dataclass
from typing import ClassVar

import pandas as pd

from ..crosscheck import FIELDS, QUANTITIES, Method, Problem, Results, Scene, Solution, Stages

ROWS = 10
"""Number of successive updates in which the pressure of a node has to alternate in a sawtooth."""
ASK_FOR_ROWS = (
    f"or give the rows of {ROWS} consecutive updates of the wear, which show whether the step of "
    "these is too long for the mesh"
)
"""What to do if a table has pressures at too few times to see a sawtooth."""


@dataclass(frozen=True, eq=False)
class OtherProgram(Method):
    """A method whose solution is read from another program; it has no error estimates.

    Parameters
    ----------
    name : of the program in figures and tables
    values : its quantities at the times and radii of the scene, in the units of the scene; NaN
        where it has none
    """

    name: str
    values: Results
    what: str = "results of another program"
    lacks: ClassVar[dict[str, str]] = {"steady state": "its results are over time"}

    @classmethod
    def from_table(cls, name: str, table: pd.DataFrame, scene: Scene) -> "OtherProgram":
        """Return the results in a table (`tables.read`) at the times and radii of a scene."""
        values = {}
        for quantity in table.columns.difference(["time", "radius"], sort=False):
            dimensions = ["time", "radius"] if quantity in FIELDS else ["time"]
            series = table.dropna(subset=[quantity]).groupby(dimensions)[quantity].first()
            if quantity in FIELDS:
                series = series.unstack().reindex(columns=scene.output.radii)
            values[quantity] = series.reindex(scene.wear.times).to_numpy()
        return cls(name, values)

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Return the results of the program, non-dimensional."""
        results = {
            name: values / getattr(problem.units, QUANTITIES[name].unit)
            for name, values in self.values.items()
        }
        return Solution(results, {}, {}, {})

    def refusal(self, problem: Problem) -> str:
        """Return an empty text: the program has already solved the problem."""
        return ""
