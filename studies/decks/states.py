"""What a deck presses on: the flat start and worn faces, as MDR computes them."""

from collections.abc import Sequence
from dataclasses import dataclass

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..crosscheck.run import run
from ..problem.scene import Scene

METHOD = "mdr"
"""The method whose faces are written: the fewest that suffice, exact in time where possible."""


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


def states(scene: Scene, times: Sequence[float], radii: Array) -> list[State]:
    """Return the punch at some times, to the accuracy of the scene.

    Parameters
    ----------
    times : increasing, in the units of the scene
    radii : (n,) increasing, in the units of the scene

    Raises
    ------
    SceneError
        if nothing presses at one of the times
    """
    wanted = ["profile", "indentation", "normal_force"]
    asked = scene.changed(
        wear={"times": list(times), "steady": False},
        output={"radii": radii.tolist(), "quantities": wanted},
    )
    table = run(asked, [METHOD]).table.variables
    if "normal_force" in table:
        forces = table["normal_force"][1][0]
    else:
        problem = asked.problem
        forces = problem.loading.at(problem.times).force * problem.units.force
    for time, force in zip(times, forces, strict=True):
        if not force > 0:
            raise SceneError(f"--time {time:g}: nothing presses then; give other times")
    rows = zip(times, table["indentation"][1][0], forces, table["profile"][1][0], strict=True)
    return [
        State(time, float(depth), float(force), heights) for time, depth, force, heights in rows
    ]
