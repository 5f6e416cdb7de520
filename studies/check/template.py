"""Write a template: what another program must model and sample so that it can be checked."""

from itertools import pairwise
from pathlib import Path

import meshio
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ...meshes import Array, SceneError
from ..crosscheck import Scene, UnitNames, fem_sizes, over_time


def write_template(scene: Scene, units: str, folder: Path) -> list[str]:
    """Write a table of times and radii to fill in, a mesh, and a description of the scene.

    Parameters
    ----------
    units : of the files, in the notation of a scene; if empty, those of the scene
    folder : to which `template.csv`, `mesh.msh`, `scene.txt` and, for a punch that is not flat,
        `unworn.csv` are written

    Returns
    -------
    the lines of `scene.txt`

    Raises
    ------
    SceneError
        if the scene has no times, or if it has layers
    """
    problem, scene_units = scene.problem, scene.unit_names
    file_units = scene_units
    if units:
        file_units = UnitNames.of(units, scene.load_.times_are_distances)
    rings = problem.graded or problem.rings
    if not scene.wear.times:
        raise SceneError("the scene has no times at which results are sampled: give wear.times")
    if scene.half_space.layers:
        raise SceneError(
            "check --template describes a homogeneous half-space: leave out half_space.layers, and "
            "model the layers in your own program"
        )

    def scaled(values: ArrayLike, kind: str) -> Array:
        return np.asarray(values) * (scene_units.size(kind) / file_units.size(kind))

    def write(values: ArrayLike, kind: str) -> str:
        numbers = ", ".join(f"{value:.10g}" for value in np.ravel(scaled(values, kind)))
        return f"{numbers} {file_units.name(kind)}".removesuffix(" 1")

    def write_load(name: str, kind: str) -> str:
        knots = over_time(getattr(scene.load_, name))
        when = f" at the times {write(knots.times, 'time')}" if len(knots.times) > 1 else ""
        return f"{name.replace('_', ' ')} {write(knots.values, kind)}{when}"

    edges = problem.ring_edges
    samples = np.unique(np.linspace(edges[:-1], edges[1:], max(5, 64 // len(edges))))
    radii = scaled(samples * problem.units.length, "length")
    times = scaled(scene.wear.times, "time")
    table = pd.MultiIndex.from_product([times, radii], names=["time", "radius"]).to_frame()
    results = ("pressure", "displacement", "profile", "indentation", "normal_force")
    table.assign(**dict.fromkeys(results, "")).to_csv(folder / "template.csv", index=False)
    if not problem.profile.flat:
        heights = (problem.profile(samples) + problem.profile.standoff) * problem.units.displacement
        unworn = pd.DataFrame({"radius": radii, "unworn_profile": scaled(heights, "displacement")})
        unworn.to_csv(folder / "unworn.csv", index=False)
    reach = 100.0
    sizes = {"mesher": "gmsh", "truncation": reach}
    half_space = fem_sizes(scene.changed(accuracy__fem=sizes).problem)
    points = half_space.mesh.p.T * scaled(scene.punch.radius, "length")
    triangles = meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), {"triangle": half_space.mesh.t.T})
    triangles.write(folder / "mesh.msh", file_format="gmsh")
    ratio, modulus = scene.half_space.poisson_ratio, problem.units.modulus
    kinds = {"normal_force": "force", "mean_pressure": "pressure", "indentation": "displacement"}
    load = next(name for name in kinds if getattr(scene.load_, name) is not None)
    sliding = write_load("sliding_speed", "speed")
    if scene.load_.times_are_distances:
        sliding = "times are sliding distances"
    bodies = ""
    if scene.half_space.punch_youngs_modulus is not None:
        bodies = ", the combined modulus of two elastic bodies"
    lines = [
        scene.title or "Untitled scene",
        "",
        f"Punch: rigid, axisymmetric, radius a = {write(scene.punch.radius, 'length')}, moves "
        f"along its axis; its face is {'flat' if problem.profile.flat else 'that of unworn.csv'}.",
        *(
            f"Ring between the radii {write(ends, 'length')}: k = "
            f"{write(wear[: 1 + (wear[0] != wear[1])], 'wear_coefficient')}"
            for ends, wear in zip(
                pairwise(rings.ring_edges * problem.units.length),
                rings.wear_coefficients.T * problem.units.wear_coefficient,
                strict=True,
            )
        ),
        f"Half-space: elastic, E = {write(modulus * (1 - ratio**2), 'pressure')}, Poisson's ratio "
        f"{ratio:g}, so that E* = {write(modulus, 'pressure')}{bodies}; small strains. No radial "
        "displacement on the axis; no friction; p >= 0 and gap >= 0 under the punch, no traction "
        "beside it.",
        "If the half-space is clamped at a distance R from the centre, the relative error of the "
        "indentation is about -1.1 a/R; mesh.msh (x: radius, y: depth; meshio converts it) reaches "
        f"to R = {reach:g} a.",
        f"Load: {write_load(load, kinds[load])}; {sliding}.",
        "Wear: df/dt = k p v, where f is the height that has been worn off the face.",
        "Fill in template.csv, and leave cells empty if you do not have the values: pressure p; "
        "displacement u of the surface, into the half-space; profile f, the height that is missing "
        "from the face plane: unworn shape plus worn height; indentation d of the plane of the "
        "unworn face, u = d - f in contact; normal_force. Pressures at ring edges, where they "
        "jump, are not compared; at the rim they may be infinite.",
        *half_space.notes,
    ]
    (folder / "scene.txt").write_text("\n".join(lines) + "\n", "utf-8")
    return lines
