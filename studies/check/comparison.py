"""What one program gives beside what we give, at its own times and radii."""

from dataclasses import dataclass

from ...meshes.radial import Array
from ..problem.scene import Scene


@dataclass(frozen=True, eq=False)
class Comparison:
    """Results of another program and ours, in the units of the scene.

    Parameters
    ----------
    times : (T,) that it gives
    radii : (R,) that it gives
    theirs, ours : pressure, displacement, profile (T, R), indentation, normal_force (T,), NaN or
        absent where they are not given
    scene : what both are of
    """

    times: Array
    radii: Array
    theirs: dict[str, Array]
    ours: dict[str, Array]
    scene: Scene
