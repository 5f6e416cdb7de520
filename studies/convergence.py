"""Orders of convergence in the element size and the degree: finite elements and MDR, graded and uniform meshes.

An order is only as clean as its sequence of meshes. One base mesh is therefore subdivided, every triangle into n^2: at
the rim and ring edges, and far away, in log-polar coordinates, in which a graded mesh is uniform (halved in plain
coordinates, it approaches its order from below by a term in h; in these by h^2), elsewhere in plain ones. The outer
boundary is at 1e4 a: nodal values on it match Boussinesq's field to order 4 (P2, P3) and 6 (P4) only, times ``a/R``.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from mdr import direct
from meshes.compliance import Compliance
from meshes.errors import MeshError
from meshes.half_space import HalfSpaceMesh, SizeField, assemble
from meshes.pressure_space import PressureSpace
from meshes.radial import Array, Indices, graded_breakpoints

from .contact import flat_start
from .levels import LEVEL_FIELDS, Recorder, Table, draw_orders, keeping_rows, legend_below, new_figure, style, write_markdown
from .methods import edge_weight
from .natural import NaturalScene
from .scene import Scene
from .stages import Report
from .wear import Wear

FAR, TRUNCATION = 1.6, 1e4
# sizes of the base meshes: rim, ring edges, growth
PUNCH_SIZES, RING_SIZES, UNIFORM_SIZES = (4e-9, 4e-9, 0.7), (1e-7, 1e-6, 0.7), (0.35, 0.35, 0.0)
MDR_SIZES = 1e-7, 1e-9  # ring edges, rim
UNIFORM_TRUNCATION = 4.0
TIME = 1.0  # of the history, in natural units
# subdivisions by degree: of the homogeneous punch, of the same on a uniform mesh, of the scene's rings
PUNCH = {2: (2, 3, 4, 6, 8), 3: (2, 3, 4, 5), 4: (1, 2, 3, 4)}
UNIFORM = {2: (3, 4, 6, 8, 12), 3: (2, 3, 4, 6), 4: (2, 3, 4)}
RINGS = {2: (2, 3, 4), 3: (1, 2, 3), 4: (1, 2)}
QUICK_LEVELS = {2: (2, 3, 4), 3: (2, 3), 4: (2, 3)}
# by degree: ratios of neighbouring sizes of the radial mesh
MDR_GRADINGS = {1: (0.4, 0.5, 0.6, 0.7), 2: (0.25, 0.35, 0.45, 0.55), 3: (0.15, 0.22, 0.3, 0.4), 4: (0.1, 0.15, 0.2, 0.27)}
RAISED_DEGREES, RAISED_GRADING = (1, 2, 3, 4, 5, 6), 0.2
# relative: below, the innermost elements (their share is proportional to their size) and roundoff take over
SLOPE_FLOOR, SHARE_OF_RIM = 3e-5, 0.06
ORDER_FIELDS = (
    "refined", "quantity", "levels", "expected order", "least squares", "between levels", "finest error",
    "Richardson value", "GCI", "three finest",
)  # fmt: skip


def subdivided(mesh: HalfSpaceMesh, count: int, tips: Array) -> HalfSpaceMesh:
    """Every triangle into ``count^2``: in log-polar coordinates about `tips` (radii) and far away, else in plain ones.

    A new point is told by the vertices it lies between and its weight on each, so that neighbours agree on it; in
    which coordinates it is interpolated depends on these vertices alone.
    """
    lattice, small = _lattice(count)
    weights = np.broadcast_to(lattice, (len(mesh.triangles), *lattice.shape))
    vertices = np.where(weights > 0, mesh.triangles[:, None, :], -1)
    order = np.argsort(vertices, axis=-1)
    told = np.concatenate([np.take_along_axis(part, order, axis=-1) for part in (vertices, weights)], axis=-1)
    unique, number = np.unique(told.reshape(-1, 6), axis=0, return_inverse=True)
    between, weight = unique[:, :3], unique[:, 3:] / count
    between = np.where(weight > 0, between, between[:, 2:])
    points = _interpolated(mesh.points, between, weight, tips)
    for axis in (0, 1):
        points[(mesh.points[between, axis] == 0).all(axis=1), axis] = 0.0
    kept = weight[:, 2] == 1
    points[kept] = mesh.points[between[kept, 2]]
    triangles = number.reshape(len(mesh.triangles), -1)[:, small].reshape(-1, 3)
    edges = mesh.contact_radii[[0, -1]]
    return assemble(points, triangles, edges, mesh.mesher)


def _lattice(count: int) -> tuple[Indices, Indices]:
    """Integer barycentric coordinates (m, 3) of the points in a subdivided triangle, and its small triangles."""
    i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
    inside = i + j <= count
    number = np.full(inside.shape, -1)
    number[inside] = np.arange(inside.sum())
    upright = np.stack([number[:-1, :-1], number[1:, :-1], number[:-1, 1:]], axis=-1).reshape(-1, 3)
    turned = np.stack([number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 3)
    triangles = np.concatenate([upright, turned])
    return np.stack([count - i - j, i, j], axis=-1)[inside], triangles[triangles.min(axis=1) >= 0]


def _interpolated(points: Array, between: Indices, weight: Array, tips: Array) -> Array:
    centres = np.append(tips, 0.0)
    distance = np.hypot(points[:, 0, None] - centres, points[:, 1, None])
    chart = np.full(len(points), -1)
    if len(tips):
        nearest = distance[:, :-1].argmin(axis=1)
        # well inside half the distance to the next singular point, or to the axis
        reach = 0.6 * np.minimum(np.diff(tips, prepend=0.0), np.diff(tips, append=np.inf))
        chart = np.where(distance[:, :-1].min(axis=1) < reach[nearest], nearest, chart)
    chart[distance[:, -1] > FAR] = len(tips)
    out, plain = np.zeros((len(between), 2)), np.ones(len(between))
    for number, centre in enumerate(centres):
        rho = distance[:, number]
        # a centre has no logarithm: the triangles at it are subdivided plainly
        share = np.where(rho[between].min(axis=1) > 0, np.sum(weight * (chart[between] == number), axis=1), 0.0)
        log = np.log(np.where(rho > 0, rho, 1.0))
        radius = np.exp(np.sum(weight * log[between], axis=1))
        angle = np.sum(weight * np.arctan2(points[:, 1], points[:, 0] - centre)[between], axis=1)
        out += (share * radius * np.array([np.cos(angle), np.sin(angle)])).T
        out[:, 0] += share * centre
        plain -= share
    return out + plain[:, None] * np.einsum("pv,pvx->px", weight, points[between])


def condensed(mesh: HalfSpaceMesh, edges: Array, degree: int, poisson_ratio: float) -> tuple[Compliance, int]:
    """Compliance and number of unknowns of the finite-element half-space on a mesh."""
    from fem.compliance import MULTIPLIER_DEGREE, HalfSpace, pressure_space
    from fem.elasticity import AxisymmetricElasticity

    space = pressure_space(mesh, edges, MULTIPLIER_DEGREE[degree])
    half_space = HalfSpace(AxisymmetricElasticity(mesh, degree, poisson_ratio), space)
    return half_space.compliance(), half_space.unknowns


def base_mesh(edges: Array, sizes: tuple[float, float, float], truncation: float) -> HalfSpaceMesh:
    """The mesh to subdivide, by gmsh or, where that cannot be loaded or fails at such sizes, by bisection."""
    from meshes import bisection, gmsh_mesher

    field = SizeField(tuple(float(edge) for edge in edges), *sizes, truncation, centre_size=truncation)
    try:
        return gmsh_mesher.mesh(field)
    except MeshError:
        return bisection.mesh(field)


class Quantities:
    """The quantities that are refined, and their exact values: closed form, or a fine MDR."""

    def __init__(self, natural: NaturalScene) -> None:
        self.edges, self.wear = natural.phases
        breakpoints = graded_breakpoints(self.edges, 1e-7, 1e-10, 0.15)
        fine = self._mdr(PressureSpace(breakpoints, np.full(len(breakpoints) - 1, 8), self.edges))
        pressures = direct.steady_pressures(self.edges, self.wear)
        self.exact = self(fine) | {"d0": 0.5, "RMS gradient": direct.rms_slope(self.edges, pressures)}

    @staticmethod
    def _mdr(space: PressureSpace) -> Compliance:
        from mdr.compliance import compliance

        return compliance(space)

    def __call__(self, compliance: Compliance) -> dict[str, float]:
        """Every quantity of a compliance, in natural units."""
        wear, space = Wear(compliance, self.wear), compliance.space
        state, history = wear.steady, wear.modal(np.array([TIME]))
        slopes = space.slope_gram(edge_weight(space, "line"))
        steady = compliance.factor @ state.pressure
        return {
            "d0": flat_start(compliance).indentation,
            f"d({TIME:g})": float(history.indentation[0]),
            "slowest relaxation time": float(wear.relaxation_times[0]),
            f"force on the outer ring at {TIME:g}": float(space.ring_forces(self.edges)[-1] @ history.pressure[0]),
            "mean steady displacement": float(steady @ steady),
            "RMS gradient": float(np.sqrt(state.displacement @ slopes @ state.displacement)),
        }

    def by_mdr(self, degree: int, grading: float) -> tuple[dict[str, float], int]:
        """The quantities by MDR on a radial mesh whose neighbouring sizes have the ratio `grading`."""
        breakpoints = graded_breakpoints(self.edges, *MDR_SIZES, grading)
        space = PressureSpace(breakpoints, np.full(len(breakpoints) - 1, degree), self.edges)
        values = self(self._mdr(space))
        # the factor holds q exactly: the energy of a known pressure has no error to refine
        del values["mean steady displacement"]
        return values, space.size


def conduct(scene: Scene, out: Path, options: argparse.Namespace, report: Report) -> list[str]:
    """Refine everything; writes `convergence.csv`, `orders.csv`, `convergence.md` and `convergence.png`."""
    quick = bool(options.quick)
    conclusions: list[str] = []
    by_degree: dict[int, float] = {}
    with threadpool_limits(1):
        quantities = Quantities(scene.natural)
        table = Table(out / "convergence.csv", LEVEL_FIELDS)
        recorder = Recorder(table, quantities.exact, {"RMS gradient": SLOPE_FLOOR}, report)
        with keeping_rows(conclusions):
            refine_mdr(recorder, quantities, quick)
            by_degree = raise_degree(recorder, quantities)
            refine_punch(recorder, scene.half_space.poisson_ratio, quick)
            if not quick:
                refine_rings(recorder, quantities, scene.half_space.poisson_ratio)
    orders = Table(out / "orders.csv", ORDER_FIELDS)
    for sequence in recorder.sequences.values():
        orders.add(**sequence.summary())
    conclusions[:0] = conclude(recorder)
    draw(recorder, by_degree, out / "convergence.png")
    write_markdown(out / "convergence.md", "Orders of convergence", conclusions, {"Orders": orders})
    return [*conclusions, orders.markdown()]


def refine_mdr(recorder: Recorder, quantities: Quantities, quick: bool) -> None:
    """MDR: squares of the best approximation by degree q, in the energy (d0), in the mean, and of slopes."""
    for degree in (1, 2) if quick else (1, 2, 3, 4):
        expected = {"d0": 2 * degree + 3.0, "RMS gradient": 2.0 * degree, "": 2 * degree + 2.0}
        for grading in MDR_GRADINGS[degree][: 3 if quick else None]:

            def compute(degree: int = degree, grading: float = grading) -> tuple[dict[str, float], int]:
                return quantities.by_mdr(degree, grading)

            # how fast polynomials converge on elements that are singular one element away (Bernstein's ellipse)
            size = (1 - grading**0.5) / (1 + grading**0.5)
            recorder.level(f"MDR degree {degree}, graded", size, expected, compute, SHARE_OF_RIM * MDR_SIZES[1])


def raise_degree(recorder: Recorder, quantities: Quantities) -> dict[int, float]:
    """Error of d0 by MDR on one radial mesh, by the degree: each gains a factor."""
    by_degree = {}
    for degree in RAISED_DEGREES:
        values, unknowns = quantities.by_mdr(degree, RAISED_GRADING)
        for quantity, value in values.items():
            error = value / recorder.exact[quantity] - 1
            recorder.table.add(
                refined=f"MDR, degree {degree} on one mesh", quantity=quantity, unknowns=unknowns, value=value, error=error
            )
        by_degree[degree] = abs(values["d0"] / recorder.exact["d0"] - 1)
    return by_degree


def refine_punch(recorder: Recorder, poisson_ratio: float, quick: bool) -> None:
    """The flat start by finite elements, on a graded and on a uniform mesh."""
    edges = np.array([0.0, 1.0])
    meshes = (
        ("graded", edges[1:], PUNCH, base_mesh(edges, PUNCH_SIZES, TRUNCATION)),
        ("uniform", edges[:0], UNIFORM, base_mesh(edges, UNIFORM_SIZES, UNIFORM_TRUNCATION)),
    )
    for name, tips, levels, base in meshes:
        for degree, counts in (QUICK_LEVELS if quick else levels).items():
            expected = {"d0": 2.0 * degree if len(tips) else 1.0}
            for count in counts:

                def compute(
                    base: HalfSpaceMesh = base, tips: Array = tips, degree: int = degree, count: int = count
                ) -> tuple[dict[str, float], int]:
                    compliance, unknowns = condensed(subdivided(base, count, tips), edges, degree, poisson_ratio)
                    return {"d0": flat_start(compliance).indentation}, unknowns

                floor = SHARE_OF_RIM * PUNCH_SIZES[0]
                recorder.level(f"FEM P{degree}, {name}", 1 / count, expected, compute, floor)


def refine_rings(recorder: Recorder, quantities: Quantities, poisson_ratio: float) -> None:
    """The scene's rings by finite elements, on a mesh graded to every ring edge."""
    edges = quantities.edges
    base = base_mesh(edges, RING_SIZES, TRUNCATION)
    for degree, counts in RINGS.items():
        # slopes are those of the displacement on the multipliers' space, one degree lower
        expected = {"": 2.0 * degree, "RMS gradient": 2.0 * (degree - 1)}
        for count in counts:

            def compute(degree: int = degree, count: int = count) -> tuple[dict[str, float], int]:
                compliance, unknowns = condensed(subdivided(base, count, edges[1:]), edges, degree, poisson_ratio)
                return quantities(compliance), unknowns

            floor = SHARE_OF_RIM * RING_SIZES[0]
            recorder.level(f"FEM P{degree}, rings, graded", 1 / count, expected, compute, floor)


