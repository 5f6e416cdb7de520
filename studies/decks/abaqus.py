"""Decks for Abaqus: prescribed displacements, and contact with an analytical rigid surface.

Their keywords were compared with documented examples, one by one. The decks have never been run.
"""

from collections.abc import Sequence

from .keywords import (
    AXIS,
    CONTACT,
    REFERENCE,
    Model,
    State,
    half_space,
    heading,
    notes,
    pressed_nodes,
    surface,
)

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
PUNCH_HEIGHT = 0.5
"""Height to which the side of the punch is modelled, in punch radii."""
NOT_RUN = ["** not run: the keywords were only compared with documented examples"]
"""Comment in each deck."""


def prescribed(model: Model, states: Sequence[State]) -> list[str]:
    """Return a linear deck that prescribes displacements of the contact nodes, a step a state."""
    lines = heading(model, "displacements of the contact nodes are prescribed") + NOT_RUN
    lines += [*notes(model, states, 1.0, 0.0), *half_space(model)]
    for number, state in enumerate(states, 1):
        lines += [
            *(f"*STEP, NAME=STEP-{number}, NLGEOM=NO", "*STATIC", *pressed_nodes(model, state)),
            *(f"*NODE PRINT, NSET={CONTACT}", "U2, RF2"),
            *("*OUTPUT, FIELD", "*NODE OUTPUT", "U, RF", "*ELEMENT OUTPUT", "S", "*END STEP"),
        ]
    return lines


def contact(model: Model, state: State, scale: float) -> list[str]:
    """Return a deck in which a rigid surface, the face of the punch, is pressed on the half-space.

    The modulus of the half-space is multiplied by `scale`, so that displacements are divided by it.
    The first step moves the punch by its indentation; if the force is prescribed, a second step
    releases the punch and applies the force.
    """
    number = len(model.mesh.points) + 1
    # from the rim inwards, because the normal of the surface must point down
    face = list(zip(model.radii, (state.heights - state.lowest) / scale, strict=True))[::-1]
    outputs = [
        *("*CONTACT PRINT", "CSTRESS, CDISP", f"*NODE PRINT, NSET={REFERENCE}", "U2, RF2"),
        *("*OUTPUT, FIELD", "*NODE OUTPUT", "U, RF", "*CONTACT OUTPUT", "CSTRESS, CDISP"),
        "*END STEP",
    ]
    if model.scene.punch.inner_radius:
        face.append((model.radii[0], PUNCH_HEIGHT * model.radius))
    indentation = [f"{REFERENCE}, 2, 2, {-state.pressing_depth / scale:.12g}"]
    fixed = [f"{REFERENCE}, 1, 1", f"{REFERENCE}, 6, 6"]
    steps = ["*STEP, NAME=STEP-1, NLGEOM=NO, INC=200", "*STATIC", "0.1, 1."]
    steps += ["*BOUNDARY", *fixed, *indentation, *outputs]
    if model.scene.load_.indentation is None:
        steps += ["*STEP, NAME=STEP-2, NLGEOM=NO, INC=200", "*STATIC", "0.1, 1."]
        # OP=NEW removes all boundary conditions: repeat them without the one that moves the punch
        held = [f"{AXIS}, 1, 1", *(f"{name}, 1, 2" for name in model.clamped)]
        steps += ["*BOUNDARY, OP=NEW", *held, *fixed]
        steps += ["*CLOAD", f"{REFERENCE}, 2, {-state.force:.12g}", *outputs]
    return [
        *heading(model, "a rigid punch is pressed on"),
        *NOT_RUN,
        *notes(model, [state], scale, state.lowest),
        *half_space(model, scale),
        *surface("SLAVE", model.mesh.faces),
        *(f"*NODE, NSET={REFERENCE}", f"{number}, 0., {PUNCH_HEIGHT * model.radius:.12g}"),
        "*SURFACE, TYPE=SEGMENTS, NAME=PUNCH",
        f"START, {face[0][0]:.12g}, {PUNCH_HEIGHT * model.radius:.12g}",
        *(f"LINE, {radius:.12g}, {height:.12g}" for radius, height in face),
        f"*RIGID BODY, ANALYTICAL SURFACE=PUNCH, REF NODE={number}",
        *("*SURFACE INTERACTION, NAME=PRESSING", "1.,", "*FRICTION", "0.,"),
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD",
        "*CONTACT PAIR, INTERACTION=PRESSING, TYPE=SURFACE TO SURFACE, SMALL SLIDING",
        "SLAVE, PUNCH",
        *steps,
    ]
