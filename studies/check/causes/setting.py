"""The settings in which another program may differ from the scene."""

from typing import Literal, NamedTuple


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
    signs, units : whether each quantity takes the sign, or the power of a thousand, that fits its
        results best
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
    units: bool = False
