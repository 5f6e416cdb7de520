"""Orders of convergence in the element size and the degree.

Finite elements and MDR, graded and uniform meshes. For finite elements one base mesh is subdivided:
an order is only as clean as its sequence of meshes.

Theory, for displacements of degree k and pressures of degree q: energies (d0, displacements,
relaxation times) are of order 2k on graded meshes and of order 1, set by the singular rim, on
uniform ones. By MDR the energy norm of a pressure is half an order weaker than the mean square: d0
is of order 2q+3, a history with its mean squares of order 2q+2, the RMS gradient of order 2q. Even
degrees come up to 2q+3, odd ones down: plane waves ``exp(ikx)`` at kh = 0.7 give 5.34, 6.60, 9.21,
10.77 (Fourier analysis); degree 4 meets roundoff before.

On quadrilaterals whose layers shrink by ``q``, the degree k itself is raised (hp). A layer ends one
layer off the singular point: polynomials converge there as ``r^k`` with ``r = (1-sqrt q)/(1+sqrt
q)``, by Bernstein's ellipse (Gui & Babuška 1986), and energies as ``r^2k``: a factor of 9 per
degree for q = 1/4. Layers further in have lower degrees, but ever less energy: they take some of
the factor, and powers of k make it greater at first. The size of a raised degree is ``10^-degree``,
so that its order is the digits that a degree gains.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...fem.contact_meshes import even_half_space
from ...mdr import direct, energy, ring_kernel
from ...meshes import bisection
from ...meshes.compliance import Compliance
from ...meshes.pressure_space import PressureSpace
from ...meshes.quads import graded
from ...meshes.radial import Array, graded_breakpoints
from ...meshes.sizes import SizeField
from ..methods.moving_evaluation import MovingContact
from ..methods.spaces import first_contact
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..sampling.norms import Results, differences
from ..sizes.defaults import FACTOR, GROWTH
from ..study.levels import Family, Record, Theory
from ..study.options import Options
from ..study.study import Study
from ..study.study_orders import study_orders
from ..tables import Row
from .core import FLAT, Discretised, condense, evaluate, flat_d0_error
from .subdivision import subdivided, triangulated

PUNCH_RIM, RING_EDGE = 1e-13, 1e-7
"""Sizes of the smallest elements: by MDR at the rim of the flat punch; of rings."""
PUNCH_MESH = SizeField((0.0, 1.0), 4e-9, 4e-9, growth=0.7, truncation=1e4, centre_size=1e4)
UNIFORM_MESH = SizeField((0.0, 1.0), 0.35, 0.35, growth=0.0, truncation=4.0, centre_size=4.0)
GRADINGS = {
    1: (0.5, 0.6, 0.7, 0.8),
    2: (0.7, 0.78, 0.84, 0.88),
    3: (0.3, 0.4, 0.5, 0.6),
    4: (0.4, 0.5, 0.6, 0.65),
}
"""MDR: by degree, ratios of neighbouring sizes of the mesh graded to the rim."""
XLABELS = {
    "FEM P": "element size over the base mesh's, $1/n$",
    "FEM quads": "$10^{-k}$, $k$ the degree on quadrilaterals",
    "MDR": r"$(1-\sqrt{q})/(1+\sqrt{q})$, $q$ the ratio of sizes",
}
"""Sizes by the beginning of a family's name."""
QUAD_DEGREES = range(4, 12)
GAIN = ((1 + FACTOR**0.5) / (1 - FACTOR**0.5)) ** 2
"""Factor per degree on quadrilaterals, by theory."""


def conduct(scene: Scene, options: Options, record: Record) -> Study:
    """Refine everything."""
    flat = scene.problem.full_contact
    refined = (families if flat else families_of_cells)(scene.problem, options.quick)
    found = study_orders(refined, record, "convergence", scene, "relative error")
    if flat:
        return found
    scatter = (
        "Edges lie anywhere within a cell, so that orders scatter; by cells half as large, "
        "those of the last levels look high. Left out: higher degrees of the pressure, whose "
        "sign is asked for at nodes, and which an edge within an element spoils."
    )
    return replace(found, conclusions=(*found.conclusions, scatter))


