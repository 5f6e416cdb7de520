"""Define the ways to refine a mesh; each is a family of levels from coarse to fine.

- `uniform` divides every triangle into four.
- `graded` chooses the sizes of triangles before solving, from the known singularities.
- `adaptive` repeatedly solves, estimates errors, marks triangles and refines them.
- `layered` is the default of ringwear: quadrilaterals in layers around the ring edges, with sizes
  and degrees that follow from `rtol`.
- `degree` raises the degree on one such mesh.
- `file` uses the meshes of the user.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from skfem import MeshTri

from ...fem.error_indicator import fewest_with_share
from ...meshes.by_gmsh.session import unavailable
from ..crosscheck import Problem, SizeField, Stages, bisection
from ..crosscheck.methods.fem import half_space_on
from ..crosscheck.problem.sections import FemAccuracy
from ..crosscheck.sizes.defaults import WIDER_TRUNCATION, triangle_degree
from ..crosscheck.sizes.half_space_mesh import half_space_mesh
from ..study.levels import Family
from ..study.options import Options
from ..tables import Row
from .case import POLES_RTOL, Case, Level, MeshSolution
from .own_meshes import OwnMeshes, least_eigenvalue

COARSEST_SIZE = 1.2
"""Size of the triangles of the coarsest mesh, in punch radii.

