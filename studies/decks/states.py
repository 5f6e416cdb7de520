"""The state of the punch at one time, which a deck presses on the half-space."""

from dataclasses import dataclass

from ...meshes import Array


@dataclass(frozen=True, eq=False)
class State:
    """The punch at one time, in the units of the scene.

    Parameters
    ----------
    time : since sliding began
    indentation : of the plane of the unworn face
    force : normal force
    heights : (n,) height that is missing from the plane of the face, at the radii of the n contact
        nodes
    """

    time: float
    indentation: float
    force: float
    heights: Array

    @property
    def lowest(self) -> float:
        """The least missing height, at the foremost point of the face."""
        return float(self.heights.min())

    @property
    def pressing_depth(self) -> float:
        """The depth of the foremost point of the face."""
        return self.indentation - self.lowest