def families(problem: Problem, quick: bool) -> Iterator[Family]:
    """Yield MDR and finite elements, on the flat start and on rings, by size and by degree."""
    edges, ratio = problem.merged.ring_edges, problem.poisson_ratio
    # exact values of rings: by a fine MDR, and their gradient in closed form
    hollow = problem.merged.hollow
    exact = ring_quantities(problem, by_mdr(edges, RING_EDGE, 10, 0.15, hollow)[0])
    steady = direct.steady_pressures(*problem.merged)
    exact["RMS gradient"] = direct.rms_slope(edges, steady, inner_radius=problem.inner_radius)

    def flat(compliance: Compliance) -> Row:
        return {"d0": flat_d0_error(compliance)}

    def worn(compliance: Compliance) -> Row:
        values = ring_quantities(problem, compliance)
        return {quantity: values[quantity] / exact[quantity] - 1 for quantity in exact}

    def refine(
        name: str,
        discretise: Callable[[Any], Discretised],
        sizes: Mapping[Any, float],
        errors: Callable[[Compliance], Row],
        theory: Mapping[str, Theory],
    ) -> Family:
        def solve(setting: Any) -> Row:
            compliance, unknowns = discretise(setting)
            return {"unknowns": unknowns, **errors(compliance)}

        (xlabel,) = (label for kind, label in XLABELS.items() if name.startswith(kind))
        return Family(name, sizes, solve, theory, xlabel)

    # errors below the floors are of roundoff, or of the innermost elements
    for degree in (1, 2) if quick else (1, 2, 3, 4):
        by_grading, sizes = partial(by_mdr, FLAT, PUNCH_RIM, degree), ellipses(GRADINGS[degree])
        theory = {"d0": Theory(2 * degree + 3, floor=1e-13)}
        yield refine(f"MDR degree {degree}, graded", by_grading, sizes, flat, theory)
    # degrees above 1 meet zeros or roundoff too early
    by_grading = partial(by_mdr, edges, RING_EDGE, 1, hollow=hollow)
    sizes = ellipses((0.6, 0.7, 0.78, 0.84))
    # the gradient is of two orders less, and feels the smallest elements more
    theory = dict.fromkeys(exact, Theory(4, floor=2e-10)) | {"RMS gradient": Theory(2, RING_EDGE)}
    yield refine("MDR degree 1, rings", by_grading, sizes, worn, theory)

    for degree, counts in {2: (4, 6, 8), 3: (3, 4, 5), 4: (1, 2, 3)}.items():
        by_count = partial(by_triangles, degree, ratio)
        sizes = {count: 1 / count for count in counts}
        # the innermost elements cost d0 0.06 of their size
        theory = {"d0": Theory(2 * degree, floor=0.06 * PUNCH_MESH.rim_size)}
        yield refine(f"FEM P{degree}, graded", by_count, sizes, flat, theory)
    for degree, halvings in {2: (1, 2, 3), 3: (0, 1, 2), 4: (0, 1, 2)}.items():
        by_halving = partial(by_even_triangles, degree, ratio)
        sizes = {count: 0.5**count for count in halvings}
        yield refine(f"FEM P{degree}, uniform", by_halving, sizes, flat, {"d0": Theory(1)})

    raised = {degree: 0.1**degree for degree in QUAD_DEGREES}
    by_degree = partial(by_quads, FLAT, 0.0, ratio)
    theory = {"d0": Theory(np.log10(GAIN), floor=1e-13)}
    yield refine("FEM quads, digits per degree", by_degree, raised, flat, theory)
    if not quick:
        by_degree = partial(by_quads, edges, RING_EDGE, ratio, hollow=hollow)
        theory = dict.fromkeys(exact, Theory(floor=1e-13))
        yield refine("FEM quads, rings, digits per degree", by_degree, raised, worn, theory)


