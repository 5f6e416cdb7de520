"""The README of a folder of decks: what is modelled, what it costs, and how to read it back."""

from collections.abc import Sequence

from ..problem.unit_names import UnitNames
from .keywords import Model
from .states import State

COMMANDS = {
    "calculix": "OMP_NUM_THREADS=1 ccx {job}          # the program takes the name without .inp",
    "abaqus": "abaqus job={job} interactive",
}
CLAMPED = 1.1
"""Relative error of the indentation of a clamped half-space, times R / a, for a Poisson's ratio of
0.3 (`ringwear study truncation`)."""


def read_me(
    model: Model, program: str, reach: float, states: Sequence[State], prescribed: bool
) -> list[str]:
    """Return the lines of the README."""
    scene, mesh = model.scene, model.mesh
    names = UnitNames.of(scene.units)
    units = scene.units or "none: numbers are in any consistent units"
    ratio = scene.half_space.poisson_ratio
    results = f"prescribed{'.dat' if program == 'calculix' else '.rpt'}"
    results = results if prescribed else results.replace("prescribed", "contact_1")
    job = results.partition(".")[0]

    def written(value: float, kind: str) -> str:
        return names.write(value, kind, 6)

    by_force = scene.load_.indentation is None
    pressed = "pressed to the indentation of the table"
    if by_force and program == "abaqus":
        pressed = "pressed to the indentation of the table, and then by its force"
    elif by_force:
        pressed += " (a flat face: by its force; a worn one does not converge under it)"
    rows = [
        f"| `contact_{number}.inp` | {f'{number} of prescribed.inp' if prescribed else '-'} | "
        f"{written(state.time, 'time')} | {written(state.indentation, 'displacement')} | "
        f"{written(state.force, 'force')} |"
        for number, state in enumerate(states, 1)
    ]
    lines = [
        f"# {scene.title or 'Untitled scene'}: input files for "
        f"{'CalculiX' if program == 'calculix' else 'Abaqus'}",
        "",
        f"Units: {units}. x is the radius, y the height; the half-space is y < 0.",
        "",
        "## What is modelled",
        "",
        f"- The half-space: a quarter disc of radius R = {reach:g} a, clamped on its arc, without "
        "radial displacement on the axis, without traction beside the punch. a = "
        f"{written(model.radius, 'length')}; E = "
        f"{written(scene.problem.units.modulus * (1 - ratio**2), 'pressure')}, Poisson's ratio "
        f"{ratio:g}. Two elastic bodies are one half-space of the modulus of both.",
        f"- {len(mesh.cells)} axisymmetric elements {model.element}, {len(mesh.points)} nodes; "
        "ring edges are nodes, and elements are smallest there and at the rim.",
        "- The punch: rigid and without friction, with the worn face that MDR computes, to the "
        f"scene's rtol {scene.accuracy.rtol:g}. The program does not compute wear.",
    ]
    if prescribed:
        lines += [
            "- `prescribed.inp` (recommended): a linear problem, a step for each time. Each "
            "contact node is pressed down by u = d - f, the indentation less the face; radial "
            "displacements are free. Reaction forces are the result.",
        ]
    else:
        lines += [
            "- Not all of the face carries, so there is no deck with prescribed displacements: "
            "which nodes touch is not known before."
        ]
    lines += [
        f"- `contact_1.inp`, ...: contact with a rigid punch on linear elements, a file for each "
        f"time, {pressed}. The half-space is made stiffer, and the heights of the face smaller, so "
        "that the indentation is at most a/1000: forces and pressures are those of the scene, and "
        "displacements are smaller by the number in the comment `displacements times`.",
        "",
        "| file | step | time | indentation | force |",
        "| --- | --- | --- | --- | --- |",
        *rows,
        "",
        "## What it costs",
        "",
        f"- Clamped at R, the half-space is too stiff: by about {CLAMPED:g} a/R = "
        f"{CLAMPED / reach:.2g} (Poisson's ratio 0.3). At a given indentation the force is too "
        "large by that, under a given force the indentation too small. Late pressures of rings "
        "that wear fast are small, and this excess is a larger part of them. Twice the reach has "
        "half this error, and few more elements.",
        "- Beside edges of rings, where pressures jump, those of the nearest elements err by about "
        "10 to 20 %, whatever their size; smaller elements have this error in a smaller part of "
        "the face.",
        "- At the start the pressure is infinite at the rim: the check compares it inside 0.95 a.",
        "",
        "## Run it, and read it back",
        "",
        f"    {COMMANDS[program].format(job=job)}",
        f"    ringwear check scene.toml {results}",
        "",
        "`ringwear check` reads the deck beside the results, for the places of its nodes: leave "
        "them in one folder.",
        "",
    ]
    return lines + (_about_calculix() if program == "calculix" else _about_abaqus())


def _about_calculix() -> list[str]:
    return [
        "Forces in the .dat are those of a wedge of 2 degrees: the check multiplies them by 180, "
        "and solves the consistent mass matrix of the contact line (2 pi r dr) for the pressures. "
        "Loads in the deck are those of the whole circumference. Tried with CalculiX 2.20.",
    ]


def _about_abaqus() -> list[str]:
    return [
        "These decks were compared with documented examples keyword by keyword. **They were not "
        "run.** In Abaqus/Viewer choose Report > Field Output, position Unique Nodal, RF.RF2 of "
        "prescribed.odb (or CPRESS, and U.U2, of a contact deck), the node set CONTACT, and every "
        "step, appended to one file with the name of the deck and the ending .rpt.",
    ]
