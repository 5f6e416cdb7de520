"""Limits on discretisations of layered ground.

Pressure elements are narrow enough for the first layer, and the mesh has lines at the interfaces
between layers.
"""

import numpy as np

from ....meshes.ground.ground import Ground
from ....meshes.pressure_space import PressureSpace
from ..problem.problem import Problem
from ..problem.refusal import Refusal
from ..problem.sections import LAYERED

# Largest width of a pressure element over the thickness of the first layer, which is the length
# over which pressures on it vary (physics/test_layers.py).
MAX_WIDTH_PER_LAYER_THICKNESS = 3.0
# Thickness, in punch radii, below which layers are not meshed.
MIN_MESHED_THICKNESS = 0.01
# Poisson's ratio of a layer above which roundoff matters, and the finest tolerance that finite
# elements reach then.
NEARLY_HALF, FINEST_RTOL_NEARLY_HALF = 0.4999, 1e-5


def narrowed_for_layers(space: PressureSpace, ground: Ground, growth: float = 0.0) -> PressureSpace:
    """Return the space, refined where elements are too wide for the first layer.

    With a `growth` they may be wider by that part of their distance from ring edges: the pressure
    of a fitted start decays from its edges over the thickness of the first layer.
    """
    if not ground.layered:
        return space
    to_edges = np.abs(space.breakpoints[:, None] - space.ring_edges).min(axis=1)
    distances = np.minimum(to_edges[:-1], to_edges[1:])
    thickness = MAX_WIDTH_PER_LAYER_THICKNESS * ground.first_thickness
    return space.no_wider(thickness + growth * distances)


def layers_beyond_meshes(problem: Problem) -> Refusal | None:
    """Return why finite elements cannot solve the layers on any mesh; None if they can."""
    ground = problem.ground
    for number, thickness in enumerate(ground.thicknesses):
        if thickness < MIN_MESHED_THICKNESS:
            return Refusal(
                f"half_space.layers.{number}.thickness is {thickness:.2g} a, and layers thinner "
                f"than {MIN_MESHED_THICKNESS:g} a cannot be meshed",
                "leave fem out of methods",
            )
    if ground.rigid and ground.share < 1:
        return Refusal(
            "half_space.rigid with punch_youngs_modulus: the mesh ends at the rigid base, and the "
            "half-space of an elastic punch needs one that goes on",
            "leave fem out of methods, or use mdr and bem",
        )
    locks = ground.layered and ground.greatest_poisson_ratio > NEARLY_HALF
    if locks and not problem.full_contact:
        return Refusal(
            f"half_space.layers with a Poisson's ratio above {NEARLY_HALF:g} are solved by fem "
            "under flat punches only, because triangles lock",
            "leave fem out of methods, or use mdr and bem",
        )
    if locks and problem.rtol < FINEST_RTOL_NEARLY_HALF:
        return Refusal(
            f"half_space.layers with a Poisson's ratio above {NEARLY_HALF:g} are solved by fem to "
            f"accuracy.rtol = {FINEST_RTOL_NEARLY_HALF:g} at best",
            "give that, or leave fem out of methods",
        )
    return None


def why_layers_are_not_meshed(problem: Problem) -> str:
    """Return why finite elements cannot mesh the layers, with the remedy; empty if they can."""
    if problem.ground.layered and problem.fem.chosen_mesher != "quads":
        return (
            "half_space.layers are meshed in quadrilaterals only: leave out accuracy.fem.mesher, "
            f"and give accuracy.fem.degree = {LAYERED} or more, or neither"
        )
    beyond = layers_beyond_meshes(problem)
    return "" if beyond is None else str(beyond)
