"""Graded triangles of degree 2 to 4 at a wanted accuracy: sizes, degree and mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
from ringwear.meshes.errors import MeshError
from ringwear.meshes.radial import Array
from ringwear.meshes.size_field import SizeField
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.problem.scene import DEGREES

TRUNCATION = 5.0


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
        truncation=chosen.truncation or TRUNCATION,
        centre_size=min(0.2 * (rtol / 1e-4) ** 0.115, 0.5),
        # in d0, sides of a quarter of the truncation cost 2e-6 in degree 3 and 1e-8 in degree 4, of an eighth nothing
        far_size=0.25 if degree(natural) == DEGREES["gmsh"][-1] and rtol > 1e-6 else 0.125,
    )


def triangle_mesh(natural: NaturalScene) -> tuple[Any, str, tuple[str, ...]]:
    """Triangles and their mesher: the one asked for, or bisection where gmsh cannot be used, with a note that says so."""
    from ringwear.meshes import bisection, gmsh_session, triangles

    field = size_field(natural)
    if natural.scene.accuracy.fem.mesher == "bisection":
        return bisection.mesh(field), "bisection", ()
    reason = gmsh_session.unavailable()
    if not reason:
        try:
            return triangles.mesh(field), "gmsh", ()
        except MeshError as error:
            reason = f"gmsh could not follow these sizes ({error})"
    return bisection.mesh(field), "bisection", (f"meshed by bisection: {reason}",)


def degree(natural: NaturalScene) -> int:
    """Degree of the displacement: the one given, else the highest."""
    highest = DEGREES["gmsh"][-1]
    return min(natural.scene.accuracy.fem.degree or highest, highest)
