"""Read meshes of the user for a study: mesh files, or meshes of scikit-fem."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from skfem import Mesh

from ...meshes import files
from ...meshes.half_space import as_half_space
from ..crosscheck import Problem


def own_mesh(problem: Problem, source: str | Path | Mesh) -> Mesh:
    """Return a mesh of the user, in punch radii, with its boundaries named.

    A file is in the units of the scene, a mesh of scikit-fem in punch radii.

    Raises
    ------
    MeshError
        if a ring edge is not a vertex of the mesh, or if it is not a mesh of a half-space
    """
    if isinstance(source, Mesh):
        return as_half_space(source, problem.merged.ring_edges)
    return files.read(source, problem.merged.ring_edges, problem.units.length)


def named_meshes(sources: Sequence[str | Path | Mesh]) -> dict[str, str | Path | Mesh]:
    """Return meshes by the names of their files, or as `mesh 1`, `mesh 2`, ... if not from files.

    If several files have the same name, the key is the path, followed by the number in parentheses.
    """
    names = [
        f"mesh {number}" if isinstance(mesh, Mesh) else Path(mesh).name
        for number, mesh in enumerate(sources, 1)
    ]
    count = Counter(names)
    unique_names = [
        name if count[name] == 1 else f"{mesh} ({number})"
        for number, (name, mesh) in enumerate(zip(names, sources, strict=True), 1)
    ]
    return dict(zip(unique_names, sources, strict=True))
