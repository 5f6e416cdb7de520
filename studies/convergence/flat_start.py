"""Families that show the orders of the flat start of a punch of one ring.

They refine the element size or raise the degree, by finite elements and MDR, on graded and on
uniform meshes. The pressure before any wear does not depend on rings. Without ring edges the
sequences are the most regular, and reach roundoff. Finite-element meshes of a family subdivide one
base mesh, because observed orders are accurate only if the meshes of a sequence are similar.

Theory, for displacements of degree k and pressures of degree q: energies (d0, displacements,
relaxation times) have order 2k on graded meshes. On uniform meshes the singular rim limits their
order to 1. In MDR, the energy norm of a pressure is half an order weaker than the mean square: d0
has order 2q+3, a history, which involves mean squares, has order 2q+2, and the RMS gradient has
order 2q. Observed orders of even degrees rise to 2q+3 under refinement, those of odd degrees fall
to it: plane waves ``exp(ikx)`` at kh = 0.7 give 5.34, 6.60, 9.21, 10.77 for q = 1 to 4 (Fourier
analysis). Degree 4 reaches roundoff before its order is 11.

On quadrilaterals in layers, with the ratio q of neighbouring layers, the degree k itself is raised
(hp). The distances of the inner and the outer end of a layer from the singular point have the ratio
q. By the Bernstein ellipse (Gui & Babuška 1986), polynomials on the layer converge like ``r^k``
with ``r = (1-sqrt q)/(1+sqrt q)``, and energies like ``r^2k``: by a factor of 9 for each degree if
q = 1/4. Inner layers have lower degrees but less and less energy. They reduce the factor a little,
and powers of k increase it at low degrees. The size of a level with a raised degree is
``10^-degree``, so that its order is the number of digits gained with each degree.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...meshes.by_gmsh.quads import graded
from ...meshes.radial import graded_breakpoints
from ..crosscheck import (
    Array,
    Compliance,
    PressureSpace,
    Problem,
    SizeField,
    bisection,
    direct,
    energy,
)
from ..crosscheck.methods.evaluation import FullContact
from ..crosscheck.sizes.defaults import GROWTH, QUAD_GRADING
from ..numerics.core import FLAT, Discretised, condense, flat_d0_error
from ..numerics.subdivision import subdivided, triangulated
from ..study.levels import Family, Theory
from ..tables import Row
from .theories import (
    ANALYTIC,
    ENERGY_OF_ELEMENTS,
    ENERGY_OF_PRESSURES,
    GRADIENT,
    HISTORY_OF_PRESSURES,
    RIM_ELEMENT,
    ROOT_AT_RIM,
    ROUNDOFF,
)

RIM_SIZE, RING_EDGE_SIZE = 1e-13, 1e-7
"""Sizes of the smallest elements: in MDR at the rim of the flat punch, and at ring edges.

