"""Pairs of spaces: displacements by elements, and contact pressures by multipliers.

For one displacement element of degree k, all pressure spaces lie in one full space: polynomials of
degree k on each facet of the contact, broken at every vertex. The compliance on the full space is
singular. The half-space is condensed to it once, and each pressure space is a basis within it.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
import skfem
from scipy.linalg import LinAlgError, eigh, solve_triangular
from scipy.sparse import csr_matrix
from skfem import Element, Mesh, MeshQuad

from ....fem import (
    AxisymmetricElasticity,
    HalfSpace,
    contact_breakpoints,
    degree_along_side,
    element_of_degree,
    enough_poles,
    is_on_quadrilaterals,
    pressure_space,
    refuse_singular,
)
from ....mdr import energy
from ....meshes import (
    Array,
    Ground,
    MeshError,
    PressureSpace,
    SceneError,
    SizeField,
    SolverError,
    as_half_space,
    bisection,
    halved,
    ring_of,
    truncation,
    values_on_rings,
)
from ....meshes.by_gmsh import quads
from ...crosscheck import Problem, Rings, Solution, least_ratio_of_energies
from ..errors import CONDITION, EIGENVALUE

TRUNCATION = 2.5
"""Radius of the half-space in punch radii; the poles represent the rest to better than 1e-9."""
RING_EDGE_SIZE, RIM_SIZE, GRADING, GROWTH = 0.06, 0.03, 0.5, 1.0
"""Element sizes at ring edges and at the rim in punch radii, ratio of layers, growth of sizes.

They define the coarsest mesh. It has few graded layers, so that halving refines all of it alike.
"""

HIGHEST_POISSON_RATIO = 0.4999999
"""Greatest Poisson's ratio that the solid takes here; in runs it is smaller."""
FAR_FIELD_ERROR = 1e-9
"""Relative error of the energy that poles may leave of the truncation; it sets their number."""
LEAST_RELAXATION = 1e-14
"""Least relaxation time that is more than roundoff, relative to the greatest one."""

Kind = Literal[
    "continuous",
    "broken at ring edges",
    "broken everywhere",
    "wear rate continuous",
    "as in ringwear run",
]


@dataclass(frozen=True)
class Displacement:
    """A displacement element.

    Parameters
    ----------
    name : name in tables and figures
    element : scikit-fem's, or the user's own
    """

    name: str
    element: Element

    @property
    def degree(self) -> int:
        """Polynomial degree along a side."""
        return degree_along_side(self.element)

    @property
    def on_quadrilaterals(self) -> bool:
        """Whether the element lives on quadrilaterals, not on triangles."""
        return is_on_quadrilaterals(self.element)


@dataclass(frozen=True)
class Pressures:
    """A space of contact pressures.

    Parameters
    ----------
    kind : where pressures may jump; ``as in ringwear run`` is the space that runs use
    degree : polynomial degree; for the space of runs, its highest one
    """

    kind: Kind
    degree: int

    def name_under(self, degree: int) -> str:
        """Return the name in tables, under a displacement of the degree k."""
        if self.kind == "as in ringwear run":
            return self.kind
        if not self.degree:
            return "constant on facets"
        lower = degree - self.degree
        return f"{self.kind}, k - {lower}" if lower else f"{self.kind}, k"

    def is_singular_with(self, degree: int) -> bool:
        """Return whether some pressures displace nothing under a displacement of a degree.

        There are then more pressures than displacements on the contact.
        """
        return self.kind.startswith("broken") and self.degree == degree

    def has_checkerboards_with(self, degree: int) -> bool:
        """Return whether the least eigenvalue falls with the size under a displacement of a degree.

        Theory and trials both say so for pressures that are one degree lower and broken everywhere.
        """
        return self.kind == "broken everywhere" and self.degree == degree - 1


