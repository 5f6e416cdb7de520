"""A level as a run: a discretisation that the study fixes, worn and sampled as any method's is.

Every level has all quantities of the scene, so that a function of a result works on it. What levels
are measured by is one reference run (`contact_kinds.py`). Closed forms take its place where there
are any: flat starts and the slope of the steady state.
"""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ...mdr import energy
from ...meshes.errors import RingwearError, SceneError
from ...meshes.radial import Array
from ..methods.base import Discretised, Solution
from ..methods.base import method as method_named
from ..methods.evaluation import Evaluation
from ..methods.moving_evaluation import MovingContact
from ..numerics.core import flat_d0_error
from ..outcome.outcome import Outcome
from ..problem.problem import Problem
from ..progress import Stages
from ..sampling.norms import Results
from ..scene.scene import Scene
from ..study.levels import Family, Theory
from ..study.options import Quantity
from ..tables import Row
from .axis_stresses import MOST_UNKNOWNS, by_boussinesq, by_elements
from .contact_kinds import KINDS
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
"""Columns of the table by the stage of a level that they tell the seconds of."""
STATES_INSIDE = 3
"""Most times at which stresses inside are compared."""


@dataclass(frozen=True)
class Studied:
    """A scene with its exact results, and the results of each level that was solved.

    Parameters
    ----------
    scene : that is studied
    problem : its problem as every level solves it
    exact : results that levels are measured by
    measures : what is measured of each level
    quantities : the user's functions of a result
    exact_values : their values of the reference run
    most_inside : unknowns up to which stresses inside are recovered
    solved : results by family and setting, as they come
    """

    scene: Scene
    problem: Problem
    exact: Results
    measures: tuple[Measure, ...]
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    exact_values: Mapping[str, float] = field(default_factory=dict)
    most_inside: int = MOST_UNKNOWNS
    solved: dict[tuple[str, Hashable], Results] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        scene: Scene,
        quantities: Mapping[str, Quantity],
        finer: float,
        most_inside: int = MOST_UNKNOWNS,
    ) -> "Studied":
        """Return a scene with its exact results.

        Parameters
        ----------
        scene, quantities : that are studied
        finer : how many times as many cells the finest level has as rtol 1e-4 asks for; only for
            punches whose contact moves
        most_inside : unknowns up to which stresses inside are recovered

        Raises
        ------
        SceneError
            if a function of a result fails, or if there is nothing to measure
        RingwearError
            if the reference cannot be computed
        """
        kind = KINDS[scene.problem.contact]
        problem, stages = kind.studied(scene.problem), Stages("reference")
        evaluation = kind.reference(problem, finer, stages)
        exact = evaluation.checked | kind.closed_forms(problem, evaluation.checked)
        states = states_inside(problem, evaluation)
        if len(states):
            exact[STRESSES] = by_boussinesq(
                evaluation.compliance.space, states, problem.poisson_ratio
            )
        values = dict[str, float]()
        if quantities:
            discretised = Discretised(evaluation.compliance, lambda: evaluation.compliance)
            result = result_of(scene, "mdr", evaluation, discretised, stages)
            try:
                values = {name: take(name, of, result) for name, of in quantities.items()}
            except RingwearError as failed:
                raise SceneError(str(failed)) from failed
        measures = measures_of(problem, exact)
        return cls(scene, problem, exact, measures, quantities, values, most_inside)

    def family(self, way: Way) -> Family:
        """Return the family of a way, whose levels are solved, measured and kept."""

        def solve(setting: Hashable) -> Row:
            return self._solve(way, setting)

        names = [measure.name for measure in self.measures if self._has(way, measure)]
        theory = {name: way.theory(name) for name in names}
        theory |= dict.fromkeys(self.quantities, Theory(reason=OWN_QUANTITY))
        return Family(way.name, way.sizes, solve, theory, way.xlabel, way.work)

    def _has(self, way: Way, measure: Measure) -> bool:
        """Return whether a way has a measure: stresses inside are those of finite elements."""
        return way.method == "fem" or measure.quantity != STRESSES

    def _solve(self, way: Way, setting: Hashable) -> Row:
        """Return the row of a level."""
        stages = Stages(way.method)
        problem = way.problem_at(setting) if way.problem_at else self.problem
        discretised = way.discretise(setting, stages)
        compliance, half_space = discretised.compliance, discretised.half_space
        with stages("marching"):
            kind = KINDS[problem.contact]
            evaluation = kind.evaluate(problem, compliance)
            values = evaluation.checked | kind.flat_start(problem, compliance)
        if half_space is not None and discretised.unknowns <= self.most_inside:
            states = states_inside(problem, evaluation)
            if len(states):
                with stages("inside"):
                    values[STRESSES] = by_elements(half_space, states)
        self.solved[way.name, setting] = values
        row: dict[str, object] = {"unknowns": discretised.unknowns or compliance.space.size}
        row |= {column: round(stages.seconds.get(of, 0.0), 4) for of, column in STAGES.items()}
        face = problem.face
        for measure in self.measures:
            if self._has(way, measure):
                row[measure.name] = error(measure, values, self.exact, face)
        if PRESSURE_PART in way.parts:
            row[PRESSURE_PART] = flat_d0_error(energy.compliance(compliance.space))
        if self.quantities:
            result = result_of(self.scene, way.method, evaluation, discretised, stages)
            for name, quantity in self.quantities.items():
                value, exact = take(name, quantity, result), self.exact_values[name]
                row[f"value of {name}"] = value
                row[name] = value / exact - 1 if exact else value
        return row


def states_inside(problem: Problem, evaluation: Evaluation) -> Array:
    """Return pressures (states, size) of a few times at which nothing singular is pressed."""
    if not len(problem.times):
        return np.zeros((0, evaluation.compliance.space.size))
    history = evaluation.history[problem.checked]
    rows = (history.distances > 0) & (history.force > 0)
    if history.pressed is not None:
        rows &= history.pressed.force == 0
    numbers = np.flatnonzero(rows)
    if len(numbers) > STATES_INSIDE:
        numbers = numbers[np.linspace(0, len(numbers) - 1, STATES_INSIDE).round().astype(int)]
    return np.asarray(history.pressure[numbers])


def result_of(
    scene: Scene, method: str, evaluation: Evaluation, discretised: Discretised, stages: Stages
) -> Outcome:
    """Return the result of a run with one method, whose errors nobody has estimated."""
    moving = evaluation if isinstance(evaluation, MovingContact) else None
    solution = Solution(
        evaluation.results,
        evaluation.checked,
        {},
        {},
        discretised.unknowns or discretised.compliance.space.size,
        wear=evaluation.wear,
        half_space=discretised.half_space,
        march=moving.marched if moving else None,
        answers=evaluation.answers,
    )
    return Outcome(
        scene, {method: method_named(method)}, {method: solution}, {method: stages}, (), ()
    )


def take(name: str, quantity: Quantity, result: Outcome) -> float:
    """Return the value of a user's function of a result.

    Raises
    ------
    RingwearError
        if the function fails, or returns no finite number
    """
    try:
        value = float(quantity(result))
    except Exception as failed:
        raise RingwearError(
            f"quantity {name} fails: {type(failed).__name__}: {failed}; it takes the result of a "
            "run, whose dataset has one solver, and returns a number"
        ) from failed
    if not np.isfinite(value):
        raise RingwearError(f"quantity {name} is {value}: it has to return a finite number")
    return value
