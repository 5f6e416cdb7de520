"""Keywords that CalculiX and Abaqus share: nodes, elements, material, and what readers need."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...meshes.radial import Array, Indices
from ..scene.scene import Scene
from .mesh import DeckMesh
from .states import State

PER_LINE = 8
"""Numbers on a line: Abaqus takes lines of up to 256 characters."""
CONTACT, FACE, FAR, AXIS, REFERENCE = "CONTACT", "FACE", "FAR", "AXIS", "REF"
"""Names of sets of nodes: the surface below the punch, the face of the punch, the arc, the axis,
and the node that moves with the punch."""


@dataclass(frozen=True, eq=False)
class Model:
    """What all decks of a scene have in common.

    Parameters
    ----------
    scene : whose units all numbers have
    mesh : in punch radii
    hybrid : whether elements are for materials that do not change their volume, in Abaqus
    """

    scene: Scene
    mesh: DeckMesh
    hybrid: bool = False

    @property
    def element(self) -> str:
        """The name of the elements."""
        return f"CAX{8 if self.mesh.quadratic else 4}{'H' if self.hybrid else ''}"

    @property
    def radius(self) -> float:
        """The punch radius."""
        return self.scene.problem.units.length

    @property
    def radii(self) -> Array:
        """(k,) radii of the contact nodes, those of the punch at its ends."""
        radii = self.mesh.points[self.mesh.contact, 0] * self.radius
        return np.clip(radii, self.scene.punch.inner_radius, self.scene.punch.radius)


def heading(model: Model, what: str) -> list[str]:
    """Return the heading: the scene, what is modelled, and the units."""
    title = model.scene.title.encode("ascii", "replace").decode() or "Untitled scene"
    units = model.scene.units or "none: any that are consistent"
    return ["*HEADING", f"{title[:70]}: {what}", f"** units: {units}"]


def notes(model: Model, states: Sequence[State], scale: float, lowest: float) -> list[str]:
    """Return comments that the reader of results needs: times, rings and the scale.

    Parameters
    ----------
    scale : by which displacements of the deck are to be multiplied
    lowest : what is then to be added for the indentation
    """
    rings = model.scene.problem.graded or model.scene.problem.rings
    inner, outer = rings.ends
    named = {
        "times": [state.time for state in states],
        "ring edges": rings.ring_edges * model.radius,
        "wear at inner edges": inner,
        "wear at outer edges": outer,
        "displacements times": [scale],
        "lowest height": [lowest],
    }
    return [f"** {name}: {line}" for name, values in named.items() for line in numbers(values)]


def numbers(values: ArrayLike) -> Iterator[str]:
    """Yield lines of numbers."""
    rest = np.ravel(values)
    for start in range(0, len(rest), PER_LINE):
        yield ", ".join(f"{value:.12g}" for value in rest[start : start + PER_LINE])


def half_space(model: Model, stiffer: float = 1.0) -> list[str]:
    """Return nodes, elements, sets, material and the clamped arc.

    Parameters
    ----------
    stiffer : times by which the half-space is stiffer than the scene's
    """
    mesh = model.mesh
    sets = {CONTACT: mesh.contact, AXIS: mesh.axis, FAR: mesh.far}
    ratio = model.scene.half_space.poisson_ratio
    youngs_modulus = stiffer * model.scene.problem.units.modulus * (1 - ratio**2)
    heights = mesh.points * [model.radius, -model.radius]
    return [
        *nodes(heights, 1, "ALL"),
        *elements(mesh.cells, model.element, "SOLID", 1),
        *(line for name, members in sets.items() for line in node_set(name, members)),
        "*MATERIAL, NAME=ELASTIC",
        "*ELASTIC",
        f"{youngs_modulus:.12g}, {ratio:.12g}",
        "*SOLID SECTION, ELSET=SOLID, MATERIAL=ELASTIC",
        "*BOUNDARY",
        f"{AXIS}, 1, 1",
        f"{FAR}, 1, 2",
    ]


def nodes(points: Array, first: int, name: str) -> list[str]:
    """Return nodes at (n, 2) radii and heights, numbered from the first."""
    rows = enumerate(points, first)
    return [
        f"*NODE, NSET={name}",
        *(f"{number}, {r:.12g}, {y + 0.0:.12g}, 0." for number, (r, y) in rows),
    ]


def elements(cells: Indices, kind: str, name: str, first: int) -> list[str]:
    """Return elements, whose nodes are counted from 0, numbered from the first."""
    return [
        f"*ELEMENT, TYPE={kind}, ELSET={name}",
        *(
            f"{number}, {', '.join(str(node + 1) for node in cell)}"
            for number, cell in enumerate(cells, first)
        ),
    ]


def node_set(name: str, members: Indices) -> list[str]:
    """Return a set of nodes that are counted from 0."""
    return [f"*NSET, NSET={name}", *numbers(members + 1)]


def surface(name: str, faces: Iterable[tuple[int, int]], first: int = 1) -> list[str]:
    """Return a surface of sides of elements, which are counted from 0."""
    return [
        f"*SURFACE, NAME={name}, TYPE=ELEMENT",
        *(f"{first + cell}, S{side}" for cell, side in faces),
    ]


def pressed_nodes(model: Model, state: State) -> list[str]:
    """Return the displacement of each contact node that the face of the punch asks for."""
    depths = state.indentation - state.heights
    pairs = zip(model.mesh.contact, depths, strict=True)
    return ["*BOUNDARY", *(f"{node + 1}, 2, 2, {-depth:.12g}" for node, depth in pairs)]
