"""Limits on discretisations of layered ground.

Pressure elements are narrow enough for the first layer, and the mesh has lines at the interfaces
between layers.
"""

from collections.abc import Sequence

from ...meshes.ground.ground import Ground
from ...meshes.pressure_space import PressureSpace
from ..problem.problem import Problem
from ..problem.sections import LAYERED

# Largest width of a pressure element over the thickness of the first layer, which is the length
# over which pressures on it vary (physics/test_layers.py).
MAX_WIDTH_PER_LAYER_THICKNESS = 3.0
# Largest depth of an interface within the mesh over the truncation radius.
MAX_INTERFACE_DEPTH = 0.8
# Thickness, in punch radii, below which layers are not meshed.
MIN_MESHED_THICKNESS = 0.01
# Poisson's ratio that replaces 1/2 in layers. Between stiff neighbours, the relative error of the
# indentation is 6 to 210 times 1 - 2 nu (physics/test_layers.py).
HIGHEST_POISSON_RATIO = 0.5 - 1e-8
# Poisson's ratio of a layer above which roundoff matters, and the finest tolerance that finite
# elements reach then.
NEARLY_HALF, FINEST_RTOL_NEARLY_HALF = 0.4999, 1e-5


def narrowed_for_layers(space: PressureSpace, ground: Ground | None) -> PressureSpace:
    """Return the space, refined where elements are too wide for the first layer."""
    return space if ground is None else space.no_wider(MAX_WIDTH_PER_LAYER_THICKNESS * ground.first)


def depths_of_interfaces(problem: Problem) -> tuple[float, ...]:
    """Return the depths of the interfaces between layers, in punch radii; empty without layers."""
    return () if problem.ground is None else tuple(problem.ground.depths.tolist())


def truncation_with_interfaces(interfaces: Sequence[float], min_radius: float) -> float:
    """Return the truncation radius that is large enough to avoid slivers at interfaces.

    Parameters
    ----------
    interfaces : depths of the interfaces, in punch radii
    min_radius : smallest truncation radius, in punch radii

    Notes
    -----
    An interface that meets the outer arc near the axis would leave a sliver between them. The
    radius R is therefore increased until no interface is between ``MAX_INTERFACE_DEPTH R`` and R.
    """
    outer = min_radius
    for depth in sorted(interfaces):
        if MAX_INTERFACE_DEPTH * outer < depth < outer:
            outer = depth / MAX_INTERFACE_DEPTH
    return outer


def why_layers_are_not_meshed(problem: Problem) -> str:
    """Return why finite elements cannot mesh the layers, with the remedy; empty if they can."""
    ground, fem = problem.ground, problem.fem
    if ground is None:
        return ""
    if not problem.full_contact:
        return (
            "fem meshes half_space.layers under flat punches in full contact only: leave fem out "
            "of methods, or use mdr and bem"
        )
    if fem.meshed_by != "quads":
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
    if problem.rtol < FINEST_RTOL_NEARLY_HALF and ground.greatest_poisson_ratio > NEARLY_HALF:
        return (
            f"half_space.layers with a Poisson's ratio above {NEARLY_HALF:g} are solved by fem to "
            f"accuracy.rtol = {FINEST_RTOL_NEARLY_HALF:g} at best: give that, or leave fem out of "
            "methods"
        )
    return ""
