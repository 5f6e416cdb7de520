"""The results of a run, in the scene's units.

They are available as a table of arrays (written as netCDF-4), as an xarray Dataset and as a summary
(written as JSON).
"""

import difflib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from ....meshes.errors import SceneError
from ....meshes.radial import Array
from ..anchors.anchor import Anchor
from ..anchors.checks import anchors, expected_anchors
from ..methods.base import Method, Solution
from ..methods.inside.interior import Interior, interior
from ..methods.sampling.field_differences import (
    IN_STEADY_STATE,
    OVER_TIME,
    FieldComparison,
    compare_fields,
)
from ..methods.sampling.sampler import Sampler
from ..problem.quantities import (
    FIELDS,
    error_name,
)
from ..problem.written import shown
from ..progress import Stages
from ..scene.scene import Scene
from ..verdict.agreement import AGREE, DISAGREE, UNDECIDED, Agreement, by_quantity, overall
from ..verdict.operators import MOST_PRESSURES, OPERATORS, OperatorDifference
from ..verdict.promise import LeftOut, allowed_error, in_words, left_out_of_promise
from ..versions import versions
from .answer import Answers
from .scope import beyond_the_model, left_out, modelled, outside
from .table import in_units, tabulate

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class Outcome:
    """All results of a run.

    Solutions are non-dimensional, `dataset` is in the scene's units.

    Parameters
    ----------
    scene : the scene that was solved
    methods : the methods by their names
    solutions : the solution by the name of each method
    stages : the seconds of each stage, by the name of each method
    agreement : the verdicts on every pair of methods and every quantity
    operators : the comparisons of every pair of compliances
    """

    scene: Scene
    methods: Mapping[str, Method]
    solutions: dict[str, Solution]
    stages: dict[str, Stages]
    agreement: tuple[Agreement, ...]
    operators: tuple[OperatorDifference, ...]

    @property
    def verdict(self) -> str:
        """`agree`, `disagree` or `undecided`: the worst verdict on the promised quantities.

        An anchor that does not hold makes it `disagree`. A missing anchor makes `agree`
        `undecided`.
        """
        if not all(anchor.holds for anchor in self.anchors):
            return DISAGREE
        verdict = overall(self.agreement)
        return UNDECIDED if verdict == AGREE and self.missing_anchors else verdict

    @property
    def missing_anchors(self) -> tuple[str, ...]:
        """Names of anchors that the report of a method should have, but does not."""
        present = {(anchor.name, anchor.method) for anchor in self.anchors}
        missing = (
            name
            for method, solution in self.solutions.items()
            if method not in self.of_others
            for name in expected_anchors(self.scene.problem, solution)
            if (name, method) not in present
        )
        return tuple(dict.fromkeys(missing))

    @property
    def left_out_operators(self) -> dict[str, str]:
        """Pairs of methods with a compliance that are not compared as operators, and why."""
        with_wear = [name for name, solution in self.solutions.items() if solution.wear is not None]
        compared = {frozenset(row.methods) for row in self.operators}
        pairs = [pair for pair in combinations(with_wear, 2) if frozenset(pair) not in compared]
        if not (self.scene.problem.full_contact and pairs):
            return {}
        names = ", ".join(" and ".join(pair) for pair in pairs)
        return {
            OPERATORS: f"not compared for {names}: one method of a pair has to compute its "
            f"compliance on the pressures of the other, or on {MOST_PRESSURES} of them"
        }

    @cached_property
    def left_out_of_promise(self) -> tuple[LeftOut, ...]:
        """Quantities that cannot be promised, with the times and the reason."""
        return tuple(left_out_of_promise(self.scene.problem, self.solutions, self.scene.wear.times))

    @property
    def quantities(self) -> dict[str, str]:
        """The verdict on each quantity, over all pairs of methods."""
        return {name: row.verdict for name, row in by_quantity(self.agreement).items()}

    @property
    def verdict_in_words(self) -> str:
        """The verdict in a sentence, with quantities left out and the number that agree."""
        if not self.agreement:
            return self._verdict_without_comparison
        verdicts = list(self.quantities.values())
        counts = [f"{verdicts.count(AGREE)} of {len(verdicts)} quantities agree"]
        counts += [
            f"{verdicts.count(word)} {word}" for word in (UNDECIDED, DISAGREE) if word in verdicts
        ]
        scene = self.scene
        left_out = in_words(self.left_out_of_promise, scene.wear.times, scene.unit_names)
        sentences = {
            AGREE: f"The methods agree{f' in all but {left_out}' if left_out else ''}",
            UNDECIDED: "Not all is decided",
            DISAGREE: "THE METHODS DISAGREE",
        }
        return f"{sentences[self.verdict]}: {', '.join(counts)}."

    @property
    def _verdict_without_comparison(self) -> str:
        """The verdict in a sentence, if no two methods are compared."""
        if self.verdict == DISAGREE:
            return "AN ANCHOR DOES NOT HOLD, and no two methods are compared."
        ours = [name for name in self.coordinates["solver"] if name not in self.of_others]
        if len(ours) == 1:
            return "One method alone is undecided: there is nothing to compare it with."
        return "Nothing is decided: no two methods compute the same quantity."

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What to know before the numbers are used: the model is not valid, or times miss it all.

        These warnings follow from the scene; `notes` are those of the methods.
        """
        problem = self.scene.problem
        slowest = float(self.first("running_in_time")) / problem.units.time
        return tuple(beyond_the_model(self.scene) + outside(problem, slowest))

    @property
    def short_of(self) -> dict[str, float]:
        """Error estimates of the indentation that are larger than is allowed, by method.

        The stated error also contains the error by which cells represent the face, which the
        difference to a coarser solution does not. If edges of the contact move, both may be twice
        as large as `rtol`, as in the verdict.
        """
        allowed = allowed_error(self.scene.problem)
        short = {}
        for name, solution in self.solutions.items():
            error = solution.error_estimate
            if "indentation" in solution.errors:
                error = max(error, solution.greatest_error("indentation"))
            if error > allowed:
                short[name] = error
        return short

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes of all methods; a note that several methods give appears once."""
        notes = [note for solution in self.solutions.values() for note in solution.notes]
        notes += [f"{name}: {reason}" for name, reason in self.left_out_operators.items()]
        return tuple(dict.fromkeys(notes))

    @cached_property
    def answers(self) -> dict[str, dict[str, Array]]:
        """The numbers of the answer, by method, in the scene's units.

        Each number has a relative error estimate `<name>_error`, by the same method and in the norm
        of the number (`studies/crosscheck/problem/quantities.py`).
        """
        return Answers.of(self.dataset)

    def gives(self, *quantities: str) -> bool:
        """Return whether some method computes all of these quantities."""
        return bool(set.intersection(*(set(self.by_method(name)) for name in quantities)))

    @property
    def has_inside(self) -> bool:
        """Whether fields inside the half-space are wanted and finite elements can compute them.

        If the contact changes, they need a history by finite elements.
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
    def dataset(self) -> "xarray.Dataset":
        """All results over dimensions solver, time, radius, ring and mode, in the scene's units."""
        return tabulate(self.scene, self.solutions)

    @cached_property
    def coordinates(self) -> dict[str, Array]:
        """Times, radii and rings, by their names in the dataset."""
        return {str(name): values.values for name, values in self.dataset.coords.items()}

    def reported(self, method: str) -> dict[str, Array]:
        """Return the quantities of a method and the coordinates, by their names in the dataset."""
        row = list(self.coordinates["solver"]).index(method)
        return self.coordinates | {
            name: values.values[row] for name, values in _arrays(self.dataset).items()
        }

    def by_method(self, quantity: str, times: Any = ...) -> dict[str, Array]:
        """Return a quantity by the name of each method that computes it, at all or some times."""
        if quantity not in self.dataset:
            return {}
        arrays = self.dataset.variables[quantity].values
        rows = zip(self.coordinates["solver"], arrays, strict=True)
        selected = {name: values[times] for name, values in rows}
        return {name: values for name, values in selected.items() if not np.isnan(values).all()}

    @property
    def of_others(self) -> tuple[str, ...]:
        """Names of other programs whose results are in the table as well."""
        return ()

    @property
    def about_others(self) -> tuple[str, ...]:
        """The verdict on the results of other programs, in sentences; empty if there are none."""
        return ()

    @property
    def compared_in_fields(self) -> tuple[str, ...]:
        """Methods that compute the same fields: the reference, the one drawn, and the others.

        The first method is the reference. The figure of the difference shows finite elements if
        they have the fields, else the second method.
        """
        for fields in (OVER_TIME, IN_STEADY_STATE):
            methods = {method: None for name in fields for method in self.by_method(name)}
            if len(methods) > 1:
                first, *others = (name for name in self.coordinates["solver"] if name in methods)
                return str(first), *sorted(map(str, others), key=lambda name: name != "fem")
        return ()

    @cached_property
    def field_comparisons(self) -> tuple[FieldComparison, ...]:
        """Differences of other methods from the reference in fields; the drawn one comes first."""
        if not self.compared_in_fields:
            return ()
        problem, (first, *others) = self.scene.problem, self.compared_in_fields
        reports = (self.reported(name) for name in others)
        compared = (
            compare_fields(problem, (first, name), self.reported(first), report)
            for name, report in zip(others, reports, strict=True)
        )
        return tuple(comparison for comparison in compared if comparison.fields)

    def first(self, quantity: str) -> Array:
        """Return a quantity by the first method that computes it; NaN if none does."""
        return next(iter(self.by_method(quantity).values()), np.asarray(np.nan))

    @cached_property
    def between(self) -> tuple[str, dict[str, Array]]:
        """The first method with values between the times of the scene, and these values.

        The values are quantities by name, in the scene's units. If no method has such values, the
        name is empty, and the values are the report of the first method that computes profiles.
        """
        problem = self.scene.problem
        later = problem.times[problem.distances > 0]
        for name, solution in self.solutions.items():
            wear, march = solution.wear, solution.march
            if problem.march != "modal" or not len(later):
                continue
            if wear is not None:
                # times that are dense enough on a linear and on a logarithmic axis
                times = np.linspace(later[0] ** 0.25, later[-1] ** 0.25, 200) ** 4
                history, compliance = wear.modal(np.append(0.0, times)), wear.compliance
            elif march is not None:
                history, compliance = march.between, march.face.compliance
                # leave out times before the first one of the scene, except the start
                history = history[(history.times == 0) | (history.times >= later[0])]
            else:
                continue
            values = Sampler(problem, compliance.space, compliance).history(history)
            time = {"time": values["time"] * problem.units.time}
            return name, self.reported(name) | in_units(problem, values) | time

        first = next(iter(self.by_method("profile")), self.coordinates["solver"][0])
        return "", self.reported(first)

    @cached_property
    def anchors(self) -> tuple[Anchor, ...]:
        """Closed forms and conservation laws that the report of each method is checked against."""
        reports = {
            name: (self.reported(name), solution)
            for name, solution in self.solutions.items()
            # results of other programs are judged by their errors instead
            if name not in self.of_others
        }
        return tuple(anchors(self.scene, reports))

    def error(self, quantity: str) -> float:
        """Return the greatest relative error estimate of a quantity, over methods and times.

        Raises
        ------
        SceneError
            if no method has an error estimate of it
        """
        variables = _arrays(self.dataset)
        estimates = variables.get(error_name(str(quantity)))
        if estimates is None:
            with_estimate = [name for name in variables if error_name(name) in variables]
            suggestions = difflib.get_close_matches(str(quantity), with_estimate, 1)
            hint = f"did you mean {suggestions[0]!r}? Else " if suggestions else ""
            raise SceneError(
                f"there is no error estimate of {shown(quantity)}: {hint}give one of those in "
                f"dataset: {', '.join(with_estimate)}"
            )
        # NaN where a method has no value
        return float(np.fmax.reduce(estimates.values, axis=None))

    @property
    def summary(self) -> dict[str, Any]:
        """The content of `summary.json`: verdict, cost, error estimates, scope and notes."""
        return summary(self)


