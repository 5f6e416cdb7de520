"""The longest stable updates of a scene on a mesh, at the start and at the end of its contact."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
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
from .contact_nodes import ContactNodes, contact_nodes
from .elements import PER_NODE, TREATMENTS
from .explicit import MOST_DENSE, ExplicitWear, explicit

REACH = 20.0
"""Radius of the half-spaces that are meshed here, with Boussinesq's far field, in punch radii."""
FEWEST_NODES = 3
"""Least number of nodes in contact for which a limit is computed."""
FIRST_ROWS = (0.5, 1.0, 2.0)
"""Thicknesses of the first row of elements over the least side on the contact, of meshes whose
limits show how much these differ at one size."""
STEP_ERROR = 0.01
"""Relative error by the steps for which the step is reported."""


@dataclass(frozen=True, eq=False)
class Contact:
    """A state of the contact, and its updates by both treatments.

    Parameters
    ----------
    name : what state it is; empty in full contact
    updates : by treatment
    """

    name: str
    updates: dict[str, ExplicitWear]

    def limit(self, treatment: str) -> float:
        """Return the longest stable step of a treatment."""
        return self.updates[treatment].limit


@dataclass(frozen=True, eq=False)
class StepLimits:
    """The longest stable updates on a mesh.

    Parameters
    ----------
    scene : the scene
    nodes : the contact nodes of the mesh
    contacts : full contact; or the contact at the start and at the end
    """

    scene: Scene
    nodes: ContactNodes
    contacts: tuple[Contact, ...]

    def limit(self, treatment: str = PER_NODE) -> float:
        """Return the longest stable step, in non-dimensional sliding distance."""
        return min(contact.limit(treatment) for contact in self.contacts)

    def distance(self, step: float) -> float:
        """Return a step as a sliding distance in the units of the scene."""
        units = self.scene.problem.units
        return step * units.length / units.modulus / units.wear_coefficient

    @property
    def _has_modes(self) -> bool:
        """Whether all modes are computed: in full contact, of so many nodes."""
        return self.scene.problem.full_contact and len(self.nodes.radii) <= MOST_DENSE

    @cached_property
    def accurate_steps(self) -> dict[str, float]:
        """Step with an error of `STEP_ERROR` over the longest stable one, by quantity.

        Pressures are per node. It is empty if edges of the contact move, if the load varies, or for
        many nodes.
        """
        problem = self.scene.problem
        if not self._has_modes or problem.loading.varies:
            return {}
        first = problem.earliest or 0.0
        return self.contacts[0].updates[PER_NODE].step_for(STEP_ERROR, first)

    @property
    def updates_of_running_in(self) -> float:
        """Number of longest updates per node until 99 % of the running-in; NaN without modes."""
        if not self._has_modes:
            return float("nan")
        return self.contacts[0].updates[PER_NODE].running_in_time / self.limit()


def limits_on_mesh(scene: Scene, mesh: Mesh, element: str) -> StepLimits:
    """Return the longest stable updates of a scene on a mesh.

    Parameters
    ----------
    scene : the scene
    mesh : quarter disc with named boundaries
    element : name of the element
    """
    return _limits(scene, contact_nodes(mesh, element, scene.problem.ground), contacts_of(scene))


Parts = Callable[[Array], Indices]
"""A function from radii of nodes to the numbers of the nodes in contact."""


def contacts_of(scene: Scene) -> dict[str, Parts]:
    """Return which nodes touch, by the state of the contact; shaped punches are solved by MDR."""
    if scene.problem.full_contact:
        return {"": lambda radii: np.arange(len(radii))}
    times = first_and_last_in_contact(scene)
    sampled = scene.changed(
        wear={"times": sorted(set(times)), "steady": False}, output__quantities=["contact_edge"]
    )
    edges = run(sampled, ["mdr"]).dataset["contact_edge"].isel(solver=0).values
    edges = edges / scene.problem.units.length

    def inside(state: Array) -> Parts:
        ends = state[np.isfinite(state)].reshape(-1, 2)

        def touching(radii: Array) -> Indices:
            within = (radii >= ends[:, :1] - 1e-9) & (radii <= ends[:, 1:] + 1e-9)
            return np.flatnonzero(within.any(axis=0))

        return touching

    names = ("at the start", "at the last time")[: len(edges)]
    return {name: inside(state) for name, state in zip(names, edges, strict=True)}


def _limits(scene: Scene, nodes: ContactNodes, parts: dict[str, Parts]) -> StepLimits:
    contacts = []
    for name, touching in parts.items():
        numbers = touching(nodes.radii)
        if len(numbers) < FEWEST_NODES:
            raise SceneError(
                f"the mesh has {len(numbers)} nodes in the contact {name}: give a mesh with "
                f"{FEWEST_NODES} or more there"
            )
        updates = {
            treatment: explicit(scene.problem, nodes, treatment, numbers)
            for treatment in TREATMENTS
        }
        contacts.append(Contact(name, updates))
    return StepLimits(scene, nodes, tuple(contacts))


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


def mesh_below(
    vertices: Array, element: str, ring_edges: Array, row: float = 1.0, rising: bool = True
) -> Mesh:
    """Return a mesh in rows and columns below given vertices of the surface.

    Parameters
    ----------
    vertices : (n,) radii of the vertices on the surface, from 0 to 1
    element : name of the element
    ring_edges : (N+1,) ring edges, from 0 or the radius of a hole to 1
    row : thickness of the first row over the least distance of two vertices
    rising : direction of the diagonals of triangles
    """
    mesh = structured.below_nodes(vertices, REACH, row * float(np.diff(vertices).min()))
    if element.startswith("P"):
        return as_half_space(structured.in_triangles(mesh, rising), ring_edges)
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
    rows = (1.0, *(row for row in FIRST_ROWS if row != 1.0))
    edges, meshes = problem.merged.ring_edges, []
    for row in rows:
        for rising in (True, False) if element.startswith("P") else (True,):
            # triangles in rows and columns of a small size would be flat at a distance
            with suppress(MeshError):
                meshes.append(mesh_below(vertices, element, edges, row, rising))
    if element.startswith("P"):
        meshes.append(_free_triangles(edges, size))
    if not meshes:
        raise SceneError("size: no mesh in rows and columns is possible for these rings")
    return [_limits(scene, contact_nodes(mesh, element, problem.ground), parts) for mesh in meshes]


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


def sides_of(nodes: ContactNodes) -> tuple[int, float, float]:
    """Return the number of sides of elements on the contact, the least and the greatest one."""
    sides = np.diff(nodes.cells)
    return len(sides), float(sides.min()), float(sides.max())
