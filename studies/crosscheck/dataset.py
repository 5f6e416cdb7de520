"""The result of a run, as a table of arrays (netCDF-4), an xarray Dataset and a summary (JSON), in
the scene's units.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..methods.base import Method, Solution
from ..methods.interior import Interior, interior
from ..methods.sampler import Sampler
from ..problem.quantities import (
    FIELDS,
    error_name,
)
from ..problem.scene import Scene
from ..progress import Stages
from ..versions import versions
from ..wear.full_contact import RunningIn
from .agreement import AGREE, DISAGREE, UNDECIDED, Agreement, by_quantity, overall
from .anchor import Anchor
from .anchors import anchors
from .answer import ALSO, answer
from .operators import OperatorDifference
from .scope import left_out, modelled
from .table import Table, in_units, tabulate

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class Result:
    """Everything that a run computed.

    Solutions are non-dimensional, `dataset` is in the scene's units.

    Parameters
    ----------
    scene : what was asked for
    methods : by their names
    solutions : by method
    stages : seconds by method
    agreement : of every two methods, by quantity
    operators : of every two compliances
    """

    scene: Scene
    methods: Mapping[str, Method]
    solutions: dict[str, Solution]
    stages: dict[str, Stages]
    agreement: tuple[Agreement, ...]
    operators: tuple[OperatorDifference, ...]

    @property
    def verdict(self) -> str:
        """`agree`, `disagree` or `undecided`.

        The least of all that is promised; an anchor that does not hold disagrees.
        """
        if not all(anchor.holds for anchor in self.anchors):
            return DISAGREE
        return overall(self.agreement)

    @property
    def quantities(self) -> dict[str, str]:
        """The verdict on each quantity, over all pairs of methods."""
        return {name: row.verdict for name, row in by_quantity(self.agreement).items()}

    @property
    def verdict_in_words(self) -> str:
        """How many quantities agree."""
        verdicts = list(self.quantities.values())
        counts = [f"{verdicts.count(AGREE)} of {len(verdicts)} quantities agree"]
        counts += [f"{verdicts.count(of)} {of}" for of in (UNDECIDED, DISAGREE) if of in verdicts]
        promised = "" if set(verdicts) == {AGREE} else " in all that is promised"
        words = {
            AGREE: f"The methods agree{promised}",
            UNDECIDED: "Not all is decided",
            DISAGREE: "THE METHODS DISAGREE",
        }
        return f"{words[self.verdict]}: {', '.join(counts)}."

    @property
    def short_of(self) -> dict[str, float]:
        """Error estimates of the indentation that are above the accuracy asked for, by method."""
        return {
            name: solution.error_estimate
            for name, solution in self.solutions.items()
            if solution.error_estimate > self.scene.accuracy.rtol
        }

    @property
    def notes(self) -> tuple[str, ...]:
        # what is the same by every method is said once
        notes = (note for solution in self.solutions.values() for note in solution.notes)
        return tuple(dict.fromkeys(notes))

    @cached_property
    def answers(self) -> dict[str, dict[str, Array]]:
        """What a user asked of the punch, by method.

        `answer.ANSWER`, and the steady wear rate and slope; scene's units.
        """
        problem, answers = self.scene.problem, {}
        for name, solution in self.solutions.items():
            given = answer(problem, solution)
            given |= {key: np.asarray(solution.results.get(key, np.nan)) for key in ALSO}
            answers[name] = in_units(problem, given)
        return answers

    def gives(self, *quantities: str) -> bool:
        """Return whether a method gives all of some quantities."""
        return bool(set.intersection(*(set(self.by_method(name)) for name in quantities)))

    @property
    def has_inside(self) -> bool:
        """Whether finite elements can tell what is inside the half-space, and fields are asked
        for: at times of a history, if contact changes.
        """
        problem, fem = self.scene.problem, self.solutions.get("fem")
        wanted = any(map(problem.wants, FIELDS)) or bool(self.scene.output.field_times)
        if not wanted or fem is None or fem.half_space is None:
            return False
        return problem.full_contact or fem.march is not None

    @cached_property
    def inside(self) -> Interior:
        """Displacements and stresses inside the half-space."""
        return interior(self.scene, self.solutions["fem"])

    @cached_property
    def table(self) -> Table:
        """All results over dimensions solver, time, radius, ring and mode, in the scene's units."""
        return tabulate(self.scene, self.solutions, self.answers)

    @cached_property
    def dataset(self) -> "xarray.Dataset":
        """The table as an xarray Dataset."""
        import xarray

        return xarray.Dataset(*self.table)

    @cached_property
    def coordinates(self) -> dict[str, Array]:
        """Times, radii and rings, by their names in the table."""
        return {name: values for name, (_, values, _) in self.table.coordinates.items()}

    def reported(self, method: str) -> dict[str, Array]:
        """Return what a method reports, and the coordinates, by their names."""
        row = list(self.coordinates["solver"]).index(method)
        variables = self.table.variables.items()
        return self.coordinates | {name: values[row] for name, (_, values, _) in variables}

    def by_method(self, quantity: str, times: Any = ...) -> dict[str, Array]:
        """Return a quantity by each method that gives it, at all or at some of the times."""
        if quantity not in self.table.variables:
            return {}
        given = zip(self.coordinates["solver"], self.table.variables[quantity][1], strict=True)
        chosen = {name: values[times] for name, values in given}
        return {name: values for name, values in chosen.items() if not np.isnan(values).all()}

    def first(self, quantity: str) -> Array:
        """Return a quantity by the first method that gives it; NaN if none does."""
        return next(iter(self.by_method(quantity).values()), np.asarray(np.nan))

    @cached_property
    def between(self) -> tuple[str, dict[str, Array]]:
        """The first method that knows more than the times asked for, and what it says between them;
        else none, and what the first method reports that gives profiles.
        """
        problem = self.scene.problem
        later = problem.times[problem.distances > 0]
        for name, solution in self.solutions.items():
            wear = solution.wear or solution.march
            if wear is None or problem.march != "modal" or not len(later):
                continue
            if isinstance(wear, RunningIn):
                # close enough, whether times are drawn in a logarithmic scale or not
                at = np.linspace(later[0] ** 0.25, later[-1] ** 0.25, 200) ** 4
                at = np.append(0.0, at)
                history = replace(wear.modal(at), distances=at)
            else:
                history = wear.between
                # before the first of the times there is little to see
                at = history.distances
                history = history[(at == 0) | (at >= later[0])]
            values = Sampler(problem, wear.compliance.space).history(history)
            times = {"time": values["time"] * problem.units.time}
            return name, self.reported(name) | in_units(problem, values) | times

        first = next(iter(self.by_method("profile")), self.coordinates["solver"][0])
        return "", self.reported(first)

    @cached_property
    def anchors(self) -> tuple[Anchor, ...]:
        """What no method can move, for each method.

        Closed forms and balances that the table is held to.
        """
        return tuple(
            anchor
            for name, solution in self.solutions.items()
            for anchor in anchors(self.scene, name, self.reported(name), solution)
        )

    def error(self, quantity: str) -> float:
        """Return the greatest relative error that a method states of a quantity, at all times.

        Raises
        ------
        SceneError
            if no method states it
        """
        stated = self.table.variables.get(error_name(quantity))
        if stated is None:
            raise SceneError(f"no error of {quantity!r} is stated; dataset has all that are")
        return float(np.nanmax(stated[1]))

    @property
    def summary(self) -> dict[str, Any]:
        """What was done, at what cost, how accurately, and what was left out."""
        return summary(self)


