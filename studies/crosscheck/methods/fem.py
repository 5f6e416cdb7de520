"""The finite-element half-space of a problem, with sizes that suit its tolerance."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ....fem.condensation import solver, unloadable
from ....meshes.sizes import NARROWEST_RING
from ..problem.problem import Problem
from ..problem.quantities import DESCRIBED, ENERGIES, LAYER_QUANTITIES
from ..problem.refusal import Refusal
from ..problem.sections import DEGREES
from ..progress import Stages
from ..sizes.finite_elements import FemSizes, coarser_pole_orders, fem_sizes, pole_orders
from ..sizes.layers import layers_beyond_meshes, why_layers_are_not_meshed
from ..sizes.ring_edges import compressibility, fem_smallest
from ..wear.first_contact import contact_cells
from .base import Discretised, SystemSize
from .error_factors import error_factor
from .pipeline import ComplianceMethod

if TYPE_CHECKING:
    from ....fem.half_space import HalfSpace
    from ....meshes.compliance import Compliance
    from ....meshes.ground.ground import Ground

LOCKING = 0.49
"""Poisson's ratio above which linear elements are refused.

At 0.499, linear triangles have an error of 19 per cent in d(t), and their error estimate is smaller
than that (tests/physics/test_low_degrees.py).
"""
DEGREE_ON_CELLS = 3
"""Degree of triangles under contact that opens and spreads (`ringwear study convergence`)."""
LINEAR_HALVINGS = 2, 1
"""How often linear triangles under cells are halved: in the fine mesh, and in the coarser one."""


def half_space_on(problem: Problem, sizes: FemSizes) -> "HalfSpace":
    """Return the half-space of a problem, in scikit-fem's elements of the given sizes."""
    from ....fem.elasticity import AxisymmetricElasticity
    from ....fem.half_space import HalfSpace, pressure_space
    from ....meshes.half_space import truncation

    # the field below the contact is smoother: lowering its degree by a fifth has no effect on the
    # contact
    solid = AxisymmetricElasticity(
        sizes.mesh, sizes.degree, problem.ground, lowered_degrees=sizes.degree // 5
    )
    poles = pole_orders(problem, truncation(sizes.mesh))
    space = pressure_space(solid, problem.merged.ring_edges)
    return HalfSpace(solid, space, poles).without_dependent_poles()


class Fem(ComplianceMethod):
    """Finite elements, condensed to the contact.

    The elements are those of scikit-fem, contact pressures are Lagrange multipliers, and the far
    field is Boussinesq's.
    """

    name = "fem"
    knows_layers = True
    what = (
        "the half-space by finite elements: a graded quarter disc with Boussinesq's far field, "
        "condensed to the contact"
    )

    def beyond(self, problem: Problem) -> Refusal | None:
        """Return why problems of this kind are beyond the method; None if it can solve them.

        Rings narrower than `NARROWEST_RING` and some layers cannot be meshed.
        """
        narrowest = float(problem.merged.widths.min())
        if narrowest < NARROWEST_RING:
            return Refusal(
                f"rings narrower than {NARROWEST_RING:g} a cannot be meshed, and the narrowest has "
                f"{narrowest:.2g} a",
                "merge it with a neighbour, or leave fem out of methods",
            )
        return layers_beyond_meshes(problem) or super().beyond(problem)

    def refusal(self, problem: Problem) -> str:
        """Return why the method cannot solve the problem, with the remedy; empty if it can."""
        if reason := _refused_degree(problem) or why_layers_are_not_meshed(problem):
            return reason
        return super().refusal(problem)

    def sizes_of_flat_punches(self, problem: Problem) -> str:
        """Return which sizes to leave out, if the scene sets more than mesher and degree."""
        if not problem.fem.model_fields_set - {"mesher", "degree"}:
            return ""
        return (
            "accuracy.fem sizes the mesh of a flat punch: with an initial profile leave out all "
            "but the mesher, which is that of the steady state, and the degree"
        )

    def sizes_given(self, problem: Problem) -> bool:
        """Return whether the scene sets sizes or degrees of the mesh."""
        return problem.fem.given_by_user

    def remedy(self, problem: Problem) -> str:
        """Return what would make the method more accurate, if that is not a smaller `rtol`."""
        if problem.fem.far_field == "fixed":
            error = "an error" if problem.ground.layered else "an error of 1.1 a/R"
            return f"the clamped boundary causes {error}; give far_field = 'boussinesq'"
        return super().remedy(problem)

    def modelling_errors(self, problem: Problem) -> dict[str, str]:
        """Return the error that a clamped outer boundary causes, if the scene has one."""
        if problem.fem.far_field != "fixed":
            return {}
        why = "the scene clamps the outer boundary: the indentation has an error of 1.1 a/R"
        if problem.ground.layered:
            why = "the scene clamps the outer boundary, on layers: the indentation has an error"
        return {"far field": why}

    def system_size(self, problem: Problem) -> SystemSize:
        """Return the number of unknowns and of pressures of the finite elements."""
        from ....fem.contact_meshes import even_half_space

        if problem.full_contact:
            sizes = fem_sizes(problem)
            half_space, notes = half_space_on(problem, sizes), _notes(*sizes.notes)
        else:
            half_space = even_half_space(contact_cells(problem)[0], problem.ground)
            notes = _notes()
        return SystemSize(half_space.unknowns, half_space.space.size, notes)

    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        """Return the condensed half-space that suits a problem, and how to make a coarser one.

        For a flat punch, elements are small at ring edges and at the rim. For any other punch, they
        are small triangles below cells of the face.
        """
        discretise = _discretise_flat if problem.full_contact else _discretise_on_cells
        return discretise(problem, stages)


