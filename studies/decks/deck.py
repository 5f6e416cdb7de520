"""Decks of a scene: a folder of input files for a finite-element program, and what to do with it.

`write_decks` chooses what suits the scene: where all of the face carries, a linear deck of
prescribed displacements with a step for each time, and for every scene a deck of contact for each
time.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..outcome.run import run
from ..output.folder import output_folder
from ..scene.scene import Scene, Source
from . import abaqus, calculix
from .keywords import Model
from .mesh import deck_mesh
from .read_me import read_me
from .states import State

PROGRAMS = {"calculix": calculix, "abaqus": abaqus}
"""What writes the decks of a program, by its name."""
ELEMENTS = ("linear", "quadratic")
SIZE, REACH = 0.1, 200.0
"""Size of the elements and radius of the half-space by default, in punch radii."""
SMALL = 1e-3
"""Greatest indentation of contact decks, in punch radii: programs follow the nodes that move."""
LOCKING = 0.49
"""Poisson's ratio above which elements of displacements alone lock."""
METHOD = "mdr"
"""The method whose faces are written: one suffices, and it is exact in time where that can be."""


@dataclass(frozen=True)
class Choice:
    """What a deck is to be.

    Parameters
    ----------
    program : `calculix` or `abaqus`
    elements : `linear` (CAX4) or `quadratic` (CAX8)
    size : of the elements below the punch, away from ring edges, in punch radii
    reach : radius of the half-space that is modelled, in punch radii
    times : of the worn faces, in the units of the scene, beside the start; None for the last time
        of the scene
    """

    program: str
    elements: str = "quadratic"
    size: float = SIZE
    reach: float = REACH
    times: tuple[float, ...] | None = None


def deck(
    scene: Source,
    program: str,
    out: str | Path,
    elements: str = "quadratic",
    size: float = SIZE,
    reach: float = REACH,
    times: Sequence[float] | None = None,
) -> list[Path]:
    """Write input files of a scene for a finite-element program, and a README that explains them.

    The face of the punch is that of MDR, at the start and at some times. `check` reads what the
    program writes.

    Parameters
    ----------
    scene : Scene, str, Path or dict
        What is modelled; its units are those of the files.
    program : str
        ``"calculix"`` or ``"abaqus"``.
    out : str or Path
        The folder to write to.
    elements : str
        ``"linear"`` (CAX4) or ``"quadratic"`` (CAX8).
    size : float
        Size of the elements below the punch, in punch radii; at ring edges and at the rim they are
        smaller.
    reach : float
        Radius of the half-space that is modelled, in punch radii; clamped there, displacements err
        by about 1.1 / `reach`.
    times : sequence of float, optional
        Times of worn faces, in the units of the scene; by default the last time of the scene. The
        start is always written.

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    SceneError
        if the scene or the deck cannot be written, naming the reason and the remedy
    """
    asked = None if times is None else tuple(map(float, times))
    choice = Choice(program, elements, size, reach, asked)
    with output_folder(Path(out), "deck", ["README.md"]) as folder:
        write_decks(Scene.of(scene), choice, folder.hidden)
    return [Path(out) / name for name in folder.written]


def write_decks(scene: Scene, choice: Choice, folder: Path) -> list[str]:
    """Write the decks of a scene, the scene, and a README; return the lines of the README."""
    if choice.program not in PROGRAMS or choice.elements not in ELEMENTS:
        raise SceneError(
            f"a deck of {choice.elements} elements for {choice.program!r}: give one of "
            f"{', '.join(PROGRAMS)}, and linear or quadratic elements"
        )
    if refused := refusal(scene, choice.program):
        raise SceneError(refused)
    problem, writer = scene.problem, PROGRAMS[choice.program]
    quadratic = choice.elements == "quadratic"
    hole = problem.inner_radius
    mesh = deck_mesh(problem.merged.ring_edges, hole, choice.size, choice.reach, quadratic)
    model = Model(scene, mesh, hybrid=problem.poisson_ratio > LOCKING)
    found = states(scene, _times(scene, choice.times), model.radii)
    # contact is that of linear elements, whose nodes are the corners alone
    corners = replace(model, mesh=replace(mesh, quadratic=False))
    files = dict[str, list[str]]()
    for number, state in enumerate(found, 1):
        scale = max(1.0, state.pressing_depth / (SMALL * model.radius))
        at_corners = replace(state, heights=state.heights[:: 1 + quadratic])
        files[f"contact_{number}.inp"] = writer.contact(corners, at_corners, scale)
    if problem.full_contact:
        files["prescribed.inp"] = writer.prescribed(model, found)
    lines = read_me(model, choice.program, choice.reach, found, problem.full_contact)
    for name, of in (files | {"README.md": lines}).items():
        (folder / name).write_text("\n".join(of) + "\n", "utf-8")
    (folder / "scene.toml").write_text(scene.to_toml(), "utf-8")
    return lines


def refusal(scene: Scene, program: str) -> str:
    """Return why a scene has no deck, with the remedy; empty if it has one."""
    problem = scene.problem
    if problem.ground is not None:
        return (
            "half_space.layers: decks model a homogeneous half-space; leave out the layers and "
            "half_space.rigid"
        )
    if np.ptp(problem.profile.recess):
        return (
            "punch.recess: the face has steps, and a node at a ring edge cannot have two heights; "
            "decks are of faces without steps"
        )
    if scene.punch.heights:
        return (
            "functions of Scene.with_heights cannot be written to a scene file; give punch.profile "
            "= { kind = 'table', ... }"
        )
    if program == "calculix" and problem.poisson_ratio > LOCKING:
        return (
            f"half_space.poisson_ratio = {problem.poisson_ratio:g}: the elements of CalculiX lock "
            f"above {LOCKING:g}; give less, or --for abaqus, which has hybrid elements"
        )
    return ""


def _times(scene: Scene, asked: tuple[float, ...] | None) -> list[float]:
    """Return the start and the times of worn faces, increasing."""
    times = tuple(scene.wear.times[-1:]) if asked is None else asked
    for time in times:
        if not 0 <= time < np.inf:
            raise SceneError(
                f"--time {time:g}: give times since sliding began, 0 or later, in the units of "
                "the scene"
            )
    return sorted({0.0, *times})


def states(scene: Scene, times: Sequence[float], radii: Array) -> list[State]:
    """Return the punch at some times, to the accuracy of the scene.

    Parameters
    ----------
    times : increasing, in the units of the scene
    radii : (n,) increasing, in the units of the scene

    Raises
    ------
    SceneError
        if nothing presses at one of the times
    """
    wanted = ["profile", "indentation", "normal_force"]
    asked = scene.changed(
        wear={"times": list(times), "steady": False},
        output={"radii": radii.tolist(), "quantities": wanted},
    )
    table = run(asked, [METHOD]).table.variables
    if "normal_force" in table:
        forces = table["normal_force"][1][0]
    else:
        problem = asked.problem
        forces = problem.loading.at(problem.times).force * problem.units.force
    for time, force in zip(times, forces, strict=True):
        if not force > 0:
            raise SceneError(f"--time {time:g}: nothing presses then; give other times")
    rows = zip(times, table["indentation"][1][0], forces, table["profile"][1][0], strict=True)
    return [
        State(time, float(depth), float(force), heights) for time, depth, force, heights in rows
    ]
