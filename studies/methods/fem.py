"""The finite-element half-space at a wanted accuracy.

It is built on the mesh that is asked for, or on the one that suits the problem best.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ...fem.condensation import solver
from ...meshes.errors import MeshError, SceneError
from ...meshes.sizes import NARROWEST
from ..problem.problem import Problem
from ..problem.quantities import DESCRIBED, ENERGIES, LAYER_QUANTITIES
from ..problem.regimes import FULL_CONTACT, MOVING_CONTACT
from ..problem.sections import DEGREES, LAYERED
from ..progress import Stages
from ..sizes import defaults
from ..sizes.layers import HIGHEST_POISSON_RATIO, why_layers_are_not_meshed
from ..sizes.low_degrees import LOW_DEGREE_HALVINGS, low_degree_quad_sizes
from .base import Discretised, SystemSize
from .error_factors import error_factor
from .pipeline import ComplianceMethod
from .spaces import contact_cells

if TYPE_CHECKING:
    from skfem import Mesh

    from ...fem.half_space import HalfSpace
    from ...meshes.compliance import Compliance
    from ...meshes.ground.ground import Ground
    from ...meshes.sizes import SizeField

LOCKING = 0.49
"""Poisson's ratio above which linear elements are refused.

At 0.499 linear triangles err by 19 per cent in d(t), and less is stated
(tests/physics/test_low_degrees.py).
"""
DEGREE_ON_CELLS = 3
"""Degree of triangles beneath contact that opens and spreads (`ringwear study convergence`)."""
LINEAR_HALVINGS = 2, 1
"""Times that linear triangles beneath cells are halved, and those that they are held against."""


# growth of the size of triangles with the distance by default
USUAL_GROWTH = 0.5
# measured on the bundled scenes: unknowns of the finite elements for each pressure, 40 to 130, and
# numbers of the sparse factor for each unknown, over the binary logarithm of their number
UNKNOWNS_PER_PRESSURE, NUMBERS_PER_UNKNOWN = 90, 50


@dataclass(frozen=True, eq=False)
class ChosenMesh:
    """The mesh of a problem.

    Parameters
    ----------
    mesh : of scikit-fem, its boundaries named
    mesher : what made it
    coarser : () -> the same of a layer less, of larger triangles, or not halved as often
    notes : what the user should know
    halved : whether the coarser one has elements twice as large everywhere
    """

    mesh: Any
    mesher: str
    coarser: Callable[[], Any]
    notes: tuple[str, ...] = ()
    halved: bool = False


def half_space_mesh(problem: Problem) -> ChosenMesh:
    """Return the mesh of a problem.

    By the mesher asked for, or by bisection where that cannot, with a note that says why.

    Raises
    ------
    SceneError
        if layers cannot be meshed as asked
    """
    if refused := why_layers_are_not_meshed(problem):
        raise SceneError(refused)
    try:
        return _meshed(problem, problem.fem.chosen_mesher)
    except MeshError as error:
        # bisection knows no interfaces of layers
        if problem.fem.chosen_mesher == "bisection" or problem.ground is not None:
            raise
        note = f"meshed by bisection, in triangles of degree 4 at most: {error}"
    return replace(_meshed(problem, "bisection"), notes=(note,))


def _meshed(problem: Problem, mesher: str) -> ChosenMesh:
    from ...meshes.quads import graded

    if problem.fem.degree and problem.fem.degree < (LAYERED if mesher == "quads" else 2):
        return _halved(problem, mesher)
    if mesher == "quads":
        layered = graded(problem.merged.ring_edges, **defaults.quad_sizes(problem))
        return ChosenMesh(layered.mesh, mesher, lambda: layered.coarser().mesh)
    field, make = defaults.triangle_sizes(problem), _triangulation(mesher)
    return ChosenMesh(make(field), mesher, lambda: make(field.coarser()))


def _triangulation(mesher: str) -> "Callable[[SizeField], Mesh]":
    from ...meshes import bisection, triangles

    return triangles.mesh if mesher == "gmsh" else bisection.mesh


def _halved(problem: Problem, mesher: str) -> ChosenMesh:
    """Return a mesh for elements of a low degree: halved, and held against one halved once less.

    There is no lower degree to hold them against, and other sizes at ring edges and rim would show
    nothing of the large elements, which err most.
    """
    from ...meshes.half_space import halved
    from ...meshes.quads import graded

    edges, count = problem.merged.ring_edges, LOW_DEGREE_HALVINGS
    if mesher == "quads":
        base = graded(edges, **low_degree_quad_sizes(problem)).mesh
    else:
        base = _triangulation(mesher)(defaults.triangle_sizes(problem))
    return ChosenMesh(
        halved(base, edges, count),
        mesher,
        lambda: halved(base, edges, count - 1),
        halved=True,
    )


def half_space_on(problem: Problem, chosen: ChosenMesh) -> "HalfSpace":
    """Return the half-space on a mesh, with scikit-fem's elements of a suitable degree."""
    from ...fem.elasticity import AxisymmetricElasticity
    from ...fem.half_space import HalfSpace, pressure_space
    from ...meshes.half_space import truncation

    quads = chosen.mesher == "quads"
    degree = (defaults.quad_degree if quads else defaults.triangle_degree)(problem)
    # the field below is smoother: a fifth of the degree less costs nothing on the contact
    solid = AxisymmetricElasticity(
        chosen.mesh,
        degree,
        problem.poisson_ratio,
        lowered_degrees=degree // 5,
        ground=problem.ground,
    )
    if problem.ground is not None:
        solid = replace(solid, highest_ratio=HIGHEST_POISSON_RATIO)
    poles = defaults.pole_orders(problem, truncation(chosen.mesh))
    space = pressure_space(solid, problem.merged.ring_edges, problem.merged.hollow)
    return HalfSpace(solid, space, poles).without_dependent_poles()