def families_of_cells(problem: Problem, quick: bool) -> Iterator[Family]:
    """Yield families of ever smaller cells on which contact opens and spreads.

    MDR, and finite elements of each degree, are compared with boundary elements on cells half as
    large as the smallest. Errors are the greatest over time.
    """
    problem = replace(problem, rtol=1e-4, march="modal", step=None)
    sizes = {finer: 1 / finer for finer in ((0.25, 0.5) if quick else (0.25, 0.5, 1.0, 2.0))}
    pressed = "indentation" if problem.indentation is None else "normal_force"
    theory = dict.fromkeys((pressed, "profile", "pressure"), Theory())

    def march(compliance: Compliance) -> Results:
        # steps in time err by less than cells
        worn = MovingContact(problem, compliance, step_tolerance_factor=0.2)
        return worn.for_estimate(worn.estimate_times)

    exact = march(ring_kernel.compliance(first_contact(problem, 2 * max(sizes))[1].space()))

    def solve(degree: int, finer: float) -> Row:
        cells = first_contact(problem, finer)[1]
        compliance = energy.compliance(cells.space())
        unknowns = compliance.space.size
        if degree:
            half_space = even_half_space(cells, problem.poisson_ratio, degree=degree)
            compliance, unknowns = half_space.compliance(), half_space.unknowns
        errors = differences(march(compliance), exact, problem.face)
        return {"unknowns": unknowns} | {name: float(errors[name].max()) for name in theory}

    for degree in (0, 2, 3, 4):
        name = f"FEM P{degree}" if degree else "MDR"
        yield Family(
            name,
            sizes,
            partial(solve, degree),
            theory,
            "size of cells over that of rtol 1e-4",
        )


def ellipses(gradings: Iterable[float]) -> dict[Any, float]:
    """Return the rate of convergence of polynomials, by the ratio of neighbouring element sizes.

    The function is singular one element away. With each degree its error is multiplied by the rate.
    The rate is (1 - q) / (1 + q) with q = sqrt(ratio) (Bernstein ellipse).
    """
    return {ratio: (1 - ratio**0.5) / (1 + ratio**0.5) for ratio in gradings}


def by_mdr(
    ring_edges: Array, smallest: float, degree: int, grading: float, hollow: bool = False
) -> Discretised:
    """Discretise by one degree on a radial mesh graded to one size at ring edges and rim."""
    breakpoints = graded_breakpoints(ring_edges, smallest, smallest, grading)
    in_hole = (breakpoints[1:] <= ring_edges[1]) & hollow
    space = PressureSpace(breakpoints, np.where(in_hole, 0, degree), ring_edges)
    return energy.compliance(space), space.size


def by_triangles(degree: int, poisson_ratio: float, count: int) -> Discretised:
    """Discretise by triangles graded to the rim, each divided into ``count^2``."""
    mesh = subdivided(triangulated(PUNCH_MESH), count)
    return condense(mesh, FLAT, degree, poisson_ratio, poles=3)


def by_even_triangles(degree: int, poisson_ratio: float, halvings: int) -> Discretised:
    """Discretise by triangles of one size, halved so many times."""
    mesh = bisection.mesh(UNIFORM_MESH).refined(halvings)
    return condense(mesh, FLAT, degree, poisson_ratio, poles=3)


def by_quads(
    ring_edges: Array, least: float, poisson_ratio: float, degree: int, hollow: bool = False
) -> Discretised:
    """Discretise by quadrilaterals, the smallest a tenth with each degree, down to `least`.

    Of d0 they cost about 0.06 of their size, some per cent of what the degree does. What is worn is
    blunt: there they cost the square of their size, and still smaller ones would have gradients of
    roundoff.
    """
    smallest = max(0.1 ** (degree + 1), least)
    mesh = graded(ring_edges, smallest, smallest, FACTOR, GROWTH, outer=2.5).mesh
    return condense(mesh, ring_edges, degree, poisson_ratio, 8, hollow)


def ring_quantities(problem: Problem, compliance: Compliance) -> dict[str, float]:
    """Return the approach, the slowest relaxation time and the steady gradient of the rings."""
    results = evaluate(replace(problem, times=np.array([1.0])), compliance)
    return {
        "d(1)": float(results["indentation"][0]),
        "slowest relaxation time": float(results["relaxation_time"][0]),
        "RMS gradient": float(results["steady_rms_slope"]),
    }
