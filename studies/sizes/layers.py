"""What discretisations of layered ground need: narrow elements, and lines at the interfaces."""

from collections.abc import Sequence

from ...meshes.ground.ground import Ground
from ...meshes.pressure_space import PressureSpace
from ..problem.problem import Problem
from ..problem.sections import LAYERED

# greatest width of an element of the pressure over the first layer, whose thickness is the length
# over which pressures on it vary (physics/test_layers.py)
WIDEST_ON_LAYERS = 3.0
# depth of the lowest interface within the mesh over the truncation radius, at most
DEEPEST_LINE = 0.8
# thickness, in punch radii, below which layers are not meshed
THINNEST_MESHED = 0.01
# Poisson's ratio that stands for 1/2 in layers: between stiff neighbours the indentation errs by 6
# to 210 times 1 - 2 nu (physics/test_layers.py)
HIGHEST_POISSON_RATIO = 0.5 - 1e-8
# Poisson's ratio of a layer above which roundoff counts, and the accuracy that it leaves
NEARLY_HALF, FINEST_INCOMPRESSIBLE = 0.4999, 1e-5


def narrow_enough(space: PressureSpace, ground: Ground | None) -> PressureSpace:
    """Return a space whose elements are narrow enough for the first of the layers, if there are."""
    return space if ground is None else space.no_wider(WIDEST_ON_LAYERS * ground.first)


def depths_of_interfaces(problem: Problem) -> tuple[float, ...]:
    """Return the depths of the interfaces, in punch radii; none without layers."""
    return () if problem.ground is None else tuple(problem.ground.depths.tolist())


def truncation_beside(interfaces: Sequence[float], least: float) -> float:
    """Return a truncation radius, at least the one given, that no interface nearly touches.

    Notes
    -----
    A line that meets the arc near the axis would leave a sliver: depths from ``DEEPEST_LINE R`` to
    R make R greater.
    """
    outer = least
    for depth in sorted(interfaces):
        if DEEPEST_LINE * outer < depth < outer:
            outer = depth / DEEPEST_LINE
    return outer


def why_layers_are_not_meshed(problem: Problem) -> str:
    """Return why finite elements cannot have the layers of a problem, with the remedy."""
    ground, fem = problem.ground, problem.fem
    if ground is None:
        return ""
    if not problem.full_contact:
        return (
            "fem meshes half_space.layers under flat punches in full contact only: leave it out of "
            "methods, or give bem beside mdr"
        )
    if fem.chosen_mesher != "quads":
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
    if problem.rtol < FINEST_INCOMPRESSIBLE and ground.greatest_poisson_ratio > NEARLY_HALF:
        return (
            f"half_space.layers with a Poisson's ratio above {NEARLY_HALF:g} are solved by fem to "
            f"accuracy.rtol = {FINEST_INCOMPRESSIBLE:g} at best: give that, or leave fem out of "
            "methods"
        )
    return ""
