"""The ways to refine a mesh, each a family of levels from coarse to fine.

`uniform` divides every triangle into four. `graded` sizes triangles before anything is solved, by
what is known of the singularities. `adaptive` solves, estimates, marks and refines. `layered` is
the default of ringwear, quadrilaterals in layers round the ring edges, whose sizes and degrees
follow from the accuracy. `degree` raises the degree on one such mesh. `file` has the meshes of the
user.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from skfem import MeshTri

from ...fem.error_indicator import fewest_with_share
from ...meshes import bisection
from ...meshes.by_gmsh.session import unavailable
from ...meshes.sizes import SizeField
from ..methods.fem import half_space_on
from ..methods.fem_meshes import half_space_mesh
from ..problem.problem import Problem
from ..problem.sections import FemAccuracy
from ..progress import Stages
from ..sizes.defaults import WIDER_TRUNCATION, triangle_degree
from ..study.levels import Family
from ..study.options import Options
from ..tables import Row
from .case import NEGLIGIBLE, Case, Level, Solved
from .own_meshes import OwnMeshes, least_eigenvalue

COARSEST = 1.2
"""Size of the first triangles, in a; they are smaller only where a ring edge has to be a vertex."""
MARKED = 0.5
"""Share of the squared indicators that the marked triangles have (Dörfler)."""
GROWTH, GROWTH_OF_ONE_RING, GROWTH_NEAR_INCOMPRESSIBILITY = 1.16, 1.12, 1.22
"""Factor by which the unknowns grow from one adaptive level to the next, measured."""
MOST_UNKNOWNS = 60_000
"""Unknowns that the adaptive levels go up to."""
MOST_UNKNOWNS_QUICK = 30_000
"""Unknowns that those of the quick study go up to, a little beyond a pressure within 1e-3."""
MOST_UNKNOWNS_OF_ONE_RING_QUICK = 15_000
"""The same of one ring, where that pressure takes less."""
MANY_RINGS, GROWTH_OF_MANY_RINGS = 8, 1.2
"""Rings beyond which the unknowns of adaptive levels grow faster, and by which factor."""
MOST_EXPECTED, MOST_EXPECTED_QUICK = 250_000, 55_000
"""Unknowns beyond which levels are left out, as with many rings."""
LEAST_LEVELS, LEAST_LEVELS_QUICK = 2, 1
"""Levels of each way that are solved all the same."""
ACCURACIES = tuple(10.0 ** (-half / 2) for half in range(2, 13))
"""Accuracies that graded and layered meshes are made for."""
ACCURACIES_QUICK = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
LAYERS = {"mesher": "quads"}
"""Settings of the default mesh."""
FIRST = "0 halvings"
"""The setting of the first level of all, which waits for the truth of its case."""
SECONDS_OF_TRUTH = 0.17
"""Seconds that the truth takes for each ring, measured with five rings."""
ACCURACY_OF_LAYERS = 1e-7
"""Accuracy that the mesh is made for on which the degree is raised."""


@dataclass(frozen=True, eq=False)
class Ways:
    """The ways to refine a mesh of a case.

    Parameters
    ----------
    case : what is solved
    options : of the study
    levels : to which each level that is solved is added
    """

    case: Case
    options: Options
    levels: list[Level]

    def families(self) -> Iterator[Family]:
        """Yield each way, and last the user's meshes."""
        quick, start = self.options.quick, self._unknowns_at_first
        halvings = range(3 if quick else 4)
        yield self._family(
            "uniform", {f"{n} halvings": start * 4.0**n for n in halvings}, self._halve
        )
        rings, most = len(self.case.problem.merged.widths), MOST_UNKNOWNS
        if quick:
            most = MOST_UNKNOWNS_QUICK if rings > 1 else MOST_UNKNOWNS_OF_ONE_RING_QUICK
        growth = GROWTH if rings > 1 else GROWTH_OF_ONE_RING
        if rings > MANY_RINGS:
            growth = GROWTH_OF_MANY_RINGS
        if self.case.problem.poisson_ratio > 0.49:
            growth = GROWTH_NEAR_INCOMPRESSIBILITY
        count = max(3, int(np.ceil(np.log(most / start) / np.log(growth))) + 1)
        adaptive = AdaptiveTriangles(self.case, self._coarsest, self.degree)
        expected = {f"level {n}": start * growth**n for n in range(count)}
        yield self._family("adaptive", expected, adaptive.solve_next, 0.8)
        accuracies = ACCURACIES_QUICK if quick else ACCURACIES
        # unknowns as measured with 1 to 32 rings
        of_rings = 0.95 + 0.025 * rings
        expected = {f"rtol {x:.0e}": start * of_rings * (10 * x) ** -0.2 for x in accuracies}
        yield self._family("graded", expected, self._grade)
        if not unavailable():  # layers are made by gmsh
            of_rings, power = 4 + rings / 8, 0.04 + 0.0037 * rings
            expected = {f"rtol {x:.0e}": start * of_rings * (10 * x) ** -power for x in accuracies}
            yield self._family("layered", expected, self._layer, 1.0)
            degrees = range(4, 8 if quick else 10)
            of_rings = 0.3 + 0.07 * rings
            expected = {f"degree {k}": start * of_rings * (k - 1) for k in degrees}
            yield self._family("degree", expected, self._raise_degree)
        if self.options.meshes:
            own = OwnMeshes(self.case, self.options)
            yield self._family("file", dict.fromkeys(own.meshes, 2 * start), own.solve)

    @property
    def degree(self) -> int:
        """Degree of the displacement on triangles, as the scene has it, or the highest."""
        return triangle_degree(self.case.problem)

    @cached_property
    def _coarsest(self) -> MeshTri:
        """The mesh that all levels of uniform and adaptive triangles begin with.

        Its outer boundary is refined once: the indicator does not see by how much nodal values
        there differ from the poles that they stand for.
        """
        edges = self.case.problem.merged.ring_edges
        mesh = bisection.mesh(
            SizeField(tuple(edges.tolist()), COARSEST, COARSEST, 0.0, WIDER_TRUNCATION, COARSEST)
        )
        return bisection.refined(mesh, mesh.f2t[0, mesh.boundaries["far"]], edges)

    @property
    def _unknowns_at_first(self) -> float:
        """About the unknowns of the coarsest mesh: k^2 nodes for two triangles."""
        return float(self._coarsest.nelements * self.degree**2)

    def _family(
        self,
        name: str,
        unknowns: dict[str, float],
        solve: Callable[[str], Solved],
        more: float = 0.0,
    ) -> Family:
        """Return a family of levels with about so many unknowns each, those that are most_unknowns.

        `more` is what their time exceeds that of uniform triangles by, as a part of it.
        """

        def solve_level(setting: str) -> Row:
            solved = solve(setting)
            self.levels.append(Level.of(self.case, name, setting, solved))
            row = self.case.row(solved)
            # of the user's meshes nobody knows yet whether their multipliers are stable
            return {**row, "least eigenvalue": least_eigenvalue(solved)} if name == "file" else row

        def work(setting: str) -> float:
            # measured on two cores: what all levels take, and what grows with the unknowns
            rings = len(self.case.problem.merged.widths)
            truth = SECONDS_OF_TRUTH * rings if setting == FIRST else 0.0
            return truth + 0.03 + 7e-6 * (1 + more) * unknowns[setting]

        most_unknowns, least = MOST_EXPECTED, LEAST_LEVELS
        if self.options.quick:
            most_unknowns, least = MOST_EXPECTED_QUICK, LEAST_LEVELS_QUICK
        settings = [
            setting
            for number, (setting, count) in enumerate(unknowns.items())
            if number < least or count <= most_unknowns
        ]
        return Family(name, dict.fromkeys(settings, np.nan), solve_level, work=work)

    def _halve(self, setting: str) -> Solved:
        stages = Stages("uniform")
        with stages("meshing"):
            mesh = self._coarsest
            for _ in range(int(setting.split()[0])):
                every = np.arange(mesh.nelements)
                mesh = bisection.refined(mesh, every, self.case.problem.merged.ring_edges)
        return self.case.solve(self.case.half_space_on(mesh, self.degree, NEGLIGIBLE), stages)

    def _grade(self, setting: str) -> Solved:
        return self._mesh_and_solve("graded", setting, {"mesher": "gmsh", "degree": self.degree})

    def _layer(self, setting: str) -> Solved:
        return self._mesh_and_solve("layered", setting, LAYERS)

    def _mesh_and_solve(self, name: str, setting: str, sizes: Mapping[str, object]) -> Solved:
        """Solve on the mesh that ringwear makes for an accuracy."""
        stages, problem = Stages(name), self._for_accuracy(float(setting.split()[1]), sizes)
        with stages("meshing"):
            chosen = half_space_mesh(problem)
        return self.case.solve(half_space_on(problem, chosen), stages)

    def _raise_degree(self, setting: str) -> Solved:
        stages, problem = Stages("degree"), self._for_accuracy(ACCURACY_OF_LAYERS, LAYERS)
        with stages("meshing"):
            mesh = half_space_mesh(problem).mesh
        degree = int(setting.split()[1])
        return self.case.solve(self.case.half_space_on(mesh, degree, ACCURACY_OF_LAYERS), stages)

    def _for_accuracy(self, rtol: float, sizes: Mapping[str, object]) -> Problem:
        return replace(self.case.problem, rtol=rtol, fem=FemAccuracy.model_validate(sizes))


@dataclass(eq=False)
class AdaptiveTriangles:
    """Triangles that are refined where the error indicator is greatest.

    Each level refines the mesh of the one before, and its seconds are those of all levels so far.

    Parameters
    ----------
    case : what is solved
    mesh : of the next level
    degree : of the displacement
    """

    case: Case
    mesh: MeshTri
    degree: int
    _stages: Stages = field(default_factory=lambda: Stages("adaptive"))

    def solve_next(self, _: str) -> Solved:
        """Solve the next level, estimate its errors, and refine its mesh for the level after it.

        An element counts by the greatest of its indicators over all states, each over the energy of
        its state. By the flat start alone, ring edges would never be refined.
        """
        half_space = self.case.half_space_on(self.mesh, self.degree, NEGLIGIBLE)
        solved = self.case.solve_and_estimate(half_space, self._stages)
        solved = replace(solved, seconds=dict(self._stages.seconds))
        with self._stages("meshing"):
            assert solved.greatest_indicators is not None
            marked = fewest_with_share(solved.greatest_indicators, MARKED)
            edges = self.case.problem.merged.ring_edges
            self.mesh = bisection.refined(self.mesh, marked, edges)
        return solved
