"""What a run computed, in the scene's units.

It can be had as a table of arrays (written as netCDF-4), as an xarray Dataset and as a summary
(written as JSON).
"""

import difflib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..anchors.anchor import Anchor
from ..anchors.checks import anchors, expected_anchors
from ..crosscheck.agreement import AGREE, DISAGREE, UNDECIDED, Agreement, by_quantity, overall
from ..crosscheck.operators import MOST_PRESSURES, OperatorDifference
from ..crosscheck.promise import LeftOut, allowed_error, in_words, left_out_of_promise
from ..inside.interior import Interior, interior
from ..methods.base import Method, Solution
from ..problem.quantities import (
    FIELDS,
    error_name,
)
from ..problem.regimes import OPERATORS
from ..progress import Stages
from ..sampling.field_differences import (
    IN_STEADY_STATE,
    OVER_TIME,
    FieldComparison,
    compare_fields,
)
from ..sampling.sampler import Sampler
from ..scene.scene import Scene
from ..versions import versions
from .answer import ALSO, answer, answer_errors
from .scope import left_out, modelled
from .table import Table, in_units, tabulate

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class Outcome:
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

        The least of all that is promised. An anchor that does not hold makes it `disagree`, and an
        anchor that should be there but is not makes it `undecided`.
        """
        if not all(anchor.holds for anchor in self.anchors):
            return DISAGREE
        verdict = overall(self.agreement)
        return UNDECIDED if verdict == AGREE and self.missing_anchors else verdict

    @property
    def missing_anchors(self) -> tuple[str, ...]:
        """Names of anchors that the report of a method should have, but does not."""
        checked = {(anchor.name, anchor.method) for anchor in self.anchors}
        missing = (
            name
            for method, solution in self.solutions.items()
            if method not in self.of_others
            for name in expected_anchors(self.scene.problem, solution)
            if (name, method) not in checked
        )
        return tuple(dict.fromkeys(missing))

    @property
    def left_out_by_size(self) -> dict[str, str]:
        """What is not computed because it would take longer than all the rest."""
        sizes = [
            solution.wear.compliance.space.size
            for solution in self.solutions.values()
            if solution.wear is not None
        ]
        by_contact = OPERATORS in self.scene.problem.contact.left_out
        if by_contact or len(sizes) < 2 or max(sizes) <= MOST_PRESSURES:
            return {}
        return {
            OPERATORS: f"compared for up to {MOST_PRESSURES} pressures: eigenvalues "
            f"of {max(sizes)} would take longer than the run; energies are still checked"
        }

    @cached_property
    def left_out_of_promise(self) -> tuple[LeftOut, ...]:
        """Quantities that cannot be promised, with the times and the reason."""
        return tuple(left_out_of_promise(self.scene.problem, self.solutions))

    @property
    def quantities(self) -> dict[str, str]:
        """The verdict on each quantity, over all pairs of methods."""
        return {name: row.verdict for name, row in by_quantity(self.agreement).items()}

    @property
    def verdict_in_words(self) -> str:
        """The verdict in a sentence: what is left out of it, and how many quantities agree."""
        verdicts = list(self.quantities.values())
        counts = [f"{verdicts.count(AGREE)} of {len(verdicts)} quantities agree"]
        counts += [f"{verdicts.count(of)} {of}" for of in (UNDECIDED, DISAGREE) if of in verdicts]
        left_out = in_words(self.left_out_of_promise, self.scene.wear.times)
        words = {
            AGREE: f"The methods agree{f' in all but {left_out}' if left_out else ''}",
            UNDECIDED: "Not all is decided",
            DISAGREE: "THE METHODS DISAGREE",
        }
        return f"{words[self.verdict]}: {', '.join(counts)}."

    @property
    def short_of(self) -> dict[str, float]:
        """Error estimates of the indentation that are above the accuracy asked for, by method.

        What cells miss of a face is in the stated error, not in the estimate by a coarser solution;
        where contact moves, twice the accuracy may be stated, as in the verdict.
        """
        rtol = self.scene.accuracy.rtol
        least = allowed_error(self.scene.problem)
        short = {}
        for name, solution in self.solutions.items():
            error = solution.error_estimate
            if "indentation" in solution.errors:
                stated = solution.greatest_error("indentation")
                error = max(error, stated if stated > least else 0.0)
            if error > rtol:
                short[name] = error
        return short

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes of all methods; a note that several methods give appears once."""
        # what is the same by every method is said once
        notes = (note for solution in self.solutions.values() for note in solution.notes)
        return tuple(dict.fromkeys(notes))

    @cached_property
    def answers(self) -> dict[str, dict[str, Array]]:
        """What a user asked of the punch, by method, in the scene's units.

        Beside each number stands its relative error, `<name>_error`, by the method's own estimate,
        in the norm of the number (`studies/problem/quantities.py`).
        """
        problem, answers = self.scene.problem, {}
        for name, solution in self.solutions.items():
            given = answer(problem, solution)
            stated = answer_errors(problem, solution)
            for key in ALSO:
                given[key] = np.asarray(solution.results.get(key, np.nan))
                stated[key] = np.asarray(solution.errors.get(key, np.nan))
            errors = {error_name(key): error for key, error in stated.items()}
            answers[name] = in_units(problem, given) | errors
        return answers

    def gives(self, *quantities: str) -> bool:
        """Return whether a method gives all of some quantities."""
        return bool(set.intersection(*(set(self.by_method(name)) for name in quantities)))

    @property
    def has_inside(self) -> bool:
        """Whether fields inside the half-space are wanted and finite elements can compute them.

        If the contact changes, they can be computed only at times of a history.
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
        from .labelled import Dataset

        return Dataset(*self.table)

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

    @property
    def of_others(self) -> tuple[str, ...]:
        """Names of other programs whose results stand beside those of the methods."""
        return ()

    @property
    def compared_in_fields(self) -> tuple[str, ...]:
        """Methods that give the same fields: the reference, the one drawn against it, and others.

        The reference is the first of them. Finite elements are drawn against it if they are among
        the others, else the second method is.
        """
        for fields in (OVER_TIME, IN_STEADY_STATE):
            giving = {method: None for name in fields for method in self.by_method(name)}
            if len(giving) > 1:
                first, *others = (name for name in self.coordinates["solver"] if name in giving)
                return str(first), *sorted(map(str, others), key=lambda name: name != "fem")
        return ()

    @cached_property
    def field_comparisons(self) -> tuple[FieldComparison, ...]:
        """The differences of other methods from the reference in fields; the one drawn first."""
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
        """Return a quantity by the first method that gives it; NaN if none does."""
        return next(iter(self.by_method(quantity).values()), np.asarray(np.nan))

    @cached_property
    def between(self) -> tuple[str, dict[str, Array]]:
        """The first method that has values between the times asked for, and these values.

        The values are quantities by name, in the scene's units. If no method has such values, the
        name is empty, and the values are the report of the first method that gives profiles.
        """
        problem = self.scene.problem
        later = problem.times[problem.distances > 0]
        for name, solution in self.solutions.items():
            wear, march = solution.wear, solution.march
            if problem.march != "modal" or not len(later):
                continue
            if wear is not None:
                # close enough, whether times are drawn in a logarithmic scale or not
                at = np.linspace(later[0] ** 0.25, later[-1] ** 0.25, 200) ** 4
                at = np.append(0.0, at)
                history = replace(wear.modal(at), distances=at)
                compliance = wear.compliance
            elif march is not None:
                history, compliance = march.between, march.face.compliance
                # before the first of the times there is little to see
                at = history.distances
                history = history[(at == 0) | (at >= later[0])]
            else:
                continue
            values = Sampler(problem, compliance.space, compliance).history(history)
            times = {"time": values["time"] * problem.units.time}
            return name, self.reported(name) | in_units(problem, values) | times

        first = next(iter(self.by_method("profile")), self.coordinates["solver"][0])
        return "", self.reported(first)

    @cached_property
    def anchors(self) -> tuple[Anchor, ...]:
        """Closed forms and conservation laws that the report of each method is checked against."""
        return tuple(
            anchor
            for name, solution in self.solutions.items()
            # of others, errors are told
            if name not in self.of_others
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
            there = self.table.variables
            named = [name for name in there if error_name(name) in there]
            near = difflib.get_close_matches(quantity, named, 1)
            meant = f"did you mean {near[0]!r}? Else " if near else ""
            raise SceneError(
                f"no error of {quantity!r} is stated: {meant}give one of those in dataset: "
                + ", ".join(named)
            )
        return float(np.nanmax(stated[1]))

    @property
    def summary(self) -> dict[str, Any]:
        """What was done, at what cost, how accurately, and what was left out."""
        return summary(self)


def summary(result: Outcome) -> dict[str, Any]:
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
        "left_out_of_promise": [
            asdict(row) | {"times": list(row.times)} for row in result.left_out_of_promise
        ],
        "anchors": [asdict(anchor) | {"holds": anchor.holds} for anchor in result.anchors],
        "operator_difference": [
            {name: getattr(row, name) for name in numbers} for row in result.operators
        ],
        "modelled": modelled(scene, result.methods),
        "left_out": left_out(scene, result.methods) | result.left_out_by_size,
        "notes": result.notes,
        "versions": versions(),
    }
