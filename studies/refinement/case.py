"""A punch whose meshes are compared, and how far a mesh is from the truth of it.

The truth is a far finer MDR, and closed forms for the indentation of a flat start. The energy error
of finite elements is known without a finer mesh. For a pressure p, MDR has the exact energy
``p . A_mdr p``, and elements whose displacement is u_h give ``p . A_fem p``. Their difference is
the energy of u - u_h, because u_h is the best displacement that the elements have.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from skfem import Mesh

from ...fem.elasticity import AxisymmetricElasticity
from ...fem.error_indicator import squared_indicators
from ...fem.half_space import HalfSpace, pressure_space
from ...mdr import energy
from ...meshes.compliance import Compliance
from ...meshes.half_space import contact_radii, truncation
from ...meshes.radial import Array
from ..methods.base import method
from ..methods.evaluation import FullContact
from ..numerics.core import FLAT, flat_d0_error
from ..problem.problem import Problem, Rings
from ..problem.sections import MdrAccuracy
from ..progress import Stages
from ..sampling.norms import Results, differences
from ..scene.scene import Scene
from ..sizes.defaults import pole_orders
from ..study.levels import SECONDS
from ..tables import Row

TIMES = np.append(0.0, np.geomspace(1e-2, 20.0, 10))
"""Times of the histories, in ``a / (E* k_max v0)``: the start, and from thin layers to the end."""
TRUTH = 1e-9
"""Relative accuracy of the history that all others are compared with."""
NEGLIGIBLE = 1e-12
"""Accuracy that decides on the number of poles where truncation must not be seen."""
ENERGY_FLOOR = 1e-11
"""Energy errors, relative to the energy, below which roundoff and truncation are above_floor."""
ERRORS = {
    "d0": "indentation d(0)",
    "history": "indentation d(t)",
    "pressure": "pressure p(t)",
    "slope": "steady RMS slope",
}
"""Columns of the errors that are drawn, and what they are errors of."""
PHASES = ("meshing", "assembling", "condensing", "marching", "estimating")
"""Columns with the seconds of a level, by what took them."""


@dataclass(frozen=True, eq=False)
class Solved:
    """A half-space, pressed, worn, and compared with the truth.

    Parameters
    ----------
    half_space : of finite elements
    compliance : of its pressures
    pressures : (states, size) of the history from the start on, then of the steady state
    results : quantities on the face of the punch
    seconds : that it took, by phase
    indicators : (states, m) squared error indicators of triangles, over the energy of each state;
        None if there are none
    """

    half_space: HalfSpace
    compliance: Compliance
    pressures: Array
    results: Results
    seconds: Mapping[str, float]
    indicators: Array | None = None

    @property
    def degree(self) -> int:
        """Degree of the displacement."""
        return self.half_space.solid.degree

    @property
    def mesh(self) -> Mesh:
        """The mesh, with its boundaries named."""
        return self.half_space.solid.mesh

    @cached_property
    def energies(self) -> Array:
        """(states,) energy of each state by the finite elements."""
        return np.sum((self.pressures @ self.compliance.factor.T) ** 2, axis=1)

    @cached_property
    def relative_energy_errors(self) -> Array:
        """(states,) energy of the error of the displacement over that of the state."""
        exact = energy.compliance(self.compliance.space)
        exact_energies = np.sum((self.pressures @ exact.factor.T) ** 2, axis=1)
        differences = exact_energies - self.energies
        unloaded = np.zeros(len(differences))
        return np.divide(differences, exact_energies, out=unloaded, where=exact_energies > 0)

    @property
    def greatest_indicators(self) -> Array | None:
        """(m,) the greatest indicator of each triangle over the states, if there are any."""
        return None if self.indicators is None else self.indicators.max(axis=0)

    @cached_property
    def effectivities(self) -> dict[str, float]:
        """The least and greatest ratio of indicator and energy error over the states.

        Errors below `ENERGY_FLOOR` are left out; it is empty if nothing is left.
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
    """A flat punch under a force, and what is known of it.

    Parameters
    ----------
    name : in tables and figures
    problem : with the times `TIMES`, whatever those of the scene are
    """

    name: str
    problem: Problem

    @classmethod
    def all_of(cls, scene: Scene) -> "Iterator[Case]":
        """Yield the flat punch of one ring, and the scene if that is another punch."""
        watched = replace(
            scene.problem,
            times=TIMES,
            steady=True,
            quantities=None,
            march="modal",
            step=None,
            mdr=MdrAccuracy(),
            gradient_average="line",
        )
        yield cls("flat punch", replace(watched, rings=Rings(FLAT, np.ones(1)), graded=None))
        if len(watched.merged.wear_coefficients) > 1 or watched.inner_radius:
            yield cls("scene", watched)

    @cached_property
    def exact(self) -> Results:
        """The truth at the radii of `watched`."""
        return method("mdr").solve(replace(self.problem, rtol=TRUTH), Stages("mdr")).checked

    @cached_property
    def watched(self) -> Problem:
        """The problem, with fields at the radii of the truth."""
        return replace(self.problem, compared_on=replace(self.problem, rtol=TRUTH).face)

    def half_space_on(self, mesh: Mesh, degree: int, rtol: float) -> HalfSpace:
        """Return the half-space on a mesh, in elements of one degree.

        `rtol` decides on the number of poles of its far field.
        """
        rings = self.problem.merged
        solid = AxisymmetricElasticity(mesh, degree, self.problem.poisson_ratio)
        poles = pole_orders(replace(self.problem, rtol=rtol), truncation(mesh))
        return HalfSpace(solid, pressure_space(solid, rings.ring_edges, rings.hollow), poles)

    def solve(self, half_space: HalfSpace, stages: Stages) -> Solved:
        """Condense a half-space, and let the punch wear on it."""
        with stages("assembling"):
            _ = half_space.lower_triangle
        with stages("condensing"):
            compliance = half_space.compliance()
        with stages("marching"):
            worn = FullContact(self.watched, compliance)
            pressures = np.concatenate([worn.history.pressure, worn.wear.steady.pressure[None]])
        return Solved(half_space, compliance, pressures, worn.checked, stages.seconds)

    def solve_and_estimate(self, half_space: HalfSpace, stages: Stages) -> Solved:
        """Solve on a half-space of triangles, and estimate the error of each triangle.

        Raises
        ------
        MeshError
            if the mesh has quadrilaterals
        """
        solved = self.solve(half_space, stages)
        # before a load rises nothing presses
        pressed = solved.energies > 0
        pressures = solved.pressures[pressed]
        with stages("estimating"):
            moved = half_space.displacements(pressures)
            squares = squared_indicators(half_space.solid, moved, half_space.space, pressures)
        return replace(solved, indicators=squares / solved.energies[pressed, None])

    def errors(self, solved: Solved) -> dict[str, float]:
        """Return the relative errors of a solution, each in the norm of its quantity.

        Those of a history are the greatest over all times but the start.
        """
        found = differences(solved.results, self.exact, self.watched.face)
        return {
            "d0": abs(flat_d0_error(solved.compliance)),
            "history": float(found["indentation"].max()),
            "start pressure": float(found["pressure"][0]),
            "pressure": float(found["pressure"][1:].max()),
            "steady": float(found["steady_displacement_max"]),
            "slope": float(found["steady_rms_slope"]),
            "energy": float(np.sqrt(max(solved.relative_energy_errors.max(), 0.0))),
        }

    def row(self, solved: Solved) -> Row:
        """Return the row of a level: its size, its errors, and the seconds that it took."""
        return {
            "case": self.name,
            "degree": solved.degree,
            "unknowns": solved.half_space.unknowns,
            "elements": solved.mesh.nelements,
            "multipliers": solved.compliance.space.size,
            "smallest facet": float(np.diff(contact_radii(solved.mesh)).min()),
            **self.errors(solved),
            **solved.effectivities,
            **{phase: solved.seconds.get(phase, 0.0) for phase in PHASES},
            SECONDS: sum(solved.seconds.values()),
        }

    def pressure_errors(self, solved: Solved) -> Array:
        """Return the errors (T, R) of p(t) after the start, over the norm of p(t)."""
        values, exact = solved.results["pressure"][1:], self.exact["pressure"][1:]
        weights = self.watched.face.weights
        norms = np.sqrt(np.sum(weights * exact**2, axis=1) / np.sum(weights))
        return np.asarray(np.abs(values - exact) / norms[:, None])


@dataclass(frozen=True, eq=False)
class Level:
    """A mesh that was solved on.

    Parameters
    ----------
    case, family, setting : of its row
    mesh : with its boundaries named
    degree : of the displacement
    unknowns : number of the displacement's
    pressure_errors : (T, R) of p(t) after the start, at the radii of the face, over the norm of p
    indicators : (m,) of the triangles, squares; greatest over the states; None if there are none
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
    def of(cls, case: Case, family: str, setting: str, solved: Solved) -> "Level":
        """Return the level that was solved."""
        return cls(
            case.name,
            family,
            setting,
            solved.mesh,
            solved.degree,
            solved.half_space.unknowns,
            case.pressure_errors(solved),
            solved.greatest_indicators,
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
"""Columns of the table of the study, besides those of every study."""