def summary(result: Result) -> dict[str, Any]:
    """Return the run in a page.

    Verdict, cost, error estimates, agreement, what was modelled and what was left out.
    """
    scene, rtol = result.scene, result.scene.accuracy.rtol
    methods = {
        name: {
            "seconds": {
                stage: round(seconds, 6) for stage, seconds in result.stages[name].seconds.items()
            },
            "unknowns": solution.unknowns,
            "settings": solution.settings,
            "rtol_asked": rtol,
            "error_estimate": solution.error_estimate,
            "error_estimate_parts": solution.parts,
            "beyond_rtol": solution.beyond(rtol),
        }
        for name, solution in result.solutions.items()
    }
    numbers = ("methods", "rings", "history", "space", "stability")
    return {
        "title": scene.title,
        "units": scene.units,
        "verdict": result.verdict,
        "quantities": result.quantities,
        "answer": {
            # JSON has null for what is infinite or not given
            name: {
                key: np.where(np.isfinite(value), value, np.array(None)).tolist()
                for key, value in given.items()
            }
            for name, given in result.answers.items()
        },
        "methods": methods,
        "agreement": [asdict(row) | {"agrees": row.agrees} for row in result.agreement],
        "agrees": result.verdict == AGREE,
        "anchors": [asdict(anchor) | {"holds": anchor.holds} for anchor in result.anchors],
        "operator_difference": [
            {name: getattr(row, name) for name in numbers} for row in result.operators
        ],
        "modelled": modelled(scene, result.methods),
        "left_out": left_out(scene, result.methods),
        "notes": result.notes,
        "versions": versions(),
    }