def _arrays(dataset: "xarray.Dataset") -> "dict[str, xarray.Variable]":
    """Return the variables of a dataset without its coordinates."""
    return {str(name): dataset.variables[name] for name in dataset.data_vars}


def summary(result: Outcome) -> dict[str, Any]:
    """Return a summary of the run that can be written as JSON.

    It contains the verdict, the answer, cost and error estimates of each method, the agreement, the
    anchors, the scope of the model, the warnings and the notes.
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
            # infinite values and NaN become null in JSON
            name: {
                key: np.where(np.isfinite(value), value, np.array(None)).tolist()
                for key, value in values.items()
            }
            for name, values in result.answers.items()
        },
        "methods": methods,
        "agreement": [
            asdict(row)
            # JSON has no number for infinity, which a missing error estimate counts as
            | {name: min(getattr(row, name), 1e99) for name in ("difference", "uncertainty")}
            | {"agrees": row.agrees}
            for row in result.agreement
        ],
        "agrees": result.verdict == AGREE,
        "left_out_of_promise": [
            asdict(row) | {"times": list(row.times)} for row in result.left_out_of_promise
        ],
        "anchors": [asdict(anchor) | {"holds": anchor.holds} for anchor in result.anchors],
        "operator_difference": [
            {name: getattr(row, name) for name in numbers} for row in result.operators
        ],
        "modelled": modelled(scene, result.methods),
        "left_out": left_out(scene, result.methods) | result.left_out_operators,
        "warnings": result.warnings,
        "notes": result.notes,
        "versions": versions(),
    }
