"""Decks for Abaqus: prescribed displacements, and contact with an analytical rigid surface.

Their keywords were compared with documented examples, one by one. The decks have never been run.
"""

from typing import Any

from .keywords import Model, State, surface

NAME, RESULTS, COMMAND = "Abaqus", ".rpt", "abaqus job={job} interactive"
ABOUT = (
    "The keywords of these decks were compared with documented examples, one by one. **The decks "
    "were not run.** In Abaqus/Viewer choose Report > Field Output, position Unique Nodal, RF.RF2 "
    "of prescribed.odb (or CPRESS, and U.U2, of a contact deck), the node set CONTACT, and every "
    "step, appended to one file with the name of the deck and the ending .rpt."
)
"""Name of the program, ending of its results, how a deck is run, and remarks in the README."""
PRESSED_BY_FORCE = ", and then by the force in it"
"""How a contact deck presses the punch if the scene gives the force."""
PRESSED = "punch"
COMMENTS = ("not run: the keywords were only compared with documented examples",)
"""What is pressed in contact decks, and comments at the head of each deck."""
PUNCH_HEIGHT = 0.5
"""Height to which the side of the punch is modelled, in punch radii."""


def contact(model: Model, state: State, scale: float) -> dict[str, Any]:
    """Return what the template of a contact deck has, in which a rigid surface is pressed.

    The surface is the face of the punch. The modulus of the half-space is multiplied by `scale`, so
    that displacements are divided by it. The first step moves the punch by its indentation; if the
    force is prescribed, a second step releases the punch and applies the force.
    """
    height = PUNCH_HEIGHT * model.radius
    # from the rim inwards, because the normal of the surface must point down
    face = list(zip(model.radii, (state.heights - state.lowest) / scale, strict=True))[::-1]
    if model.scene.punch.inner_radius:
        face.append((model.radii[0], height))
    return {
        "surface": "\n".join(surface("SLAVE", model.mesh.faces)),
        "face": face,
        "by_force": model.scene.load_.indentation is None,
        "reference": len(model.mesh.points) + 1,
        "height": height,
    }
