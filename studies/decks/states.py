"""What a deck presses on: the punch at a time."""

from dataclasses import dataclass

from ...meshes.radial import Array


@dataclass(frozen=True, eq=False)
class State:
    """A punch at a time, in the units of the scene.

    Parameters
    ----------
    time : when
    indentation : of the plane of the unworn face
    force : the normal force
    heights : (n,) material that is missing at the radii of the contact nodes
    """

    time: float
    indentation: float
    force: float
    heights: Array

    @property
    def lowest(self) -> float:
        """The least height, of the part of the face that is foremost."""
        return float(self.heights.min())

    @property
    def pressing_depth(self) -> float:
        """The depth of the foremost part of the face."""
        return self.indentation - self.lowest