def choose_displacements(elements: Sequence[Element], quick: bool) -> list[Displacement]:
    """Return the displacements to compare: the user's elements, or else several of scikit-fem.

    Parameters
    ----------
    elements : of the user; may be empty
    quick : whether fewer of scikit-fem's elements are enough

    Raises
    ------
    SceneError
        if the half-space cannot take one of the elements, or if an element is given twice
    """
    own = list[Displacement]()
    counts = Counter(type(element).__name__ for element in elements)
    for element in elements:
        degree, name = degree_along_side(element), type(element).__name__
        several = counts[name] > 1
        own.append(Displacement(f"{name} of degree {degree}" if several else name, element))
    if len({displacement.name for displacement in own}) < len(own):
        raise SceneError("an element is given twice: give elements of other kinds or degrees")
    names = ("P1", "P2", "P4", "Q1", "Q2") if quick else ("P1", "P2", "P3", "P4", "Q1", "Q2", "Q4")
    return own or [displacement_by_name(name) for name in names]


def displacement_by_name(name: str) -> Displacement:
    """Return scikit-fem's element by its name: P1 to P4 on triangles, Q1, Q2, ... on quads."""
    mesh = skfem.MeshQuad() if name[0] == "Q" else skfem.MeshTri()
    return Displacement(name, element_of_degree(mesh, int(name[1:])))


def pressure_spaces(displacement: Displacement, rings: Rings) -> list[Pressures]:
    """Return the pressure spaces to compare for a displacement of degree k.

    They are: degrees k, k - 1 and k - 2, as far as these are at least 1, continuous or broken;
    constants on each facet; pressures with a continuous wear rate; and the space that runs use. A
    punch of one ring has no ring edges at which pressures could break.
    """
    degree = displacement.degree
    degrees = [lower for lower in (degree - 1, degree, degree - 2) if lower >= 1]
    kinds: tuple[Kind, ...] = ("continuous", "broken everywhere")
    continuous_rate = list[Pressures]()
    if len(rings.widths) > 1:
        kinds = ("continuous", "broken at ring edges", "broken everywhere")
        continuous_rate = [Pressures("wear rate continuous", max(degree - 1, 1))]
    spaces = [Pressures(kind, lower) for kind in kinds for lower in degrees]
    return [
        *spaces,
        Pressures("broken everywhere", 0),
        *continuous_rate,
        pressures_of_runs(displacement),
    ]


def pressures_of_runs(displacement: Displacement) -> Pressures:
    """Return the pressure space that runs use with a displacement (`pressure_space` in `fem`)."""
    lower = 2 if displacement.on_quadrilaterals else 1
    return Pressures("as in ringwear run", max(displacement.degree - lower, 1))


@dataclass(frozen=True, eq=False)
class Meshes:
    """One graded mesh of quadrilaterals, halved repeatedly, and the same mesh cut into triangles.

    Parameters
    ----------
    rings : of the punch
    """

    rings: Rings

    @cached_property
    def coarsest(self) -> Mesh:
        """The coarsest mesh; triangles by bisection if gmsh cannot be used."""
        edges = self.rings.ring_edges
        at_edges = np.minimum(RING_EDGE_SIZE, 0.3 * self.rings.narrower)
        at_rim = min(RIM_SIZE, 0.15 * float(self.rings.widths[-1]))
        try:
            return quads.graded(edges, at_edges, at_rim, GRADING, GROWTH, TRUNCATION).mesh
        except MeshError:
            sizes = tuple(float(size) for size in at_edges)
            field = SizeField(tuple(edges.tolist()), at_rim, sizes, GROWTH, TRUNCATION)
            return bisection.mesh(field)

    @property
    def has_quadrilaterals(self) -> bool:
        """Whether the meshes exist as quadrilaterals."""
        return isinstance(self.coarsest, MeshQuad)

    def halved(self, count: int, on_quadrilaterals: bool) -> Mesh:
        """Return the mesh with every element halved `count` times and new points put on the arc."""
        mesh = halved(self.coarsest, self.rings.ring_edges, count)
        if isinstance(mesh, MeshQuad) and not on_quadrilaterals:
            return as_half_space(mesh.to_meshtri(), self.rings.ring_edges)
        return mesh


