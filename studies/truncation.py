"""Truncation: the error of the outer boundary of the mesh over its radius, for every far field.

Theory: with n poles, the first neglected pole decays as ``1/rho^(2n+1)``, and its energy outside R
as ``(a/R)^(4n+1)``. Hence the order is 1, 5, 9, 13 for a clamped boundary and for one, two, three
poles. The next pole adds a term that is smaller by ``(a/R)^2``; levels therefore begin at R = 4 a.
Far below layers, the field on an elastic substrate is that of a homogeneous half-space, so that the
orders are the same. On a rigid base the errors decay exponentially with R over its depth.
"""

from collections.abc import Sequence
from dataclasses import replace

from ..meshes import Ground
from .crosscheck import Source, numbers
from .study.declared import Declared, conduct
from .study.own import accept
from .study.record import Record
from .study.study import Study
from .study.way import Case
from .study.ways.truncated import exact_disc, far_fields

RADII = {
    False: (4, 5, 6, 7, 8, 11, 16, 32, 128, 1024),
    True: (1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 7.0, 10.0, 16.0),
}
"""Truncation radii in punch radii, so that the size a/R decreases, by whether there are layers."""
RATIOS = (0.3, 0.0, 0.4999, 0.5)
"""Poisson's ratios that are tested besides that of the scene."""
QUICK_RADII, QUICK_RATIOS = 5, 1
"""Numbers of radii and ratios of the quick study, from the first on."""


def truncation(
    scene: Source = "five_rings",
    *,
    radii: Sequence[float] = (),
    quick: bool = False,
    record: Record | None = None,
) -> Study:
    """Tell how far away the outer boundary of the mesh must be, for each far field.

    Parameters
    ----------
    scene : a scene, of which the ground counts; the punch is flat, of one ring and the radius 1
    radii : truncation radii in punch radii, increasing
    quick : whether to use fewer radii and Poisson's ratios
    record : rows so far, and the file that they are written to

    Raises
    ------
    SceneError
        if the scene or an option does not fit the study
    """
    scene = accept("truncation", scene, layered=True)
    ground, chosen = scene.problem.ground, tuple(numbers("radii", radii))
    problem = replace(Case.of(scene).with_one_ring().problem, ground=ground)
    if ground.layered:
        cases = [Case("layers", None, problem)]
    else:
        tested = RATIOS[: QUICK_RATIOS if quick else None]
        cases = [
            Case(f"nu = {ratio:g}", None, replace(problem, ground=Ground.half_space(ratio)), ratio)
            for ratio in sorted({problem.poisson_ratio, *tested})
        ]
    ways = far_fields(chosen or RADII[ground.layered][: QUICK_RADII if quick else None], ground)

    declared = Declared(
        *("truncation", "how far away must the outer boundary be?", scene, cases),
        *(lambda _: ways, ("indentation",), exact_disc, "reach"),
    )
    return conduct(declared, record, quick)
