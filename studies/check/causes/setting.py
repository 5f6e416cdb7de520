"""What another program may have modelled or printed otherwise."""

from typing import Literal, NamedTuple


class Setting(NamedTuple):
    """What another program has modelled or printed otherwise.

    Parameters
    ----------
    force, stiffness, wear, radius : factors on what is ours
    box : punch radius over the radius of a clamped half-space
    late : time after which its history begins
    step : length of implicit steps in time; below 0 of explicit ones
    ground : what is under the punch; a homogeneous one has the first layer's material
    layer : thickness of the layer over the punch radius, and its modulus over that below
    depth : length by which displacements differ in plane strain, over F / (a E*)
    swapped : whether the two materials of the rings are exchanged
    time, radii : factors on times and radii of its table
    pressure, lengths, normal_force : factors on what is printed
    signs, units : whether quantities have the sign, or the power of a thousand, that suits theirs
    """

    force: float = 1.0
    stiffness: float = 1.0
    wear: float = 1.0
    radius: float = 1.0
    box: float = 0.0
    late: float = 0.0
    step: float = 0.0
    ground: Literal["ours", "homogeneous", "layer", "plane strain"] = "ours"
    layer: tuple[float, float] = (1.0, 1.0)
    depth: float = 0.0
    swapped: bool = False
    time: float = 1.0
    radii: float = 1.0
    pressure: float = 1.0
    lengths: float = 1.0
    normal_force: float = 1.0
    signs: bool = False
    units: bool = False