They are in punch radii.
"""
PUNCH_MESH = SizeField((0.0, 1.0), 4e-9, 4e-9, growth=0.7, truncation=1e4, centre_size=1e4)
UNIFORM_MESH = SizeField((0.0, 1.0), 0.35, 0.35, growth=0.0, truncation=4.0, centre_size=4.0)
GRADINGS = {
    1: (0.5, 0.6, 0.7, 0.8),
    2: (0.7, 0.78, 0.84, 0.88),
    3: (0.3, 0.4, 0.5, 0.6),
    4: (0.4, 0.5, 0.6, 0.65),
}
"""Ratios of neighbouring cell sizes on MDR meshes graded to the rim, by pressure degree."""
XLABELS = {
    "FEM P": "element size over that of the base mesh, $1/n$",
    "FEM quads": "$10^{-k}$, $k$ the degree on quadrilaterals",
    "MDR": r"$(1-\sqrt{q})/(1+\sqrt{q})$, $q$ the ratio of sizes",
}
"""Labels of sizes, by the beginning of the name of a family."""
QUAD_DEGREES = range(4, 12)
"""Degrees of the displacement on quadrilaterals, from coarse to fine."""
FACTOR_PER_DEGREE = ((1 + QUAD_GRADING**0.5) / (1 - QUAD_GRADING**0.5)) ** 2
"""Theoretical factor by which each degree on quadrilaterals reduces the error of an energy."""


def flat_families(problem: Problem, quick: bool) -> Iterator[Family]:
    """Yield the families of the flat punch of one ring, and one of MDR on the scene's rings."""
    ratio = problem.poisson_ratio

    def refine(
        name: str,
        discretise: Callable[[Any], Discretised],
        sizes: Mapping[Any, float],
        theory: Theory,
    ) -> Family:
        def solve(setting: Any) -> Row:
            compliance, unknowns = discretise(setting)
            return {"unknowns": unknowns, "d0": flat_d0_error(compliance)}

        (xlabel,) = (label for kind, label in XLABELS.items() if name.startswith(kind))
        return Family(name, sizes, solve, {"d0": theory}, xlabel, partial(work, name))

    for degree in (1, 2) if quick else (1, 2, 3, 4):
        by_grading = partial(discretise_by_mdr, FLAT, RIM_SIZE, degree)
        sizes = convergence_rates(GRADINGS[degree])
        theory = Theory(2 * degree + 3, 1e-13, ENERGY_OF_PRESSURES, ROUNDOFF)
        yield refine(f"MDR degree {degree}, graded", by_grading, sizes, theory)
    if problem.indentation is None and not problem.loading.varies and not problem.merged.linear:
        yield mdr_on_rings(problem)
    for degree, counts in {2: (4, 6, 8), 3: (3, 4, 5), 4: (1, 2, 3)}.items():
        by_count = partial(discretise_by_triangles, degree, ratio)
        sizes = {count: 1 / count for count in counts}
        # the innermost elements cause a relative error of d0 of 0.06 times their size
        floor, reason = 0.06 * PUNCH_MESH.rim_size, ENERGY_OF_ELEMENTS.format(what="d0")
        theory = Theory(2 * degree, floor, reason, RIM_ELEMENT)
        yield refine(f"FEM P{degree}, graded", by_count, sizes, theory)
    for degree, halvings in {2: (1, 2, 3), 3: (0, 1, 2), 4: (0, 1, 2)}.items():
        by_halving = partial(discretise_by_uniform_triangles, degree, ratio)
        sizes = {count: 0.5**count for count in halvings}
        theory = Theory(1.0, reason=ROOT_AT_RIM)
        yield refine(f"FEM P{degree}, uniform", by_halving, sizes, theory)
    raised = {degree: 0.1**degree for degree in QUAD_DEGREES}
    by_degree = partial(discretise_by_quads, FLAT, 0.0, ratio)
    theory = Theory(np.log10(FACTOR_PER_DEGREE), 1e-13, ANALYTIC, ROUNDOFF)
    yield refine("FEM quads, digits per degree", by_degree, raised, theory)


def mdr_on_rings(problem: Problem) -> Family:
    """Return the family of MDR of degree 1 on the rings of a scene.

    Higher degrees would reach roundoff after a few levels. Exact values are those of a fine MDR,
    except for the gradient, which has a closed form.
    """
    edges, (wear_coefficients, _) = problem.merged
    exact = ring_quantities(problem, discretise_by_mdr(edges, RING_EDGE_SIZE, 10, 0.15)[0])
    exact["RMS gradient"] = direct.rms_slope(
        edges, direct.steady_pressures(edges, wear_coefficients)
    )

    def solve(grading: float) -> Row:
        compliance, unknowns = discretise_by_mdr(edges, RING_EDGE_SIZE, 1, grading)
        values = ring_quantities(problem, compliance)
        errors = {quantity: values[quantity] / exact[quantity] - 1 for quantity in exact}
        return {"unknowns": unknowns, **errors}

    # the gradient has an order lower by two, and depends more on the smallest elements
    energy_theory = Theory(4.0, 2e-10, HISTORY_OF_PRESSURES, RIM_ELEMENT)
    theory = dict.fromkeys(exact, energy_theory)
    theory["RMS gradient"] = Theory(2.0, RING_EDGE_SIZE, GRADIENT, RIM_ELEMENT)
    sizes, name = convergence_rates((0.6, 0.7, 0.78, 0.84)), "MDR degree 1, rings"
    return Family(name, sizes, solve, theory, XLABELS["MDR"], partial(work, name))


