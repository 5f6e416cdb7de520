"""Differences between flat and shaped punches in the convergence study.

A flat punch keeps full contact. Its levels are exact in time, its flat start has a closed form, and
its reference is MDR at the finest accuracy. The contact edges of any other punch move. Its levels
are computed by a march on cells. Its reference has cells half as large as those of the finest
level, and its start is computed with functions fitted to the contact edges.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from ..crosscheck import (
    Compliance,
    Problem,
    Results,
    SceneError,
    Stages,
    direct,
    flat_punch,
    press_flat,
    ring_kernel,
)
from ..crosscheck.methods.evaluation import Evaluation, FullContact
from ..crosscheck.methods.mdr import METHOD as MDR
from ..crosscheck.methods.moving_evaluation import MovingContact
from ..crosscheck.methods.pipeline import fitted_starts
from ..crosscheck.methods.spaces import first_contact, scaled_cells
from ..crosscheck.problem.quantities import FINEST_RTOL
from ..crosscheck.problem.sections import MdrAccuracy
from ..crosscheck.wear.flat_contact import FittedPress
from ..study.levels import Theory
from . import theories
from .measures import FLAT_INDENTATION, FLAT_PRESSURE

STEP_TOLERANCE_FACTOR = 0.2
"""Factor on the tolerance of time steps in moving contact, so that cells dominate the error."""


TheoryOfMeasure = Callable[[str], Theory]
"""Function that returns the theory of a measure by its name."""


class ContactKind(ABC):
    """How the study treats problems of one kind of contact.

    Attributes
    ----------
    elements_refusal : why meshes and elements of the user are refused; empty if they are accepted
    no_theory_reason : why no order can be compared with theory, if no sequence has a theory
    """

    elements_refusal: str = ""
    no_theory_reason: str = ""

    @abstractmethod
    def prepare(self, problem: Problem) -> Problem:
        """Return the problem that every level solves: with the modal march and all quantities.

        Raises
        ------
        SceneError
            if there is nothing to study
        """

    @abstractmethod
    def reference(self, problem: Problem, cell_factor: float, stages: Stages) -> Evaluation:
        """Return the reference run, with which the levels are compared.

        Parameters
        ----------
        problem : problem that every level solves
        cell_factor : number of cells of the finest level over the number for rtol 1e-4
        stages : timer of the stages, which logs progress
        """

    @abstractmethod
    def evaluate(self, problem: Problem, compliance: Compliance) -> Evaluation:
        """Compute wear on a compliance and its quantities, as the pipeline of every method does."""

    @abstractmethod
    def flat_start(self, problem: Problem, compliance: Compliance) -> Results:
        """Return the flat start computed in the pressure space itself, under the force 1."""

    @abstractmethod
    def closed_forms(self, problem: Problem, results: Results) -> Results:
        """Return closed-form values of the flat start and of quantities in the results."""

    @abstractmethod
    def theory_of_steps(self, short: bool) -> TheoryOfMeasure:
        """Return the theory of the implicit march, depending on whether all steps are short."""


class FlatPunch(ContactKind):
    """A flat punch, which keeps full contact."""

    no_theory_reason = theories.OWN_MESH

    def prepare(self, problem: Problem) -> Problem:
        """Return the problem with the radii at which fields of all levels are compared."""
        problem = replace(problem, march="modal", step=None, quantities=None)
        return replace(problem, compared_on=problem.face)

    def reference(self, problem: Problem, cell_factor: float, stages: Stages) -> Evaluation:
        """Return MDR at the finest accuracy."""
        finest = replace(problem, rtol=FINEST_RTOL, mdr=MdrAccuracy())
        return self.evaluate(problem, MDR.discretise(finest, stages).compliance)

    def evaluate(self, problem: Problem, compliance: Compliance) -> Evaluation:
        """Return the evaluation of the history, which is exact in time."""
        return FullContact(problem, compliance)

    def flat_start(self, problem: Problem, compliance: Compliance) -> Results:
        """Return the indentation, and the pressure at the radii of the face."""
        pressed = press_flat(compliance)
        pressure = compliance.space.matrix(problem.face.radii) @ pressed.pressure
        return {FLAT_INDENTATION: np.asarray(pressed.indentation), FLAT_PRESSURE: pressure}

    def closed_forms(self, problem: Problem, results: Results) -> Results:
        """Return the flat start and, if k is constant on each ring, the steady RMS slope."""
        flat = flat_punch(problem.inner_radius)
        exact = {
            FLAT_INDENTATION: np.asarray(flat.indentation),
            FLAT_PRESSURE: flat.pressure_at(problem.face.radii),
        }
        if "steady_rms_slope" in results and not problem.merged.linear:
            rings = problem.merged
            slope = direct.rms_slope(
                rings.ring_edges,
                direct.steady_pressures(rings.ring_edges, rings.wear_coefficients[0]),
                problem.gradient_average,
            )
            exact["steady_rms_slope"] = np.asarray(problem.loading.forces[-1] * slope)
        return exact

    def theory_of_steps(self, short: bool) -> TheoryOfMeasure:
        """Return the theory of the implicit march, which has order one in short steps."""
        return partial(theories.for_steps, short)


class ShapedPunch(ContactKind):
    """A punch whose contact opens, closes and spreads."""

    elements_refusal = (
        "study convergence accepts your own meshes and elements only for flat punches under a "
        "force that never decreases, because other punches need cells that follow the contact; "
        "leave the meshes and elements out"
    )
    no_theory_reason = theories.MOVING_EDGES

    def prepare(self, problem: Problem) -> Problem:
        """Return the problem of the history alone, with rtol 1e-4, to which cell sizes refer."""
        if not len(problem.times):
            raise SceneError(
                "the steady state of this punch equals that of a flat punch: give wear.times for a "
                "history, or study a flat punch"
            )
        problem = replace(problem, march="modal", step=None, quantities=None)
        problem = replace(problem, rtol=1e-4, steady=False)
        return replace(problem, compared_on=problem.face)

    def reference(self, problem: Problem, cell_factor: float, stages: Stages) -> Evaluation:
        """Return the march on cells half as large as on the finest level, from a fitted start."""
        compliance = ring_kernel.compliance(scaled_cells(problem, 2 * cell_factor).space())
        start = fitted_start(problem, stages)
        return MovingContact(problem, compliance, start, STEP_TOLERANCE_FACTOR)

    def evaluate(self, problem: Problem, compliance: Compliance) -> Evaluation:
        """Return the march on the cells of the compliance."""
        return MovingContact(problem, compliance, step_tolerance_factor=STEP_TOLERANCE_FACTOR)

    def flat_start(self, problem: Problem, compliance: Compliance) -> Results:
        """Return nothing: the start is not flat."""
        return {}

    def closed_forms(self, problem: Problem, results: Results) -> Results:
        """Return nothing: there is no closed form if the contact moves."""
        return {}

    def theory_of_steps(self, short: bool) -> TheoryOfMeasure:
        """Return a theory without an order, because contact moves during the steps."""
        return theories.for_steps_in_moving_contact


CONTACT_KINDS: dict[bool, ContactKind] = {True: FlatPunch(), False: ShapedPunch()}
"""Treatment of problems, by whether the punch is in full contact."""


def fitted_start(problem: Problem, stages: Stages) -> FittedPress | None:
    """Return the unworn contact with functions fitted to its edges; None if there is no fit."""
    intervals, _ = first_contact(problem)
    presses, _ = fitted_starts(problem, intervals, MDR.discretise(problem, stages))
    # there is no fit, for example, if edges inside the contact are free; then the cells of the
    # march also approximate the start
    return presses[0] if presses else None
