"""What the study of convergence refines, and how a level of it is computed."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from skfem import Mesh

from ...fem.elasticity import AxisymmetricElasticity
from ...fem.half_space import HalfSpace, pressure_space
from ...mdr import direct, energy
from ...meshes.compliance import Compliance
from ...meshes.pressure_space import PressureSpace
from ...meshes.quads import graded
from ...meshes.radial import Array, graded_breakpoints
from ...meshes.sizes import SizeField
from ..methods.sampler import Evaluation
from ..problem.defaults import FACTOR, GROWTH
from ..problem.problem import D0, Problem
from ..wear.flat_contact import press_flat
from .meshes import subdivided, triangulated
from .orders import Refinement, Sequence

Discretised = tuple[Compliance, int]  # with the number of unknowns

FLAT = np.array([0.0, 1.0])
SMOOTH, SLOPE, STEADY = "energy of a smooth pressure", "RMS gradient", "mean steady displacement"
DIGITS = ", digits per degree"  # ends the names of what is raised in degree
# sizes of the smallest elements: by MDR at the rim of the flat punch; at edges and rim of rings
PUNCH_RIM, RING_EDGE = 1e-13, 1e-7
# base meshes of triangles, and their subdivisions by degree: of the flat punch, graded and uniform,
# and of the scene's rings
PUNCH_MESH = SizeField((0.0, 1.0), 4e-9, 4e-9, growth=0.7, truncation=1e4, centre_size=1e4)
UNIFORM_MESH = SizeField((0.0, 1.0), 0.35, 0.35, growth=0.0, truncation=4.0, centre_size=4.0)
PUNCH = {2: (2, 3, 4, 6, 8), 3: (2, 3, 4, 5), 4: (1, 2, 3, 4)}
UNIFORM = {2: (3, 4, 6, 8, 12), 3: (2, 3, 4, 6), 4: (2, 3, 4)}
RINGS = {2: (4, 6, 8), 3: (3, 4, 5), 4: (1, 2, 3)}
QUICK = {2: (2, 3, 4), 3: (2, 3), 4: (2, 3)}
# MDR: elements under a smooth pressure; by degree, ratios of neighbouring sizes of the mesh graded
# to the rim
ELEMENTS = (12, 16, 24, 32)
GRADINGS = {
    1: (0.5, 0.6, 0.7, 0.8),
    2: (0.7, 0.78, 0.84, 0.88),
    3: (0.3, 0.4, 0.5, 0.6),
    4: (0.4, 0.5, 0.6, 0.65),
}
QUAD_DEGREES = range(4, 12)
# relative errors below which roundoff or the innermost elements count: their part of d0 is 0.06 of
# their size
ROUNDOFF, RIM_FLOOR, RING_FLOOR = 1e-13, 0.06 * PUNCH_MESH.rim_size, 2e-10


def refinements(problem: Problem, quick: bool) -> Iterator[Refinement]:
    """MDR under a smooth pressure, the flat start and rings.

    Finite elements on triangles; and degrees raised on one mesh.

    The size of a raised degree is ``10^-degree``, so that its order is the digits that a degree
    gains.
    """
    edges, ratio, rings = (
        problem.merged.ring_edges,
        problem.poisson_ratio,
        partial(of_rings, problem),
    )
    # exact values: of rings by a fine MDR, and their gradient in closed form
    flat, worn = {"d0": D0}, rings(by_mdr(edges, RING_EDGE, 10, 0.15)[0])
    worn[SLOPE] = direct.rms_slope(edges, direct.steady_pressures(*problem.merged))
    for degree in (1, 2) if quick else (1, 2, 3, 4):
        smooth = sequences(f"MDR degree {degree}, uniform", {SMOOTH: 0.0}, 2 * degree + 3)
        yield Refinement(
            smooth,
            {n: 1 / n for n in ELEMENTS},
            partial(equal_by_mdr, degree),
            partial(lost_energy, degree),
        )
        punch = sequences(f"MDR degree {degree}, graded", flat, 2 * degree + 3, ROUNDOFF)
        yield Refinement(
            punch, ellipses(GRADINGS[degree]), partial(by_mdr, FLAT, PUNCH_RIM, degree), flat_d0
        )
    # by MDR the energy of the known steady pressures has no error; degrees above 1 meet zeros or
    # roundoff too early
    history = sequences(
        "MDR degree 1, rings", {name: worn[name] for name in worn if name != STEADY}, 4, RING_FLOOR
    )
    gradings = (0.6, 0.7, 0.78) if quick else (0.6, 0.7, 0.78, 0.84)
    yield Refinement(history, ellipses(gradings), partial(by_mdr, edges, RING_EDGE, 1), rings)
    ring_mesh = replace(
        PUNCH_MESH, ring_edges=tuple(edges.tolist()), rim_size=RING_EDGE, ring_size=RING_EDGE
    )
    families: list[tuple[Any, ...]] = [
        ("graded", PUNCH_MESH, PUNCH, flat, flat_d0, RIM_FLOOR),
        ("uniform", UNIFORM_MESH, UNIFORM, flat, flat_d0, RIM_FLOOR),
        ("rings, graded", ring_mesh, RINGS, worn, rings, RING_FLOOR),
    ]
    for name, field, counts, exact, quantities, floor in families[: 2 if quick else None]:
        for degree, divided in (QUICK if quick else counts).items():
            own = sequences(
                f"FEM P{degree}, {name}", exact, 2 * degree if field.growth else 1, floor
            )
            yield Refinement(
                own,
                {n: 1 / n for n in divided},
                partial(by_triangles, field, degree, ratio),
                quantities,
            )
    raised, levels = sequences("MDR" + DIGITS, flat), {k: 0.1**k for k in range(1, 7)}
    yield Refinement(raised, levels, lambda degree: by_mdr(FLAT, PUNCH_RIM, degree, 0.2), flat_d0)
    raised, levels = (
        sequences("FEM quads" + DIGITS, flat, floor=ROUNDOFF),
        {k: 0.1**k for k in QUAD_DEGREES},
    )
    yield Refinement(raised, levels, partial(by_quads, FLAT, 0.0, ratio), flat_d0)
    if not quick:
        raised = sequences("FEM quads, rings" + DIGITS, worn, floor=ROUNDOFF)
        yield Refinement(raised, levels, partial(by_quads, edges, RING_EDGE, ratio), rings)


def sequences(
    name: str, exact: dict[str, float], order: float = np.nan, floor: float = 0.0
) -> list[Sequence]:
    """A sequence for each quantity.

    Slopes are of two orders less, and feel the smallest elements more.
    """
    judged = dict.fromkeys(exact, (order, floor)) | {SLOPE: (order - 2, RING_EDGE)}
    return [Sequence(name, one, judged[one][0], exact[one], judged[one][1]) for one in exact]


def ellipses(gradings: Iterable[float]) -> dict[float, float]:
    """By the ratio of neighbouring sizes.

    How fast polynomials converge if singular one element away (Bernstein).
    """
    return {ratio: (1 - ratio**0.5) / (1 + ratio**0.5) for ratio in gradings}


def equal_by_mdr(degree: int, count: int) -> Discretised:
    """Equal elements of a degree that holds every digit of a smooth pressure, and the unknowns of
    the lower `degree`.
    """
    space = PressureSpace(np.linspace(0, 1, count + 1), np.full(count, degree + 6), FLAT)
    return energy.compliance(space), count * degree + 1


def by_mdr(ring_edges: Array, smallest: float, degree: int, grading: float) -> Discretised:
    """One degree on a radial mesh graded to one size at ring edges and rim."""
    breakpoints = graded_breakpoints(ring_edges, smallest, smallest, grading)
    space = PressureSpace(breakpoints, np.full(len(breakpoints) - 1, degree), ring_edges)
    return energy.compliance(space), space.size


def by_triangles(field: SizeField, degree: int, poisson_ratio: float, count: int) -> Discretised:
    """Finite elements on a mesh subdivided, in log-polar coordinates about the ring edges that it
    is graded to.
    """
    ring_edges = np.array(field.ring_edges)
    mesh = subdivided(
        triangulated(field), count, ring_edges[1:] if field.growth else ring_edges[:0]
    )
    return condensed(mesh, ring_edges, degree, poisson_ratio, (0, 2, 4))


def by_quads(ring_edges: Array, least: float, poisson_ratio: float, degree: int) -> Discretised:
    """Finite elements on quadrilaterals, the smallest shrinking tenfold with each degree down to
    `least`.

    Of d0 they cost about 0.06 of their size, some per cent of what the degree does. What is worn is
    blunt: there they cost the square of their size, and still smaller ones would have gradients of
    roundoff.
    """
    smallest = max(0.1 ** (degree + 1), least)
    mesh = graded(ring_edges, smallest, smallest, FACTOR, GROWTH, outer=2.5).mesh
    return condensed(mesh, ring_edges, degree, poisson_ratio, tuple(range(0, 16, 2)))


def condensed(
    mesh: Mesh, ring_edges: Array, degree: int, poisson_ratio: float, poles: tuple[int, ...]
) -> Discretised:
    """The finite-element half-space on a mesh."""
    solid = AxisymmetricElasticity(mesh, degree, poisson_ratio)
    half_space = HalfSpace(solid, pressure_space(solid, ring_edges), poles)
    return half_space.compliance(), half_space.unknowns


def flat_d0(compliance: Compliance) -> dict[str, float]:
    """Indentation of the flat start, singular at the rim."""
    return {"d0": press_flat(compliance).indentation}


def lost_energy(degree: int, fine: Compliance) -> dict[str, float]:
    """Fraction of the energy of the pressure ``exp(-2 r^2)`` that a degree cannot hold.

    Galerkin's error is at right angles to what the space holds, so it is a sum of squares and meets
    no roundoff.
    """
    count = 16 * len(fine.space.degrees)
    radii = (np.arange(count) + 0.5) / count
    pressure, *_ = np.linalg.lstsq(
        fine.space.matrix(radii).toarray(), np.exp(-2 * radii**2), rcond=None
    )
    whole, held = fine.factor @ pressure, fine.factor[:, fine.space.order <= degree]
    best, *_ = np.linalg.lstsq(held, whole, rcond=None)
    return {SMOOTH: float(np.sum((whole - held @ best) ** 2) / np.sum(whole**2))}


def of_rings(problem: Problem, compliance: Compliance) -> dict[str, float]:
    """The quantities of the scene's rings."""
    wanted = replace(
        problem, times=np.array([1.0]), steady=True, march="modal", gradient_average="line"
    )
    evaluated = Evaluation(wanted, compliance)
    steady = compliance.factor @ evaluated.wear.steady.pressure
    return {
        "d(1)": float(evaluated.results["indentation"][0]),
        "slowest relaxation time": float(evaluated.results["relaxation_time"][0]),
        "force on the outer ring at 1": float(evaluated.results["ring_force"][0, -1]),
        STEADY: float(steady @ steady),
        SLOPE: float(evaluated.results["steady_rms_slope"]),
    }