def full_pressure_space(mesh: Mesh, ring_edges: Array, degree: int) -> PressureSpace:
    """Return the space of all pressures of a degree on the facets, broken at every vertex."""
    breakpoints, _ = contact_breakpoints(mesh, ring_edges)
    return PressureSpace(breakpoints, np.full(len(breakpoints) - 1, degree), breakpoints)


def basis(
    full_space: PressureSpace, pressures: Pressures, rings: Rings, solid: AxisymmetricElasticity
) -> csr_matrix:
    """Return a basis (full size, n) of a pressure space within the full one.

    Parameters
    ----------
    full_space : space of all pressures, of `full_pressure_space`
    pressures : the pressure space
    rings : of the punch, with their wear coefficients
    solid : elastic solid with the displacement; the space of runs follows from it
    """
    if pressures.kind == "as in ringwear run":
        space_of_runs = replace(pressure_space(solid, rings.ring_edges), low_parts=None)
        return full_space.embedding(space_of_runs)
    if pressures.degree == 0:
        return csr_matrix(full_space.ring_indicator())
    edges = {
        "continuous": rings.ring_edges[[0, -1]],
        "broken everywhere": full_space.breakpoints,
    }.get(pressures.kind, rings.ring_edges)
    degrees = np.full(len(full_space.degrees), pressures.degree)
    space = PressureSpace(full_space.breakpoints, degrees, edges)
    embedded = full_space.embedding(space)
    if pressures.kind == "wear rate continuous":
        return embedded @ space.joined(rings.wear_coefficients)
    return embedded


class Worn(NamedTuple):
    """Indentations and pressures of a punch on a pair of spaces.

    Parameters
    ----------
    indentation : (T,) indentations in F/(a E*)
    pressure : (T, size) coefficients of the pressures in the full space
    """

    indentation: Array
    pressure: Array


@dataclass(frozen=True, eq=False)
class Condensed:
    """The half-space in one displacement space, condensed to all pressures of the same degree.

    A factor B of a compliance A satisfies A = B^T B.

    Parameters
    ----------
    half_space : with the full pressure space, on which its compliance is singular
    fem_factor, mdr_factor : (m, size) factors of the compliance by finite elements and by MDR
    """

    half_space: HalfSpace
    fem_factor: Array
    mdr_factor: Array

    @property
    def space(self) -> PressureSpace:
        """The full pressure space: all pressures of the degree, broken at every vertex."""
        return self.half_space.space


def condense(
    mesh: Mesh, displacement: Displacement, rings: Rings, poisson_ratio: float
) -> Condensed:
    """Condense the half-space in a displacement space to all pressures of the same degree.

    Parameters
    ----------
    mesh : of the half-space
    displacement : element of the displacement
    rings : of the punch
    poisson_ratio : up to `HIGHEST_POISSON_RATIO`
    """
    solid = AxisymmetricElasticity(
        mesh,
        displacement.degree,
        Ground.half_space(poisson_ratio),
        displacement.element,
        highest_ratio=HIGHEST_POISSON_RATIO,
    )
    full_space = full_pressure_space(mesh, rings.ring_edges, displacement.degree)
    half_space = HalfSpace(solid, full_space, enough_poles(truncation(mesh), FAR_FIELD_ERROR))
    exact = energy.compliance(full_space).factor
    return Condensed(half_space, half_space.condensed(), exact)


