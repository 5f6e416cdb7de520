"""Meshes of the user's own, as studies take them: files, or meshes of scikit-fem."""

from collections import Counter
from collections.abc import Sequence
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


def named_meshes(given: Sequence[str | Path | Mesh]) -> dict[str, str | Path | Mesh]:
    """Return meshes by the names of their files, or by their numbers, which start at 1.

    Files of one name in several folders have their paths, and their number behind these.
    """
    names = [
        f"mesh {number}" if isinstance(mesh, Mesh) else Path(mesh).name
        for number, mesh in enumerate(given, 1)
    ]
    count = Counter(names)
    unique = [
        name if count[name] == 1 else f"{mesh} ({number})"
        for number, (name, mesh) in enumerate(zip(names, given, strict=True), 1)
    ]
    return dict(zip(unique, given, strict=True))
