"""The finite-element half-space at a wanted accuracy, on the mesh that is asked for or that suits
it best.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

from ...fem.condensation import solver
from ...meshes.errors import MeshError
from ...meshes.gmsh_session import unavailable
from ...meshes.sizes import NARROWEST
from ..problem import defaults
from ..problem.problem import Problem
from ..progress import Stages
from . import fem_counts
from .base import Cost
from .by_compliance import ComplianceMethod, Discretised, marches_contact
from .estimate import SAFETY, SAFETY_OF_TRIANGLES
from .unilateral import costs

if TYPE_CHECKING:
    from ...fem.half_space import HalfSpace
    from ...meshes.compliance import Compliance
    from ...meshes.quads import GradedQuads
    from .unilateral.solution import UnilateralMethod


@dataclass(frozen=True, eq=False)
class Meshed:
    """The mesh of a problem.

    Parameters
    ----------
    mesh : of scikit-fem, its boundaries named
    mesher : what made it
    graded : how its quadrilaterals were made, if it has any
    notes : what the user should know
    """

    mesh: Any
    mesher: str
    graded: "GradedQuads | None" = None
    notes: tuple[str, ...] = ()


MESHERS = ("quads", "gmsh", "bisection")


def usable_here(problem: Problem) -> tuple[Problem, tuple[str, ...]]:
    """The problem with the mesher that a run will use, and a note if that is not the one asked for.

    Whether gmsh loads is known only by loading it, which takes little of a plan's time. It may
    still fail on a mesh: that is known only when it meshes.
    """
    asked, last = problem.fem.meshed_by, MESHERS[-1]
    if asked == last or not (reason := unavailable()):
        return problem, ()
    return replace(problem, fem=problem.fem.model_copy(update={"mesher": last})), (
        _replaced(asked, last, reason),
    )


def _replaced(asked: str, mesher: str, reason: str) -> str:
    lower = ", in triangles of lower degree" if asked == "quads" else ""
    return f"meshed by {mesher}{lower}: {reason}"


def half_space_mesh(problem: Problem) -> Meshed:
    """The mesh of a problem.

    By the mesher asked for, or by the next that can, with a note that says why.
    """
    asked, reason = problem.fem.meshed_by, ""
    for mesher in MESHERS[MESHERS.index(asked) :]:
        try:
            meshed = _meshed(problem, mesher)
        except MeshError as error:
            if mesher == MESHERS[-1]:
                raise
            reason = reason or str(error)
        else:
            break
    return replace(meshed, notes=(_replaced(asked, meshed.mesher, reason),) if reason else ())


def _meshed(problem: Problem, mesher: str) -> Meshed:
    from ...meshes import bisection, triangles
    from ...meshes.quads import graded

    if mesher == "quads":
        sizes = defaults.quad_sizes(problem)
        between = sizes.factor, sizes.growth, sizes.truncation, sizes.sharpness
        layered = graded(problem.merged.ring_edges, sizes.ring_sizes, sizes.rim_size, *between)
        return Meshed(layered.mesh, mesher, layered)
    field = defaults.triangle_sizes(problem)
    return Meshed(triangles.mesh(field) if mesher == "gmsh" else bisection.mesh(field), mesher)


def half_space_on(problem: Problem, meshed: Meshed) -> "HalfSpace":
    """The half-space on a mesh, with scikit-fem's elements of the degree that goes with it."""
    from ...fem.elasticity import AxisymmetricElasticity
    from ...fem.half_space import HalfSpace, pressure_space
    from ...meshes.half_space import truncation

    degree = (
        defaults.triangle_degree(problem)
        if meshed.graded is None
        else defaults.quad_sizes(problem).degree
    )
    solid = AxisymmetricElasticity(meshed.mesh, degree, problem.poisson_ratio)
    poles = defaults.pole_orders(problem, truncation(meshed.mesh))
    return HalfSpace(solid, pressure_space(solid, problem.merged.ring_edges), poles)


