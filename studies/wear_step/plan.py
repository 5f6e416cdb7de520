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
from ..study.own import read_meshes
from .contact_nodes import CONSISTENT, PER_NODE, element_named
from .limits import STEP_ERROR, StepLimits, limits_of_size, limits_on_mesh, sides_of

if TYPE_CHECKING:
    from skfem import Mesh

RECOMMENDED = 0.5
"""Recommended step over the longest stable one: pressures then err by 1 to 4 % (`ringwear study
march`)."""
SIZES = (1e-3, 1.0)
"""Least and greatest size of elements on the contact, in punch radii."""
LOCKING = 0.45
"""Poisson's ratio above which the note on locking is added."""


@naming_arguments
def plan(
    source: Source,
    memory: float | None = None,
    size: float | None = None,
    element: str | None = None,
    mesh: "str | Path | Mesh | None" = None,
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

    Returns
    -------
    list of str
        Lines of text: unknowns, seconds, memory, refusals and notes of a run; or the mesh, the
        longest stable step in a line that begins with ``stable``, and steps of a given accuracy.

    Examples
    --------
    >>> lines = plan("flat_punch", size=0.1)
    >>> print(lines[1][:43])
    stable: at most a sliding distance of 0.175
    """
    scene = Scene.of(source)
    if size is None and mesh is None:
        if element is not None:
            raise SceneError("element is about the mesh of another program: give size or mesh, too")
        return plan_run(scene, memory)
    if size is not None and mesh is not None:
        raise SceneError("size and mesh are two ways to describe a mesh: give one of them")
    problem = scene.problem
    if mesh is not None:
        (found,) = read_meshes(problem, [mesh]).values()
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


def describe(found: list[StepLimits]) -> list[str]:
    """Return the lines about the longest stable updates.

    Parameters
    ----------
    found : limits on a mesh of the user; or on several meshes of one size, the usual one first
    """
    limits = found[0]
    scene, names = limits.scene, limits.scene.unit_names
    ratio = scene.problem.ground.greatest_poisson_ratio
    count, least, greatest = sides_of(limits.nodes)
    ends = [names.write(end * scene.problem.units.length, "length", 3) for end in (least, greatest)]
    sides = f"{ends[0]} each" if greatest < least * 1.001 else f"{ends[0]} to {ends[1]}"
    lines = [
        f"mesh: {count} sides of {limits.nodes.element} on the contact, {sides}; limits are for "
        f"full integration and Poisson's ratio {ratio:g}",
        f"stable: at most {written(limits, limits.limit())} per update, if pressures are forces "
        "over the areas of nodes; at most "
        f"{written(limits, limits.limit(CONSISTENT))} with a consistent mass matrix",
    ]
    if len(limits.contacts) > 1:
        states = (
            f"{written(limits, contact.limit(PER_NODE))} {contact.name}"
            for contact in limits.contacts
        )
        lines.append(f"contact: edges move; {', '.join(states)}")
    recommended = RECOMMENDED * limits.limit()
    lines.append(f"recommended: half of it, {written(limits, recommended)}{_updates(limits)}")
    lines += _accuracy(limits)
    if len(found) > 1:
        least, greatest = (end(each.limit() for each in found) for end in (min, max))
        lines.append(
            f"range: {written(limits, least)} to {written(limits, greatest)} on {len(found)} "
            "meshes of this size, with first rows from half to twice as thick, and triangles in "
            "rows or free; other meshes may differ more: --mesh FILE gives the limit of yours"
        )
    if ratio > LOCKING:
        lines.append(
            f"note: at Poisson's ratio {ratio:g} elements with full integration are too stiff, "
            "which shortens the stable step up to fivefold; selective or reduced integration "
            "(B-bar, CAX8R, hybrid elements) does not have this effect"
        )
    edges = scene.problem.merged.ring_edges
    if len(edges) > 2:
        lines.append(
            "note: nodes on ring edges have the harmonic mean of both wear coefficients, with "
            "which their pressures err least"
        )
    return lines


def written(limits: StepLimits, step: float) -> str:
    """Return a step as text: a sliding distance, and a time if speed is constant."""
    scene, names = limits.scene, limits.scene.unit_names
    units, load = scene.problem.units, scene.load_
    distance = names.write(limits.distance(step), "distance", 3)
    if load.times_are_distances or scene.problem.loading.varies:
        return f"a sliding distance of {distance}"
    return (
        f"a sliding distance of {distance} (a time of {names.write(step * units.time, 'time', 3)})"
    )


def _updates(limits: StepLimits) -> str:
    count = limits.updates_of_running_in / RECOMMENDED
    if not count < float("inf"):
        return ""
    return f": {max(round(count), 1)} updates until 99 % of the running-in"


def _accuracy(limits: StepLimits) -> list[str]:
    """Return a line on the steps with a given error; none if edges of the contact move."""
    parts = limits.accurate_steps
    if not parts:
        return []
    texts = [
        f"{name} by {written(limits, part * limits.limit())}"
        if part
        else f"{name} by less than a thousandth of the stable step"
        for name, part in parts.items()
    ]
    earliest = limits.scene.problem.earliest or 0.0
    since = limits.scene.unit_names.write(earliest * limits.scene.problem.units.time, "time", 3)
    after = f" from {since} on" if earliest else ""
    error = f"an error of {STEP_ERROR:.0%} by the steps{after}"
    return [f"accuracy: {error} is caused in {'; '.join(texts)}"]
