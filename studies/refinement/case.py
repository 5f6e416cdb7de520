"""Solve a punch on the meshes to compare, and compute the errors on each mesh.

The reference is a far finer MDR, and a closed form for the indentation of the flat start. The
energy error of finite elements can be computed without a finer mesh. For a pressure p, MDR gives
the exact energy ``p . A_mdr p``, and elements with the displacement u_h give ``p . A_fem p``. Their
difference is the energy of u - u_h, because u_h is the best approximation in the finite-element
space.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from skfem import Mesh

from ...fem.error_indicator import squared_indicators
from ...fem.half_space import pressure_space
from ...meshes.half_space import contact_radii, truncation
from ..crosscheck import (
    Array,
    AxisymmetricElasticity,
    Compliance,
    HalfSpace,
    Problem,
    Results,
    Rings,
    Scene,
    Stages,
    differences,
    energy,
    method,
)
from ..crosscheck.methods.evaluation import FullContact
from ..crosscheck.problem.sections import MdrAccuracy
from ..crosscheck.sizes.defaults import pole_orders
from ..numerics.core import FLAT, flat_d0_error
from ..study.levels import SECONDS
from ..tables import Row

TIMES = np.append(0.0, np.geomspace(1e-2, 20.0, 10))
"""Times of the histories in ``a / (E* k_max v0)``: the start, and times from thin worn layers to
the steady state."""
REFERENCE_RTOL = 1e-9
"""Relative tolerance of the reference history, with which all others are compared."""
POLES_RTOL = 1e-12
"""Tolerance for the number of far-field poles if the truncation error has to be negligible."""
ENERGY_FLOOR = 1e-11
"""Relative energy error below which roundoff and the truncation dominate."""
ERRORS = {
    "d0": "indentation d(0)",
    "history": "indentation d(t)",
    "pressure": "pressure p(t)",
    "slope": "steady RMS slope",
}
"""Columns of the errors that are drawn, and the names of their quantities."""
PHASES = ("meshing", "assembling", "condensing", "marching", "estimating")
"""Phases of a level: columns with their seconds."""


@dataclass(frozen=True, eq=False)
class MeshSolution:
    """A solution on one mesh.

    Parameters
    ----------
    half_space : half-space in finite elements
    compliance : compliance on its pressure space
    pressures : (states, size) coefficients of the pressures of the history, from the start on, and
        of the steady state
    results : quantities on the face of the punch
    seconds : seconds by phase
    indicators : (states, m) squared error indicators of the m triangles, over the energy of each
        state; None if they were not computed
    """

    half_space: HalfSpace
    compliance: Compliance
    pressures: Array
    results: Results
    seconds: Mapping[str, float]
    indicators: Array | None = None

    @property
    def degree(self) -> int:
        """Polynomial degree of the displacement."""
        return self.half_space.solid.degree

    @property
    def mesh(self) -> Mesh:
        """The mesh with its named boundaries."""
        return self.half_space.solid.mesh

    @cached_property
    def energies(self) -> Array:
        """(states,) finite-element energy of each state."""
        return np.sum((self.pressures @ self.compliance.factor.T) ** 2, axis=1)

    @cached_property
    def relative_energy_errors(self) -> Array:
        """(states,) energy of the displacement error over the energy of the state."""
        exact = energy.compliance(self.compliance.space)
        exact_energies = np.sum((self.pressures @ exact.factor.T) ** 2, axis=1)
        energy_errors = exact_energies - self.energies
        # errors of unloaded states are 0
        relative_errors = np.zeros(len(energy_errors))
        return np.divide(
            energy_errors, exact_energies, out=relative_errors, where=exact_energies > 0
        )

    @property
    def greatest_indicators(self) -> Array | None:
        """(m,) greatest indicator of each triangle over the states; None without indicators."""
        return None if self.indicators is None else self.indicators.max(axis=0)

    @cached_property
    def effectivities(self) -> dict[str, float]:
        """Least and greatest ratio of the indicator and the true energy error over the states.

        States with energy errors below `ENERGY_FLOOR` are left out. The dictionary is empty if no
        states remain or if there are no indicators.
        """
        if self.indicators is None:
            return {}
        errors = self.relative_energy_errors[self.energies > 0]
        above_floor = errors > ENERGY_FLOOR
        ratios = np.sqrt(self.indicators.sum(axis=1)[above_floor] / errors[above_floor])
        if not len(ratios):
            return {}
        return {
            "least effectivity": float(ratios.min()),
            "greatest effectivity": float(ratios.max()),
        }


@dataclass(frozen=True, eq=False)
class Case:
    """A flat punch under a force, with its reference solution.

    Parameters
    ----------
    name : name in tables and names of figures
    problem : problem of the scene, but with the times `TIMES`
    """

    name: str
    problem: Problem

    @classmethod
    def all_of(cls, scene: Scene) -> "Iterator[Case]":
        """Yield the case of the flat punch of one ring and, if it differs, that of the scene."""
        with_times = replace(
            scene.problem,
            times=TIMES,
            steady=True,
            quantities=None,
            march="modal",
            step=None,
            mdr=MdrAccuracy(),
            gradient_average="line",
        )
        yield cls(
            "flat punch", replace(with_times, rings=Rings.constant(FLAT, np.ones(1)), graded=None)
        )
        if len(with_times.merged.widths) > 1 or with_times.inner_radius:
            yield cls("scene", with_times)

    @property
    def title(self) -> str:
        """The punch in a few words, for figures: flat punch, 5 rings, hollow punch, ..."""
        if self.name != "scene":
            return self.name
        if self.problem.merged.linear:
            return "wear along the radius"
        count = len(self.problem.wear_coefficients)
        kind = f"{count} rings" if count > 1 else "punch"
        return f"hollow, {kind}" if self.problem.inner_radius else kind

    @cached_property
    def exact(self) -> Results:
        """Results of the reference solution, at the radii of `compared_problem`."""
        return (
            method("mdr").solve(replace(self.problem, rtol=REFERENCE_RTOL), Stages("mdr")).compared
        )

    @cached_property
    def compared_problem(self) -> Problem:
        """The problem, with fields at the radii of the reference solution."""
        return replace(self.problem, compared_on=replace(self.problem, rtol=REFERENCE_RTOL).face)

    def half_space_on(self, mesh: Mesh, degree: int, rtol: float) -> HalfSpace:
        """Return the half-space on a mesh with elements of one degree.

        The tolerance `rtol` determines the number of poles of the far field.
        """
        rings = self.problem.merged
        solid = AxisymmetricElasticity(mesh, degree, self.problem.ground)
        poles = pole_orders(replace(self.problem, rtol=rtol), truncation(mesh))
        return HalfSpace(solid, pressure_space(solid, rings.ring_edges), poles)

    def solve(self, half_space: HalfSpace, stages: Stages) -> MeshSolution:
        """Condense a half-space, and compute the wear of the punch on it."""
        with stages("assembling"):
            half_space.assemble()
        with stages("condensing"):
            compliance = half_space.compliance()
        with stages("marching"):
            evaluation = FullContact(self.compared_problem, compliance)
            pressures = np.concatenate(
                [evaluation.history.pressure, evaluation.wear.steady.pressure[None]]
            )
        return MeshSolution(half_space, compliance, pressures, evaluation.compared, stages.seconds)

    def solve_and_estimate(self, half_space: HalfSpace, stages: Stages) -> MeshSolution:
        """Solve on a half-space of triangles, and compute the error indicator of each triangle.

        Raises
        ------
        MeshError
            if the mesh has quadrilaterals
        """
        solution = self.solve(half_space, stages)
        # states before the load rises have no energy
        loaded = solution.energies > 0
        pressures = solution.pressures[loaded]
        with stages("estimating"):
            displacements = half_space.displacements(pressures)
            squares = squared_indicators(
                half_space.solid, displacements, half_space.space, pressures
            )
        return replace(solution, indicators=squares / solution.energies[loaded, None])

    def errors(self, solution: MeshSolution) -> dict[str, float]:
        """Return the relative errors of a solution, each in the norm of its quantity.

        The entry `history` is the greatest error over all times, and `pressure` is the greatest
        over the times after the start.
        """
        errors = differences(solution.results, self.exact, self.compared_problem.face)
        return {
            "d0": abs(flat_d0_error(solution.compliance)),
            "history": float(errors["indentation"].max()),
            "start pressure": float(errors["pressure"][0]),
            "pressure": float(errors["pressure"][1:].max()),
            "steady": float(errors["steady_displacement_max"]),
            "slope": float(errors["steady_rms_slope"]),
            "energy": float(np.sqrt(max(solution.relative_energy_errors.max(), 0.0))),
        }

    def row(self, solution: MeshSolution) -> Row:
        """Return the row of a level: its sizes, its errors, and its seconds by phase."""
        return {
            "case": self.name,
            "degree": solution.degree,
            "unknowns": solution.half_space.unknowns,
            "elements": solution.mesh.nelements,
            "multipliers": solution.compliance.space.size,
            "smallest facet": float(np.diff(contact_radii(solution.mesh)).min()),
            **self.errors(solution),
            **solution.effectivities,
            **{phase: solution.seconds.get(phase, 0.0) for phase in PHASES},
            SECONDS: sum(solution.seconds.values()),
        }

    def pressure_errors(self, solution: MeshSolution) -> Array:
        """Return the absolute errors (T, R) of p(t) after the start, over the norm of p(t)."""
        values, exact = solution.results["pressure"][1:], self.exact["pressure"][1:]
        weights = self.compared_problem.face.weights
        norms = np.sqrt(np.sum(weights * exact**2, axis=1) / np.sum(weights))
        return np.asarray(np.abs(values - exact) / norms[:, None])


@dataclass(frozen=True, eq=False)
class Level:
    """A solved level, with its mesh and pressure errors.

    Parameters
    ----------
    case, family, setting : entries of its row in the table
    mesh : mesh with its named boundaries
    degree : polynomial degree of the displacement
    unknowns : number of unknowns of the displacement
    pressure_errors : (T, R) absolute errors of p(t) after the start, at the radii of the face, over
        the norm of p(t)
    indicators : (m,) squared error indicator of each triangle, the greatest over the states; None
        if there are none
    """

    case: str
    family: str
    setting: str
    mesh: Mesh
    degree: int
    unknowns: int
    pressure_errors: Array
    indicators: Array | None = None

    @classmethod
    def of(cls, case: Case, family: str, setting: str, solution: MeshSolution) -> "Level":
        """Return the level of a solution."""
        return cls(
            case.name,
            family,
            setting,
            solution.mesh,
            solution.degree,
            solution.half_space.unknowns,
            case.pressure_errors(solution),
            solution.greatest_indicators,
        )


COLUMNS = [
    "case",
    "family",
    "setting",
    "degree",
    "unknowns",
    "elements",
    "multipliers",
    "smallest facet",
    "d0",
    "history",
    "start pressure",
    "pressure",
    "steady",
    "slope",
    "energy",
    "least effectivity",
    "greatest effectivity",
    "least eigenvalue",
    *PHASES,
]
"""Columns of the table of this study, in addition to those of every study."""
