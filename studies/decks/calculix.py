"""Decks for CalculiX: prescribed displacements, and contact with a rigid pad.

The decks were tested with CalculiX 2.20; variants that do not work there are described below.
"""

from typing import Any

import numpy as np

from ...meshes import Array, Indices, SceneError
from .keywords import FACE, Model, State, elements, node_set, nodes, surface

NAME, RESULTS = "CalculiX", ".dat"
COMMAND = "OMP_NUM_THREADS=1 ccx {job}          # give the name without .inp"
ABOUT = (
    "Forces in the .dat file are those on a wedge of 2 degrees. `ringwear check` multiplies them "
    "by 180, and computes the pressures by the consistent mass matrix of the contact line (2 pi r "
    "dr). Loads in the deck are those on the whole circumference. Tested with CalculiX 2.20."
)
"""Name of the program, ending of its results, how a deck is run, and remarks in the README."""
PRESSED_BY_FORCE = " (a flat face: by the force; under a force, a worn face does not converge)"
"""How a contact deck presses the punch if the scene gives the force."""
PRESSED, COMMENTS = "pad", ()
"""What is pressed in contact decks, and comments at the head of each deck."""
PAD_HEIGHT = 0.3
"""Height of the pad, in punch radii."""
SPRING_STIFFNESS = 1e5
"""Stiffness of the contact springs, times the punch radius, over the plane strain modulus of the
deck. The half-space penetrates the pad by 3e-6 of the indentation. The modulus of the pad, over the
same modulus, has this value, too."""
LEAST_DETERMINANT = 1e-20
"""Determinant of Jacobi's matrix below which CalculiX takes an element for degenerate, whatever the
units of lengths."""
WEDGE, NEAREST_POINT = np.pi / 90, 0.2
"""Angle of the wedge that replaces axisymmetric elements; radius of the nearest integration point
of an element on the axis over that of its middle, about."""
SPRING_DISTANCE = 0.1
"""Distance up to which contact springs are created, over the root of the area of a spring (`c0` in
the manual of CalculiX)."""


def refuse_small_elements(model: Model) -> None:
    """Refuse elements that are so small in the units of the scene that CalculiX rejects them.

    Raises
    ------
    SceneError
        if there are such elements; it names the remedy
    """
    radii, depths = (model.mesh.points[model.mesh.cells[:, :4]] * model.radius).transpose(2, 0, 1)
    products = radii * np.roll(depths, -1, axis=1) - np.roll(radii, -1, axis=1) * depths
    areas = np.abs(products.sum(axis=1)) / 2
    # a wedge of 2 degrees; the integration points are nearer to the axis than the middle
    determinants = areas / 4 * WEDGE / 2 * radii.mean(axis=1) * NEAREST_POINT
    if determinants.min() < LEAST_DETERMINANT:
        raise SceneError(
            "units: the elements of the deck are so small in the units of the scene that CalculiX "
            "takes them for degenerate: give the scene in smaller units, such as mm, N, MPa, s"
        )


def contact(model: Model, state: State, scale: float) -> dict[str, Any]:
    """Return what the template of a contact deck has, in which a rigid pad is pressed.

    The pad has the face of the punch. The modulus of the half-space is multiplied by `scale`, so
    that displacements are divided by it. Elements are linear, because with quadratic ones pressures
    near the axis are wrong (CalculiX 2.20). A flat face is pressed by its force if that is
    prescribed, and any other face by its indentation, because a worn pad under a force does not
    converge.
    """
    first, height = len(model.mesh.points), PAD_HEIGHT * model.radius
    face = np.stack([model.radii, (state.heights - state.lowest) / scale], axis=1)
    points, cells = _pad(face, height)
    first_cell, reference = len(model.mesh.cells) + 1, first + len(points) + 1
    pad = [
        *nodes(points, first + 1, "PAD"),
        *elements(first + cells, model.element, "PUNCH", first_cell),
        *node_set(FACE, first + np.arange(len(face))),
    ]
    lower_sides = ((cell, 1) for cell in range(len(cells)))
    surfaces = [*surface("SLAVE", model.mesh.faces), *surface("MASTER", lower_sides, first_cell)]
    return {
        "pad": "\n".join(pad),
        "pad_nodes": range(first + 1, reference),
        "surfaces": "\n".join(surfaces),
        "stiffness": SPRING_STIFFNESS * scale * model.scene.problem.units.modulus,
        "spring_distance": SPRING_DISTANCE,
        "by_force": model.scene.load_.indentation is None and not np.ptp(state.heights),
        "reference": reference,
        "height": height,
    }


def _pad(face: Array, height: float) -> tuple[Array, Indices]:
    """Return the points (2 k, 2) and elements (k - 1, 4) of a pad, points of the lower side first.

    Parameters
    ----------
    face : (k, 2) radii and heights of the nodes of the lower side
    height : of the upper side
    """
    top = np.stack([face[:, 0], np.full(len(face), height)], axis=1)
    low, high = np.arange(len(face)), len(face) + np.arange(len(face))
    cells = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=1)
    return np.concatenate([face, top]), cells
