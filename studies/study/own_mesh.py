"""A mesh of the user's own, as studies take it: a file, or a mesh of scikit-fem."""

from pathlib import Path

from skfem import Mesh

from ...meshes import files
from ...meshes.half_space import as_half_space
from ..problem.problem import Problem


def own_mesh(problem: Problem, given: str | Path | Mesh) -> Mesh:
    """Return the user's mesh, read from a file if it is one.

    Files are in the units of the scene, meshes of scikit-fem in punch radii.

    Raises
    ------
    MeshError
        if a ring edge is not a vertex of it, or if it is no mesh of a half-space
    """
    if isinstance(given, Mesh):
        return as_half_space(given, problem.merged.ring_edges)
    return files.read(given, problem.merged.ring_edges, problem.units.length)
