"""Each method as a compliance at a wanted accuracy, with the coarser twins that its error is estimated from.

The estimate compares a result with what the same method gives with one thing made coarser: the highest pressure
bubbles left out, the displacement one degree lower, the last far-field pole clamped. Each twin is far less accurate
than the result; the shares are how much of their difference is counted, and were measured on the bundled scenes.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from ringwear.meshes.compliance import Compliance
from ringwear.meshes.pressure_space import PressureSpace
from ringwear.meshes.radial import Array, graded_breakpoints, layer_degrees
from ringwear.studies.methods.fem import fem_model
from ringwear.studies.methods.model import Model, Twin
from ringwear.studies.problem.problem import NaturalScene
from ringwear.studies.progress import Stages


def mdr_settings(natural: NaturalScene) -> dict[str, float]:
    """Sizes of the MDR's radial mesh at the scene's accuracy."""
    rtol, chosen = natural.scene.accuracy.rtol, natural.scene.accuracy.mdr
    return {
        "degree": chosen.degree or round(3 - np.log10(rtol)),
        "rim_size": chosen.rim_size or 0.1 * rtol,
        "ring_size": chosen.ring_size or 3e-3 * rtol**0.25,
        "grading": chosen.grading or 0.2,
    }


def mdr_space(
    natural: NaturalScene, degree: float, rim_size: float, ring_size: float, grading: float, widest: float = 0.1
) -> PressureSpace:
    """A graded space whose degrees rise away from the singular points.

    A ring narrower than the sizes still gets a layer at each of its edges: none is wider than `widest` of the ring.
    """
    edges, _ = natural.phases
    widths = np.diff(edges)
    at_edges = np.minimum(ring_size, widest * np.minimum(widths[:-1], widths[1:]))
    breakpoints = graded_breakpoints(edges, at_edges, min(rim_size, widest * float(widths[-1])), grading)
    degrees = layer_degrees(breakpoints, edges, int(degree), rise=1, lowest=int(max(1, degree - 5)))
    return PressureSpace(breakpoints, degrees, edges)


def radial_compliance(method: str) -> Callable[[PressureSpace], Compliance]:
    """The method, `mdr` or `bem`, as a compliance on any pressure space."""
    if method == "bem":
        from ringwear.mdr.ring_kernel import compliance
    else:
        from ringwear.mdr.energy import compliance
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
            # also where the ring's width, not the size asked for, set the layer
            twin = mdr_space(natural, **coarser, widest=min(0.1 / layer, 0.5))
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


MODELS: dict[str, Callable[..., Model]] = {"mdr": mdr_model, "bem": bem_model, "fem": fem_model}


def edge_weight(space: PressureSpace, average: str) -> Array:
    """(n, q) weight of a radial average at the quadrature radii of `space`: over the radius, or over the area."""
    radii, _, _ = space.quadrature
    return np.ones_like(radii) if average == "line" else 2 * radii
