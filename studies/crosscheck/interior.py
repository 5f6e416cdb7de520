"""What happens inside the half-space: displacements and stresses of the finite elements at chosen times."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ringwear.meshes.radial import Array, Indices
from ringwear.studies.methods.base import Solution
from ringwear.studies.problem.problem import Units
from ringwear.studies.problem.scene import Scene

# times that each element is refined to show what its polynomials say
REFINEMENTS = {"MeshQuad1": 3, "MeshTri1": 2}


@dataclass(frozen=True, eq=False)
class Interior:
    """Fields of the half-space, non-dimensional, on small triangles within each element: not averaged between elements.

    Parameters
    ----------
    labels : of the states, `t=...` and `steady`
    points, triangles : (2, n) radius and depth, and the small triangles (3, m) between them
    displacement : (states, n, 2) radial, and into the half-space
    stress : (states, n, 4) rr, zz, rz, hoop
    von_mises : (states, n)
    """

    labels: tuple[str, ...]
    points: Array
    triangles: Indices
    displacement: Array
    stress: Array
    von_mises: Array


def interior(scene: Scene, fem: Solution) -> Interior:
    """Recover the inside of the half-space from the contact pressures: at the scene's field times, and when steady."""
    from ringwear.fem.stresses import sampled, von_mises

    assert fem.half_space is not None
    assert fem.wear is not None
    times = scene.output.field_times
    if times is None:
        times = [0.0] if scene.wear.steady else [0.0, scene.wear.times[-1]]
    wanted = np.array(times) / scene.problem.units.time
    wear = replace(fem.wear, earliest=float(min(wanted[wanted > 0], default=0.0)))
    pressures = list(wear.modal(wanted).pressure)
    labels = [f"t={time:g}" for time in times]
    if scene.wear.steady:
        pressures.append(wear.steady.pressure)
        labels.append("steady")
    refinements = REFINEMENTS[type(fem.half_space.solid.mesh).__name__]
    points, triangles, moved, stress = sampled(fem.half_space, np.array(pressures), refinements)
    return Interior(tuple(labels), points, triangles, moved, stress, von_mises(stress))


def write_half_space(fields: Interior, units: Units, path: Path) -> None:
    """Write the fields as VTU, in the scene's units and upright: x is the radius, y the height (depth is negative)."""
    import meshio

    data: dict[str, Array] = {}
    for state, label in enumerate(fields.labels):
        radial, down = fields.displacement[state].T
        data[f"displacement {label}"] = np.stack([radial, -down, np.zeros_like(radial)], axis=1) * units.displacement
        for column, (name, sign) in enumerate((("rr", 1), ("zz", 1), ("rz", -1), ("hoop", 1))):
            data[f"stress_{name} {label}"] = sign * fields.stress[state, :, column] * units.pressure
        data[f"von_mises {label}"] = fields.von_mises[state] * units.pressure
    r, z = fields.points * units.length
    upright = np.stack([r, -z, np.zeros_like(r)], axis=1)
    meshio.Mesh(upright, [("triangle", fields.triangles.T)], point_data=data).write(path, file_format="vtu")
