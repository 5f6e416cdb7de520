"""Graded triangles of degree 2 to 4 at a wanted accuracy: sizes, mesh, half-space, and the twins of its estimate."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from meshes.compliance import Compliance
from meshes.errors import MeshError
from meshes.half_space import HalfSpaceMesh, SizeField
from meshes.pressure_space import PressureSpace
from meshes.radial import Array

from .model import Twin
from .natural import NaturalScene
from .scene import DEGREES

if TYPE_CHECKING:
    from fem.compliance import HalfSpace


def edge_sizes(natural: NaturalScene) -> Array:
    """(N-1,) wanted sizes at the ring edges between centre and rim, in a few distinct values."""
    rtol = natural.scene.accuracy.rtol
    edges, _ = natural.phases
    widths = np.diff(edges)
    narrower = np.minimum(widths[:-1], widths[1:])
    # in proportion to the narrower ring beside each edge, and less so where rings are so narrow that their pattern has
    # little of the energy
    share = np.minimum(10 * rtol**0.6 * np.maximum(1, 1 / (32 * narrower)), 0.25)
    # wear blunts a ring edge over a length of k E* v0 t: the first time asked for is the sharpest to resolve
    blunted = max(0.5 * natural.earliest, rtol**0.75) if natural.earliest else 1.0
    return np.asarray(2.0 ** np.floor(np.log2(np.minimum(share, blunted / narrower) * narrower)))


def size_field(natural: NaturalScene) -> SizeField:
    """Element sizes of the triangles at the scene's accuracy."""
    rtol, chosen = natural.scene.accuracy.rtol, natural.scene.accuracy.fem
    edges, _ = natural.phases
    return SizeField(
        edges=tuple(float(edge) for edge in edges),
        rim_size=chosen.rim_size or min(0.1 * rtol, float(edges[-1] - edges[-2]) / 4),
        ring_size=chosen.ring_size or tuple(float(size) for size in edge_sizes(natural)),
        growth=chosen.growth or min(0.7 * (rtol / 1e-4) ** 0.115, 0.9),
        truncation=chosen.truncation,
        centre_size=min(0.2 * (rtol / 1e-4) ** 0.115, 0.5),
        # in d0, sides of a quarter of the truncation cost 2e-6 in degree 3 and 1e-8 in degree 4, of an eighth nothing
        far_size=0.25 if degree(natural) == DEGREES["gmsh"][-1] and rtol > 1e-6 else 0.125,
    )


def triangle_mesh(natural: NaturalScene) -> tuple[HalfSpaceMesh, tuple[str, ...]]:
    """Triangles by the mesher asked for; by bisection where gmsh cannot be used, with a note that says so."""
    from meshes import bisection, gmsh_mesher

    field = size_field(natural)
    if natural.scene.accuracy.fem.mesher == "bisection":
        return bisection.mesh(field), ()
    reason = gmsh_mesher.unavailable()
    if not reason:
        try:
            return gmsh_mesher.mesh(field), ()
        except MeshError as error:
            reason = f"gmsh could not follow these sizes ({error})"
    return bisection.mesh(field), (f"meshed by bisection: {reason}",)


def degree(natural: NaturalScene) -> int:
    """Degree of the displacement: the one given, else the highest."""
    highest = DEGREES["gmsh"][-1]
    return min(natural.scene.accuracy.fem.degree or highest, highest)


def half_space(natural: NaturalScene, mesh: HalfSpaceMesh, poles: tuple[int, ...]) -> HalfSpace:
    """The half-space on triangles."""
    from fem.compliance import MULTIPLIER_DEGREE, HalfSpace, pressure_space
    from fem.elasticity import AxisymmetricElasticity

    solid = AxisymmetricElasticity(mesh, degree(natural), natural.scene.half_space.poisson_ratio)
    return HalfSpace(solid, pressure_space(mesh, natural.phases[0], MULTIPLIER_DEGREE[solid.degree]), poles)


def twins(natural: NaturalScene, whole: HalfSpace, fine: Compliance) -> list[Twin]:
    """The pressure and the displacement one degree coarser.

    On finer meshes one degree less costs ever more accuracy: of the difference in an indentation, a smaller share
    remains. The power fits scenes drawn at random (`random_scenes`) from growth 0.3 to 0.9.
    """
    from fem.elasticity import AxisymmetricElasticity

    solid = whole.solid
    assert isinstance(solid, AxisymmetricElasticity)
    remains = min(1.0, (size_field(natural).growth / 0.75) ** 3)

    def with_degree(degree: int, space: PressureSpace) -> Compliance:
        lower = AxisymmetricElasticity(solid.mesh, degree, solid.given_ratio)
        return replace(whole, solid=lower, space=space).compliance()

    coarser = fine.coarser()
    made = [Twin("pressure space", fine, coarser, 1.2 * remains, 5.0)] if fine.space.top > 1 else []
    if solid.degree == 2:
        # no stable multipliers go with a lower degree, so the twin is finer, and the difference the error itself
        return [*made, Twin("discretisation", with_degree(3, fine.space), fine, 1.2, 3.0)]
    return [*made, Twin("discretisation", coarser, with_degree(solid.degree - 1, coarser.space), 0.6 * remains, 1.0)]
