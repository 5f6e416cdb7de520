"""Decks for CalculiX: prescribed displacements, and contact with a rigid pad.

What works, and what does not, was tried with CalculiX 2.20.
"""

from collections.abc import Sequence

import numpy as np

from ...meshes.radial import Array, Indices
from .keywords import (
    CONTACT,
    FACE,
    REFERENCE,
    Model,
    elements,
    half_space,
    heading,
    node_set,
    nodes,
    notes,
    numbers,
    pressed_nodes,
    surface,
)
from .states import State

PAD_HEIGHT = 0.3
"""Height of the pad, in punch radii."""
SPRINGS = 1e5
"""Stiffness of the contact, times the punch radius, over the plane strain modulus of the deck: the
half-space enters the pad by 3e-6 of the indentation."""
WITHIN = 0.1
"""Distance up to which springs of the contact are made, over the root of an area."""


def prescribed(model: Model, states: Sequence[State]) -> list[str]:
    """Return a linear deck, a step for each state: contact nodes have the face's displacement."""
    lines = heading(model, "displacements of the contact nodes are given")
    lines += [*notes(model, states, 1.0, 0.0), *half_space(model)]
    for state in states:
        lines += [
            *("*STEP", "*STATIC", *pressed_nodes(model, state)),
            *(f"*NODE PRINT, NSET={CONTACT}", "U, RF"),
            *("*NODE FILE, OUTPUT=2D", "U, RF", "*EL FILE, OUTPUT=2D", "S"),
            "*END STEP",
        ]
    return lines


def contact(model: Model, state: State, scale: float) -> list[str]:
    """Return a deck in which a rigid pad with the face of the punch is pressed on.

    The half-space is stiffer by `scale`, so that displacements are as much smaller. Elements are
    linear: under quadratic ones pressures beside the axis are wrong (CalculiX 2.20). A flat face is
    pressed on by its force; any other by its indentation, because a worn pad under a force does not
    converge.
    """
    mesh, modulus = model.mesh, scale * model.scene.problem.units.modulus
    first = len(mesh.points)
    face = np.stack([model.radii, (state.heights - state.lowest) / scale], axis=1)
    points, cells = _pad(face, PAD_HEIGHT * model.radius)
    number = first + len(points) + 1
    by_force = model.scene.load_.indentation is None and not np.ptp(state.heights)
    ties, held = list[str](), ["*BOUNDARY", "PAD, 1, 1"]
    load = ["*BOUNDARY", f"PAD, 2, 2, {-state.pressing_depth / scale:.12g}"]
    if by_force:
        # every node of the pad moves with the reference node, which is no node of an element
        ties = [f"*NODE, NSET={REFERENCE}", f"{number}, 0., {PAD_HEIGHT * model.radius:.12g}, 0."]
        for node in range(first + 1, number):
            ties += ["*EQUATION", "2", f"{node}, 2, 1., {number}, 2, -1."]
        held += [f"{number}, 1, 1", f"{number}, 3, 3"]
        load = ["*CLOAD", f"{number}, 2, {-state.force:.12g}"]
    return [
        *heading(model, "a rigid pad is pressed on"),
        *notes(model, [state], scale, state.lowest),
        *half_space(model, scale),
        *nodes(points, first + 1, "PAD"),
        *elements(first + cells, model.element, "PUNCH", len(mesh.cells) + 1),
        *node_set(FACE, first + np.arange(len(face))),
        *("*MATERIAL, NAME=PAD", "*ELASTIC", f"{SPRINGS * modulus:.12g}, 0."),
        "*SOLID SECTION, ELSET=PUNCH, MATERIAL=PAD",
        *surface("SLAVE", mesh.faces),
        *surface("MASTER", ((cell, 1) for cell in range(len(cells))), len(mesh.cells) + 1),
        "*SURFACE INTERACTION, NAME=PRESSING",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
        *numbers([SPRINGS * modulus / model.radius, 0.0, WITHIN]),
        "*CONTACT PAIR, INTERACTION=PRESSING, TYPE=NODE TO SURFACE, SMALL SLIDING",
        "SLAVE, MASTER",
        *ties,
        *held,
        *("*STEP, INC=200", "*STATIC", "1., 1.", *load),
        *(f"*NODE PRINT, NSET={CONTACT}", "U", f"*NODE PRINT, NSET={FACE}", "RF"),
        *(f"*NODE PRINT, NSET={REFERENCE}", "U") * by_force,
        *("*NODE FILE, OUTPUT=2D", "U, RF", "*CONTACT FILE", "CDIS, CSTR", "*END STEP"),
    ]


def _pad(face: Array, height: float) -> tuple[Array, Indices]:
    """Return points and elements of a pad; its first points are those of its lower side.

    Parameters
    ----------
    face : (k, 2) radii and heights of the nodes of its lower side
    height : of its upper side
    """
    above = np.stack([face[:, 0], np.full(len(face), height)], axis=1)
    low, high = np.arange(len(face)), len(face) + np.arange(len(face))
    cells = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
    return np.concatenate([face, above]), cells
