"""Write fields inside the half-space as VTU files, in the scene's units."""

from pathlib import Path

import numpy as np

from .....meshes.radial import Array
from ...methods.inside.interior import Interior
from ...problem.quantities import Units
from ...scene.scene import Scene


def write_half_space(fields: Interior, scene: Scene, path: Path, series: bool) -> None:
    """Write the fields as VTU, in the scene's units, with x = r and y = -z (y points upwards).

    If `series`, also write one file for each time, and a collection (.pvd) of them for ParaView.
    """
    units, solid = scene.problem.units, scene.half_space
    # an elastic punch takes a part of the displacement; the rest is that of the half-space
    half_space_part = solid.modulus / solid.own_modulus
    states = [
        _upright(fields, state, units, half_space_part) for state in range(len(fields.labels))
    ]
    labelled = {
        f"{name} {label}": values
        for label, state in zip(fields.labels, states, strict=True)
        for name, values in state.items()
    }
    if solid.layers:
        # numbers begin with 1; the substrate has the last one
        labelled["material"] = (fields.layers + 1).astype(np.float64)
    _write_vtu(fields, units, path, labelled)
    times = [label.removeprefix("t=") for label in fields.labels if label != "steady"]
    if series and len(times) > 1:
        sets = []
        for number, (time, state) in enumerate(zip(times, states, strict=False)):
            file = path.with_stem(f"{path.stem}_{number}")
            _write_vtu(fields, units, file, state)
            sets.append(f'<DataSet timestep="{time}" file="{file.name}"/>')
        collection = "\n".join(["<Collection>", *sets, "</Collection>"])
        path.with_suffix(".pvd").write_text(
            f'<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n{collection}\n'
            "</VTKFile>\n",
            "utf-8",
        )


def _upright(
    fields: Interior, state: int, units: Units, half_space_part: float
) -> dict[str, Array]:
    """Return the fields at the points in a state, with y upwards, in the scene's units.

    `half_space_part` is the part of the displacement that belongs to the half-space.
    """
    radial, down = fields.displacement[state].T * units.displacement * half_space_part
    stress = (fields.stress[state] * [1, 1, -1, 1] * units.pressure).T
    return {
        "displacement": np.stack([radial, -down, np.zeros_like(radial)], axis=1),
        **dict(zip(("stress_rr", "stress_zz", "stress_rz", "stress_hoop"), stress, strict=True)),
        "von_mises": fields.von_mises[state] * units.pressure,
    }


def _write_vtu(fields: Interior, units: Units, path: Path, data: dict[str, Array]) -> None:
    import meshio

    r, z = fields.points * units.length
    upright = np.stack([r, -z, np.zeros_like(r)], axis=1)
    meshio.Mesh(upright, [("triangle", fields.triangles.T)], point_data=data).write(
        path, file_format="vtu", compression=None
    )