class Fem(ComplianceMethod):
    """Finite elements, condensed to the contact.

    The elements are scikit-fem's, contact pressures are Lagrange multipliers, and the far field is
    Boussinesq's.
    """

    name = "fem"
    knows_layers = True
    what = (
        "the half-space by finite elements: a graded quarter disc with Boussinesq's far field, "
        "condensed to the contact"
    )

    def refusal(self, problem: Problem) -> str:
        """Return why the problem cannot be solved at all, with the remedy; empty if it can.

        Besides what every `ComplianceMethod` refuses, rings narrower than `NARROWEST` cannot be
        meshed.
        """
        if refused := _refused_degree(problem) or why_layers_are_not_meshed(problem):
            return refused
        narrowest = float(problem.merged.widths.min())
        if narrowest < NARROWEST:
            return (
                f"rings narrower than {NARROWEST:g} a cannot be meshed: the narrowest is "
                f"{narrowest:.2g} a; merge it with a neighbour, or leave fem out of methods"
            )
        return super().refusal(problem)

    def sizes_of_flat_punches(self, problem: Problem) -> str:
        """Return what to leave out if the user has given more than the mesher and the degree."""
        if not problem.fem.model_fields_set - {"mesher", "degree"}:
            return ""
        return (
            "accuracy.fem sizes the mesh of a flat punch: with an initial profile leave out all "
            "but the mesher, which is that of the steady state, and the degree"
        )

    def sizes_given(self, problem: Problem) -> bool:
        """Return whether the user has given sizes or degrees of the mesh."""
        return problem.fem.given_by_user

    def remedy(self, problem: Problem) -> str:
        """Return what would make it more accurate, if that is not a smaller `rtol`."""
        if problem.fem.far_field == "fixed":
            errs = "errs" if problem.ground else "errs by 1.1 a/R"
            return f"the clamped boundary {errs}; far_field = 'boussinesq' does not"
        return super().remedy(problem)

    def modelling_errors(self, problem: Problem) -> dict[str, str]:
        """Return what a clamped outer boundary costs, if the user asks for one."""
        if problem.fem.far_field != "fixed":
            return {}
        why = "the scene clamps the outer boundary: expect the indentation to err by 1.1 a/R"
        if problem.ground is not None:
            why = "the scene clamps the outer boundary, on layers: expect the indentation to err"
        return {"far field": why}

    def system_size(self, problem: Problem) -> SystemSize:
        """Return how many unknowns and pressures the finite elements of a problem will have."""
        half_space = HALF_SPACES[problem.contact](problem)
        return SystemSize(half_space.unknowns, half_space.space.size)

    def numbers_in_memory(self, problem: Problem, pressures: int) -> float:
        """Return about how many numbers its dense matrices and its sparse factor have."""
        # triangles that grow more slowly with the depth than by default
        slower = max(1.0, USUAL_GROWTH / (problem.fem.growth or USUAL_GROWTH))
        unknowns = UNKNOWNS_PER_PRESSURE * pressures * slower**2
        factor = NUMBERS_PER_UNKNOWN * unknowns * np.log2(unknowns)
        return super().numbers_in_memory(problem, pressures) + float(factor)

    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        """Return the half-space that suits a problem, condensed, and what makes a coarser one.

        For a flat punch, elements are small at ring edges and rim; for any other, there are cells
        over the face.
        """
        return DISCRETISED[problem.contact](problem, stages)


