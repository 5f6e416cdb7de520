"""Write the decks of a scene: a folder of input files for a finite-element program, and a README.

`deck` chooses the decks that suit the scene: for every scene, a contact deck for each time; in full
contact also a linear deck of prescribed displacements, with a step for each time.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from ...meshes import Array, SceneError
from ..crosscheck import (
    Scene,
    Source,
    did_you_mean,
    first_and_last_in_contact,
    naming_arguments,
    numbers,
    output_folder,
    run,
    shown,
)
from ..wear_step.limits import describe, limits_on_mesh
from . import abaqus, calculix
from .keywords import Model, State, head, pressed_nodes, render
from .mesh import deck_mesh, layered_mesh

PROGRAMS = {"calculix": calculix, "abaqus": abaqus}
"""Modules that write decks, by the name of the program."""
ELEMENTS = ("Q1", "Q2S")
ELEMENT, SIZE, REACH = "Q2S", 0.1, 200.0
"""Default element, its default size and the default radius of the half-space, in punch radii."""
SIZES = (1e-3, 0.5)
"""Least and greatest size of the elements, in punch radii."""
MAX_INDENTATION = 1e-3
"""Greatest indentation in contact decks, in punch radii. It is small because programs update the
positions of the nodes."""
LOCKING = 0.49
"""Poisson's ratio above which pure displacement elements lock."""
AT_THE_HEAD = ("mesh: ", "stable: ", "recommended: ")
"""Lines about wear steps that each deck has at its head."""
CLAMPED = 1.1
"""Relative error of the indentation of a half-space that is clamped at R, times R / a, for a
Poisson's ratio of 0.3 (`ringwear study truncation`)."""
METHOD = "mdr"
"""The method that computes the worn faces: it is exact in time in full contact."""


@naming_arguments
def deck(
    scene: Source,
    program: str,
    out: str | Path,
    element: str = ELEMENT,
    size: float | None = None,
    reach: float = REACH,
    times: Sequence[float] | None = None,
) -> list[Path]:
    """Write input files of a scene for a finite-element program, and a README that explains them.

    The face of the punch is computed by MDR, at the start and at some times. `check` reads the
    results of the program.

    Parameters
    ----------
    scene : the scene that is modelled; the files have its units
    program : the program, ``"calculix"`` or ``"abaqus"``, in upper or lower case
    out : the folder to write to
    element : ``"Q1"`` (CAX4) or ``"Q2S"`` (CAX8) in the deck of prescribed displacements (default:
        Q2S); contact decks have Q1
    size : size of the elements below the punch, in the units of the scene; they are smaller at ring
        edges and at the rim (default: a tenth of the radius of the punch)
    reach : radius at which the modelled half-space is clamped, in punch radii (default: 200); the
        relative error of the indentation by clamping is about 1.1 / reach
    times : time of a worn face, in the units of the scene (default: the last time of the scene at
        which the punch is loaded); the start, or the first time with a load, is always written

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    SceneError
        if the scene has no deck, or if an option is out of range; it names the remedy
    """
    scene, (reach,) = Scene.of(scene), numbers("reach", [reach])
    program, element, radius = str(program).lower(), str(element), scene.problem.units.length
    if program not in PROGRAMS:
        hint = did_you_mean(program, PROGRAMS, f"give one of {', '.join(PROGRAMS)}")
        raise SceneError(f"a deck for {shown(program)} cannot be written{hint}")
    if element.upper() not in ELEMENTS:
        raise SceneError(
            f"element = {shown(element)}: decks have Q1, with four nodes (CAX4), or Q2S, with "
            "eight (CAX8)"
        )
    (given,) = (SIZE * radius,) if size is None else numbers("size", [size])
    least, most = (f"{share * radius:.4g}" for share in SIZES)
    if not SIZES[0] <= given / radius <= SIZES[1]:
        raise SceneError(
            f"size = {given:g}: give the size of the elements below the punch in the units of the "
            f"scene, {least} to {most}"
        )
    chosen_times = None if times is None else numbers("times", times)
    if reason := refusal(scene, program):
        raise SceneError(reason)
    problem, writer, relative_size = scene.problem, PROGRAMS[program], given / radius
    quadratic = element.upper() == "Q2S"
    edges, ground = problem.merged.ring_edges, problem.ground
    with output_folder(out, "deck", ["README.md"]) as folder:
        if ground.layered:
            mesh = layered_mesh(edges, relative_size, reach, quadratic, ground)
        else:
            mesh = deck_mesh(edges, relative_size, reach, quadratic)
        model = Model(scene, mesh, hybrid=ground.greatest_poisson_ratio > LOCKING)
        if program == "calculix":
            calculix.refuse_small_elements(model)
        punch_states = states(scene, _times(scene, chosen_times), model.radii)
        steps = describe([limits_on_mesh(scene, mesh.mesh, element.upper())])
        heads = tuple(line for line in steps if line.startswith(AT_THE_HEAD))
        model = replace(model, wear_steps=heads)
        # contact decks have linear elements, whose nodes are the corners
        linear_model = replace(model, mesh=replace(mesh, quadratic=False))
        files = dict[str, str]()
        for number, state in enumerate(punch_states, 1):
            scale = max(1.0, state.pressing_depth / (MAX_INDENTATION * model.radius))
            at_corners = replace(state, heights=state.heights[:: 1 + quadratic])
            about = f"a rigid {writer.PRESSED} is pressed on"
            files[f"contact_{number}.inp"] = render(
                f"{program}_contact.inp",
                head=head(linear_model, about, writer.COMMENTS, [at_corners], scale),
                model=linear_model,
                state=at_corners,
                scale=scale,
                **writer.contact(linear_model, at_corners, scale),
            )
        if problem.full_contact:
            about = "displacements of the contact nodes are prescribed"
            files["prescribed.inp"] = render(
                f"{program}_prescribed.inp",
                head=head(model, about, writer.COMMENTS, punch_states),
                pressed_nodes=[pressed_nodes(model, state) for state in punch_states],
            )
        files["README.md"] = render(
            "readme.md",
            model=model,
            scene=scene,
            writer=writer,
            states=punch_states,
            reach=reach,
            wear_steps=steps,
            clamped=CLAMPED,
            prescribed=problem.full_contact,
            write=partial(scene.unit_names.write, digits=6),
        )
        for name, content in files.items():
            (folder.hidden / name).write_text(f"{content}\n", "utf-8")
        (folder.hidden / "scene.toml").write_text(scene.to_toml(), "utf-8")
    return [Path(out) / name for name in folder.written]


