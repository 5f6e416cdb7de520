"""Direct integration: the steady state in closed form (Eqs. 21 to 27)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ....mdr import direct
from ....meshes.radial import Array, ring_of
from ..problem.norms import Results
from ..problem.problem import Problem
from ..problem.quantities import ANSWER, QUANTITIES, STEADY
from ..problem.refusal import Feature, Refusal
from ..progress import Stages
from .base import Method, Solution
from .sampling.answers import SteadyRun, answers_of


class Direct(Method):
    """The steady state in closed form, accurate to roundoff."""

    name = "direct"
    knows_layers = True
    what = "the steady state by direct integration, in closed form"
    lacks: ClassVar[dict[str, str]] = {"history": "direct integration gives the steady state only"}
    refused: ClassVar[Mapping[Feature, Refusal]] = {
        "wear along the radius": Refusal(
            "direct integration needs pressures that are constant on each ring, and with "
            "punch.wear_coefficient along the radius they are not",
            "leave direct out of methods, or give steps, or many rings",
        ),
        "fixed indentation": Refusal(
            "direct gives the steady state only, and with load.indentation nothing presses in the "
            "end"
        ),
    }

    def beyond(self, problem: Problem) -> Refusal | None:
        """Return why problems of this kind are beyond the method; None if it can solve them.

        Without a force or without sliding in the end, there is no steady state.
        """
        if refusal := super().beyond(problem):
            return refusal
        end = problem.loading.final
        if end.forces.all() and end.speeds.all():
            return None
        return Refusal(f"direct gives the steady state only, and {problem.reason_not_steady}")

    def solve(self, problem: Problem, stages: Stages) -> Solution:
        """Return the steady state in closed form."""
        return self.solve_alike([problem], stages)[0]

    def solve_alike(self, problems: Sequence[Problem], stages: Stages) -> list[Solution]:
        """Return the steady states of several problems on the same ring edges, in closed form."""
        ring_edges, ground = problems[0].merged.ring_edges, problems[0].ground
        coefficients = [problem.merged.wear_coefficients[0] for problem in problems]
        slopes = max_displacements = np.full(len(problems), np.nan)
        wanted = {name for name in STEADY for problem in problems if problem.wants(name)}
        with stages("integrating"):
            pressures = [
                problem.loading.forces[-1] * direct.steady_pressures(ring_edges, wear)
                for problem, wear in zip(problems, coefficients, strict=True)
            ]
            columns = np.stack(pressures, axis=1)
            if "steady_rms_slope" in wanted:
                average = problems[0].gradient_average
                slopes = direct.rms_slope(ring_edges, columns, average, ground)
            if wanted & {"steady_displacement_max", "steady_profile"}:
                max_displacements = direct.greatest_displacement(ring_edges, columns, ground)
            return [
                _solution(*arguments)
                for arguments in zip(problems, pressures, max_displacements, slopes, strict=True)
            ]


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """The steady state in closed form: the attributes of `SampledSteadyState`.

    Parameters
    ----------
    problem : the problem
    pressures : (N,) pressure on each ring
    radii : (R,) radii of the fields
    displacement_max, rms_slope : () NaN if they are not wanted
    """

    problem: Problem
    pressures: Array
    radii: Array
    displacement_max: Array
    rms_slope: Array

    @property
    def pressure(self) -> Array:
        """(R,) contact pressure."""
        return self.pressures[ring_of(self.problem.merged.ring_edges, self.radii)]

    @property
    def displacement(self) -> Array:
        """(R,) displacement of the half-space."""
        edges, ground = self.problem.merged.ring_edges, self.problem.ground
        return direct.displacement(edges, self.pressures, self.radii, ground)

    @property
    def wear_rate(self) -> Array:
        """() rate at which height is lost."""
        speed = self.problem.loading.speeds[-1]
        return speed * self.problem.merged.wear_coefficients[0, -1] * self.pressures[-1]


def _solution(problem: Problem, pressures: Array, greatest: float, slope: float) -> Solution:
    """Return the steady state for ring pressures (N,); NaN marks values that are not wanted."""
    ring_edges, force = problem.merged.ring_edges, problem.loading.forces[-1]

    def sample(radii: Array) -> Results:
        steady = ClosedForm(problem, pressures, radii, np.asarray(greatest), np.asarray(slope))
        return {
            name: np.asarray(QUANTITIES[name].value(steady))
            for name in QUANTITIES
            if name in STEADY and problem.wants(name)
        }

    # cancellation: the displacement of a narrow ring of high pressure is the small difference of
    # those of two discs
    discs, steps = direct.pressure_steps(ring_edges, pressures)
    cancellation = float(np.abs(steps) @ discs)
    # scale of the roundoff: the mean displacement is at least that of the mean pressure at the rim
    # (Betti)
    roundoff = 1e-12 + 4 * np.finfo(float).eps * cancellation / float(
        np.fmax(greatest, 4 / np.pi**2 * force)
    )
    results = sample(problem.radii)
    errors: Results = dict.fromkeys(results, np.asarray(roundoff))
    # without fields, sampling on the face would only compute the same scalars again
    fields = {"steady_pressure", "steady_profile"} & results.keys()
    compared = sample(problem.face.radii) if fields else results
    answers = answers_of(SteadyRun(problem, compared))
    for name, value in answers.items():
        estimate = np.where(np.isnan(value), np.nan, roundoff)
        errors[name] = estimate[..., 0] if "ring" in ANSWER[name].dims else estimate
    return Solution(results | answers, compared | answers, errors, {"roundoff": roundoff})


METHOD = Direct()