def conclude(recorder: Recorder) -> list[str]:
    """The orders of d0 in a line."""
    graded, uniform = (
        ", ".join(f"{s.name.split(',')[0].removeprefix('FEM ')} {s.order:.2f}" for s in recorder.of("d0", *names))
        for names in ([f"FEM P{k}, {mesh}" for k in PUNCH] for mesh in ("graded", "uniform"))
    )
    return [f"d0 converges with order {graded} on graded meshes (theory 4, 6, 8), but {uniform} on uniform ones (1)."]


def draw(recorder: Recorder, by_degree: dict[int, float], path: Path) -> None:
    """Finite elements graded against uniform, MDR, and the error against the degree."""
    figure = new_figure(13, 5.6)
    left, middle, right = figure.subplots(1, 3)
    error = r"relative error of the flat start, $|d_0 / (F/2aE^*) - 1|$"
    size = r"element size over the base mesh's, $h/h_0 = 1/n$"
    punch = [f"FEM P{degree}, {mesh}" for mesh in ("graded", "uniform") for degree in PUNCH]
    draw_orders(left, recorder.of("d0", *punch), size, error)
    left.set_title("finite elements", fontsize=9)
    size = r"$h = (1-\sqrt{q})/(1+\sqrt{q})$, $q$ the ratio of neighbouring sizes"
    draw_orders(middle, recorder.of("d0", "MDR"), size, error)
    middle.set_title("MDR, piecewise polynomial pressure", fontsize=9)
    curves = {f"MDR, pressure of degree $k$, $q$ = {RAISED_GRADING:g}": by_degree}
    for mesh in ("graded", "uniform"):
        found = {k: s for k in PUNCH for s in recorder.of("d0", f"FEM P{k}, {mesh}") if 1 / 3 in s.sizes}
        curve = {k: float(s.errors[s.sizes == 1 / 3][0]) for k, s in found.items()}
        curves[f"FEM, displacement of degree $k$, {mesh}, $n$ = 3"] = curve
    for number, (label, curve) in enumerate(curves.items()):
        right.semilogy(list(curve), list(curve.values()), label=label, **style(number))
    right.set(xlabel="polynomial degree $k$", ylabel=error, xticks=RAISED_DEGREES)
    right.set_title("raising the degree on one mesh", fontsize=9)
    right.grid(True, color="0.88", linewidth=0.6)
    legend_below(right)
    figure.savefig(path)
