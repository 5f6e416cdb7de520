"""The longest stable updates of a scene on a mesh, at the start and at the end of its contact."""

from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from skfem import Mesh

from ...meshes import (
    Array,
    Indices,
    MeshError,
    SceneError,
    SizeField,
    as_half_space,
    bisection,
    from_axis,
    structured,
)
from ..crosscheck import Problem, Scene, first_and_last_in_contact, run
from .contact_nodes import CONSISTENT, PER_NODE, ContactNodes, contact_nodes, longest_step

REACH = 20.0
"""Radius of the half-spaces that are meshed here, with Boussinesq's far field, in punch radii."""
FEWEST_NODES = 3
"""Least number of nodes in contact for which a limit is computed."""
FIRST_ROWS = (1.0, 0.5, 2.0)
"""Thicknesses of the first row of elements over the least side on the contact, of meshes whose
limits show how much these differ at one size; the usual one first."""
RECOMMENDED = 0.5
"""Recommended step over the longest stable one: pressures then err by 1 to 4 % (`ringwear study
march`)."""
LOCKING = 0.45
"""Poisson's ratio above which the note on locking is added."""


@dataclass(frozen=True, eq=False)
class StepLimits:
    """The longest stable updates on a mesh.

    Parameters
    ----------
    scene : the scene
    nodes : the contact nodes of the mesh
    contacts : numbers of the nodes in contact, by the state of the contact: without a name in full
        contact, or at the start and at the end
    """

    scene: Scene
    nodes: ContactNodes
    contacts: dict[str, Indices]

    def limit(self, treatment: str = PER_NODE) -> float:
        """Return the longest stable step, in non-dimensional sliding distance."""
        return min(self.limit_in(contact, treatment) for contact in self.contacts)

    def limit_in(self, contact: str, treatment: str = PER_NODE) -> float:
        """Return the longest stable step in a state of the contact."""
        touching = self.contacts[contact]
        return longest_step(self.scene.problem, self.nodes, treatment, touching)

    def distance(self, step: float) -> float:
        """Return a step as a sliding distance in the units of the scene."""
        units = self.scene.problem.units
        return step * units.length / units.modulus / units.wear_coefficient

    def written(self, step: float) -> str:
        """Return a step as text: a sliding distance, and a time if speed is constant."""
        problem, names = self.scene.problem, self.scene.unit_names
        text = f"a sliding distance of {names.write(self.distance(step), 'distance', 3)}"
        if self.scene.load_.times_are_distances or problem.loading.varies:
            return text
        return f"{text} (a time of {names.write(step * problem.units.time, 'time', 3)})"


def contacts_of(scene: Scene) -> dict[str, Array]:
    """Return the intervals (k, 2) in contact, in punch radii, by the state of the contact.

    Shaped punches are solved by MDR.
    """
    if scene.problem.full_contact:
        return {"": np.array([[0.0, 1.0]])}
    times = first_and_last_in_contact(scene)
    sampled = scene.changed(
        wear={"times": sorted(set(times)), "steady": False}, output__quantities=["contact_edge"]
    )
    edges = run(sampled, ["mdr"]).dataset["contact_edge"].isel(solver=0).values
    states = edges / scene.problem.units.length
    intervals = [state[np.isfinite(state)].reshape(-1, 2) for state in states]
    return dict(zip(("at the start", "at the last time"), intervals, strict=False))


def limits_on_mesh(
    scene: Scene, mesh: Mesh, element: str, intervals: dict[str, Array] | None = None
) -> StepLimits:
    """Return the longest stable updates of a scene on a mesh.

    Parameters
    ----------
    scene : the scene
    mesh : quarter disc with named boundaries
    element : name of the element
    intervals : in contact, if they are known (`contacts_of`)

    Raises
    ------
    SceneError
        if the mesh has too few nodes in contact
    """
    nodes = contact_nodes(mesh, element, scene.problem.ground)
    contacts = dict[str, Indices]()
    for name, ends in (intervals or contacts_of(scene)).items():
        within = (nodes.radii >= ends[:, :1] - 1e-9) & (nodes.radii <= ends[:, 1:] + 1e-9)
        contacts[name] = numbers = np.flatnonzero(within.any(axis=0))
        if len(numbers) < FEWEST_NODES:
            raise SceneError(
                f"the mesh has {len(numbers)} nodes in the contact {name}: give a mesh with "
                f"{FEWEST_NODES} or more there"
            )
    return StepLimits(scene, nodes, contacts)


