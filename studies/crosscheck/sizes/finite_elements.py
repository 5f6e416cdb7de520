"""Mesh, degree and far field of the finite elements under a flat punch, chosen once for a run.

Three kinds of elements have a mesh, and a coarser one for the error estimate: quadrilaterals in
geometric layers (`meshes.by_gmsh.quads.GradedQuads`), triangles, and elements that are halved
because their degree is low.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ....meshes.errors import MeshError, SceneError
from ....meshes.radial import Array
from ....meshes.sizes import SizeField
from ..problem.problem import Problem
from ..problem.sections import LAYERED
from . import quads, triangles
from .layers import why_layers_are_not_meshed

if TYPE_CHECKING:
    from ....meshes.by_gmsh.quads import GradedQuads

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
class Triangles:
    """Triangles by a mesher.

    Parameters
    ----------
    field : their sizes
    triangulate : the mesher
    """

    field: SizeField
    triangulate: Callable[[SizeField], Any]

    @cached_property
    def mesh(self) -> Any:
        """The mesh."""
        return self.triangulate(self.field)

    def coarser(self) -> "Triangles":
        """Return larger triangles."""
        return replace(self, field=self.field.coarser())


@dataclass(frozen=True, eq=False)
class Halved:
    """Elements that are halved, because their degree is low.

    These have no lower degree to compare with, and larger sizes at ring edges and rim alone would
    not show the error of the large elements, which have the largest error.

    Parameters
    ----------
    base : the mesh to halve
    ring_edges : (N+1,) ring edges
    count : how often every element is halved
    """

    base: Any
    ring_edges: Array
    count: int

    @cached_property
    def mesh(self) -> Any:
        """The mesh."""
        from ....meshes.half_space import halved

        return halved(self.base, self.ring_edges, self.count)

    def coarser(self) -> "Halved":
        """Return elements that are halved once less."""
        return replace(self, count=self.count - 1)


@dataclass(frozen=True, eq=False)
class FemSizes:
    """Elements and degree of the half-space under a flat punch.

    Parameters
    ----------
    mesher : the mesher that made the elements: quads, gmsh or bisection
    elements : the elements
    degree : degree of the displacement
    notes : texts for the user
    same_elements : whether the coarser solution has the same elements, of a lower degree: triangles
        whose sizes and degree are the defaults, because larger ones would miss modes of thin
        layers, and the difference would often be 100 times the error
    """

    mesher: str
    elements: "GradedQuads | Triangles | Halved"
    degree: int
    notes: tuple[str, ...] = ()
    same_elements: bool = False

    @property
    def mesh(self) -> Any:
        """The mesh."""
        return self.elements.mesh

    @property
    def halved(self) -> bool:
        """Whether the elements are halved, so that those of the coarser mesh are twice as large."""
        return isinstance(self.elements, Halved)

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
        if self.halved:
            return replace(self, elements=self.elements.coarser())
        if self.degree <= 2:
            return replace(self, degree=3)
        elements = self.elements if self.same_elements else self.elements.coarser()
        return replace(self, degree=self.degree - 1, elements=elements)


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
        sizes = _sizes_by(problem, mesher)
        sizes.mesh  # noqa: B018 (a cached property, so that a mesher that fails does so here)
    except MeshError as error:
        # bisection cannot mesh interfaces of layers
        if mesher == "bisection" or problem.ground.layered:
            raise
        note = f"meshed by bisection, in triangles of degree 4 at most: {error}"
        return replace(_sizes_by(problem, "bisection"), notes=(note,))
    return sizes


def _sizes_by(problem: Problem, mesher: str) -> FemSizes:
    """Return the sizes of elements by a mesher."""
    layered = mesher == "quads"
    degree = quads.quad_degree(problem) if layered else triangles.triangle_degree(problem)
    low = bool(problem.fem.degree and problem.fem.degree < (LAYERED if layered else 2))
    if layered and not low:
        return FemSizes(mesher, quads.layered_quads(problem), degree)
    if layered:
        elements: GradedQuads | Triangles = quads.quads_to_halve(problem, HALVINGS)
    else:
        elements = Triangles(triangles.triangle_sizes(problem), _triangulation(mesher))
    if low:
        halved = Halved(elements.mesh, problem.merged.ring_edges, HALVINGS)
        return FemSizes(mesher, halved, degree)
    return FemSizes(mesher, elements, degree, same_elements=not problem.fem.given_by_user)


def _triangulation(mesher: str) -> Callable[[SizeField], Any]:
    from ....meshes import bisection
    from ....meshes.by_gmsh import triangles as by_gmsh

    return by_gmsh.mesh if mesher == "gmsh" else bisection.mesh


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