def _layered_half_space(problem: Problem) -> "HalfSpace":
    return half_space_on(problem, half_space_mesh(problem))


def _half_space_on_cells(problem: Problem) -> "HalfSpace":
    from ...fem.contact_meshes import even_half_space

    return even_half_space(contact_cells(problem)[0], problem.poisson_ratio)


def _refused_degree(problem: Problem) -> str:
    """Return why a degree that is given does not go with a problem, with the remedy."""
    degree = problem.fem.degree
    if degree == 1 and problem.poisson_ratio > LOCKING:
        return (
            f"accuracy.fem.degree = 1 locks for Poisson's ratios above {LOCKING:g}, and no error "
            "estimate shows it: give degree = 2 or more, or leave it out"
        )
    on_triangles = problem.fem.mesher != "quads" and (degree or 1) in DEGREES["bisection"]
    if degree and not problem.full_contact and not on_triangles:
        return (
            "accuracy.fem.degree: contact that opens and spreads is solved on triangles: with an "
            "initial profile give degree = 1 to 4 without mesher = 'quads', or leave it out"
        )
    return ""


def _layered(problem: Problem, stages: Stages) -> Discretised:
    """Return the half-space of a flat punch, small elements at ring edges and rim."""
    from ...meshes.half_space import truncation

    fixed = problem.fem.far_field == "fixed"
    with stages("meshing"):
        chosen = half_space_mesh(problem)
    with stages("assembling"):
        half_space = half_space_on(problem, chosen)
        _ = half_space.lower_triangle
    with stages("condensing"):
        fine = half_space.compliance()
        if fixed:
            # the last rows of the factor belong to the poles: without them the outer boundary is
            # clamped
            fine = replace(fine, factor=fine.factor[: len(fine.factor) - len(half_space.poles)])
    settings = {
        "mesher": chosen.mesher,
        "elements": chosen.mesh.nelements,
        "degree": half_space.solid.degree,
        "poles": 0 if fixed else len(half_space.poles),
        "truncation": truncation(chosen.mesh),
        "solver": solver(),
    }
    return Discretised(
        fine,
        lambda: _coarser_half_space(problem, chosen, half_space).compliance(),
        half_space.unknowns,
        settings,
        # displacements and stresses inside are those of the clamped half-space, too
        replace(half_space, poles=()) if fixed else half_space,
        chosen.notes,
        # on triangles, whose degree is low, solutions of two sizes or degrees may miss the same
        safety=error_factor(_kind_of_difference(chosen)),
        smallest=_smallest(problem, chosen),
        limited_by_degree=_limited_by_degree(half_space.solid.degree, chosen.mesher),
    )


