"""Each method as a compliance at a wanted accuracy, with the coarser twins that its error is estimated from.

The estimate compares a result with what the same method gives with one thing made coarser: the highest pressure
bubbles left out, the displacement one degree lower, the last far-field pole clamped. Each twin is far less accurate
than the result; the shares are how much of their difference is counted, and were measured on the bundled scenes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from meshes.compliance import Compliance
from meshes.errors import MeshError
from meshes.half_space import HalfSpaceMesh, SizeField
from meshes.pressure_space import PressureSpace
from meshes.radial import Array, graded_breakpoints, layer_degrees

from .natural import NaturalScene
from .stages import Stages

if TYPE_CHECKING:
    from fem.compliance import HalfSpace


@dataclass(frozen=True, eq=False)
class Twin:
    """A pair whose difference estimates one part of the error.

    Parameters
    ----------
    part : what differs
    finer, coarser : the pair
    share : how much of the difference is counted for indentations, which converge twice as fast
    field_share : the same for everything else
    """

    part: str
    finer: Compliance
    coarser: Compliance
    share: float
    field_share: float


@dataclass(frozen=True, eq=False)
class Model:
    """A method made ready for a scene.

    Parameters
    ----------
    compliance : on the method's own pressure space
    twins : for the error estimate
    unknowns : size of the system behind the compliance
    settings : the sizes chosen, for the summary
    half_space : the finite-element half-space, if there is one
    notes : remarks for the summary, such as a mesher replaced
    """

    compliance: Compliance
    twins: tuple[Twin, ...]
    unknowns: int
    settings: dict[str, object]
    half_space: HalfSpace | None = None
    notes: tuple[str, ...] = ()

    @property
    def rim_size(self) -> float:
        """Size of the element at the rim."""
        return float(np.diff(self.compliance.space.breakpoints)[-1])


def mdr_settings(natural: NaturalScene) -> dict[str, float]:
    """Sizes of the MDR's radial mesh at the scene's accuracy."""
    rtol, chosen = natural.scene.accuracy.rtol, natural.scene.accuracy.mdr
    return {
        "degree": chosen.degree or round(3 - np.log10(rtol)),
        "rim_size": chosen.rim_size or 0.1 * rtol,
        "ring_size": chosen.ring_size or 3e-3 * rtol**0.25,
        "grading": chosen.grading or 0.2,
    }


def mdr_space(natural: NaturalScene, degree: float, rim_size: float, ring_size: float, grading: float) -> PressureSpace:
    """A graded space whose degrees rise away from the singular points."""
    edges, _ = natural.phases
    # a ring narrower than the sizes still gets a layer at each of its edges
    widths = np.diff(edges)
    at_edges = np.minimum(ring_size, 0.1 * np.minimum(widths[:-1], widths[1:]))
    breakpoints = graded_breakpoints(edges, at_edges, min(rim_size, 0.1 * float(widths[-1])), grading)
    degrees = layer_degrees(breakpoints, edges, int(degree), rise=1, lowest=int(max(1, degree - 5)))
    return PressureSpace(breakpoints, degrees, edges)


def radial_compliance(method: str) -> Callable[[PressureSpace], Compliance]:
    """The method, `mdr` or `bem`, as a compliance on any pressure space."""
    if method == "bem":
        from mdr.bem import compliance
    else:
        from mdr.compliance import compliance
    return compliance


def radial_model(method: str, natural: NaturalScene, stages: Stages, twins: bool = True) -> Model:
    """Compliance by `mdr` or `bem`; its twin has one layer less at every singular point, and one degree less."""
    compliance = radial_compliance(method)
    settings = mdr_settings(natural)
    with stages("assembling"):
        fine = compliance(mdr_space(natural, **settings))
    made = []
    if twins:
        with stages("estimating"):
            layer = settings["grading"]
            coarser = {"degree": max(1, settings["degree"] - 1), "grading": layer}
            coarser |= {name: min(settings[name] / layer, 0.5) for name in ("rim_size", "ring_size")}
            twin = mdr_space(natural, **coarser)
            if settings["degree"] > 2 and len(twin.breakpoints) < len(fine.space.breakpoints):
                made.append(Twin("pressure space", fine, compliance(twin), 0.3, 2.0))
            else:
                # nothing is left to coarsen: the twin is finer, and the difference the error itself
                narrow = 0.1 * float(np.diff(natural.phases[0]).min())
                richer = {"degree": settings["degree"] + 1, "grading": layer}
                richer |= {name: layer * min(settings[name], narrow) for name in ("rim_size", "ring_size")}
                made.append(Twin("pressure space", compliance(mdr_space(natural, **richer)), fine, 1.5, 2.0))
    return Model(fine, tuple(made), fine.space.size, dict(settings))


def mdr_model(natural: NaturalScene, stages: Stages, twins: bool = True) -> Model:
    """Compliance by the MDR energy."""
    return radial_model("mdr", natural, stages, twins)


def bem_model(natural: NaturalScene, stages: Stages, twins: bool = True) -> Model:
    """Compliance by the ring kernel."""
    return radial_model("bem", natural, stages, twins)


def size_field(natural: NaturalScene) -> SizeField:
    """Element sizes of the half-space at the scene's accuracy."""
    rtol, chosen = natural.scene.accuracy.rtol, natural.scene.accuracy.fem
    edges, _ = natural.phases
    widths = np.diff(edges)
    narrower = np.minimum(widths[:-1], widths[1:])
    # in proportion to the narrower ring beside each edge, and less so where rings are so narrow that their pattern has
    # little of the energy; in few distinct values, which is what a mesher digests
    share = np.minimum(10 * rtol**0.6 * np.maximum(1, 1 / (32 * narrower)), 0.25)
    # wear blunts a ring edge over a length of k E* v0 t: the first time asked for is the sharpest to resolve
    later = natural.times[natural.times > 0]
    blunted = max(0.5 * float(later[0]), rtol**0.75) if len(later) else 1.0
    at_edges = 2.0 ** np.floor(np.log2(np.minimum(share, blunted / narrower) * narrower))
    return SizeField(
        edges=tuple(float(edge) for edge in edges),
        rim_size=chosen.rim_size or min(0.1 * rtol, float(widths[-1]) / 4),
        ring_size=chosen.ring_size or tuple(float(size) for size in at_edges),
        growth=chosen.growth or min(0.7 * (rtol / 1e-4) ** 0.115, 0.9),
        truncation=chosen.truncation,
        centre_size=min(0.2 * (rtol / 1e-4) ** 0.115, 0.5),
    )