def refusal(scene: Scene, program: str) -> str:
    """Return the reason why a scene has no deck, with the remedy; empty if it has one."""
    problem = scene.problem
    if np.ptp(problem.profile.recess):
        return (
            "punch.recess: the face has steps, and a node at a ring edge cannot have two heights; "
            "give a scene whose face has no steps"
        )
    if scene.punch.heights:
        return (
            "functions of Scene.with_heights cannot be written to a scene file; give punch.profile "
            "= { kind = 'table', ... }"
        )
    if problem.ground.share < 1:
        return (
            "half_space.punch_youngs_modulus: on layers, decks have a rigid punch; leave it "
            "out, or leave out the layers"
        )
    ratio = problem.ground.greatest_poisson_ratio
    if program == "calculix" and ratio > LOCKING:
        return (
            f"half_space.poisson_ratio = {ratio:g}: the elements of CalculiX lock above "
            f"{LOCKING:g}; give a smaller ratio, or --for abaqus, which has hybrid elements"
        )
    return ""


def _times(scene: Scene, chosen_times: Sequence[float] | None) -> list[float]:
    """Return the first time with a load and the times of worn faces, increasing.

    Raises
    ------
    SceneError
        if a time is negative or not finite, or if the force is zero then
    """
    first, last = first_and_last_in_contact(scene)
    times = (last,) if chosen_times is None else chosen_times
    loading, unit = scene.problem.loading, scene.problem.units.time

    def loaded(time: float) -> bool:
        return bool(loading.at(np.array([time]) / unit).force[0] > 0)

    for time in times:
        if not 0 <= time < np.inf:
            raise SceneError(
                f"--time {time:g}: give times since sliding began, 0 or later, in the units of "
                "the scene"
            )
        if not loaded(time):
            example = loading.times[loading.forces > 0][0] * unit
            raise SceneError(
                f"--time {time:g}: the load is zero then: give times at which the punch is loaded, "
                f"such as {example:g}"
            )
    return sorted({*times, *([first] if loaded(first) else [])})


def states(scene: Scene, times: Sequence[float], radii: Array) -> list[State]:
    """Return the punch at some times, computed to the `rtol` of the scene.

    Parameters
    ----------
    times : increasing, in the units of the scene
    radii : (n,) increasing, in the units of the scene

    Raises
    ------
    SceneError
        if the force has vanished at one of the times, under a given indentation
    """
    quantities = ["indentation", "normal_force", "profile"]
    sampled_scene = scene.changed(
        wear={"times": list(times), "steady": False},
        output={"radii": radii.tolist(), "quantities": quantities},
    )
    data = run(sampled_scene, [METHOD]).dataset.isel(solver=0)
    depths, forces, profiles = (data[name].values for name in quantities)
    problem = sampled_scene.problem
    if problem.prescribed == "normal_force":
        # as given, without the last digits of a sum
        forces = problem.loading.at(problem.times).force * problem.units.force
    for time, force in zip(times, forces, strict=True):
        if not force > 0:
            raise SceneError(
                f"--time {time:g}: all of the overlap is worn off, and the force is zero then: "
                "give earlier times"
            )
    rows = zip(times, depths, forces, profiles, strict=True)
    return [
        State(time, float(depth), float(force), heights) for time, depth, force, heights in rows
    ]
