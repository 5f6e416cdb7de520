"""What happens inside the half-space: displacements and stresses of the finite elements at chosen times."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from meshes.half_space import HalfSpaceMesh
from meshes.radial import Array

from .wear import Wear

if TYPE_CHECKING:
    from .runs import Result


@dataclass(frozen=True, eq=False)
class Interior:
    """Fields at the mesh vertices, in natural units.

    Parameters
    ----------
    mesh : the half-space
    labels : of the states, `t=...` and `steady`
    displacement : (states, vertices, 2) radial, and into the half-space
    stress : (states, vertices, 4) rr, zz, rz, hoop
    von_mises : (states, vertices)
    """

    mesh: HalfSpaceMesh
    labels: tuple[str, ...]
    displacement: Array
    stress: Array
    von_mises: Array


def interior(result: Result) -> Interior:
    """Recover the inside of the half-space from the contact pressures: at the scene's field times, and when steady."""
    from fem.fields import displacements, vertex_stresses, von_mises

    scene, natural = result.scene, result.scene.natural
    model = result.models["fem"]
    assert model.half_space is not None
    wear = Wear(model.compliance, natural.phases[1])
    times = scene.output.field_times
    if times is None:
        times = [0.0] if scene.wear.steady else [0.0, scene.wear.times[-1]]
    pressures = list(wear.modal(np.array(times) / natural.time).pressure)
    labels = [f"t={time:g}" for time in times]
    if scene.wear.steady:
        pressures.append(wear.steady.pressure)
        labels.append("steady")
    moved = displacements(model.half_space, np.array(pressures))
    stress = vertex_stresses(model.half_space.solid, moved)
    mesh = model.half_space.solid.mesh
    return Interior(mesh, tuple(labels), moved[:, : len(mesh.points)], stress, von_mises(stress))


def write_half_space(result: Result, fields: Interior, path: Path) -> None:
    """Write the fields as VTU, in the scene's units and upright: x is the radius, y the height (depth is negative)."""
    import meshio

    natural = result.scene.natural
    data: dict[str, Array] = {}
    for state, label in enumerate(fields.labels):
        radial, down = fields.displacement[state].T
        data[f"displacement {label}"] = np.stack([radial, -down, np.zeros_like(radial)], axis=1) * natural.displacement
        for column, (name, sign) in enumerate((("rr", 1), ("zz", 1), ("rz", -1), ("hoop", 1))):
            data[f"stress_{name} {label}"] = sign * fields.stress[state, :, column] * natural.pressure
        data[f"von_mises {label}"] = fields.von_mises[state] * natural.pressure
    points = fields.mesh.points * natural.length
    upright = np.stack([points[:, 0], -points[:, 1], np.zeros(len(points))], axis=1)
    meshio.Mesh(upright, [("triangle", fields.mesh.triangles)], point_data=data).write(path, file_format="vtu")