Triangles are smaller only where a ring edge has to be a vertex.
"""
MARKED_SHARE = 0.5
"""Fraction of the sum of the squared indicators in the marked triangles (Dörfler)."""
GROWTH, GROWTH_OF_ONE_RING, GROWTH_NEAR_INCOMPRESSIBILITY = 1.16, 1.12, 1.22
"""Measured factors of the unknowns of an adaptive level over those of the level before."""
MOST_UNKNOWNS = 60_000
"""Unknowns of the finest adaptive level, approximately."""
MOST_UNKNOWNS_QUICK = 30_000
"""The same in the quick study: slightly more than a pressure error of 1e-3 needs."""
MOST_UNKNOWNS_OF_ONE_RING_QUICK = 15_000
"""The same in the quick study for one ring, where this pressure error needs fewer unknowns."""
MANY_RINGS, GROWTH_OF_MANY_RINGS = 8, 1.2
"""Number of rings above which the unknowns of adaptive levels grow by this larger factor."""
MOST_EXPECTED, MOST_EXPECTED_QUICK = 250_000, 55_000
"""Levels with more expected unknowns are left out, for example with many rings."""
LEAST_LEVELS, LEAST_LEVELS_QUICK = 2, 1
"""Number of levels of each way that are always solved."""
ACCURACIES = tuple(10.0 ** (-half / 2) for half in range(2, 13))
"""Values of `rtol` for which graded and layered meshes are made."""
ACCURACIES_QUICK = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
LAYERED_SETTINGS = {"mesher": "quads"}
"""Settings of the default mesh (`accuracy.fem`)."""
FIRST_SETTING = "0 halvings"
"""Setting of the first level of a case, whose time includes the reference solution."""
REFERENCE_SECONDS = 0.17
"""Seconds of the reference solution for each ring, measured with five rings."""
DEGREE_MESH_RTOL = 1e-7
"""Value of `rtol` for which the mesh is made on which the degree is raised."""


@dataclass(frozen=True, eq=False)
class Ways:
    """The ways to refine a mesh for a case.

    Parameters
    ----------
    case : case that is solved
    options : options of the study
    levels : list to which each solved level is appended
    """

    case: Case
    options: Options
    levels: list[Level]

    def families(self) -> Iterator[Family]:
        """Yield the family of each way, and last that of the user's meshes."""
        quick, coarsest_unknowns = self.options.quick, self._coarsest_unknowns
        halvings = range(3 if quick else 4)
        yield self._family(
            "uniform", {f"{n} halvings": coarsest_unknowns * 4.0**n for n in halvings}, self._halve
        )
        rings, greatest_unknowns = len(self.case.problem.merged.widths), MOST_UNKNOWNS
        if quick:
            greatest_unknowns = (
                MOST_UNKNOWNS_QUICK if rings > 1 else MOST_UNKNOWNS_OF_ONE_RING_QUICK
            )
        growth = GROWTH if rings > 1 else GROWTH_OF_ONE_RING
        if rings > MANY_RINGS:
            growth = GROWTH_OF_MANY_RINGS
        if self.case.problem.poisson_ratio > 0.49:
            growth = GROWTH_NEAR_INCOMPRESSIBILITY
        count = max(
            3, int(np.ceil(np.log(greatest_unknowns / coarsest_unknowns) / np.log(growth))) + 1
        )
        adaptive = AdaptiveTriangles(self.case, self._coarsest, self.degree)
        expected = {f"level {n}": coarsest_unknowns * growth**n for n in range(count)}
        yield self._family("adaptive", expected, adaptive.solve_next, 0.8)
        accuracies = ACCURACIES_QUICK if quick else ACCURACIES
        # fits to the unknowns measured with 1 to 32 rings
        ring_factor = 0.95 + 0.025 * rings
        expected = {
            f"rtol {x:.0e}": coarsest_unknowns * ring_factor * (10 * x) ** -0.2 for x in accuracies
        }
        yield self._family("graded", expected, self._grade)
        if not unavailable():  # gmsh makes the layered meshes
            ring_factor, power = 4 + rings / 8, 0.04 + 0.0037 * rings
            expected = {
                f"rtol {x:.0e}": coarsest_unknowns * ring_factor * (10 * x) ** -power
                for x in accuracies
            }
            yield self._family("layered", expected, self._layer, 1.0)
            degrees = range(4, 8 if quick else 10)
            ring_factor = 0.3 + 0.07 * rings
            expected = {f"degree {k}": coarsest_unknowns * ring_factor * (k - 1) for k in degrees}
            yield self._family("degree", expected, self._raise_degree)
        if self.options.meshes:
            own_meshes = OwnMeshes(self.case, self.options)
            yield self._family(
                "file", dict.fromkeys(own_meshes.meshes, 2 * coarsest_unknowns), own_meshes.solve
            )

    @property
    def degree(self) -> int:
        """Degree of the displacement on triangles: that of the scene, or else the highest."""
        return triangle_degree(self.case.problem)

    @cached_property
    def _coarsest(self) -> MeshTri:
        """The coarsest mesh of uniform and adaptive triangles.

        Its outer boundary is refined once, because the error indicator does not include the
        difference between the nodal values there and the poles that they interpolate.
        """
        edges = self.case.problem.merged.ring_edges
        mesh = bisection.mesh(
            SizeField(
                tuple(edges.tolist()),
                COARSEST_SIZE,
                COARSEST_SIZE,
                0.0,
                WIDER_TRUNCATION,
                COARSEST_SIZE,
            )
        )
        return bisection.refined(mesh, mesh.f2t[0, mesh.boundaries["far"]], edges)

    @property
    def _coarsest_unknowns(self) -> float:
        """Approximate unknowns of the coarsest mesh: k^2 nodes with 2 each for two triangles."""
        return float(self._coarsest.nelements * self.degree**2)

    def _family(
        self,
        name: str,
        unknowns: dict[str, float],
        solve: Callable[[str], MeshSolution],
        extra_work: float = 0.0,
    ) -> Family:
        """Return a family of levels, without the levels that are expected to be too large.

        Parameters
        ----------
        name : name of the family
        unknowns : expected unknowns of each level, by its setting
        solve : function that solves the level of a setting
        extra_work : time for each unknown in addition to that of uniform triangles, relative to it
        """

        def solve_level(setting: str) -> Row:
            solution = solve(setting)
            self.levels.append(Level.of(self.case, name, setting, solution))
            row = self.case.row(solution)
            # the multipliers may be unstable only on meshes of the user
            return (
                {**row, "least eigenvalue": least_eigenvalue(solution)} if name == "file" else row
            )

        def work(setting: str) -> float:
            # measured on two cores: a constant time, and a time proportional to the unknowns
            rings = len(self.case.problem.merged.widths)
            reference = REFERENCE_SECONDS * rings if setting == FIRST_SETTING else 0.0
            return reference + 0.03 + 7e-6 * (1 + extra_work) * unknowns[setting]

        most_unknowns, least_levels = MOST_EXPECTED, LEAST_LEVELS
        if self.options.quick:
            most_unknowns, least_levels = MOST_EXPECTED_QUICK, LEAST_LEVELS_QUICK
        settings = [
            setting
            for number, (setting, count) in enumerate(unknowns.items())
            if number < least_levels or count <= most_unknowns
        ]
        return Family(name, dict.fromkeys(settings, np.nan), solve_level, work=work)

    def _halve(self, setting: str) -> MeshSolution:
        stages = Stages("uniform")
        with stages("meshing"):
            mesh = self._coarsest
            for _ in range(int(setting.split()[0])):
                all_elements = np.arange(mesh.nelements)
                mesh = bisection.refined(mesh, all_elements, self.case.problem.merged.ring_edges)
        return self.case.solve(self.case.half_space_on(mesh, self.degree, POLES_RTOL), stages)

    def _grade(self, setting: str) -> MeshSolution:
        return self._mesh_and_solve("graded", setting, {"mesher": "gmsh", "degree": self.degree})

    def _layer(self, setting: str) -> MeshSolution:
        return self._mesh_and_solve("layered", setting, LAYERED_SETTINGS)

    def _mesh_and_solve(self, name: str, setting: str, sizes: Mapping[str, object]) -> MeshSolution:
        """Solve on the mesh that ringwear makes for the `rtol` in the setting."""
        stages, problem = Stages(name), self._with_rtol(float(setting.split()[1]), sizes)
        with stages("meshing"):
            chosen_mesh = half_space_mesh(problem)
        return self.case.solve(half_space_on(problem, chosen_mesh), stages)

    def _raise_degree(self, setting: str) -> MeshSolution:
        stages, problem = Stages("degree"), self._with_rtol(DEGREE_MESH_RTOL, LAYERED_SETTINGS)
        with stages("meshing"):
            mesh = half_space_mesh(problem).mesh
        degree = int(setting.split()[1])
        return self.case.solve(self.case.half_space_on(mesh, degree, DEGREE_MESH_RTOL), stages)

    def _with_rtol(self, rtol: float, sizes: Mapping[str, object]) -> Problem:
        return replace(self.case.problem, rtol=rtol, fem=FemAccuracy.model_validate(sizes))


@dataclass(eq=False)
class AdaptiveTriangles:
    """Triangles that are refined where the error indicator is greatest.

    Each level refines the mesh of the previous level. The seconds of a level include those of all
    previous levels.

    Parameters
    ----------
    case : case that is solved
    mesh : mesh of the next level
    degree : polynomial degree of the displacement
    """

    case: Case
    mesh: MeshTri
    degree: int
    _stages: Stages = field(default_factory=lambda: Stages("adaptive"))

    def solve_next(self, _: str) -> MeshSolution:
        """Solve the next level, compute its error indicators, and refine its mesh for later levels.

        Triangles are marked by the greatest of their indicators over all states, each relative to
        the energy of its state. The flat start alone would never refine ring edges.
        """
        half_space = self.case.half_space_on(self.mesh, self.degree, POLES_RTOL)
        solution = self.case.solve_and_estimate(half_space, self._stages)
        solution = replace(solution, seconds=dict(self._stages.seconds))
        with self._stages("meshing"):
            assert solution.greatest_indicators is not None
            marked = fewest_with_share(solution.greatest_indicators, MARKED_SHARE)
            edges = self.case.problem.merged.ring_edges
            self.mesh = bisection.refined(self.mesh, marked, edges)
        return solution
