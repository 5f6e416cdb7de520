"""The files of a run: numbers, then what shows them; no failure of a figure loses a number."""

import json
from functools import cache
from typing import TYPE_CHECKING

from ...meshes.errors import RingwearError
from ..problem.scene import Scene
from ..progress import LOG
from .csv_tables import write_csv
from .folder import Folder, signals_wait
from .side_by_side import Job, make

if TYPE_CHECKING:
    from ..crosscheck.run import Result
    from ..methods.fem import Meshed


def write_numbers(result: "Result", folder: Folder, tables: bool = False) -> None:
    """Write the numbers of a run, before anything is drawn."""
    LOG.info("  output  writing ...")
    dataset = result.dataset
    try:
        # interrupted while it holds its locks, xarray would wait for them forever
        with signals_wait():
            dataset.to_netcdf(folder.hidden / "results.nc", engine="netcdf4")
    except RuntimeError as error:
        # what netCDF makes of a full disk
        raise RingwearError(
            f"results.nc could not be written to {folder.out} ({error}): is the disk full?"
        ) from error
    (folder.hidden / "summary.json").write_text(
        json.dumps(result.summary, indent=1, allow_nan=False) + "\n", "utf-8"
    )
    if tables:
        write_csv(dataset, folder.hidden)


def draw(result: "Result", folder: Folder, figures: bool = True) -> list[str]:
    """Draw a run; returns what could not be made, with the reason.

    The inside of the half-space takes as long as the contact: without figures it is left out unless
    the scene asks for it.
    """
    if not figures:
        return make(
            [], of_inside(result)[:1] if result.scene.output.field_times else [], folder.hidden
        )
    LOG.info("  output  drawing ...")
    inside = of_inside(result)
    # the inside and its stresses take as long as all the others
    return make(
        [*of_contact(result), *of_operators(result), *inside[2:]], inside[:2], folder.hidden
    )


def of_contact(result: "Result") -> list[Job]:
    """Figures of what is on the face of the punch."""
    from ..figures.history import draw_history
    from ..figures.states import draw_states, draw_steady, given

    scene, solutions, jobs = result.scene, result.solutions, []
    if given("profile", solutions):
        jobs.append(
            Job("profiles_and_pressures.png", lambda path: draw_states(scene, solutions, path))
        )
        if scene.problem.earliest:
            jobs.append(Job("history.png", lambda path: draw_history(scene, solutions, path)))
            if not scene.problem.full_contact:
                from ..figures.contact import draw_contact

                jobs.append(Job("contact.png", lambda path: draw_contact(scene, solutions, path)))
    if given("steady_profile", solutions):
        jobs.append(Job("steady_state.png", lambda path: draw_steady(scene, solutions, path)))
    return jobs


def of_operators(result: "Result") -> list[Job]:
    """The figure that compares methods for every pressure."""
    from ..figures.operators import draw_operators

    draw = Job(
        "operator_difference.png", lambda path: draw_operators(result.scene, result.operators, path)
    )
    return [draw] if result.operators else []


def of_inside(result: "Result") -> list[Job]:
    """The inside of the half-space as a file, then its figures.

    For flat punches by finite elements only.
    """
    fem = result.solutions.get("fem")
    if fem is None or fem.half_space is None or not result.scene.problem.full_contact:
        return []
    from ..crosscheck import interior
    from ..figures.mesh import draw_mesh, draw_stress

    scene, solid, mesher = result.scene, fem.half_space.solid.mesh, fem.settings["mesher"]
    fields = cache(lambda: interior.interior(scene, fem))
    return [
        Job(
            "half_space.vtu",
            lambda path: interior.write_half_space(fields(), scene.problem.units, path),
        ),
        Job("stress.png", lambda path: draw_stress(scene, fields(), path)),
        Job("mesh.png", lambda path: draw_mesh(solid, mesher, scene.problem.ring_edges, path)),
    ]


def write_mesh(scene: Scene, meshed: "Meshed", folder: Folder) -> None:
    """Write the mesh as scikit-fem does, in the scene's units and with its boundaries, and its
    figure.

    The file can be read back: by `skfem.Mesh.load`, and as a mesh of one's own by `ringwear study
    refinement --mesh`.
    """
    import numpy as np
    from skfem.io.meshio import to_meshio

    from ...meshes.half_space import quality
    from ..figures.mesh import draw_mesh

    content = to_meshio(
        meshed.mesh.scaled(scene.punch.radius), cell_data={"quality": [quality(meshed.mesh)]}
    )
    content.points = np.column_stack([content.points, np.zeros(len(content.points))])
    content.write(folder.hidden / "mesh.vtu", file_format="vtu")
    draw_mesh(meshed.mesh, meshed.mesher, scene.problem.ring_edges, folder.hidden / "mesh.png")