def solution_on(problem: Problem, condensed: Condensed, of_pressures: csr_matrix) -> Solution:
    """Return the solution of a pair of spaces; its results have an eigenvalue, too.

    Parameters
    ----------
    problem : of a flat punch under the force 1
    condensed : half-space in the displacement space of the pair
    of_pressures : (size, n) basis of the pressure space of the pair

    Raises
    ------
    SolverError
        if the pair is singular
    """
    half_space, space = condensed.half_space, condensed.space
    contact = len(condensed.fem_factor) - len(half_space.poles)
    refuse_singular(half_space.stability(of_pressures), of_pressures.shape[1], contact)
    factor = (of_pressures.T @ condensed.fem_factor.T).T
    least = least_ratio_of_energies(factor, (of_pressures.T @ condensed.mdr_factor.T).T)
    depth, coefficients, condition = press(factor, of_pressures.T @ space.weights)
    times = problem.times[problem.compared_rows]
    worn = wear(space, of_pressures, factor, problem.merged, times[times > 0])
    starts = int((times == 0).sum())
    pressures = np.concatenate([np.tile(of_pressures @ coefficients, (starts, 1)), worn.pressure])
    compared = {
        "time": times,
        "indentation": np.concatenate([np.full(starts, depth), worn.indentation]),
        "pressure": pressures @ space.matrix(problem.face.radii).T,
        EIGENVALUE: np.asarray(least),
        CONDITION: np.asarray(condition),
    }
    return Solution({}, compared, {}, {}, half_space.unknowns)


def press(factor: Array, weights: Array) -> tuple[float, Array, float]:
    """Return the indentation and the pressures (n,) of the flat start, and the condition number.

    The condition number is that of the compliance after each basis function is scaled to energy
    one.

    Parameters
    ----------
    factor : (m, n) factor of the compliance
    weights : (n,) force of each basis function
    """
    # with A = R^T R and the weights b: solve A p = d b, b . p = 1, hence d = 1 / |R^-T b|^2
    scale = np.linalg.norm(factor, axis=0)
    triangle = np.linalg.qr(factor / scale, mode="r")
    scaled_weights = solve_triangular(triangle, weights / scale, trans="T")
    depth = float(1 / (scaled_weights @ scaled_weights))
    pressures = depth * solve_triangular(triangle, scaled_weights) / scale
    return depth, pressures, float(np.linalg.cond(triangle) ** 2)


def wear(
    space: PressureSpace, of_pressures: csr_matrix, factor: Array, rings: Rings, times: Array
) -> Worn:
    """Return the indentations and pressures of a punch that wears, exact in time.

    The history solves ``A p' = d' b - K p``, ``b . p = 1`` on the basis, by modes of the pencil
    (A, K) on pressures that carry no force. So wear rates are continuous only if the basis is.

    Parameters
    ----------
    space : full pressure space
    of_pressures : (size, n) basis of the pressure space
    factor : (m, n) factor of the compliance A on it
    rings : of the punch
    times : (T,) in a/(E* k_max v0)

    Raises
    ------
    SolverError
        if the pressures of the basis are linearly dependent
    """
    middles = (space.breakpoints[1:] + space.breakpoints[:-1]) / 2
    ring = ring_of(rings.ring_edges, middles)
    ends = space.breakpoints[:-1], space.breakpoints[1:]
    mass = space.mass(np.stack([values_on_rings(*rings, radii, ring) for radii in ends]))
    try:
        root = np.linalg.cholesky((of_pressures.T @ mass @ of_pressures).toarray())
    except LinAlgError as error:
        raise SolverError("the pressures of a pair are not independent") from error
    displaced = solve_triangular(root, factor.T, lower=True).T
    weights = solve_triangular(root, of_pressures.T @ space.weights, lower=True)
    rate = float(1 / (weights @ weights))
    steady = rate * weights
    forceless = np.linalg.qr(weights[:, None], mode="complete")[0][:, 1:]
    forceless_factor, steady_factor = displaced @ forceless, displaced @ steady
    relaxation, modes = eigh(forceless_factor.T @ forceless_factor)
    resolved = relaxation > LEAST_RELAXATION * relaxation[-1]
    relaxation, modes = relaxation[resolved], modes[:, resolved]
    amplitudes = -(modes.T @ (forceless_factor.T @ steady_factor)) / relaxation
    decaying = np.exp(-times[:, None] / relaxation) * amplitudes
    pressures = steady + decaying @ modes.T @ forceless.T
    depths = rate * times + pressures @ displaced.T @ steady_factor
    coefficients = solve_triangular(root, pressures.T, lower=True, trans="T")
    return Worn(depths, (of_pressures @ coefficients).T)
