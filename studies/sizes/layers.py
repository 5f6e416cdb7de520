"""Limits on discretisations of layered ground.

Pressure elements are narrow enough for the first layer, and the mesh has lines at the interfaces
between layers.
"""

from ...meshes.ground.ground import Ground
from ...meshes.pressure_space import PressureSpace
from ..problem.problem import Problem
from ..problem.sections import LAYERED

# Largest width of a pressure element over the thickness of the first layer, which is the length
# over which pressures on it vary (physics/test_layers.py).
MAX_WIDTH_PER_LAYER_THICKNESS = 3.0
# Thickness, in punch radii, below which layers are not meshed.
MIN_MESHED_THICKNESS = 0.01
# Poisson's ratio of a layer above which roundoff matters, and the finest tolerance that finite
# elements reach then.
NEARLY_HALF, FINEST_RTOL_NEARLY_HALF = 0.4999, 1e-5


def narrowed_for_layers(space: PressureSpace, ground: Ground | None) -> PressureSpace:
    """Return the space, refined where elements are too wide for the first layer."""
    if ground is None:
        return space
    return space.no_wider(MAX_WIDTH_PER_LAYER_THICKNESS * ground.first_thickness)


def depths_of_interfaces(problem: Problem) -> tuple[float, ...]:
    """Return the depths of the interfaces between layers, in punch radii; empty without layers."""
    return () if problem.ground is None else tuple(problem.ground.depths.tolist())


def why_layers_are_not_meshed(problem: Problem) -> str:
    """Return why finite elements cannot mesh the layers, with the remedy; empty if they can."""
    ground, fem = problem.ground, problem.fem
    if ground is None:
        return ""
    if fem.chosen_mesher != "quads":
        return (
            "half_space.layers are meshed in quadrilaterals only: leave out accuracy.fem.mesher, "
            f"and give accuracy.fem.degree = {LAYERED} or more, or neither"
        )
    for number, thickness in enumerate(ground.thicknesses):
        if thickness < MIN_MESHED_THICKNESS:
            return (
                f"half_space.layers.{number}.thickness is {thickness:.2g} a, and layers thinner "
                f"than {MIN_MESHED_THICKNESS:g} a cannot be meshed: leave fem out of methods"
            )
    if ground.greatest_poisson_ratio > NEARLY_HALF and not problem.full_contact:
        return (
            f"half_space.layers with a Poisson's ratio above {NEARLY_HALF:g} are solved by fem "
            "under flat punches only, because triangles lock: leave fem out of methods, or use "
            "mdr and bem"
        )
    if problem.rtol < FINEST_RTOL_NEARLY_HALF and ground.greatest_poisson_ratio > NEARLY_HALF:
        return (
            f"half_space.layers with a Poisson's ratio above {NEARLY_HALF:g} are solved by fem to "
            f"accuracy.rtol = {FINEST_RTOL_NEARLY_HALF:g} at best: give that, or leave fem out of "
            "methods"
        )
    return ""
