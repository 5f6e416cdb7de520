"""The settings in which another program may differ from the scene."""

from collections.abc import Callable
from itertools import product
from typing import Literal, NamedTuple

import numpy as np

from ...crosscheck import Scene

# layers that are computed: thickness over the punch radius, and modulus over that of the half-space
# below; other layers are interpolated
THICKNESSES = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)
STIFFNESSES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)


class SceneChange(NamedTuple):
    """A changed scene, which the other program has solved.

    Parameters
    ----------
    change : returns the scene that is changed by a size
    size : of the change
    nodes : increasing sizes for which the changed scene is solved; results of sizes between them
        are interpolated in the logarithm of the size; empty if every size is solved
    points : number of nodes that are used for one interpolation
    """

    change: Callable[[Scene, float], Scene]
    size: float
    nodes: tuple[float, ...] = ()
    points: int = 2


class Setting(NamedTuple):
    """What another program has modelled or printed differently from the scene.

    The defaults describe a program without any mistake.

    Parameters
    ----------
    force, stiffness, wear, radius : factors on the values of the scene
    truncation : punch radius over the radius at which the half-space is clamped; 0 if it is not
    start_delay : time at which its history begins, in the units of the scene
    step : length of its implicit time steps of first order; below 0: of explicit steps
    ground : what is under the punch; "homogeneous" has the material of the first layer
    layer : thickness of the layer over the punch radius, and its modulus over that of the
        half-space below
    depth_offset : constant that is added to displacements in plane strain, over F / (a E*)
    swapped : whether the two materials of the rings are exchanged
    table_time, table_radii : factors that turn the times and radii of its table into ours
    pressure, lengths, normal_force : factors on the printed quantities
    signs : whether each quantity takes the sign that fits its results best
    units : whether each kind of quantity, or each column alone, takes the power of a thousand that
        fits its results best; empty if none does
    column : name of a quantity, and a factor on it alone
    rim : part of the radius by which a coarse mesh makes the punch seem greater at the start, and
        relative error of the first pressures next to the rim
    scene_change : a change of the scene that no other field describes; None if there is none
    """

    force: float = 1.0
    stiffness: float = 1.0
    wear: float = 1.0
    radius: float = 1.0
    truncation: float = 0.0
    start_delay: float = 0.0
    step: float = 0.0
    ground: Literal["ours", "homogeneous", "layer", "plane strain"] = "ours"
    layer: tuple[float, float] = (1.0, 1.0)
    depth_offset: float = 0.0
    swapped: bool = False
    table_time: float = 1.0
    table_radii: float = 1.0
    pressure: float = 1.0
    lengths: float = 1.0
    normal_force: float = 1.0
    signs: bool = False
    units: Literal["", "kinds", "columns"] = ""
    column: tuple[str, float] = ("", 1.0)
    rim: tuple[float, float] = (0.0, 0.0)
    scene_change: SceneChange | None = None


def computed_settings(setting: Setting) -> list[tuple[Setting, float]]:
    """Return the settings whose histories are computed, with their weights in a setting's history.

    Layers are interpolated linearly in the logarithms of thickness and modulus.
    """
    layers = [(setting.layer, 1.0)]
    if setting.ground == "layer":
        layers = [
            ((thickness, stiffness), first * second)
            for (thickness, first), (stiffness, second) in product(
                _neighbours(setting.layer[0], THICKNESSES),
                _neighbours(setting.layer[1], STIFFNESSES),
            )
        ]
    changes: list[tuple[SceneChange | None, float]] = [(setting.scene_change, 1.0)]
    if (change := setting.scene_change) and change.nodes:
        changes = [
            (None if node == 1 else change._replace(size=node), weight)
            for node, weight in _neighbours(change.size, change.nodes, change.points)
        ]
    return [
        (setting._replace(layer=layer, scene_change=node), layer_weight * weight)
        for (layer, layer_weight), (node, weight) in product(layers, changes)
        if layer_weight and weight
    ]


def _neighbours(
    size: float, sizes: tuple[float, ...], points: int = 2
) -> list[tuple[float, float]]:
    """Return the computed sizes around a size, each with its weight in Lagrange's interpolation."""
    count = min(points, len(sizes))
    first = int(np.searchsorted(sizes, size)) - count // 2
    first = min(max(first, 0), len(sizes) - count)
    nodes = sizes[first : first + count]
    distances = np.log(nodes) - np.log(np.clip(size, sizes[0], sizes[-1]))
    weights = [
        float(np.prod([other / (other - own) for other in distances if other != own]))
        for own in distances
    ]
    return list(zip(nodes, weights, strict=True))
