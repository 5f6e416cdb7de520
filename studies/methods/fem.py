"""The finite-element half-space at a wanted accuracy, on the mesh that the scene asks for or that suits it best."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.errors import MeshError
from ringwear.studies.methods import quads, triangles
from ringwear.studies.methods.model import Model, Twin
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.progress import Stages

if TYPE_CHECKING:
    from ringwear.fem.half_space import HalfSpace
    from ringwear.meshes.quads import GradedQuads


@dataclass(frozen=True, eq=False)
class Meshed:
    """The mesh of a scene.

    Parameters
    ----------
    mesh : of scikit-fem, its boundaries named
    mesher : what made it
    graded : how its quadrilaterals were made, if it has any
    notes : what the user should know
    """

    mesh: Any
    mesher: str
    graded: GradedQuads | None = None
    notes: tuple[str, ...] = ()

    @property
    def radius(self) -> float:
        """Radius of the half-space."""
        from ringwear.meshes.half_space import truncation

        return truncation(self.mesh)


def half_space_mesh(natural: NaturalScene) -> Meshed:
    """The mesh of the scene; without gmsh it is made of triangles by bisection."""
    reason = ""
    if natural.scene.accuracy.fem.meshed_by == "quads":
        try:
            graded = quads.graded_quads(natural)
            return Meshed(graded.mesh, "quads", graded)
        except MeshError as error:
            reason = str(error)
    mesh, mesher, notes = triangles.triangle_mesh(natural)
    if reason:
        notes = (f"meshed by {mesher}, in triangles of lower degree: {reason}",)
    return Meshed(mesh, mesher, None, notes)


def far_poles(natural: NaturalScene, truncation: float) -> tuple[int, ...]:
    """Orders of the poles tied to the outer boundary: those asked for, or enough of them."""
    from ringwear.fem.far_field import enough_poles

    accuracy = natural.scene.accuracy
    if accuracy.fem.poles:
        return tuple(range(0, 2 * accuracy.fem.poles, 2))
    return enough_poles(truncation, min(1e-9, accuracy.rtol / 10))


def discretised(natural: NaturalScene, meshed: Meshed) -> HalfSpace:
    """The half-space on a mesh, with scikit-fem's elements of the degree that goes with it."""
    from ringwear.fem.elasticity import AxisymmetricElasticity
    from ringwear.fem.half_space import HalfSpace, pressure_space

    degree = triangles.degree(natural) if meshed.graded is None else quads.settings(natural).degree
    nu = natural.scene.half_space.poisson_ratio
    solid = AxisymmetricElasticity(meshed.mesh, degree, nu)
    return HalfSpace(solid, pressure_space(solid, natural.phases[0]), far_poles(natural, meshed.radius))


def truncation(natural: NaturalScene) -> float:
    """Radius of the half-space that the scene will have."""
    by_quads = natural.scene.accuracy.fem.meshed_by == "quads"
    return quads.settings(natural).truncation if by_quads else triangles.size_field(natural).truncation


def described(natural: NaturalScene) -> str:
    """What the half-space will be made of."""
    chosen = natural.scene.accuracy.fem
    made: Any
    if chosen.meshed_by == "quads":
        made = quads.settings(natural)
        degree, what, sizes = made.degree, "quadrilaterals", made.sizes
    else:
        made = triangles.size_field(natural)
        degree, what, sizes = triangles.degree(natural), f"triangles by {chosen.meshed_by}", made.ring_sizes
    return (
        f"{what}, degree {degree}, {chosen.far_field} far field at R = {made.truncation:g} a, "
        f"rim_size {made.rim_size:.3g}, ring_size {min(sizes, default=made.rim_size):.3g}, growth {made.growth:.3g}"
    )


def fem_model(natural: NaturalScene, stages: Stages, twins: bool = True) -> Model:
    """Compliance by condensing the finite-element half-space."""
    from ringwear.fem.condensation import solver

    fixed = natural.scene.accuracy.fem.far_field == "fixed"
    with stages("meshing"):
        meshed = half_space_mesh(natural)
    with stages("assembling"):
        half_space = discretised(natural, meshed)
        _ = half_space.lower_triangle
    with stages("condensing"):
        tied = half_space.compliance()
        # the last rows of the factor belong to the poles: without them the outer boundary is clamped
        fine = replace(tied, factor=tied.factor[: -len(half_space.poles)]) if fixed else tied
    made: list[Twin] = []
    outer = meshed.radius
    if twins:
        with stages("estimating"):
            made = coarser_pairs(natural, meshed, half_space, tied)
            # each pole takes the truncation error down by four orders in a/R (`ringwear study truncation`)
            share = 1.1 if fixed else 2 / outer**4
            made.append(Twin("truncation", tied, fine if fixed else replace(tied, factor=tied.factor[:-1]), share, share))
    settings = {
        "mesher": meshed.mesher, "elements": meshed.mesh.nelements, "degree": half_space.solid.degree,
        "multipliers": fine.space.size, "far_field": natural.scene.accuracy.fem.far_field,
        "poles": 0 if fixed else len(half_space.poles), "truncation": outer, "solver": solver(),
    }  # fmt: skip
    if fixed:
        # displacements and stresses inside are those of the clamped half-space, too
        half_space = replace(half_space, poles=())
    return Model(fine, tuple(made), half_space.unknowns, settings, half_space, meshed.notes)


def coarser_pairs(natural: NaturalScene, meshed: Meshed, whole: HalfSpace, fine: Compliance) -> list[Twin]:
    """The half-space with one degree (and one layer) less, and with the pressure alone one degree lower."""
    from ringwear.fem.half_space import pressure_space

    def with_degree(degree: int, mesh: Any) -> HalfSpace:
        solid = replace(whole.solid, degree=degree, mesh=mesh)
        return replace(whole, solid=solid, space=pressure_space(solid, natural.phases[0]))

    degree = whole.solid.degree
    if meshed.graded is not None:
        lower = with_degree(degree - 1, meshed.graded.coarser().mesh).compliance()
        # a degree takes the error down tenfold, but only twofold where elements grow away from much smaller patches
        alike = np.ptp(np.log(np.diff(natural.phases[0]))) <= np.log(quads.ALIKE)
        return [
            Twin("pressure space", fine, fine.coarser(), 0.05, 0.5),
            Twin("discretisation", fine, lower, 0.55 if alike else 2.5, 2.0, other_mesh=True),
        ]
    # on finer meshes one degree less costs ever more accuracy: of the difference in an indentation, a smaller share
    # remains. The power fits scenes drawn at random (`random_scenes`) from growth 0.3 to 0.9
    remains = min(1.0, (triangles.size_field(natural).growth / 0.75) ** 3)
    coarser = fine.coarser()
    made = [Twin("pressure space", fine, coarser, 1.2 * remains, 5.0)] if fine.space.top > 1 else []
    if degree == 2:
        # no stable multipliers go with a lower degree, so the pair is finer, and the difference the error itself
        finer = replace(with_degree(3, meshed.mesh), space=whole.space).compliance()
        return [*made, Twin("discretisation", finer, fine, 1.2, 3.0)]
    lower = replace(with_degree(degree - 1, meshed.mesh), space=coarser.space).compliance()
    return [*made, Twin("discretisation", coarser, lower, 0.6 * remains, 1.0)]
