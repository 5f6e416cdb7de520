"""Solve a level as a run with a discretisation that the study prescribes, and measure its errors.

Wear and sampling are the same as for every method, so that a level has all quantities of the scene
and a function of a result works on it. The exact results, with which levels are compared, come from
one reference run (`contact_kinds.py`). Closed forms replace its values for flat starts and for the
RMS slope of the steady state, where they exist.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..crosscheck import (
    Array,
    Discretised,
    Problem,
    Results,
    RingwearError,
    Scene,
    SceneError,
    Solution,
    Stages,
    energy,
)
from ..crosscheck import method as method_named
from ..crosscheck.methods.evaluation import Evaluation
from ..crosscheck.methods.moving_evaluation import MovingContact
from ..crosscheck.result.outcome import Outcome
from ..numerics.core import flat_d0_error
from ..study.levels import Family, Theory
from ..study.options import Quantity
from ..tables import Row
from .axis_stresses import MOST_UNKNOWNS, boussinesq_stresses, element_stresses
from .contact_kinds import CONTACT_KINDS
from .measures import (
    PRESSURE_PART,
    STRESSES,
    Measure,
    error,
    measures_of,
)
from .theories import OWN_QUANTITY
from .way import Way

STAGES = {
    "meshing": "mesh s",
    "condensing": "condensation s",
    "marching": "march s",
    "inside": "inside s",
}
"""Columns with the seconds of each stage of a level, by the name of the stage."""
MOST_STATES_INSIDE = 3
"""Greatest number of times at which stresses inside the half-space are compared."""


@dataclass(frozen=True)
class StudiedScene:
    """A scene with its exact results, and the results of the levels solved so far.

    Parameters
    ----------
    scene : scene that is studied
    problem : problem that every level solves
    exact : exact results, with which levels are compared
    measures : measures whose errors are computed on each level
    quantities : functions of a result, defined by the user, by name
    exact_values : values of these functions for the reference run
    most_unknowns_inside : greatest number of unknowns for which stresses inside are computed
    level_results : results of the solved levels by family and setting
    """

    scene: Scene
    problem: Problem
    exact: Results
    measures: tuple[Measure, ...]
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    exact_values: Mapping[str, float] = field(default_factory=dict)
    most_unknowns_inside: int = MOST_UNKNOWNS
    level_results: dict[tuple[str, Hashable], Results] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        scene: Scene,
        quantities: Mapping[str, Quantity],
        cell_factor: float,
        most_unknowns_inside: int = MOST_UNKNOWNS,
    ) -> "StudiedScene":
        """Compute the exact results of a scene.

        Parameters
        ----------
        scene : scene that is studied
        quantities : functions of a result, defined by the user, by name
        cell_factor : number of cells of the finest level over the number for rtol 1e-4; used only
            if the contact moves
        most_unknowns_inside : greatest number of unknowns for which stresses inside are computed

        Raises
        ------
        SceneError
            if a function of a result fails, or if the scene has no quantity to study
        RingwearError
            if the reference cannot be computed
        """
        kind = CONTACT_KINDS[scene.problem.full_contact]
        problem, stages = kind.prepare(scene.problem), Stages("reference")
        evaluation = kind.reference(problem, cell_factor, stages)
        exact = evaluation.compared | kind.closed_forms(problem, evaluation.compared)
        states = states_inside(problem, evaluation)
        if len(states):
            exact[STRESSES] = boussinesq_stresses(
                evaluation.compliance.space, states, problem.poisson_ratio
            )
        values = dict[str, float]()
        if quantities:
            discretised = Discretised(evaluation.compliance, lambda: evaluation.compliance)
            result = result_of(scene, "mdr", evaluation, discretised, stages)
            try:
                values = {
                    name: evaluate_quantity(name, quantity, result)
                    for name, quantity in quantities.items()
                }
            except RingwearError as error_of_function:
                raise SceneError(str(error_of_function)) from error_of_function
        measures = measures_of(problem, exact)
        return cls(scene, problem, exact, measures, quantities, values, most_unknowns_inside)

    def family(self, way: Way) -> Family:
        """Return the family of a way; its `solve` stores the results in `level_results`."""

        def solve(setting: Hashable) -> Row:
            return self._solve(way, setting)

        names = [measure.name for measure in self.measures if self._has(way, measure)]
        theory = {name: way.theory(name) for name in names}
        theory |= dict.fromkeys(self.quantities, Theory(reason=OWN_QUANTITY))
        return Family(way.name, way.sizes, solve, theory, way.xlabel, way.work)

    def _has(self, way: Way, measure: Measure) -> bool:
        """Return whether a way has a measure: only finite elements have stresses inside."""
        return way.method == "fem" or measure.quantity != STRESSES

    def _solve(self, way: Way, setting: Hashable) -> Row:
        """Solve a level, store its results in `level_results`, and return its row of the table."""
        stages = Stages(way.method)
        problem = way.problem_at(setting) if way.problem_at else self.problem
        discretised = way.discretise(setting, stages)
        compliance, half_space = discretised.compliance, discretised.half_space
        with stages("marching"):
            kind = CONTACT_KINDS[problem.full_contact]
            evaluation = kind.evaluate(problem, compliance)
            values = evaluation.compared | kind.flat_start(problem, compliance)
        if half_space is not None and discretised.unknowns <= self.most_unknowns_inside:
            states = states_inside(problem, evaluation)
            if len(states):
                with stages("inside"):
                    values[STRESSES] = element_stresses(half_space, states)
        self.level_results[way.name, setting] = values
        row: dict[str, object] = {"unknowns": discretised.unknowns or compliance.space.size}
        row |= {
            column: round(stages.seconds.get(stage, 0.0), 4) for stage, column in STAGES.items()
        }
        face = problem.face
        for measure in self.measures:
            if self._has(way, measure):
                row[measure.name] = error(measure, values, self.exact, face)
        if PRESSURE_PART in way.error_parts:
            row[PRESSURE_PART] = flat_d0_error(energy.compliance(compliance.space))
        if self.quantities:
            result = result_of(self.scene, way.method, evaluation, discretised, stages)
            for name, quantity in self.quantities.items():
                value, exact = evaluate_quantity(name, quantity, result), self.exact_values[name]
                row[f"value of {name}"] = value
                row[name] = value / exact - 1 if exact else value
        return row


def states_inside(problem: Problem, evaluation: Evaluation) -> Array:
    """Return pressures (states, size) at a few times at which the contact is loaded and worn.

    The start and times with a fitted press (`history.pressed`) are left out, because the pressure
    is singular there.
    """
    if not len(problem.times):
        return np.zeros((0, evaluation.compliance.space.size))
    history = evaluation.history[problem.compared_rows]
    rows = (history.distances > 0) & (history.force > 0)
    if history.pressed is not None:
        rows &= history.pressed.force == 0
    indices = np.flatnonzero(rows)
    if len(indices) > MOST_STATES_INSIDE:
        indices = indices[np.linspace(0, len(indices) - 1, MOST_STATES_INSIDE).round().astype(int)]
    return np.asarray(history.pressure[indices])


def result_of(
    scene: Scene, method: str, evaluation: Evaluation, discretised: Discretised, stages: Stages
) -> Outcome:
    """Return the result of a run with one method, without error estimates."""
    moving = evaluation if isinstance(evaluation, MovingContact) else None
    solution = Solution(
        evaluation.results | evaluation.answers,
        evaluation.compared | evaluation.answers,
        {},
        {},
        discretised.unknowns or discretised.compliance.space.size,
        wear=evaluation.wear,
        half_space=discretised.half_space,
        march=moving.marched if moving else None,
    )
    return Outcome(
        scene, {method: method_named(method)}, {method: solution}, {method: stages}, (), ()
    )


def evaluate_quantity(name: str, quantity: Quantity, result: Outcome) -> float:
    """Return the value of a function of a result that the user defined.

    Raises
    ------
    RingwearError
        if the function fails, or does not return a finite number
    """
    try:
        value = float(quantity(result))
    except Exception as error_of_function:
        raise RingwearError(
            f"quantity {name} fails: {type(error_of_function).__name__}: {error_of_function}; the "
            "function has to accept the result of a run, whose dataset has one solver, and to "
            "return a number"
        ) from error_of_function
    if not np.isfinite(value):
        raise RingwearError(
            f"quantity {name} is {value}: the function has to return a finite number"
        )
    return value