def _notes(*of_sizes: str) -> tuple[str, ...]:
    """Return the notes of the sizes, and that CHOLMOD had to be replaced, if it had to."""
    return tuple(filter(None, (*of_sizes, unloadable())))


def _refused_degree(problem: Problem) -> str:
    """Return why a degree that the scene sets is not possible, with the remedy; empty if it is."""
    degree = problem.fem.degree
    if degree == 1 and problem.poisson_ratio > LOCKING:
        return (
            f"accuracy.fem.degree = 1 locks for Poisson's ratios above {LOCKING:g}, and the error "
            "estimate does not show that: give degree = 2 or more, or leave it out"
        )
    on_triangles = problem.fem.mesher != "quads" and (degree or 1) in DEGREES["bisection"]
    if degree and not problem.full_contact and not on_triangles:
        return (
            "accuracy.fem.degree: contact that opens and spreads is solved on triangles: with an "
            "initial profile give degree = 1 to 4 without mesher = 'quads', or leave it out"
        )
    return ""


def _discretise_flat(problem: Problem, stages: Stages) -> Discretised:
    """Return the half-space of a flat punch, with small elements at ring edges and at the rim."""
    from ....meshes.half_space import truncation

    fixed = problem.fem.far_field == "fixed"
    with stages("meshing"):
        sizes = fem_sizes(problem)
    with stages("assembling"):
        half_space = half_space_on(problem, sizes)
        coarser = stages.begin(
            lambda _: _coarser_half_space(problem, sizes.coarser(), half_space).compliance(),
            "estimating",
        )
        half_space.lower_triangle  # noqa: B018 (a cached property, which `compliance` uses)
    with stages("condensing"):
        # the first of the compliances by poles is that of the clamped outer boundary
        fine = half_space.compliances_by_poles()[0] if fixed else half_space.compliance()
    extrapolated = problem.ground.layered and half_space.more_compressible is not None
    settings = {
        "mesher": sizes.mesher,
        "elements": sizes.mesh.nelements,
        "smallest": float(half_space.space.widths.min()),
        "degree": sizes.degree,
        "poles": 0 if fixed else len(half_space.poles),
        "truncation": truncation(sizes.mesh),
        "solver": solver(),
    }
    return Discretised(
        fine,
        coarser,
        half_space.unknowns,
        settings,
        # so that displacements and stresses inside are those of the clamped half-space, too
        replace(half_space, poles=()) if fixed else half_space,
        _notes(*sizes.notes),
        safety=error_factor(sizes.error_factor),
        smallest=_smallest_size(problem, sizes),
        slope_roundoff=error_factor("roundoff of slopes") / compressibility(problem),
        least_error=error_factor("incompressible layers") if extrapolated else 0.0,
        limited_by_degree=_limited_by_degree(sizes.degree, sizes.mesher),
    )


