"""Read meshes of the user, solve on them, and find where their pressure error is greatest."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from skfem import Mesh, MeshQuad, MeshTri

from ...meshes.half_space import contact_radii
from ..crosscheck import MeshError, SceneError, Stages, energy
from ..crosscheck.sizes.defaults import triangle_degree
from ..crosscheck.verdict.operators import MOST_PRESSURES, least_ratio_of_energies
from ..study.options import Options
from ..study.own_mesh import named_meshes, own_mesh
from .case import TIMES, Case, Level, MeshSolution

DEGREES = {"triangles": range(2, 5), "quadrilaterals": range(2, 17)}
"""Degrees of the displacement for which stable multipliers exist, by kind of elements."""
DEGREE_ON_QUADRILATERALS = 6
"""Degree on quadrilaterals of the user, if neither the option nor the scene specifies it."""


@dataclass(frozen=True, eq=False)
class OwnMeshes:
    """The meshes of the user for a case.

    Parameters
    ----------
    case : case that is solved
    options : options of the study, with the meshes and the degree
    """

    case: Case
    options: Options

    @cached_property
    def meshes(self) -> dict[str, str | Path | Mesh]:
        """Mesh files and meshes of the user, by their names."""
        return named_meshes(self.options.meshes)

    def refuse(self) -> None:
        """Raise an error if a mesh does not fit the half-space, or if the degree does not fit it.

        Raises
        ------
        SceneError
            its message names the mesh and the fault
        """
        for name, source in self.meshes.items():
            try:
                mesh = own_mesh(self.case.problem, source)
            except MeshError as error:
                where = f"{name}: " if isinstance(source, Mesh) else ""
                raise SceneError(f"--mesh {where}{error}") from error
            kind = "quadrilaterals" if isinstance(mesh, MeshQuad) else "triangles"
            if self._degree_on(mesh) not in DEGREES[kind]:
                raise SceneError(
                    f"--degree {self._degree_on(mesh)}: does not fit {name}, which has {kind}: "
                    f"give {DEGREES[kind][0]} to {DEGREES[kind][-1]}"
                )

    def solve(self, name: str) -> MeshSolution:
        """Solve on a mesh; on triangles, also compute the error indicator."""
        stages = Stages("file")
        with stages("meshing"):
            mesh = own_mesh(self.case.problem, self.meshes[name])
        half_space = self.case.half_space_on(mesh, self._degree_on(mesh), self.case.problem.rtol)
        if isinstance(mesh, MeshTri):
            return self.case.solve_and_estimate(half_space, stages)
        return self.case.solve(half_space, stages)

    def _degree_on(self, mesh: Mesh) -> int:
        """Return the degree of the options, or else that of the scene, or else the default."""
        problem = self.case.problem
        if self.options.degree is not None:
            return self.options.degree
        if isinstance(mesh, MeshQuad):
            return problem.fem.degree or DEGREE_ON_QUADRILATERALS
        return triangle_degree(problem)


def least_eigenvalue(solution: MeshSolution) -> float:
    """Return the least ratio of the finite-element energy and the MDR energy of a pressure.

    It is the square of the inf-sup constant of the multipliers. If it is near 0, some pressures
    have almost no effect on the displacement. It is NaN if there are more than `MOST_PRESSURES`
    pressures.
    """
    if solution.compliance.space.size > MOST_PRESSURES:
        return np.nan
    exact = energy.compliance(solution.compliance.space)
    return least_ratio_of_energies(solution.compliance.factor, exact.factor)


class WorstPlace(NamedTuple):
    """Place on the contact with the greatest error of the pressure.

    Parameters
    ----------
    time : time at which the error is greatest, in ``a / (E* k_max v0)``
    edge : ring edge, or rim, with the greatest error near it, in punch radii
    share : fraction of the squared error at that time that is nearer to this edge than to any other
    facet : ends of the facet with the greatest part of that error, in punch radii
    share_of_facet : fraction of the squared error at that time on this facet and nearest to this
        edge
    """

    time: float
    edge: float
    share: float
    facet: tuple[float, float]
    share_of_facet: float


def worst_place(case: Case, level: Level) -> WorstPlace:
    """Return the place of a mesh at which the squared error of the pressure is greatest."""
    face = case.compared_problem.face
    squares = face.weights * level.pressure_errors**2
    worst_time = int(squares.sum(axis=1).argmax())
    shares = squares[worst_time] / squares[worst_time].sum()
    edges = case.problem.merged.from_axis[1:]
    nearest = np.abs(face.radii[:, None] - edges).argmin(axis=1)
    edge_shares = np.bincount(nearest, shares, len(edges))
    edge = int(edge_shares.argmax())
    facet_ends = contact_radii(level.mesh)
    facets = np.clip(
        np.searchsorted(facet_ends, face.radii, side="right") - 1, 0, len(facet_ends) - 2
    )
    facet_shares = np.bincount(facets, np.where(nearest == edge, shares, 0.0), len(facet_ends) - 1)
    facet = int(facet_shares.argmax())
    return WorstPlace(
        float(TIMES[1:][worst_time]),
        float(edges[edge]),
        float(edge_shares[edge]),
        (float(facet_ends[facet]), float(facet_ends[facet + 1])),
        float(facet_shares[facet]),
    )