def _limited_by_degree(degree: int, mesher: str) -> frozenset[str]:
    """Return the quantities that elements of a degree know no better on a finer mesh.

    These are fields, if the degree is the highest that there is. Layers of quadrilaterals become
    thinner all the same, and with them the errors of what is felt in layers; energies converge by
    the size of triangles, too.
    """
    if degree < DEGREES[mesher][-1]:
        return frozenset()
    refined_by_layers = {*ENERGIES, *(LAYER_QUANTITIES if mesher == "quads" else ())}
    return frozenset(DESCRIBED.keys() - refined_by_layers)


def _kind_of_difference(chosen: ChosenMesh) -> str:
    """Return the name of the factor on the difference to the coarser half-space."""
    if chosen.halved:
        return "flat punch on halved elements"
    return "flat punch" if chosen.mesher == "quads" else "flat punch on triangles"


def _smallest(problem: Problem, chosen: ChosenMesh) -> float:
    """Return the least size of elements beside a ring edge that a mesher is asked for.

    Triangles and elements that are halved, whose degree is low, are as small as they are, because
    smaller ones would not help.
    """
    from ...meshes.half_space import contact_radii

    if chosen.mesher == "quads" and not chosen.halved:
        return defaults.fem_smallest(problem)
    return float(np.diff(contact_radii(chosen.mesh)).min())


def _on_cells(problem: Problem, stages: Stages) -> Discretised:
    """Return the half-space of a punch whose contact edges move, triangles on cells of its face."""
    from ...fem.contact_meshes import COARSER_GROWTH, even_half_space, fitted_half_space

    ratio, degree = problem.poisson_ratio, problem.fem.degree or DEGREE_ON_CELLS
    halvings = LINEAR_HALVINGS if degree == 1 else (0, 0)
    cells, coarser = contact_cells(problem)
    with stages("condensing"):
        half_space = even_half_space(cells, ratio, degree=degree, halvings=halvings[0])
        compliance = half_space.compliance()

    def fitted(
        edges: tuple[float, ...], infinite: tuple[bool, ...], _: "Ground | None", degree: int
    ) -> "Compliance":
        return fitted_half_space(edges, infinite, degree, ratio).compliance()

    return Discretised(
        compliance,
        lambda: even_half_space(coarser, ratio, COARSER_GROWTH, degree, halvings[1]).compliance(),
        half_space.unknowns,
        half_space=half_space,
        # elements of a degree that is asked for have the start, too, not others of a high degree
        fitted=None
        if problem.fem.degree
        else (partial(fitted, degree=8), partial(fitted, degree=7)),
    )


def _coarser_half_space(problem: Problem, chosen: ChosenMesh, whole: "HalfSpace") -> "HalfSpace":
    """Return the half-space that a half-space is compared with to estimate its error.

    It has a degree and a layer less, or larger triangles, and a pole less. What cannot be coarser
    is compared with something better: a clamped boundary with poles, because it errs by far more
    than one of them does, and degree 2 with degree 3 on the same mesh, because no multipliers are
    stable on degree 1, and larger triangles of degree 2 may miss the same relaxation modes.
    """
    from ...fem.half_space import HalfSpace, pressure_space

    if chosen.halved:
        # halving once less is coarse enough
        solid = replace(whole.solid, mesh=chosen.coarser())
    elif whole.solid.degree > 2:
        solid = replace(whole.solid, degree=whole.solid.degree - 1, mesh=chosen.coarser())
    else:
        solid = replace(whole.solid, degree=3)
    fixed = problem.fem.far_field == "fixed"
    poles = whole.poles if fixed else defaults.coarser_pole_orders(whole.poles)
    if problem.ground is not None and problem.ground.rigid and len(whole.poles) < 2:
        # what a rigid base leaves beyond the mesh hardly matters
        poles = ()
    return HalfSpace(
        solid, pressure_space(solid, problem.merged.ring_edges, problem.merged.hollow), poles
    )


HALF_SPACES = {FULL_CONTACT: _layered_half_space, MOVING_CONTACT: _half_space_on_cells}
DISCRETISED = {FULL_CONTACT: _layered, MOVING_CONTACT: _on_cells}

METHOD = Fem()