def vertices_of_size(problem: Problem, size: float) -> Array:
    """Return the radii of vertices on the contact, equally spaced on each ring, at most a size.

    Parameters
    ----------
    problem : the problem with its ring edges
    size : in punch radii
    """
    edges = from_axis(problem.merged.ring_edges)
    radii = [np.zeros(1)]
    for inner, outer in pairwise(edges):
        count = max(1, int(np.ceil((outer - inner) / size * (1 - 1e-9))))
        radii.append(np.linspace(inner, outer, count + 1)[1:])
    return np.concatenate(radii)


def mesh_below(vertices: Array, element: str, ring_edges: Array, row: float = 1.0) -> Mesh:
    """Return a mesh in rows and columns below given vertices of the surface.

    Parameters
    ----------
    vertices : (n,) radii of the vertices on the surface, from 0 to 1
    element : name of the element
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1
    row : thickness of the first row over the least distance of two vertices
    """
    mesh = structured.below_nodes(vertices, REACH, row * float(np.diff(vertices).min()))
    if element.startswith("P"):
        return as_half_space(structured.in_triangles(mesh), ring_edges)
    return as_half_space(mesh, ring_edges)


def limits_of_size(scene: Scene, size: float, element: str) -> list[StepLimits]:
    """Return the longest stable updates on several meshes of one size, the usual one first.

    Parameters
    ----------
    scene : the scene
    size : size of the elements on the contact, in punch radii
    element : name of the element
    """
    problem = scene.problem
    vertices, parts = vertices_of_size(problem, size), contacts_of(scene)
    edges, meshes = problem.merged.ring_edges, []
    for row in FIRST_ROWS:
        # triangles in rows and columns of a small size would be flat at a distance
        with suppress(MeshError):
            meshes.append(mesh_below(vertices, element, edges, row))
    if element.startswith("P"):
        meshes.append(_free_triangles(edges, size))
    if not meshes:
        raise SceneError("size: no mesh in rows and columns is possible for these rings")
    return [limits_on_mesh(scene, mesh, element, parts) for mesh in meshes]


def _free_triangles(ring_edges: Array, size: float) -> Mesh:
    """Return triangles by bisection, whose sides on the contact have at most a size."""
    return bisection.mesh(
        SizeField(
            tuple(ring_edges.tolist()),
            rim_size=size,
            ring_size=size,
            growth=structured.GROWTH,
            truncation=REACH,
            centre_size=size,
            cells=lambda radii: np.full(len(radii), size),
        )
    )


def describe(found: list[StepLimits]) -> list[str]:
    """Return the lines about the longest stable updates.

    Parameters
    ----------
    found : limits on a mesh of the user; or on several meshes of one size, the usual one first
    """
    limits = found[0]
    scene, names, longest = limits.scene, limits.scene.unit_names, limits.limit()
    ratio = scene.problem.ground.greatest_poisson_ratio
    widths = np.diff(limits.nodes.cells) * scene.problem.units.length
    least, greatest = (names.write(end, "length", 3) for end in (widths.min(), widths.max()))
    sides = f"{least} each" if np.ptp(widths) < 0.001 * widths.min() else f"{least} to {greatest}"
    lines = [
        f"mesh: {len(widths)} sides of {limits.nodes.element} on the contact, {sides}; limits are "
        f"for full integration and Poisson's ratio {ratio:g}",
        f"stable: at most {limits.written(longest)} per update, if pressures are forces "
        "over the areas of nodes; at most "
        f"{limits.written(limits.limit(CONSISTENT))} with a consistent mass matrix",
    ]
    if len(limits.contacts) > 1:
        states = (
            f"{limits.written(limits.limit_in(contact))} {contact}" for contact in limits.contacts
        )
        lines.append(f"contact: edges move; {', '.join(states)}")
    lines.append(f"recommended: half of it, {limits.written(RECOMMENDED * longest)}")
    if len(found) > 1:
        steps = sorted(each.limit() for each in found)
        lines.append(
            f"range: {limits.written(steps[0])} to {limits.written(steps[-1])} on {len(found)} "
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
