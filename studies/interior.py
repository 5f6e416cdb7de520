"""What happens inside the half-space: displacements and stresses of the finite elements at chosen times."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from meshes.radial import Array, Indices

from .wear import Wear

if TYPE_CHECKING:
    from fem.compliance import HalfSpace

    from .runs import Result

FINENESS = 4
STAR_FINENESS = 6


@dataclass(frozen=True, eq=False)
class Interior:
    """Fields of the half-space, in natural units.

    Parameters
    ----------
    labels : of the states, `t=...` and `steady`
    points, triangles : (n, 2) radius and depth, and the triangles between them: those of the mesh, or elements of high
        degree cut into small ones
    displacement : (states, n, 2) radial, and into the half-space
    stress : (states, n, 4) rr, zz, rz, hoop
    von_mises : (states, n)
    fine_points, fine_triangles, fine_von_mises : the same on every element cut into small triangles, not averaged
        between elements: what the polynomials inside them say
    """

    labels: tuple[str, ...]
    points: Array
    triangles: Indices
    displacement: Array
    stress: Array
    von_mises: Array
    fine_points: Array
    fine_triangles: Indices
    fine_von_mises: Array


def _cut_triangle() -> tuple[Array, Indices]:
    """A lattice of reference points (2, q), and the small triangles between them (FINENESS^2, 3)."""
    n = FINENESS
    number = {pair: k for k, pair in enumerate((i, j) for j in range(n + 1) for i in range(n + 1 - j))}
    upward = [(number[i, j], number[i + 1, j], number[i, j + 1]) for i, j in number if i + j < n]
    downward = [(number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]) for i, j in number if i + j < n - 1]
    return np.array(list(number), dtype=float).T / n, np.array(upward + downward)


def interior(result: Result) -> Interior:
    """Recover the inside of the half-space from the contact pressures: at the scene's field times, and when steady."""
    from fem.hp import HpElasticity

    scene, natural = result.scene, result.scene.natural
    model = result.models["fem"]
    assert model.half_space is not None
    times = scene.output.field_times
    if times is None:
        times = [0.0] if scene.wear.steady else [0.0, scene.wear.times[-1]]
    wanted = np.array(times) / natural.time
    wear = Wear(model.compliance, natural.phases[1], float(min(wanted[wanted > 0], default=0.0)))
    pressures = list(wear.modal(wanted).pressure)
    labels = [f"t={time:g}" for time in times]
    if scene.wear.steady:
        pressures.append(wear.steady.pressure)
        labels.append("steady")
    sampled = _on_stars if isinstance(model.half_space.solid, HpElasticity) else _on_triangles
    return sampled(model.half_space, tuple(labels), np.array(pressures))


def _on_stars(half_space: HalfSpace, labels: tuple[str, ...], pressures: Array) -> Interior:
    """What the polynomials in large elements say."""
    from fem.fields import von_mises
    from fem.hp_fields import sampled

    points, triangles, moved, stress = sampled(half_space, pressures, STAR_FINENESS)
    mises = von_mises(stress)
    return Interior(labels, points, triangles, moved, stress, mises, points, triangles, mises)


def _on_triangles(half_space: HalfSpace, labels: tuple[str, ...], pressures: Array) -> Interior:
    """Averages at the vertices, and what the polynomials in the triangles say."""
    from fem.elasticity import AxisymmetricElasticity
    from fem.fields import displacements, stresses, vertex_stresses, von_mises

    solid = half_space.solid
    assert isinstance(solid, AxisymmetricElasticity)
    moved = displacements(half_space, pressures)
    stress = vertex_stresses(solid, moved)
    lattice, small = _cut_triangle()
    fine = von_mises(stresses(solid, moved, lattice)).reshape(len(moved), -1)
    corner = np.stack([1 - lattice[0] - lattice[1], lattice[0], lattice[1]])
    points = np.einsum("xvm,vq->mqx", solid.corners, corner).reshape(-1, 2)
    triangles = (lattice.shape[1] * np.arange(solid.corners.shape[2])[:, None, None] + small).reshape(-1, 3)
    mesh = solid.mesh
    at_vertices = moved[:, : len(mesh.points)]
    return Interior(labels, mesh.points, mesh.triangles, at_vertices, stress, von_mises(stress), points, triangles, fine)


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
    points = fields.points * natural.length
    upright = np.stack([points[:, 0], -points[:, 1], np.zeros(len(points))], axis=1)
    meshio.Mesh(upright, [("triangle", fields.triangles)], point_data=data).write(path, file_format="vtu")