class Fem(ComplianceMethod):
    """scikit-fem's elements, Lagrange multipliers, Boussinesq's far field, condensed to the
    contact.
    """

    name = "fem"
    what = (
        "the half-space by finite elements: a graded quarter disc with Boussinesq's far field, "
        "condensed to the contact"
    )
    look: ClassVar[dict[str, Any]] = {
        "color": "#c0392b",
        "linestyle": "--",
        "linewidth": 1.0,
        "marker": "o",
        "markersize": 3,
        "markerfacecolor": "none",
    }

    def described(self, problem: Problem) -> str:
        if marches_contact(problem):
            return costs.described(problem)
        problem, _ = usable_here(problem)
        chosen = problem.fem
        sizes: Any
        if chosen.meshed_by == "quads":
            sizes = defaults.quad_sizes(problem)
            degree, what = sizes.degree, "quadrilaterals"
        else:
            sizes = defaults.triangle_sizes(problem)
            degree, what = defaults.triangle_degree(problem), f"triangles by {chosen.meshed_by}"
        ring_size = min(sizes.ring_sizes, default=sizes.rim_size)
        return (
            f"{what}, degree {degree}, {chosen.far_field} far field at R = {sizes.truncation:g} a, "
            "rim_size "
            f"{sizes.rim_size:.3g}, ring_size {ring_size:.3g}, growth {sizes.growth:.3g}, "
            f"factorised by {solver()}"
        )

    def counted(self, problem: Problem) -> tuple[int, int]:
        if marches_contact(problem):
            return costs.counted(problem, elements=True)
        return fem_counts.counted(usable_here(problem)[0])

    def cost(self, problem: Problem) -> Cost:
        return (
            costs.cost(problem, elements=True)
            if marches_contact(problem)
            else super().cost(problem)
        )

    def refusal(self, problem: Problem) -> str:
        if not problem.full_contact and problem.fem.model_fields_set - {"mesher"}:
            return (
                "accuracy.fem sizes the mesh of a flat punch: with an initial profile or a fixed "
                "indentation leave out all "
                "but the mesher, which is that of the steady state"
            )
        narrowest = float(problem.merged.widths.min())
        if narrowest < NARROWEST:
            less = (
                f"rings narrower than {NARROWEST:g} a cannot be meshed: the narrowest is "
                f"{narrowest:.2g} a"
            )
            return f"{less}; merge it with a neighbour, or leave fem out of methods"
        return super().refusal(problem)

    def notes(self, problem: Problem) -> tuple[str, ...]:
        return usable_here(problem)[1]

    def kind(self, problem: Problem) -> str:
        mesher = usable_here(problem)[0].fem.meshed_by
        return f"fem {mesher}" if solver() == "cholmod" else f"fem {mesher}, {solver()}"

    def sizes_given(self, problem: Problem) -> bool:
        return problem.fem.given

    def discretised(self, problem: Problem, stages: Stages, coarser: bool = True) -> Discretised:
        from ...meshes.half_space import truncation

        fixed = problem.fem.far_field == "fixed"
        with stages("meshing"):
            meshed = half_space_mesh(problem)
        with stages("assembling"):
            half_space = half_space_on(problem, meshed)
            _ = half_space.lower_triangle
        with stages("condensing"):
            fine = half_space.compliance()
            if fixed:
                # the last rows of the factor belong to the poles: without them the outer boundary
                # is clamped
                fine = replace(fine, factor=fine.factor[: -len(half_space.poles)])
        other = None
        if coarser:
            with stages("estimating"):
                other = _coarser_half_space(problem, meshed, half_space).compliance()
        settings = {
            "mesher": meshed.mesher,
            "elements": meshed.mesh.nelements,
            "degree": half_space.solid.degree,
            "multipliers": fine.space.size,
            "far_field": problem.fem.far_field,
            "poles": 0 if fixed else len(half_space.poles),
            "truncation": truncation(meshed.mesh),
            "solver": solver(),
        }
        if fixed:
            # displacements and stresses inside are those of the clamped half-space, too
            half_space = replace(half_space, poles=())
        safety = SAFETY_OF_TRIANGLES if meshed.graded is None else SAFETY
        return Discretised(
            fine, other, half_space.unknowns, settings, half_space, meshed.notes, safety
        )

    def unilateral(self, problem: Problem) -> "UnilateralMethod":
        from ...fem.contact_meshes import (
            COARSER_GROWTH,
            TRIANGLE_GROWTH,
            even_half_space,
            fitted_half_space,
        )
        from ...meshes.contact_cells import ContactCells
        from .unilateral.solution import UnilateralMethod

        def even(cells: ContactCells, coarser: bool) -> "tuple[Compliance, int]":
            growth = COARSER_GROWTH if coarser else TRIANGLE_GROWTH
            half_space = even_half_space(cells, problem.poisson_ratio, growth)
            return half_space.compliance(), half_space.unknowns

        def fitted(
            edges: tuple[float, ...], infinite: tuple[bool, ...], degree: int
        ) -> "Compliance":
            return fitted_half_space(edges, infinite, degree, problem.poisson_ratio).compliance()

        return UnilateralMethod(even, fitted, (8, 7))


def _coarser_half_space(problem: Problem, meshed: Meshed, whole: "HalfSpace") -> "HalfSpace":
    """A degree and a layer less, or larger triangles, and a pole less.

    A clamped boundary is held against poles: what it errs by is far more than one of them does.
    """
    from ...fem.half_space import HalfSpace, pressure_space
    from ...meshes import bisection, triangles

    degree = whole.solid.degree - 1
    if meshed.graded is not None:
        mesh = meshed.graded.coarser().mesh
    else:
        field = defaults.triangle_sizes(problem).coarser()
        mesh = triangles.mesh(field) if meshed.mesher == "gmsh" else bisection.mesh(field)
        # with less than two no multipliers are stable
        degree = max(degree, 2)
    solid = replace(whole.solid, degree=degree, mesh=mesh)
    poles = whole.poles if problem.fem.far_field == "fixed" else whole.poles[:-1]
    return HalfSpace(solid, pressure_space(solid, problem.merged.ring_edges), poles)


METHOD = Fem()
