"""Programs of others, as people write them, for results that ringwear did not compute.

Each takes what a user types in (`Input`), so that mistakes can be typed in, and returns a table of
time, radius, pressure, displacement, profile and indentation. Their own errors are a few per cent:
linear finite elements in a box, springs on a uniform grid (MDR), and, from `tamaas_wear.py`, tables
of tamaas on squares of points.
"""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

FOLDER = Path(__file__).parent / "physics" / "programs"


@dataclass(frozen=True)
class Input:
    """What a user types into a program.

    `reach` is the side of the box over the radius, `layer` the thickness and the modulus of a layer
    over the radius and over the modulus, `plane` whether elements are of plane strain.
    """

    radius: float
    edges: tuple[float, ...]
    wear: tuple[float, ...]
    youngs: float
    ratio: float
    force: float
    speed: float
    times: tuple[float, ...]
    reach: float = 200.0
    layer: tuple[float, float] | None = None
    plane: bool = False

    @property
    def modulus(self):
        """The plane strain modulus."""
        return self.youngs / (1 - self.ratio**2)

    def wear_at(self, radii):
        """Wear coefficients at radii."""
        ring = np.searchsorted(self.edges, radii * (1 - 1e-9)).clip(max=len(self.edges) - 1)
        return np.array(self.wear)[ring]

    def changed(self, **changes):
        """Return what another user types in."""
        return replace(self, **changes)


def input_of(scene):
    """Return what is typed in by somebody who makes no mistake."""
    punch, ground = scene.punch, scene.half_space
    edges = scene.problem.ring_edges[1:] * punch.radius
    youngs = ground.youngs_modulus or ground.plane_strain_modulus * (1 - ground.poisson_ratio**2)
    wear = np.resize(punch.coefficients, len(edges))
    force = scene.load_.normal_force
    return Input(
        punch.radius,
        tuple(edges.tolist()),
        tuple(wear.tolist()),
        youngs,
        ground.poisson_ratio,
        force,
        scene.load_.sliding_speed,
        tuple(scene.wear.times),
    )


def table(times, radii, pressures, profiles, depths):
    """Return rows of all times and radii."""
    rows = [
        pd.DataFrame(
            {
                "time": time,
                "radius": radii,
                "pressure": pressure,
                "displacement": depth - profile,
                "profile": profile,
                "indentation": depth,
            }
        )
        for time, pressure, profile, depth in zip(times, pressures, profiles, depths, strict=True)
    ]
    return pd.concat(rows, ignore_index=True)


def explicit_steps(given, stiffness, areas, radii, force, steps_to_longest):
    """Return pressures, profiles and depths at the times, by explicit steps of Archard's law.

    `stiffness` are the forces on nodes by displacements of nodes, `force` that of all of them.
    """
    wear, profile, time = given.wear_at(radii) * given.speed, 0 * radii, 0.0
    # explicit steps are stable to about this
    stable = 0.4 / np.max(np.abs(np.linalg.eigvals(stiffness / areas[:, None] * wear)))
    rigid, found = stiffness.sum(axis=1), []
    for end in given.times:
        count = int(np.ceil((end - time) / min(stable, max(given.times) / steps_to_longest)))
        for _ in range(count):
            depth = (force + rigid @ profile) / rigid.sum()
            profile = (
                profile + wear * (stiffness @ (depth - profile)) / areas * (end - time) / count
            )
        time, depth = end, (force + rigid @ profile) / rigid.sum()
        found.append((stiffness @ (depth - profile) / areas, profile, depth))
    return zip(*found, strict=True)


def finite_elements(given, cells=40):
    """Linear triangles in a box that is clamped outside; displacements are prescribed."""
    from scipy.sparse.linalg import splu
    from skfem import Basis, BilinearForm, ElementTriP1, ElementVector, MeshTri, enforce
    from skfem.helpers import ddot, div, sym_grad

    size, plane = given.radius, given.plane
    radii = np.linspace(0, 1, cells + 1)
    thickness, softness = given.layer or (0.0, 1.0)
    lines = np.append(radii, np.geomspace(1 + 1 / cells, given.reach, cells))
    # rounded, lest a line stands twice beside itself
    depths = np.unique(np.append(lines, thickness).round(9))
    mesh = MeshTri.init_tensor(lines, -depths[::-1])
    shear, ratio = given.youngs / (2 * (1 + given.ratio)), given.ratio

    @BilinearForm
    def stiffness(u, v, at):
        modulus = shear * np.where(at.x[1] > -thickness, softness, 1.0)
        lame = 2 * modulus * ratio / (1 - 2 * ratio)
        hoop, hoop_v = (0.0, 0.0) if plane else (u[0] / at.x[0], v[0] / at.x[0])
        around = 2.0 if plane else 2 * np.pi * at.x[0] * size
        strain = ddot(sym_grad(u), sym_grad(v)) + hoop * hoop_v
        return around * (lame * (div(u) + hoop) * (div(v) + hoop_v) + 2 * modulus * strain)

    basis, (r, z) = Basis(mesh, ElementVector(ElementTriP1())), mesh.p
    (across, down), far = basis.nodal_dofs, (r == given.reach) | (z == z.min())
    fixed, contact = np.append(across[far | (r == 0)], down[far]), down[(z == 0) & (r <= 1)]
    contact = contact[np.argsort(r[(z == 0) & (r <= 1)])]
    loads = np.zeros((basis.N, cells + 1))
    loads[contact, range(cells + 1)] = 1
    matrix = enforce(stiffness.assemble(basis), D=fixed).tocsc()
    stiff = np.linalg.inv(splu(matrix).solve(loads)[contact])
    ends = np.clip(np.arange(-0.5, cells + 1) / cells, 0, 1) * size
    areas = np.diff(2 * ends if plane else np.pi * ends**2)
    results = explicit_steps(given, stiff, areas, radii * size, given.force, 400)
    rows = table(given.times, radii * size, *results)
    return rows[~rows["radius"].isin([edge for edge in given.edges if edge < size])]


def springs(given, cells=120):
    """The rule of springs on a uniform grid: q = d - g, and pressures by a sum of flat punches.

    Abel's integrals are taken between the points of the grid, in closed form for linear profiles.
    """
    size = given.radius
    ends = np.linspace(0, 1, cells + 1) * size
    radii, places = (ends[1:] + ends[:-1]) / 2, ends[1:]
    # a flat punch of radius b under the force F has p = F / (2 pi b sqrt(b^2 - r^2)): its share in
    # each ring, and the displacement (2/pi) d arcsin(b/r) beside it
    inner, outer = ends[:-1], ends[1:]
    root = np.sqrt(np.maximum(places[:, None] ** 2 - ends**2, 0.0))
    shares = (root[:, :-1] - root[:, 1:]) / places[:, None]
    areas = np.pi * (outer**2 - inner**2)
    moved = np.arcsin(np.minimum(places[:, None] / radii, 1.0)) * 2 / np.pi
    # forces on rings by the depth of each flat punch, and displacements by these depths
    forces = 2 * given.modulus * places[:, None] * shares
    stiffness = np.linalg.solve(moved.T, np.eye(cells)).T @ forces
    results = explicit_steps(given, stiffness.T, areas, radii, given.force, 400)
    return table(given.times, radii, *results)


@cache
def of_tamaas(name):
    """A table of tamaas, which `tamaas_wear.py` has written."""
    return pd.read_csv(FOLDER / f"{name}.csv", comment="#")
