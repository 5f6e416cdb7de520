"""Predict what a run needs, or the longest stable update of another program on its own mesh."""

from pathlib import Path
from typing import TYPE_CHECKING

from ...meshes import SceneError
from ..crosscheck import (
    Scene,
    Source,
    naming_arguments,
    numbers,
    plan_run,
)
from ..study.own import element_named, length_of, read_meshes

if TYPE_CHECKING:
    from skfem import Mesh

SIZES = (1e-3, 1.0)
"""Least and greatest size of elements on the contact, in punch radii."""


@naming_arguments
def plan(
    source: Source,
    memory: float | None = None,
    size: float | None = None,
    element: str | None = None,
    mesh: "str | Path | Mesh | None" = None,
    units: str = "",
) -> list[str]:
    """Predict what a run needs, or the longest stable update of wear on the mesh of a program.

    Programs that update the worn profile explicitly, ``f += k v p dt`` at the nodes of a mesh, are
    stable up to a step that is proportional to the size of the elements. Longer steps show as a
    sawtooth of the pressure from node to node.

    Parameters
    ----------
    source : Scene, str, Path or dict
        The scene that would be computed.
    memory : float, optional
        Largest memory that a run may use, in GiB; by default that of the machine.
    size : float, optional
        Size of the elements on the contact of another program, in the units of the scene: the
        longest stable step is given for such a mesh, and the range for meshes of that size.
    element : str, optional
        Its elements: P1 or P2 on triangles, Q1, Q2 or Q2S (eight nodes) on quadrilaterals; by
        default Q1, or P1 on triangles of a file.
    mesh : str, Path or Mesh, optional
        The mesh of the other program: the longest stable step is that of this very mesh.
    units : str, optional
        The unit of lengths in the file of the mesh, such as "mm", or a factor on them, such as 0.1,
        if they are not in the units of the scene.

    Returns
    -------
    list of str
        Lines of text: unknowns, seconds, memory, refusals and notes of a run; or the mesh, the
        longest stable step in a line that begins with ``stable``, and the recommended one.

    Examples
    --------
    >>> lines = plan("flat_punch", size=0.1)
    >>> print(lines[1][:43])
    stable: at most a sliding distance of 0.175
    """
    scene = Scene.of(source)
    if units and mesh is None:
        raise SceneError("units are those of the mesh of another program: give mesh, too")
    if size is None and mesh is None:
        if element is not None:
            raise SceneError("element is about the mesh of another program: give size or mesh, too")
        return plan_run(scene, memory)
    if size is not None and mesh is not None:
        raise SceneError("size and mesh are two ways to describe a mesh: give one of them")
    # they load scikit-fem, which the plan of a run does not need
    from .limits import describe, limits_of_size, limits_on_mesh

    problem = scene.problem
    if mesh is not None:
        (found,) = read_meshes(problem, [mesh], length_of(scene, units)).values()
        usual = "P1" if found.t.shape[0] == 3 else "Q1"
        return describe([limits_on_mesh(scene, found, element_named(element or usual))])
    if problem.ground.layered:
        raise SceneError(
            "size: meshes of a size are made for a homogeneous half-space only: with "
            "half_space.layers give mesh, a file whose elements do not cross the interfaces"
        )
    (given,) = numbers("size", [size])
    part = given / problem.units.length
    if not SIZES[0] <= part <= SIZES[1]:
        least, most = (f"{share * problem.units.length:.4g}" for share in SIZES)
        raise SceneError(
            f"size = {given:g}: give the size of the elements on the contact in the units of the "
            f"scene, {least} to {most}"
        )
    return describe(limits_of_size(scene, part, element_named(element or "Q1")))