def work(name: str, setting: float) -> float:
    """Return the expected seconds of a level of a family, by the name of the family."""
    if name.startswith("MDR"):
        return 0.02 if "rings" not in name else 0.02 / (1 - setting) ** 2
    if name.startswith("FEM quads"):
        return 0.02 + 1e-5 * setting**4
    elements = 340 * setting**2 if "graded" in name else 220 * 4**setting
    return 0.03 + 1.2e-5 * elements * int(name[len("FEM P")]) ** 2


def convergence_rates(gradings: Iterable[float]) -> dict[Any, float]:
    """Return the convergence rates of polynomials, by the ratios of neighbouring element sizes.

    With each degree, the error of a polynomial on an element is multiplied by the rate. The
    distances of the two ends of the element from the singular point of the function have the same
    ratio, so that the rate is (1 - q) / (1 + q) with q = sqrt(ratio) (Bernstein ellipse).
    """
    return {ratio: (1 - ratio**0.5) / (1 + ratio**0.5) for ratio in gradings}


def discretise_by_mdr(
    ring_edges: Array, smallest: float, degree: int, grading: float
) -> Discretised:
    """Discretise by MDR of one degree, on a radial mesh with one smallest size at all edges."""
    breakpoints = graded_breakpoints(ring_edges, smallest, smallest, grading)
    space = PressureSpace(breakpoints, np.full(len(breakpoints) - 1, degree), ring_edges)
    return energy.compliance(space), space.size


def discretise_by_triangles(degree: int, poisson_ratio: float, count: int) -> Discretised:
    """Discretise by triangles graded to the rim, each divided into ``count^2`` triangles."""
    mesh = subdivided(triangulated(PUNCH_MESH), count)
    return condense(mesh, FLAT, degree, poisson_ratio, poles=3)


def discretise_by_uniform_triangles(
    degree: int, poisson_ratio: float, halvings: int
) -> Discretised:
    """Discretise by triangles of one size after a number of halvings."""
    mesh = bisection.mesh(UNIFORM_MESH).refined(halvings)
    return condense(mesh, FLAT, degree, poisson_ratio, poles=3)


def discretise_by_quads(
    ring_edges: Array, lower_bound: float, poisson_ratio: float, degree: int
) -> Discretised:
    """Discretise by quadrilaterals whose smallest size is 0.1^(degree + 1), but >= `lower_bound`.

    The smallest elements cause a relative error of d0 of about 0.06 times their size, a few per
    cent of the error due to the degree. Wear smooths the pressure, so that the smallest elements
    then cause an error in proportion to the square of their size. In still smaller elements,
    gradients would consist of roundoff.
    """
    smallest = max(0.1 ** (degree + 1), lower_bound)
    mesh = graded(ring_edges, smallest, smallest, QUAD_GRADING, GROWTH, outer=2.5).mesh
    return condense(mesh, ring_edges, degree, poisson_ratio, 8)


def ring_quantities(problem: Problem, compliance: Compliance) -> dict[str, float]:
    """Return the approach, the slowest relaxation time and the steady gradient of the rings."""
    with_history = replace(problem, times=np.array([1.0]), steady=True, gradient_average="line")
    results = FullContact(with_history, compliance).results
    return {
        "d(1)": float(results["indentation"][0]),
        "slowest relaxation time": float(results["relaxation_time"][0]),
        "RMS gradient": float(results["steady_rms_slope"]),
    }
