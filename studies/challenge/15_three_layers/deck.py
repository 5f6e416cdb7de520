"""Write the input file of problem 15 for CalculiX and Abaqus: a uniform pressure on three layers.

``python -m ringwear.studies.challenge.15_three_layers.deck`` writes `road.inp`. All its keywords
are those that both programs share. The half-space is clamped on an arc.
"""

from pathlib import Path

from ...crosscheck import Scene
from ...decks.keywords import AXIS, Model, half_space, heading
from ...decks.mesh import layered_mesh

FOLDER = Path(__file__).parent
SIZE, REACH = 0.2, 200.0
"""Size of the elements below the pressure, and radius of the half-space, in radii of the circle."""


def deck(scene: Scene) -> list[str]:
    """Return the lines of the input file, in the units of the scene."""
    problem, pressure = scene.problem, scene.table()["load"]["mean_pressure"]
    mesh = layered_mesh(problem.merged.ring_edges, SIZE, REACH, True, problem.ground)
    model = Model(scene, mesh)
    loads = [f"{cell + 1}, P{side}, {pressure:.12g}" for cell, side in mesh.faces]
    return [
        *heading(model, "a uniform pressure"),
        *half_space(model),
        *("*STEP", "*STATIC", "*DLOAD", *loads),
        *(f"*NODE PRINT, NSET={AXIS}", "U", "*EL PRINT, ELSET=SOLID", "S", "*END STEP"),
    ]


if __name__ == "__main__":
    lines = deck(Scene.load(FOLDER / "scene.toml"))
    (FOLDER / "road.inp").write_text("\n".join(lines) + "\n", "utf-8")
