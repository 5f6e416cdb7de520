"""Stars of quadrilaterals with triangles between them at a wanted accuracy (hp): the degree grows with it.

In d0, indentations and steady states the error falls about tenfold with each degree, and keeps its sign: the twin one
degree lower tells it reliably.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from meshes.compliance import Compliance

from .model import Twin
from .natural import NaturalScene
from .scene import DEGREES
from .triangles import edge_sizes

if TYPE_CHECKING:
    from fem.compliance import HalfSpace
    from meshes.stars import StarMesh

# shells shrink by this, triangles between the stars grow by that
GRADING, GROWTH = 0.25, 0.8
NEARLY_INCOMPRESSIBLE = 0.4


@dataclass(frozen=True)
class StarSettings:
    """Degree of the displacement, and sizes of the cores of the stars in punch radii."""

    degree: int
    sizes: tuple[float, ...]
    rim_size: float
    growth: float


def settings(natural: NaturalScene) -> StarSettings:
    """Degree and sizes at the scene's accuracy."""
    rtol, chosen = natural.scene.accuracy.rtol, natural.scene.accuracy.fem
    edges, _ = natural.phases
    sizes = np.full(len(edges) - 2, chosen.ring_size) if chosen.ring_size else edge_sizes(natural)
    return StarSettings(
        degree=chosen.degree or _degree(rtol, starts=bool((natural.times == 0).any())),
        sizes=tuple(float(size) for size in sizes),
        rim_size=chosen.rim_size or 0.1 * rtol,
        growth=chosen.growth or GROWTH,
    )


def _degree(rtol: float, starts: bool) -> int:
    """Ten times the accuracy for each degree; one more for the nearly singular pressure at the start, if asked for."""
    lowest, highest = DEGREES["stars"][0], DEGREES["stars"][-1]
    return min(max(lowest, round(1 - np.log10(rtol))) + starts, highest)


def lowest_degree(natural: NaturalScene) -> int:
    """Degree at singular points: the least that goes with a stable linear pressure, and does not lock.

    Of degree 3, near incompressibility, errors were up to 3 times what the twin told, and of degree 4 half of it.
    """
    return 4 if natural.scene.half_space.poisson_ratio > NEARLY_INCOMPRESSIBLE else 3


def star_mesh(natural: NaturalScene) -> StarMesh:
    """The mesh of the scene."""
    from meshes.stars import mesh

    chosen, truncation = settings(natural), natural.scene.accuracy.fem.truncation
    return mesh(natural.phases[0], chosen.sizes, chosen.rim_size, GRADING, chosen.growth, truncation)


def half_space(natural: NaturalScene, mesh: StarMesh, poles: tuple[int, ...]) -> HalfSpace:
    """The half-space on stars and the triangles between them."""
    from fem.compliance import HalfSpace
    from fem.hp import HpElasticity

    nu = natural.scene.half_space.poisson_ratio
    solid = HpElasticity(mesh, settings(natural).degree, nu, lowest_degree(natural))
    return HalfSpace(solid, solid.pressure_space(natural.phases[0]), poles)


def twins(natural: NaturalScene, whole: HalfSpace, fine: Compliance) -> list[Twin]:
    """Everything one degree lower: displacement and pressure; and the pressure alone."""
    from fem.hp import HpElasticity

    assert isinstance(whole.solid, HpElasticity)
    lower = whole.solid.coarser()
    coarser = replace(whole, solid=lower, space=lower.pressure_space(natural.phases[0])).compliance()
    return [
        Twin("pressure space", fine, fine.coarser(), 0.05, 0.5),
        Twin("discretisation", fine, coarser, 0.5, 2.0, other_mesh=True),
    ]
