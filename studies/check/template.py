"""What another program has to model and to sample, so that its results can be checked."""

from itertools import pairwise
from pathlib import Path

import meshio
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..methods.fem_meshes import half_space_mesh
from ..problem.fields import over_time
from ..problem.unit_names import UnitNames
from ..scene.scene import Scene


def write_template(scene: Scene, units: str, folder: Path) -> list[str]:
    """Write a table of times and radii to fill in, a mesh, and the scene in words.

    Parameters
    ----------
    units : of theirs, as a scene states them; those of the scene if empty
    folder : where `template.csv`, `unworn.csv` of a punch that is not flat, `mesh.msh` and
        `scene.txt` go

    Returns
    -------
    the lines of `scene.txt`
    """
    problem, stated = scene.problem, UnitNames.of(scene.units)
    theirs, rings = UnitNames.of(units or scene.units), problem.graded or problem.rings
    if not scene.wear.times:
        raise SceneError("the scene has no times to sample: give wear.times")
    if scene.half_space.layers:
        raise SceneError(
            "check --template writes a homogeneous half-space: leave out half_space.layers, and "
            "make the layers in your own program"
        )

    def scaled(values: ArrayLike, kind: str) -> Array:
        return np.asarray(values) * (stated.size(kind) / theirs.size(kind))

    def write(values: ArrayLike, kind: str) -> str:
        numbers = ", ".join(f"{value:.10g}" for value in np.ravel(scaled(values, kind)))
        return f"{numbers} {theirs.name(kind)}".removesuffix(" 1")

    def write_load(name: str, kind: str) -> str:
        knots = over_time(getattr(scene.load_, name))
        at = f" at the times {write(knots.times, 'time')}" if len(knots.times) > 1 else ""
        return f"{name.replace('_', ' ')} {write(knots.values, kind)}{at}"

    ends = problem.ring_edges
    places = np.unique(np.linspace(ends[:-1], ends[1:], max(5, 64 // len(ends))))
    radii = scaled(places * problem.units.length, "length")
    times = scaled(scene.wear.times, "time")
    table = pd.MultiIndex.from_product([times, radii], names=["time", "radius"]).to_frame()
    results = ("pressure", "displacement", "profile", "indentation", "normal_force")
    table.assign(**dict.fromkeys(results, "")).to_csv(folder / "template.csv", index=False)
    if not problem.profile.flat:
        heights = (problem.profile(places) + problem.profile.standoff) * problem.units.displacement
        unworn = pd.DataFrame({"radius": radii, "unworn_profile": scaled(heights, "displacement")})
        unworn.to_csv(folder / "unworn.csv", index=False)
    reach = 100.0
    sizes = {"mesher": "gmsh", "truncation": reach}
    chosen = half_space_mesh(scene.changed(accuracy__fem=sizes).problem)
    points = chosen.mesh.p.T * scaled(scene.punch.radius, "length")
    triangles = meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), {"triangle": chosen.mesh.t.T})
    triangles.write(folder / "mesh.msh", file_format="gmsh")
    ratio, modulus = scene.half_space.poisson_ratio, problem.units.modulus
    kinds = {"normal_force": "force", "mean_pressure": "pressure", "indentation": "displacement"}
    load = next(name for name in kinds if getattr(scene.load_, name) is not None)
    lines = [
        scene.title or "Untitled scene",
        "",
        f"Punch: rigid, axisymmetric, radius a = {write(scene.punch.radius, 'length')}, moves "
        f"along its axis; its face is {'flat' if problem.profile.flat else 'that of unworn.csv'}.",
        *(
            f"Ring between {write(edges, 'length')}: k = "
            f"{write(wear[: 1 + (wear[0] != wear[1])], 'wear_coefficient')}"
            for edges, wear in zip(
                pairwise(rings.ring_edges * problem.units.length),
                rings.ends.T * problem.units.wear_coefficient,
                strict=True,
            )
        ),
        f"Half-space: elastic, E = {write(modulus * (1 - ratio**2), 'pressure')}, Poisson's ratio "
        f"{ratio:g}, so that E* = {write(modulus, 'pressure')}; small strains. No radial "
        "displacement on the axis; no friction; p >= 0 and gap >= 0 under the punch, no traction "
        "beside it.",
        "Clamped at a distance R from the centre it is indented too little, by about 1.1 a/R; "
        f"mesh.msh (x: radius, y: depth; meshio converts it) reaches to R = {reach:g} a.",
        f"Load: {write_load(load, kinds[load])}; {write_load('sliding_speed', 'wear_rate')}.",
        "Wear: df/dt = k p v, where f is the height that is gone from the face.",
        "Fill in template.csv, and leave empty what you do not have: pressure p; displacement u of "
        "the surface, into the half-space; profile f, with what the unworn face lacks; indentation "
        "d of the unworn face plane, u = d - f in contact; normal_force. Pressures at ring edges, "
        "where they jump, are not compared; at the rim they may be infinite.",
        *chosen.notes,
    ]
    (folder / "scene.txt").write_text("\n".join(lines) + "\n", "utf-8")
    return lines
