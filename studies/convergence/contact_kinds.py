"""What the convergence study does differently for flat and for shaped punches.

A flat punch keeps full contact. Its levels are exact in time, its flat start is known in closed
form, and its reference is MDR at the finest accuracy. The contact of any other punch moves: its
levels are marched on cells, and its reference has cells half as large as the smallest, and a start
that is fitted to its edges.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from ...mdr import direct, ring_kernel
from ...mdr.flat_punch import flat_punch
from ...meshes.compliance import Compliance
from ...meshes.errors import SceneError
from ..methods.evaluation import Evaluation, FullContact
from ..methods.mdr import METHOD as MDR
from ..methods.moving_evaluation import MovingContact
from ..methods.pipeline import fitted_starts
from ..methods.spaces import first_contact
from ..problem.problem import Problem
from ..problem.quantities import FINEST_RTOL
from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT
from ..problem.sections import MdrAccuracy
from ..progress import Stages
from ..sampling.norms import Results
from ..study.levels import Theory
from ..wear.flat_contact import FittedPress, press_flat
from . import theories
from .measures import FLAT_INDENTATION, FLAT_PRESSURE

STEP_TOLERANCE_FACTOR = 0.2
"""Where contact moves: steps in time err by less than cells (a factor on their tolerance)."""


TheoryOfMeasure = Callable[[str], Theory]
"""The theory of a measure by its name."""


class ContactKind(ABC):
    """How problems of one contact regime are studied.

    Attributes
    ----------
    refuses_elements : why meshes and elements of the user's own are refused; empty if they are not
    no_order : why no order can be judged where no sequence has a theory
    """

    refuses_elements: str = ""
    no_order: str = ""

    @abstractmethod
    def studied(self, problem: Problem) -> Problem:
        """Return a problem as every level solves it: exact in time, with all quantities.

        Raises
        ------
        SceneError
            if there is nothing to study
        """

    @abstractmethod
    def reference(self, problem: Problem, finer: float, stages: Stages) -> Evaluation:
        """Return the run that levels are measured by.

        Parameters
        ----------
        problem : as every level solves it
        finer : how many times as many cells the finest level has as rtol 1e-4 asks for
        stages : tells of the progress
        """

    @abstractmethod
    def evaluate(self, problem: Problem, compliance: Compliance) -> Evaluation:
        """Return a compliance worn and sampled, as the pipeline of every method does."""

    @abstractmethod
    def flat_start(self, problem: Problem, compliance: Compliance) -> Results:
        """Return the flat start by the pressures of the space itself, under the force 1."""

    @abstractmethod
    def closed_forms(self, problem: Problem, results: Results) -> Results:
        """Return what is known exactly, of the quantities in the results and of flat starts."""

    @abstractmethod
    def theory_of_steps(self, short: bool) -> TheoryOfMeasure:
        """Return the theory of the implicit march, given whether all of its steps are short."""


class FlatPunch(ContactKind):
    """A flat punch, which keeps full contact."""

    no_order = theories.OWN_MESH

    def studied(self, problem: Problem) -> Problem:
        """Return the problem with the radii that fields of all levels are compared at."""
        problem = replace(problem, march="modal", step=None, quantities=None)
        return replace(problem, compared_on=problem.face)

    def reference(self, problem: Problem, finer: float, stages: Stages) -> Evaluation:
        """Return MDR at the finest accuracy."""
        finest = replace(problem, rtol=FINEST_RTOL, mdr=MdrAccuracy())
        return self.evaluate(problem, MDR.discretise(finest, stages).compliance)

    def evaluate(self, problem: Problem, compliance: Compliance) -> Evaluation:
        """Return the history that is exact in time."""
        return FullContact(problem, compliance)

    def flat_start(self, problem: Problem, compliance: Compliance) -> Results:
        """Return the indentation and the pressure at the radii of the face."""
        pressed = press_flat(compliance)
        pressure = compliance.space.matrix(problem.face.radii) @ pressed.pressure
        return {FLAT_INDENTATION: np.asarray(pressed.indentation), FLAT_PRESSURE: pressure}

    def closed_forms(self, problem: Problem, results: Results) -> Results:
        """Return the flat start, and the slope of the steady state where k is constant on rings."""
        flat = flat_punch(problem.inner_radius)
        exact = {
            FLAT_INDENTATION: np.asarray(flat.indentation),
            FLAT_PRESSURE: flat.pressure_at(problem.face.radii),
        }
        if "steady_rms_slope" in results and not problem.merged.linear:
            rings = problem.merged
            slope = direct.rms_slope(
                rings.ring_edges,
                direct.steady_pressures(*rings),
                problem.gradient_average,
                problem.inner_radius,
            )
            exact["steady_rms_slope"] = np.asarray(problem.loading.forces[-1] * slope)
        return exact

    def theory_of_steps(self, short: bool) -> TheoryOfMeasure:
        """Return the first order of the implicit march."""
        return partial(theories.of_steps, short)


class ShapedPunch(ContactKind):
    """A punch whose contact opens, closes and spreads."""

    refuses_elements = (
        "study convergence takes meshes and elements of your own for flat punches under a force "
        "that never falls: cells of a face follow its contact; leave them out"
    )
    no_order = theories.MOVING_EDGES

    def studied(self, problem: Problem) -> Problem:
        """Return the history alone, with sizes of cells that are counted from one accuracy."""
        if not len(problem.times):
            raise SceneError(
                "the steady state of this punch is that of a flat one: give wear.times for a "
                "history, or a flat punch"
            )
        problem = replace(problem, march="modal", step=None, quantities=None)
        problem = replace(problem, rtol=1e-4, steady=False)
        return replace(problem, compared_on=problem.face)

    def reference(self, problem: Problem, finer: float, stages: Stages) -> Evaluation:
        """Return the march on cells half as large as the finest, from a fitted start."""
        compliance = ring_kernel.compliance(first_contact(problem, 2 * finer)[1].space())
        start = fitted_start(problem, stages)
        return MovingContact(problem, compliance, start, STEP_TOLERANCE_FACTOR)

    def evaluate(self, problem: Problem, compliance: Compliance) -> Evaluation:
        """Return the march on the cells of the compliance."""
        return MovingContact(problem, compliance, step_tolerance_factor=STEP_TOLERANCE_FACTOR)

    def flat_start(self, problem: Problem, compliance: Compliance) -> Results:
        """Return nothing: the start is not flat."""
        return {}

    def closed_forms(self, problem: Problem, results: Results) -> Results:
        """Return nothing: a contact that moves has no closed form."""
        return {}

    def theory_of_steps(self, short: bool) -> TheoryOfMeasure:
        """Return why there is no order: steps are taken where contact moves, too."""
        return theories.of_steps_in_moving_contact


KINDS: dict[object, ContactKind] = {FULL_CONTACT: FlatPunch(), MOVING_CONTACT: ShapedPunch()}
"""How problems are studied, by their contact regime."""


def fitted_start(problem: Problem, stages: Stages) -> FittedPress | None:
    """Return the unworn press fitted to the edges of its contact; None where that is not had."""
    intervals, _ = first_contact(problem)
    presses, _ = fitted_starts(problem, intervals, MDR.discretise(problem, stages))
    # where edges within the contact are free, cells show the start as they show the rest
    return presses[0] if presses else None