def half_space_mesh(natural: NaturalScene) -> tuple[HalfSpaceMesh, tuple[str, ...]]:
    """The mesh by the mesher asked for; by bisection where gmsh cannot be used, with a note that says so."""
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


def fem_model(natural: NaturalScene, stages: Stages, twins: bool = True) -> Model:
    """Compliance by condensing the finite-element half-space."""
    from fem.compliance import MULTIPLIER_DEGREE, HalfSpace, pressure_space
    from fem.condensation import solver
    from fem.elasticity import AxisymmetricElasticity

    chosen = natural.scene.accuracy.fem
    nu = natural.scene.half_space.poisson_ratio
    fixed = chosen.far_field == "fixed"
    poles = tuple(range(0, 2 * chosen.poles, 2))
    edges, _ = natural.phases
    with stages("meshing"):
        mesh, notes = half_space_mesh(natural)
    with stages("assembling"):
        space = pressure_space(mesh, edges, MULTIPLIER_DEGREE[chosen.degree])
        half_space = HalfSpace(AxisymmetricElasticity(mesh, chosen.degree, nu), space, poles)
        _ = half_space.system
    with stages("condensing"):
        tied = half_space.compliance()
        # the last rows of the factor belong to the poles: without them the outer boundary is clamped
        fine = replace(tied, factor=tied.factor[: -len(poles)]) if fixed else tied
    made = []
    if twins:
        with stages("estimating"):
            made = _fem_twins(half_space, tied, size_field(natural).growth)
            if fixed:
                made = [twin for twin in made if twin.part != "truncation"] + [Twin("truncation", tied, fine, 1.1, 1.1)]
    if fixed:
        # displacements and stresses inside are those of the clamped half-space, too
        half_space = replace(half_space, poles=())
    settings = {
        "mesher": mesh.mesher, "triangles": len(mesh.triangles), "degree": chosen.degree, "multipliers": space.size,
        "far_field": chosen.far_field, "poles": len(half_space.poles), "truncation": chosen.truncation,
        "solver": solver(),
    }  # fmt: skip
    return Model(fine, tuple(made), half_space.unknowns, settings, half_space, notes)


def _fem_twins(half_space: HalfSpace, fine: Compliance, growth: float) -> list[Twin]:
    """The pressure, the displacement and the far field, each one degree or one pole coarser.

    On finer meshes one degree less costs ever more accuracy: of the difference in an indentation, a smaller share
    remains. The power fits scenes drawn at random (`random_scenes`) from growth 0.3 to 0.9.
    """
    from fem.compliance import HalfSpace as Whole
    from fem.elasticity import AxisymmetricElasticity

    solid, poles = half_space.solid, half_space.poles
    coarser = fine.coarser()
    remains = min(1.0, (growth / 0.75) ** 3)
    twins = [Twin("pressure space", fine, coarser, 1.2 * remains, 5.0)] if fine.space.top > 1 else []
    twins.append(Twin("truncation", fine, replace(fine, factor=fine.factor[:-1]), 0.1, 0.1))

    def with_degree(degree: int, space: PressureSpace) -> Compliance:
        return Whole(AxisymmetricElasticity(solid.mesh, degree, solid.given_ratio), space, poles).compliance()

    if solid.degree == 2:
        # no stable multipliers go with a lower degree, so the twin is finer, and the difference the error itself
        twins.append(Twin("discretisation", with_degree(3, fine.space), fine, 1.2, 3.0))
    else:
        twins.append(Twin("discretisation", coarser, with_degree(solid.degree - 1, coarser.space), 0.6 * remains, 1.0))
    return twins


MODELS: dict[str, Callable[..., Model]] = {"mdr": mdr_model, "bem": bem_model, "fem": fem_model}


def edge_weight(space: PressureSpace, average: str) -> Array:
    """(n, q) weight of a radial average at the quadrature radii of `space`: over the radius, or over the area."""
    radii, _, _ = space.quadrature
    return np.ones_like(radii) if average == "line" else 2 * radii
