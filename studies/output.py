"""All files of a run, written whole or not at all: into a hidden directory first, then moved into place."""

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ringwear.meshes.errors import SceneError
from ringwear.studies.problem.scene import Scene
from ringwear.studies.progress import LOG

if TYPE_CHECKING:
    from ringwear.studies.crosscheck.dataset import Result
    from ringwear.studies.methods.fem import Meshed


@contextmanager
def whole(out: Path) -> Iterator[Path]:
    """A directory to write to; what is in it moves to `out` when all of it is there."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        hidden = Path(tempfile.mkdtemp(prefix=".writing-", dir=out))
    except OSError as error:
        raise SceneError(f"--out {out} cannot be written to: {error.strerror}") from error
    try:
        yield hidden
        for file in sorted(hidden.iterdir()):
            os.replace(file, out / file.name)
    finally:
        shutil.rmtree(hidden, ignore_errors=True)


def write(result: "Result", out: Path) -> list[str]:
    """Write results, summary, half-space and figures to `out`; returns the names of the files."""
    from ringwear.studies.crosscheck.interior import interior, write_half_space
    from ringwear.studies.figures import mesh, run

    scene, solutions = result.scene, result.solutions
    with whole(out) as hidden:
        LOG.info("  output  writing ...")
        result.dataset.to_netcdf(hidden / "results.nc", engine="netcdf4")
        (hidden / "summary.json").write_text(json.dumps(result.summary, indent=1) + "\n", "utf-8")
        LOG.info("  output  drawing ...")
        if "fem" in solutions and (half_space := solutions["fem"].half_space) is not None:
            fields = interior(scene, solutions["fem"])
            write_half_space(fields, scene.problem.units, hidden / "half_space.vtu")
            mesh.draw_stress(scene, fields, hidden / "stress.png")
            mesher = solutions["fem"].settings["mesher"]
            mesh.draw_mesh(half_space.solid.mesh, mesher, scene.problem.ring_edges, hidden / "mesh.png")
        run.draw_states(scene, solutions, hidden / "profiles_and_pressures.png")
        run.draw_history(scene, solutions, hidden / "history.png")
        run.draw_steady(scene, solutions, hidden / "steady_state.png")
        if result.operators:
            run.draw_operators(scene, result.operators, hidden / "operator_difference.png")
        return sorted(file.name for file in hidden.iterdir())


def write_mesh(scene: Scene, meshed: "Meshed", out: Path) -> list[str]:
    """Write the mesh as scikit-fem does, in the scene's units and with its boundaries, and its figure.

    The file can be read back: by `skfem.Mesh.load`, and as a mesh of one's own by `ringwear study refinement --mesh`.
    """
    import numpy as np
    from skfem.io.meshio import to_meshio

    from ringwear.meshes.half_space import quality
    from ringwear.studies.figures.mesh import draw_mesh

    with whole(out) as hidden:
        content = to_meshio(meshed.mesh.scaled(scene.punch.radius), cell_data={"quality": [quality(meshed.mesh)]})
        content.points = np.column_stack([content.points, np.zeros(len(content.points))])
        content.write(hidden / "mesh.vtu", file_format="vtu")
        draw_mesh(meshed.mesh, meshed.mesher, scene.problem.ring_edges, hidden / "mesh.png")
        return sorted(file.name for file in hidden.iterdir())
