"""Meshes of the user's own: read, solved on, and told where to refine them."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from skfem import Mesh, MeshQuad, MeshTri

from ...mdr import energy
from ...meshes.errors import MeshError, SceneError
from ...meshes.half_space import contact_radii
from ..crosscheck.operators import MOST_PRESSURES, least_ratio_of_energies
from ..progress import Stages
from ..sizes.defaults import triangle_degree
from ..study.options import Options
from ..study.own_mesh import named_meshes, own_mesh
from .case import TIMES, Case, Level, Solved

DEGREES = {"triangles": range(2, 5), "quadrilaterals": range(2, 17)}
"""Degrees of the displacement for which there are stable multipliers."""
DEGREE_ON_QUADRILATERALS = 6
"""Degree on a user's quadrilaterals, if neither the study nor the scene has one."""


@dataclass(frozen=True, eq=False)
class OwnMeshes:
    """The meshes of the user, on a case.

    Parameters
    ----------
    case : what is solved
    options : with the meshes, and the degree if it is given
    """

    case: Case
    options: Options

    @cached_property
    def meshes(self) -> dict[str, str | Path | Mesh]:
        """What the user gave, by what it is called."""
        return named_meshes(self.options.meshes)

    def refuse(self) -> None:
        """Raise if a mesh is not one of a half-space, or if the degree does not go with it.

        Raises
        ------
        SceneError
            which names the mesh and what is wrong
        """
        for name, given in self.meshes.items():
            try:
                mesh = own_mesh(self.case.problem, given)
            except MeshError as error:
                where = f"{name}: " if isinstance(given, Mesh) else ""
                raise SceneError(f"--mesh {where}{error}") from error
            kind = "quadrilaterals" if isinstance(mesh, MeshQuad) else "triangles"
            if self._degree_on(mesh) not in DEGREES[kind]:
                raise SceneError(
                    f"--degree {self._degree_on(mesh)}: does not go with {name}, which has {kind}: "
                    f"give {DEGREES[kind][0]} to {DEGREES[kind][-1]}"
                )

    def solve(self, name: str) -> Solved:
        """Solve on a mesh; on triangles, errors are estimated, too."""
        stages = Stages("file")
        with stages("meshing"):
            mesh = own_mesh(self.case.problem, self.meshes[name])
        half_space = self.case.half_space_on(mesh, self._degree_on(mesh), self.case.problem.rtol)
        if isinstance(mesh, MeshTri):
            return self.case.solve_and_estimate(half_space, stages)
        return self.case.solve(half_space, stages)

    def _degree_on(self, mesh: Mesh) -> int:
        """Return the degree asked for, or that of the scene, or the default of the elements."""
        problem = self.case.problem
        if self.options.degree is not None:
            return self.options.degree
        if isinstance(mesh, MeshQuad):
            return problem.fem.degree or DEGREE_ON_QUADRILATERALS
        return triangle_degree(problem)


def least_eigenvalue(solved: Solved) -> float:
    """Return the least ratio of the energies of a pressure by finite elements and by MDR.

    It is the square of the inf-sup constant of the multipliers; near 0 some pressures are not seen
    by the displacement. It is NaN if there are more than `MOST_PRESSURES`.
    """
    if solved.compliance.space.size > MOST_PRESSURES:
        return np.nan
    exact = energy.compliance(solved.compliance.space)
    return least_ratio_of_energies(solved.compliance.factor, exact.factor)


class WorstPlace(NamedTuple):
    """Where on the contact the pressure of a mesh errs most.

    Parameters
    ----------
    time : at which it errs most
    edge : ring edge next to which that is, or the rim, in punch radii
    share : of the squared error at that time, nearer to this edge than to any other
    facet : ends of the facet there that has the greatest part of it
    share_of_facet : that part
    """

    time: float
    edge: float
    share: float
    facet: tuple[float, float]
    share_of_facet: float


def worst_place(case: Case, level: Level) -> WorstPlace:
    """Return where the pressure errs most on a mesh, by its error in the norm of the pressure."""
    face = case.watched.face
    squares = face.weights * level.pressure_errors**2
    worst = int(squares.sum(axis=1).argmax())
    shares = squares[worst] / squares[worst].sum()
    edges = case.problem.merged.ring_edges[1:]
    nearest = np.abs(face.radii[:, None] - edges).argmin(axis=1)
    of_edges = np.bincount(nearest, shares, len(edges))
    edge = int(of_edges.argmax())
    ends = contact_radii(level.mesh)
    facets = np.clip(np.searchsorted(ends, face.radii, side="right") - 1, 0, len(ends) - 2)
    of_facets = np.bincount(facets, np.where(nearest == edge, shares, 0.0), len(ends) - 1)
    facet = int(of_facets.argmax())
    return WorstPlace(
        float(TIMES[1:][worst]),
        float(edges[edge]),
        float(of_edges[edge]),
        (float(ends[facet]), float(ends[facet + 1])),
        float(of_facets[facet]),
    )
