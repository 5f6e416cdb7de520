"""Simple programs as other people write them, whose results are compared with ringwear's.

The programs are linear finite elements in a box, springs on a uniform grid (MDR), and tamaas on a
square grid, whose tables are in `physics/programs`: 64 x 64 points over 2.2 radii, without
periodicity, and 240 explicit steps of Archard's law (tamaas 2.9). Each takes the input of a
user (`Input`), in which a test can make a mistake, and returns a table of time, radius, pressure,
displacement, profile and indentation. The programs have errors of a few per cent.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
from explicit_loops import condensed
from skfem import MeshTri

from ringwear import run

FOLDER = Path(__file__).parent / "physics" / "programs"


@dataclass(frozen=True)
class Input:
    """Input that a user types into a program.

    `law` is another law of wear: ``law(p, t, r)`` takes the pressure over its mean, the time
    over the last one, and the radius over that of the punch, and returns the wear rate over
    that by the mean pressure. `reach` is the side of the box relative to the radius. `layer`
    has the thickness of a layer relative to the radius, and its modulus relative to that of the
    half-space. `plane` chooses plane strain elements, which is a mistake.
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
    law: Callable[..., np.ndarray] | None = None

    @property
    def modulus(self):
        """The plane strain modulus."""
        return self.youngs / (1 - self.ratio**2)

    def wear_at(self, radii):
        """Return wear coefficients at radii."""
        ring = np.searchsorted(self.edges, radii * (1 - 1e-9)).clip(max=len(self.edges) - 1)
        return np.array(self.wear)[ring]

    def changed(self, **changes):
        """Return the input with changes."""
        return replace(self, **changes)


def input_of(scene):
    """Return the right input for a scene."""
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
    """Return a DataFrame with one row for each time and radius."""
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
    """Return pressures, profiles and indentations at the times, by explicit steps.

    The matrix `stiffness` maps displacements of nodes to forces on nodes; `force` is the total.
    """
    wear, profile, time = given.wear_at(radii) * given.speed, 0 * radii, 0.0
    # explicit steps are stable up to about this length, which is shorter for some laws
    part = 0.1 if given.law else 0.4
    stable = part / np.max(np.abs(np.linalg.eigvals(stiffness / areas[:, None] * wear)))
    rigid, states, last, mean = stiffness.sum(axis=1), [], max(given.times), force / areas.sum()
    for end in given.times:
        count = int(np.ceil((end - time) / min(stable, last / steps_to_longest)))
        for step in range(count):
            depth = (force + rigid @ profile) / rigid.sum()
            rate = stiffness @ (depth - profile) / areas
            if given.law:
                now = (time + (end - time) * step / count) / last
                rate = mean * given.law(rate / mean, now, radii / given.radius)
            profile = profile + wear * rate * (end - time) / count
        time, depth = end, (force + rigid @ profile) / rigid.sum()
        states.append((stiffness @ (depth - profile) / areas, profile, depth))
    return zip(*states, strict=True)


def finite_elements(given, cells=40):
    """Return a table by linear triangles in a box with a clamped outer boundary."""
    size, shear = given.radius, given.youngs / (2 * (1 + given.ratio))
    thickness, softness = given.layer or (0.0, 1.0)
    lines = np.append(np.linspace(0, 1, cells + 1), np.geomspace(1 + 1 / cells, given.reach, cells))
    # rounded, so that no two lines differ by roundoff only
    depths = np.unique(np.append(lines, thickness).round(9))
    mesh = MeshTri.init_tensor(lines, -depths[::-1]).scaled((1.0, -1.0))

    def shear_at(depth):
        return shear * np.where(depth < thickness, softness, 1.0)

    radii, stiffness = condensed(mesh, "P1", given.ratio, shear_at, given.plane)
    ends = np.clip(np.arange(-0.5, cells + 1) / cells, 0, 1) * size
    areas = np.diff(2 * ends if given.plane else np.pi * ends**2)
    stiffness = stiffness * (1.0 if given.plane else size)
    results = explicit_steps(given, stiffness, areas, radii * size, given.force, 400)
    rows = table(given.times, radii * size, *results)
    return rows[~rows["radius"].isin([edge for edge in given.edges if edge < size])]


def springs(given, cells=120):
    """Return a table by springs (MDR) on a uniform grid, whose pressures are sums of flat punches.

    The line density is q = d - g. Each interval of the grid has one flat punch, whose pressure and
    displacement have closed forms.
    """
    size = given.radius
    ends = np.linspace(0, 1, cells + 1) * size
    radii, places = (ends[1:] + ends[:-1]) / 2, ends[1:]
    # a flat punch of radius b under the force F has p = F / (2 pi b sqrt(b^2 - r^2)): the share of
    # its force on each ring of the grid, and the displacement (2/pi) d arcsin(b/r) outside it
    inner, outer = ends[:-1], ends[1:]
    root = np.sqrt(np.maximum(places[:, None] ** 2 - ends**2, 0.0))
    shares = (root[:, :-1] - root[:, 1:]) / places[:, None]
    areas = np.pi * (outer**2 - inner**2)
    moved = np.arcsin(np.minimum(places[:, None] / radii, 1.0)) * 2 / np.pi
    # forces on rings due to the depth of each flat punch; displacements are `moved` times depths
    forces = 2 * given.modulus * places[:, None] * shares
    stiffness = np.linalg.solve(moved.T, np.eye(cells)).T @ forces
    results = explicit_steps(given, stiffness.T, areas, radii, given.force, 400)
    return table(given.times, radii, *results)


def ours(scene, **changes):
    """Return our results of a scene with changes, as a table of another program."""
    radii = np.linspace(0.008, 0.99, 60) * scene.punch.radius
    dataset = run(scene.changed(output__radii=radii.tolist(), **changes), methods=["mdr"]).dataset
    names = ("pressure", "displacement", "profile", "indentation")
    columns = {name: dataset[name].isel(solver=0) for name in names}
    rows = [
        pd.DataFrame(
            {"time": time, "radius": radii}
            | {name: values.sel(time=time).values for name, values in columns.items()}
        )
        for time in scene.wear.times
    ]
    return pd.concat(rows, ignore_index=True)


@cache
def of_tamaas(name):
    """Return a table of tamaas; plane strain modulus, radius, force and speed are 1."""
    return pd.read_csv(FOLDER / f"{name}.csv", comment="#")
