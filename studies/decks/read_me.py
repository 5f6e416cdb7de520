"""Write the README of a folder of decks: the model, its errors, and how to check the results."""

from collections.abc import Sequence

from .keywords import Model, State

COMMANDS = {
    "calculix": "OMP_NUM_THREADS=1 ccx {job}          # give the name without .inp",
    "abaqus": "abaqus job={job} interactive",
}
CLAMPED = 1.1
"""Relative error of the indentation of a half-space that is clamped at R, times R / a, for a
Poisson's ratio of 0.3 (`ringwear study truncation`)."""


def read_me(
    model: Model,
    program: str,
    reach: float,
    states: Sequence[State],
    prescribed: bool,
    wear_step: Sequence[str],
) -> list[str]:
    """Return the lines of the README.

    Parameters
    ----------
    program : `calculix` or `abaqus`
    reach : radius of the modelled half-space, in punch radii
    states : the punch at each time
    prescribed : whether there is a deck with prescribed displacements
    wear_step : lines about the longest stable update of wear on the mesh
    """
    scene, mesh = model.scene, model.mesh
    names = scene.unit_names
    units = scene.units or "none: numbers are in any consistent units"
    results = f"prescribed{'.dat' if program == 'calculix' else '.rpt'}"
    results = results if prescribed else results.replace("prescribed", "contact_1")
    job = results.partition(".")[0]

    def written(value: float, kind: str) -> str:
        return names.write(value, kind, 6)

    by_force = scene.load_.indentation is None
    pressed = "pressed to the indentation in the table"
    if by_force and program == "abaqus":
        pressed = "pressed to the indentation in the table, and then by the force in it"
    elif by_force:
        pressed += " (a flat face: by the force; under a force, a worn face does not converge)"
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
        f"- The half-space is a quarter disc of radius R = {reach:g} a. It is clamped on its arc"
        f"{' and on its rigid base' if len(mesh.base) else ''}, has no radial displacement on the "
        f"axis, and no traction beside the punch. a = {written(model.radius, 'length')}; "
        + "; ".join(
            f"{'' if len(model.materials) == 1 else material.name + ': '}E = "
            f"{written(material.youngs_modulus, 'pressure')}, Poisson's ratio "
            f"{material.poisson_ratio:g}"
            for material in model.materials
        )
        + ". If both bodies are elastic, this is one half-space with their common modulus.",
        f"- The mesh has {len(mesh.cells)} axisymmetric elements {model.element} and "
        f"{len(mesh.points)} nodes. All ring edges are nodes; elements are smallest there and "
        "at the rim.",
        "- The punch is rigid and without friction. Its worn face was computed by MDR to the "
        f"scene's rtol, {scene.accuracy.rtol:g}; the program does not compute wear.",
    ]
    if prescribed:
        lines += [
            "- `prescribed.inp` (recommended) is a linear problem with a step for each time. Each "
            "contact node is displaced downwards by u = d - f, the indentation minus the height of "
            "the face; radial displacements are free. The results are the reaction forces.",
        ]
    else:
        lines += [
            "- There is no deck with prescribed displacements, because only a part of the face "
            "touches, and it is not known in advance which nodes do."
        ]
    lines += [
        "- `contact_1.inp`, ..., one file for each time, model contact of linear elements with a "
        f"rigid punch, {pressed}. The modulus of the half-space is multiplied, and the heights of "
        "the face divided, by the number in the comment `displacements times`, so that the "
        "indentation is at most a/1000. Forces and pressures are those of the scene; displacements "
        "are divided by this number.",
        "",
        "| file | step | time | indentation | force |",
        "| --- | --- | --- | --- | --- |",
        *rows,
        "",
        "## Errors of the model",
        "",
        *_about_clamping(model, reach),
        "- Near ring edges, where pressures jump, the pressures of the nearest elements err by "
        "about 10 to 20 %, whatever the element size. With smaller elements, this error affects a "
        "smaller part of the face.",
        "- At the start the pressure is infinite at the rim. `ringwear check` compares it inside "
        "0.95 a.",
        "",
        "## Wear in steps",
        "",
        "A loop around this mesh that updates the face by `f += k v p dt` is stable up to a step:",
        "",
        *(f"- {line}" for line in wear_step),
        "",
        "## Run the deck and check the results",
        "",
        f"    {COMMANDS[program].format(job=job)}",
        f"    ringwear check scene.toml {results}",
        "",
        "`ringwear check` also reads the deck, which contains the positions of the nodes: leave "
        "the deck and the results in the same folder.",
        "",
    ]
    return lines + (_about_calculix() if program == "calculix" else _about_abaqus())


def _about_clamping(model: Model, reach: float) -> list[str]:
    """Return the line about the error of the clamped arc."""
    if len(model.mesh.base):
        return []
    if model.scene.problem.ground.layered:
        return [
            f"- Because it is clamped at R = {reach:g} a, the half-space is too stiff. Twice the "
            "reach halves this error and needs few more elements."
        ]
    return [
        f"- Because it is clamped at R, the half-space is too stiff by about {CLAMPED:g} a/R = "
        f"{CLAMPED / reach:.2g} (for Poisson's ratio 0.3). At a given indentation the force is too "
        "large by this relative error; under a given force the indentation is too small. The "
        "relative error is larger in the late pressures of rings that wear fast, because these "
        "pressures are small. Twice the reach halves this error and needs few more elements."
    ]


def _about_calculix() -> list[str]:
    return [
        "Forces in the .dat file are those on a wedge of 2 degrees. `ringwear check` multiplies "
        "them by 180, and computes the pressures by the consistent mass matrix of the contact line "
        "(2 pi r dr). Loads in the deck are those on the whole circumference. Tested with CalculiX "
        "2.20.",
    ]


def _about_abaqus() -> list[str]:
    return [
        "The keywords of these decks were compared with documented examples, one by one. **The "
        "decks were not run.** In Abaqus/Viewer choose Report > Field Output, position Unique "
        "Nodal, RF.RF2 of prescribed.odb (or CPRESS, and U.U2, of a contact deck), the node set "
        "CONTACT, and every step, appended to one file with the name of the deck and the ending "
        ".rpt.",
    ]