def _limited_by_degree(degree: int, mesher: str) -> frozenset[str]:
    """Return the quantities that a finer mesh of this degree does not make more accurate.

    If the degree of quadrilaterals is the highest available, these are fields. Energies still
    become more accurate, and on thinner layers also the quantities that depend on thin layers at
    ring edges. Triangles have no such quantities: with a tenth of the tolerance, all of them are
    smaller, and the errors of slopes are a quarter.
    """
    if mesher != "quads" or degree < DEGREES[mesher][-1]:
        return frozenset()
    return frozenset(DESCRIBED) - ENERGIES - LAYER_QUANTITIES


def _smallest_size(problem: Problem, sizes: FemSizes) -> float:
    """Return the smallest element size at a ring edge that a mesher can use.

    For triangles and for halved elements, which have a low degree, it is the size that the mesh
    has, because smaller ones would not be more accurate.
    """
    from ....meshes.half_space import contact_radii

    if sizes.mesher == "quads" and not sizes.halved:
        return fem_smallest(problem)
    return float(np.diff(contact_radii(sizes.mesh)).min())


def _discretise_on_cells(problem: Problem, stages: Stages) -> Discretised:
    """Return the half-space of a punch whose contact edges move: triangles below cells."""
    from ....fem.contact_meshes import COARSER_GROWTH, even_half_space, fitted_half_space

    ground, degree = problem.ground, problem.fem.degree or DEGREE_ON_CELLS
    halvings = LINEAR_HALVINGS if degree == 1 else (0, 0)
    cells, coarser_cells = contact_cells(problem)
    coarser = stages.begin(
        lambda _: even_half_space(
            coarser_cells, ground, COARSER_GROWTH, degree, halvings[1]
        ).compliance(),
        "estimating",
    )
    with stages("condensing"):
        half_space = even_half_space(cells, ground, degree=degree, halvings=halvings[0])
        compliance = half_space.compliance()

    def fitted(
        edges: tuple[float, ...],
        sizes: tuple[float, ...],
        scaled_ground: "Ground",
        degree: int,
    ) -> "Compliance":
        return fitted_half_space(edges, sizes, degree, scaled_ground).compliance()

    return Discretised(
        compliance,
        coarser,
        half_space.unknowns,
        half_space=half_space,
        notes=_notes(),
        # if the scene sets the degree, its elements also solve the start, instead of others of high
        # degree
        fitted=None
        if problem.fem.degree
        else (partial(fitted, degree=8), partial(fitted, degree=7)),
    )


def _coarser_half_space(problem: Problem, coarser: FemSizes, fine: "HalfSpace") -> "HalfSpace":
    """Return the coarser half-space that is compared with a half-space to estimate its error.

    It has the coarser sizes, and a pole less. A clamped boundary is compared with a far field of
    poles, which is a better solution, because the error of the boundary is far greater than theirs.
    """
    from ....fem.half_space import HalfSpace, pressure_space
    from ....meshes.half_space import truncation

    solid = replace(fine.solid, degree=coarser.degree, mesh=coarser.mesh)
    poles = coarser_pole_orders(fine.poles)
    wanted_poles = pole_orders(problem, truncation(fine.solid.mesh))
    if problem.fem.far_field == "fixed" or len(fine.poles) < min(2, len(wanted_poles)):
        poles = fine.poles
    elif problem.ground.rigid and len(fine.poles) < 2:
        # the scene gives one pole, and above a rigid base a second one may depend on it
        poles = ()
    return HalfSpace(solid, pressure_space(solid, problem.merged.ring_edges), poles)


METHOD = Fem()
