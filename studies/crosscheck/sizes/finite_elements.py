"""Mesh, degree and far field of the finite elements under a flat punch, chosen once for a run.

Three kinds of elements have a mesh, and a coarser one for the error estimate: quadrilaterals in
geometric layers (`meshes.by_gmsh.quads.GradedQuads`), triangles, and elements that are halved
because their degree is low.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from ....meshes.errors import MeshError, SceneError
from ..problem.problem import Problem
from ..problem.sections import LAYERED
from . import quads, triangles
from .layers import why_layers_are_not_meshed

# Upper limit of the share of the energy that the truncation may lose (physics/test_size_rules.py,
# `ringwear study truncation`).
MAX_TRUNCATION_LOSS = 1e-9
# That share is also smaller than rtol by this factor.
TRUNCATION_MARGIN = 10
# How often elements of a low degree are halved; in the coarser mesh for the error estimate, once
# less. If errors fall at least in proportion to the size, they are at most the difference of the
# two solutions (physics/test_low_degrees.py).
HALVINGS = 2


@dataclass(frozen=True, eq=False)
class FemSizes:
    """Elements and degree of the half-space under a flat punch.

    Parameters
    ----------
    mesher : the mesher that made the elements: quads, gmsh or bisection
    mesh : the mesh
    coarser_mesh : makes the mesh of the coarser solution that is compared with this one
    degree : degree of the displacement
    notes : texts for the user
    halved : whether the elements are halved, because their degree is low. They have no lower degree
        to compare with, and larger sizes at ring edges and rim alone would not show the error of
        the large elements, which have the largest error; those of the coarser mesh are twice as
        large
    same_elements : whether the coarser solution has the same elements, of a lower degree: triangles
        whose sizes and degree are the defaults, because larger ones would miss modes of thin
        layers, and the difference would often be 100 times the error
    """

    mesher: str
    mesh: Any
    coarser_mesh: Callable[[], Any]
    degree: int
    notes: tuple[str, ...] = ()
    halved: bool = False
    same_elements: bool = False

    @property
    def error_factor(self) -> str:
        """Name of the factor on the difference to the coarser solution."""
        if self.halved:
            return "flat punch on halved elements"
        if self.mesher == "quads":
            return "flat punch"
        return "flat punch on triangles" if self.same_elements else "flat punch on larger triangles"

    def coarser(self) -> "FemSizes":
        """Return the sizes of the solution that is compared with this one to estimate its error.

        The degree is lower by one, and quadrilaterals have a layer less. Triangles that the scene
        sets may be too large themselves, and are compared with still larger ones. Degree 2 is
        compared with a better solution instead, of degree 3 on the same mesh: no multipliers are
        stable on degree 1, and larger triangles of degree 2 may miss the same relaxation modes.
        """
        if self.degree <= 2 and not self.halved:
            return replace(self, degree=3)
        mesh = self.mesh if self.same_elements else self.coarser_mesh()
        return replace(self, mesh=mesh, degree=self.degree - (not self.halved))


def fem_sizes(problem: Problem) -> FemSizes:
    """Return the elements and the degree that the tolerance of a problem requires.

    They are made by the requested mesher, or by bisection if that fails; a note gives the reason.

    Raises
    ------
    SceneError
        if layers cannot be meshed as requested
    """
    if reason := why_layers_are_not_meshed(problem):
        raise SceneError(reason)
    mesher = problem.fem.chosen_mesher
    try:
        return _sizes_by(problem, mesher)
    except MeshError as error:
        # bisection cannot mesh interfaces of layers
        if mesher == "bisection" or problem.ground.layered:
            raise
        note = f"meshed by bisection, in triangles of degree 4 at most: {error}"
        return replace(_sizes_by(problem, "bisection"), notes=(note,))


def _sizes_by(problem: Problem, mesher: str) -> FemSizes:
    """Return the sizes of elements by a mesher."""
    from ....meshes import bisection
    from ....meshes.by_gmsh import triangles as by_gmsh
    from ....meshes.half_space import halved

    scene_degree, by_default = problem.fem.degree, not problem.fem.given_by_user
    if mesher == "quads":
        degree, low = quads.quad_degree(problem), bool(scene_degree and scene_degree < LAYERED)
        elements = quads.quads_to_halve(problem, HALVINGS) if low else quads.layered_quads(problem)
        sizes = FemSizes(mesher, elements.mesh, lambda: elements.coarser().mesh, degree)
    else:
        degree, low = triangles.triangle_degree(problem), scene_degree == 1
        field, mesh_of = triangles.triangle_sizes(problem), bisection.mesh
        if mesher == "gmsh":
            mesh_of = by_gmsh.mesh
        sizes = FemSizes(
            mesher,
            mesh_of(field),
            lambda: mesh_of(field.coarser()),
            degree,
            same_elements=by_default,
        )
    if not low:
        return sizes
    mesh, edges = sizes.mesh, problem.merged.ring_edges
    return FemSizes(
        mesher,
        halved(mesh, edges, HALVINGS),
        lambda: halved(mesh, edges, HALVINGS - 1),
        degree,
        halved=True,
    )


def pole_orders(problem: Problem, truncation: float) -> tuple[int, ...]:
    """Return the orders of the far-field poles that are tied to the outer boundary.

    Notes
    -----
    The number of poles is that of the scene, or else the smallest with which the truncation loses
    at most the share ``min(MAX_TRUNCATION_LOSS, rtol / TRUNCATION_MARGIN)`` of the energy
    (`fem.far_field.enough_poles`). Shown by
    unit/studies/study/test_ways.py::test_truncation_by_every_far_field.
    """
    from ....fem.far_field import enough_poles

    if problem.fem.poles:
        return tuple(range(0, 2 * problem.fem.poles, 2))
    return enough_poles(truncation, min(MAX_TRUNCATION_LOSS, problem.rtol / TRUNCATION_MARGIN))


def coarser_pole_orders(orders: tuple[int, ...]) -> tuple[int, ...]:
    """Return the orders of the poles of the coarser solution used for the error estimate.

    It has one pole less. But one pole is compared with two, because without any the boundary would
    be clamped: its error is 1.1 a/R, far greater than the (a/R)^5 of one pole.
    """
    return orders[:-1] if len(orders) > 1 else (0, 2)
