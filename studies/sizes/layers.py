"""What discretisations of layered ground need: narrow elements, and lines at the interfaces."""

from ...meshes.ground.ground import Ground
from ...meshes.pressure_space import PressureSpace
from ..problem.problem import Problem
from ..problem.sections import LAYERED

# greatest width of an element of the pressure over the first layer, whose thickness is the length
# over which pressures on it vary (physics/test_layers.py)
WIDEST_ON_LAYERS = 3.0
# thickness, in punch radii, below which layers are not meshed
THINNEST_MESHED = 0.01
# Poisson's ratio of a layer above which roundoff counts, and the accuracy that it leaves
NEARLY_HALF, FINEST_INCOMPRESSIBLE = 0.4999, 1e-5


def narrow_enough(space: PressureSpace, ground: Ground | None) -> PressureSpace:
    """Return a space whose elements are narrow enough for the first of the layers, if there are."""
    return space if ground is None else space.no_wider(WIDEST_ON_LAYERS * ground.first_thickness)


def depths_of_interfaces(problem: Problem) -> tuple[float, ...]:
    """Return the depths of the interfaces, in punch radii; none without layers."""
    return () if problem.ground is None else tuple(problem.ground.depths.tolist())


def why_layers_are_not_meshed(problem: Problem) -> str:
    """Return why finite elements cannot have the layers of a problem, with the remedy."""
    ground, fem = problem.ground, problem.fem
    if ground is None:
        return ""
    if fem.meshed_by != "quads":
        return (
            "half_space.layers are meshed in quadrilaterals only: leave out accuracy.fem.mesher, "
            f"and give accuracy.fem.degree = {LAYERED} or more, or neither"
        )
    for number, thickness in enumerate(ground.thicknesses):
        if thickness < THINNEST_MESHED:
            return (
                f"half_space.layers.{number}.thickness is {thickness:.2g} a, and layers thinner "
                f"than {THINNEST_MESHED:g} a cannot be meshed: leave fem out of methods"
            )
    if ground.greatest_poisson_ratio > NEARLY_HALF and not problem.full_contact:
        return (
            f"half_space.layers with a Poisson's ratio above {NEARLY_HALF:g} are solved by fem "
            "under flat punches only, because triangles lock: leave fem out of methods, or give "
            "bem beside mdr"
        )
    if problem.rtol < FINEST_INCOMPRESSIBLE and ground.greatest_poisson_ratio > NEARLY_HALF:
        return (
            f"half_space.layers with a Poisson's ratio above {NEARLY_HALF:g} are solved by fem to "
            f"accuracy.rtol = {FINEST_INCOMPRESSIBLE:g} at best: give that, or leave fem out of "
            "methods"
        )
    return ""
