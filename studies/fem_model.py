"""The finite-element half-space at a wanted accuracy, on the elements that the scene asks for or that suit it best."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from meshes.errors import MeshError
from meshes.half_space import HalfSpaceMesh

from . import stars, triangles
from .model import Model, Twin
from .natural import NaturalScene
from .stages import Stages

if TYPE_CHECKING:
    from fem.compliance import HalfSpace
    from meshes.stars import StarMesh


THREE_POLES = 3e-9


def half_space_mesh(natural: NaturalScene) -> tuple[HalfSpaceMesh | StarMesh, tuple[str, ...]]:
    """The mesh of the scene, with notes; without gmsh it is made of triangles only."""
    if natural.scene.accuracy.fem.meshed_by != "stars":
        return triangles.triangle_mesh(natural)
    try:
        return stars.star_mesh(natural), ()
    except MeshError as error:
        mesh, notes = triangles.triangle_mesh(natural)
        return mesh, notes or (f"triangles only, of lower degree: {error}",)


def far_poles(natural: NaturalScene) -> tuple[int, ...]:
    """Orders of the poles tied to the outer boundary: at 5 a, three of them leave 3e-10 of the indentation."""
    accuracy = natural.scene.accuracy
    count = accuracy.fem.poles or (3 if accuracy.rtol > THREE_POLES else 4)
    return tuple(range(0, 2 * count, 2))


def discretised(natural: NaturalScene, mesh: HalfSpaceMesh | StarMesh, poles: tuple[int, ...]) -> HalfSpace:
    """The half-space on a mesh, with the elements that go with it."""
    if isinstance(mesh, HalfSpaceMesh):
        return triangles.half_space(natural, mesh, poles)
    return stars.half_space(natural, mesh, poles)


def described(natural: NaturalScene) -> str:
    """What the half-space will be made of."""
    chosen = natural.scene.accuracy.fem
    if chosen.meshed_by == "stars":
        made = stars.settings(natural)
        degree, what, rim_size, sizes, growth = made.degree, "stars", made.rim_size, made.sizes, made.growth
    else:
        field = triangles.size_field(natural)
        degree, what = triangles.degree(natural), f"triangles by {chosen.meshed_by}"
        rim_size, sizes, growth = field.rim_size, field.ring_sizes, field.growth
    return (
        f"{what}, degree {degree}, {chosen.far_field} far field at R = {chosen.truncation:g} a, "
        f"rim_size {rim_size:.3g}, ring_size {min(sizes, default=rim_size):.3g}, growth {growth:.3g}"
    )


def fem_model(natural: NaturalScene, stages: Stages, twins: bool = True) -> Model:
    """Compliance by condensing the finite-element half-space."""
    from fem.condensation import solver

    chosen = natural.scene.accuracy.fem
    fixed = chosen.far_field == "fixed"
    poles = far_poles(natural)
    with stages("meshing"):
        mesh, notes = half_space_mesh(natural)
    with stages("assembling"):
        half_space = discretised(natural, mesh, poles)
        _ = half_space.lower_triangle
    with stages("condensing"):
        tied = half_space.compliance()
        # the last rows of the factor belong to the poles: without them the outer boundary is clamped
        fine = replace(tied, factor=tied.factor[: -len(poles)]) if fixed else tied
    made: list[Twin] = []
    if twins:
        with stages("estimating"):
            family = triangles if isinstance(mesh, HalfSpaceMesh) else stars
            made = family.twins(natural, half_space, tied)
            # each pole takes the truncation error down by four orders in a/R (`ringwear study truncation`)
            share = 1.1 if fixed else 2 / chosen.truncation**4
            made.append(Twin("truncation", tied, fine if fixed else replace(tied, factor=tied.factor[:-1]), share, share))
    if fixed:
        # displacements and stresses inside are those of the clamped half-space, too
        half_space = replace(half_space, poles=())
    settings = {
        "mesher": mesh.mesher, "elements": sum(map(len, mesh.cells.values())), "degree": half_space.solid.degree,
        "multipliers": fine.space.size, "far_field": chosen.far_field, "poles": len(half_space.poles),
        "truncation": chosen.truncation, "solver": solver(),
    }  # fmt: skip
    return Model(fine, tuple(made), half_space.unknowns, settings, half_space, notes)
