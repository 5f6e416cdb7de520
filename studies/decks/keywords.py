"""What the decks of CalculiX and Abaqus share: the model, templates, and the head of a deck."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...meshes import Array, Indices
from ..crosscheck import Scene
from .mesh import DeckMesh

COMMENT_WIDTH = 100
"""Greatest number of characters in a line of a comment."""
PER_LINE = 8
"""Greatest number of numbers on a line, because Abaqus reads at most 256 characters a line."""
CONTACT, FACE, FAR, BASE, AXIS = "CONTACT", "FACE", "FAR", "BASE", "AXIS"
"""Names of node sets: the surface below the punch, the face of the punch, the clamped arc, a rigid
base, and the axis."""


class Material(NamedTuple):
    """An elastic material of the half-space.

    Parameters
    ----------
    name : its name
    elset : name of the set of its elements
    youngs_modulus : in the units of the scene
    poisson_ratio : Poisson's ratio
    elements : (k,) indices of its elements, from 0; None if all elements are in the set
    """

    name: str
    elset: str
    youngs_modulus: float
    poisson_ratio: float
    elements: Indices | None = None


@dataclass(frozen=True, eq=False)
class Model:
    """The scene and the mesh that all decks of a scene share.

    Parameters
    ----------
    scene : its units are those of all numbers in the decks
    mesh : in punch radii
    hybrid : whether Abaqus uses hybrid elements, for nearly incompressible materials
    wear_steps : lines about the wear steps that are stable on the mesh
    """

    scene: Scene
    mesh: DeckMesh
    hybrid: bool = False
    wear_steps: tuple[str, ...] = ()

    @property
    def element(self) -> str:
        """The type of the elements, such as CAX8H."""
        return f"CAX{8 if self.mesh.quadratic else 4}{'H' if self.hybrid else ''}"

    @property
    def clamped(self) -> tuple[str, ...]:
        """Names of the sets of nodes that are clamped: the arc, and a rigid base."""
        return (FAR, BASE) if len(self.mesh.base) else (FAR,)

    @property
    def materials(self) -> list["Material"]:
        """The materials of the half-space, from the surface down, each with its elements."""
        ground, modulus = self.scene.problem.ground, self.scene.problem.units.modulus
        constants = [
            (2 * shear * (1 + ratio) * modulus, ratio)
            for shear, ratio in zip(ground.shear_moduli, ground.poisson_ratios, strict=True)
        ]
        if not ground.layered:
            return [Material("ELASTIC", "SOLID", *constants[0])]
        depths = self.mesh.points[self.mesh.cells[:, :4], 1].mean(axis=1)
        layers = ground.layer_at(depths)
        names = [*(f"LAYER_{number}" for number in range(1, len(constants))), "SUBSTRATE"]
        return [
            Material(name, name, *pair, np.flatnonzero(layers == number))
            for number, (name, pair) in enumerate(zip(names, constants, strict=True))
            if (layers == number).any()
        ]

    @property
    def radius(self) -> float:
        """The punch radius, in the units of the scene."""
        return self.scene.problem.units.length

    @property
    def radii(self) -> Array:
        """(k,) radii of the contact nodes, without roundoff beyond the rim or the hole."""
        radii = self.mesh.points[self.mesh.contact, 0] * self.radius
        return np.clip(radii, self.scene.punch.inner_radius, self.scene.punch.radius)


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


def render(template: str, **context: Any) -> str:
    """Return a text from a template in this folder, without a line end."""
    from jinja2 import StrictUndefined, Template

    source = Path(__file__).with_name(f"{template}.j2").read_text("utf-8")
    read = Template(source, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    return read.render(**context).rstrip("\n")


def head(
    model: Model,
    description: str,
    comments: Sequence[str],
    states: Sequence[State],
    scale: float | None = None,
) -> str:
    """Return what decks have before their steps: a heading, comments and the half-space.

    A line that began with the title of the scene could be a keyword, because titles may begin with
    an asterisk. The comments that `reports.py` reads have times, rings, and the scale of
    displacements.

    Parameters
    ----------
    description, comments : of the deck
    states : the punch at the times of the deck
    scale : of contact decks, the factor that turns displacements of the deck into those of the
        scene, and which the modulus is multiplied by; the punch then touches at first
    """
    mesh, rings = model.mesh, model.scene.problem.graded or model.scene.problem.rings
    inner, outer = rings.wear_coefficients
    notes = {
        "times": [state.time for state in states],
        "ring edges": rings.ring_edges * model.radius,
        "wear at inner edges": inner,
        "wear at outer edges": outer,
        "displacements times": [scale or 1.0],
        # height that is added to the displacement of the punch to obtain the indentation
        "lowest height": [states[0].lowest if scale else 0.0],
    }
    sets = {CONTACT: mesh.contact, AXIS: mesh.axis, FAR: mesh.far}
    if len(mesh.base):
        sets[BASE] = mesh.base
    lines = [
        *nodes(mesh.points * [model.radius, -model.radius], 1, "ALL"),
        *elements(mesh.cells, model.element, "SOLID", 1),
        *(line for name, members in sets.items() for line in node_set(name, members)),
    ]
    return render(
        "head.inp",
        model=model,
        description=description,
        comments=comments,
        notes=notes,
        title=model.scene.title.encode("ascii", "replace").decode() or "untitled",
        steps=[part for line in model.wear_steps for part in wrap(line, COMMENT_WIDTH)],
        numbers=numbers,
        mesh="\n".join(lines),
        scale=scale or 1.0,
    )


def numbers(values: ArrayLike) -> Iterator[str]:
    """Yield lines of numbers, separated by commas."""
    rest = np.ravel(values)
    for start in range(0, len(rest), PER_LINE):
        yield ", ".join(f"{value:.12g}" for value in rest[start : start + PER_LINE])


def nodes(points: Array, first: int, name: str) -> list[str]:
    """Return nodes at points (n, 2), radii and heights, numbered from `first`."""
    rows = enumerate(points, first)
    return [
        f"*NODE, NSET={name}",
        *(f"{number}, {r:.12g}, {y + 0.0:.12g}, 0." for number, (r, y) in rows),
    ]


def elements(cells: Indices, kind: str, name: str, first: int) -> list[str]:
    """Return elements (m, nodes) of node indices from 0, numbered from `first`."""
    return [
        f"*ELEMENT, TYPE={kind}, ELSET={name}",
        *(
            f"{number}, {', '.join(str(node + 1) for node in cell)}"
            for number, cell in enumerate(cells, first)
        ),
    ]


def node_set(name: str, members: Indices) -> list[str]:
    """Return a set of nodes, given by their indices from 0."""
    return [f"*NSET, NSET={name}", *numbers(members + 1)]


def surface(name: str, faces: Iterable[tuple[int, int]], first: int = 1) -> list[str]:
    """Return a surface of element sides: pairs of element index, from 0, and side, from 1."""
    return [
        f"*SURFACE, NAME={name}, TYPE=ELEMENT",
        *(f"{first + cell}, S{side}" for cell, side in faces),
    ]


def pressed_nodes(model: Model, state: State) -> str:
    """Return prescribed displacements u = d - f that press the contact nodes on the face."""
    depths = state.indentation - state.heights
    pairs = zip(model.mesh.contact, depths, strict=True)
    return "\n".join(f"{node + 1}, 2, 2, {-depth:.12g}" for node, depth in pairs)
