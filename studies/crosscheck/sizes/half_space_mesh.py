"""The mesh of the finite-element half-space of a problem, by the mesher of the scene."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ....meshes.errors import MeshError, SceneError
from ..problem.problem import Problem
from ..problem.sections import LAYERED
from . import defaults
from .layers import why_layers_are_not_meshed
from .low_degrees import LOW_DEGREE_HALVINGS, low_degree_quad_sizes

if TYPE_CHECKING:
    from skfem import Mesh

    from ....meshes.sizes import SizeField


@dataclass(frozen=True, eq=False)
class ChosenMesh:
    """The mesh of a problem, and how to make a coarser one.

    Parameters
    ----------
    mesh : mesh of scikit-fem with named boundaries
    mesher : the mesher that made it
    coarser : () -> the mesh of the coarser solution for the error estimate: with a layer less, with
        larger triangles, halved once less, or the same mesh
    notes : texts for the user
    halved : whether the elements of the coarser mesh are twice as large everywhere
    same_elements : whether the coarser mesh is the same
    """

    mesh: Any
    mesher: str
    coarser: Callable[[], Any]
    notes: tuple[str, ...] = ()
    halved: bool = False
    same_elements: bool = False


def half_space_mesh(problem: Problem) -> ChosenMesh:
    """Return the mesh of a problem.

    It is made by the requested mesher, or by bisection if that fails; a note gives the reason.

    Raises
    ------
    SceneError
        if layers cannot be meshed as requested
    """
    if reason := why_layers_are_not_meshed(problem):
        raise SceneError(reason)
    try:
        return _mesh_with(problem, problem.fem.chosen_mesher)
    except MeshError as error:
        # bisection cannot mesh interfaces of layers
        if problem.fem.chosen_mesher == "bisection" or problem.ground.layered:
            raise
        note = f"meshed by bisection, in triangles of degree 4 at most: {error}"
    return replace(_mesh_with(problem, "bisection"), notes=(note,))


def _mesh_with(problem: Problem, mesher: str) -> ChosenMesh:
    from ....meshes.by_gmsh.quads import graded

    if problem.fem.degree and problem.fem.degree < (LAYERED if mesher == "quads" else 2):
        return _halved_mesh(problem, mesher)
    if mesher == "quads":
        layered = graded(problem.merged.ring_edges, **defaults.quad_sizes(problem))
        return ChosenMesh(layered.mesh, mesher, lambda: layered.coarser().mesh)
    field, triangulate = defaults.triangle_sizes(problem), _triangulation_function(mesher)
    triangles = triangulate(field)
    if problem.fem.given_by_user:
        return ChosenMesh(triangles, mesher, lambda: triangulate(field.coarser()))
    return ChosenMesh(triangles, mesher, lambda: triangles, same_elements=True)


def _triangulation_function(mesher: str) -> "Callable[[SizeField], Mesh]":
    from ....meshes import bisection
    from ....meshes.by_gmsh import triangles

    return triangles.mesh if mesher == "gmsh" else bisection.mesh


def _halved_mesh(problem: Problem, mesher: str) -> ChosenMesh:
    """Return a halved mesh for elements of a low degree; the coarser mesh is halved once less.

    These elements have no lower degree to compare with. Larger sizes at ring edges and rim alone
    would not show the error of the large elements, which have the largest error.
    """
    from ....meshes.by_gmsh.quads import graded
    from ....meshes.half_space import halved

    edges, count = problem.merged.ring_edges, LOW_DEGREE_HALVINGS
    if mesher == "quads":
        base = graded(edges, **low_degree_quad_sizes(problem)).mesh
    else:
        base = _triangulation_function(mesher)(defaults.triangle_sizes(problem))
    return ChosenMesh(
        halved(base, edges, count),
        mesher,
        lambda: halved(base, edges, count - 1),
        halved=True,
    )
