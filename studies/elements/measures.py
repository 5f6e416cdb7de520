"""What is measured of a pair of spaces: its eigenvalues, and errors of the start and of wear.

Everything is non-dimensional: punch radius 1, plane strain modulus 1, force 1.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, eigh, solve_triangular
from scipy.sparse import csr_matrix
from skfem import Mesh

from ...fem.elasticity import AxisymmetricElasticity
from ...fem.far_field import enough_poles
from ...fem.half_space import HalfSpace
from ...fem.stability import refuse_singular
from ...mdr import energy
from ...mdr.flat_punch import D0, flat_punch
from ...meshes.errors import SolverError
from ...meshes.half_space import truncation
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, gauss, graded_breakpoints, ring_of
from ..crosscheck.operators import least_ratio_of_energies
from ..problem.problem import Rings
from ..tables import Row
from ..wear.full_contact import RunningIn
from .pairs import Displacement, whole_space

TIMES = np.geomspace(0.1, 20.0, 4)
"""Times of wear in a/(E* k_max v0), at which errors are taken."""
CLOSEST_TO_HALF = 0.4999999
"""Greatest Poisson's ratio; the elastic solid of runs is never closer than 0.49999."""
FAR_FIELD = 1e-9
"""Error of the truncated half-space that is left to its poles."""
QUADRATURE = 6
"""Gauss points on an element beyond the degree of its pressures, for the root at the rim."""
EXCITED = 1e-14
"""Relaxation times below this part of the greatest are roundoff."""


class Worn(NamedTuple):
    """A punch that wears.

    Parameters
    ----------
    space : of the pressures
    indentation : (T,) at `TIMES`
    pressure : (T, size) coefficients
    """

    space: PressureSpace
    indentation: Array
    pressure: Array


@dataclass(frozen=True, eq=False)
class Condensed:
    """A displacement on a mesh, condensed to all pressures of its degree.

    Parameters
    ----------
    half_space : with the whole pressure space, which is singular
    by_elements, by_theory : (m, size) factors of the compliance by finite elements and by MDR
    seconds : of condensing
    """

    half_space: HalfSpace
    by_elements: Array
    by_theory: Array
    seconds: float

    @property
    def space(self) -> PressureSpace:
        """The whole pressure space."""
        return self.half_space.space

    def factors_of(self, basis: csr_matrix) -> tuple[Array, Array]:
        """Return the factors by finite elements and by MDR on pressures (size, n) of the whole."""
        return (basis.T @ self.by_elements.T).T, (basis.T @ self.by_theory.T).T


def condense(
    mesh: Mesh, displacement: Displacement, rings: Rings, poisson_ratio: float
) -> Condensed:
    """Condense a displacement on a mesh to all pressures of its degree."""
    start = time.perf_counter()
    degree = displacement.degree
    solid = AxisymmetricElasticity(
        mesh, degree, poisson_ratio, displacement.element, highest_ratio=CLOSEST_TO_HALF
    )
    whole = whole_space(mesh, rings.ring_edges, degree)
    half_space = HalfSpace(solid, whole, enough_poles(truncation(mesh), FAR_FIELD))
    by_elements = half_space.condensed()
    seconds = time.perf_counter() - start
    return Condensed(half_space, by_elements, energy.compliance(whole).factor, seconds)


def exact_wear(rings: Rings) -> Worn:
    """Return the history by an MDR of degree 10 whose smallest elements are 1e-8 punch radii."""
    breakpoints = graded_breakpoints(rings.ring_edges, 1e-8, 1e-9, 0.25)
    degrees = np.full(len(breakpoints) - 1, 10)
    space = PressureSpace(breakpoints, degrees, rings.ring_edges)
    history = RunningIn(energy.compliance(space), rings.wear_coefficients).modal(TIMES)
    return Worn(space, history.indentation, history.pressure)


def measure(condensed: Condensed, basis: csr_matrix, rings: Rings, exact: Worn | None) -> Row:
    """Return the row of a pair of spaces: eigenvalues, errors, condition number, or its refusal.

    Parameters
    ----------
    basis : (size, n) of the pressures
    exact : the history that wear is compared with; None leaves wear out

    Returns
    -------
    row : errors are relative; a singular pair has no errors but a remark
    """
    contact = len(condensed.by_elements) - len(condensed.half_space.poles)
    row: dict[str, Any] = {
        "pressures": basis.shape[1],
        "on the contact": condensed.half_space.stability(basis),
    }
    first, second = condensed.factors_of(basis)
    row["least eigenvalue"] = least_ratio_of_energies(first, second)
    try:
        refuse_singular(row["on the contact"], basis.shape[1], contact)
    except SolverError:
        return row | {"remark": "singular: refused where it is condensed"}
    weights = basis.T @ condensed.space.weights
    depth, coefficients, condition = press(first, weights)
    row |= {
        "d0": depth / D0 - 1,
        "p at the start": start_error(condensed.space, basis @ coefficients),
        "condition number": condition,
    }
    if exact:
        row["d(t)"], row["p(t)"] = wear_errors(condensed.space, basis, first, rings, exact)
    return row


def press(factor: Array, weights: Array) -> tuple[float, Array, float]:
    """Return indentation and pressures (n,) of the flat start, and the condition number.

    The condition number is that of the compliance of pressures of energy one.
    """
    scale = np.linalg.norm(factor, axis=0)
    triangle = np.linalg.qr(factor / scale, mode="r")
    half = solve_triangular(triangle, weights / scale, trans="T")
    depth = float(1 / (half @ half))
    pressures = depth * solve_triangular(triangle, half) / scale
    return depth, pressures, float(np.linalg.cond(triangle) ** 2)


def start_error(space: PressureSpace, pressures: Array) -> float:
    """Return the relative error of the pressure of the flat start, in the mean square.

    Squares are weighted by ``1 - r^2``, because the square of the exact pressure has no integral.
    """
    node, weight = gauss(space.top + QUADRATURE)
    half = space.widths[:, None] / 2
    radii = space.breakpoints[:-1, None] + half * (1 + node)
    weights = 2 * np.pi * radii * half * weight * (1 - radii) * (1 + radii)
    exact = flat_punch(0.0).pressure_at(radii.ravel()).reshape(radii.shape)
    error = (space.on_elements(node) @ pressures).reshape(radii.shape) - exact
    return float(np.sqrt((weights * error**2).sum() / (weights * exact**2).sum()))


def wear_errors(
    space: PressureSpace, basis: csr_matrix, factor: Array, rings: Rings, exact: Worn
) -> tuple[float, float]:
    """Return the greatest relative errors over `TIMES` of the indentation and of the pressure.

    That of the pressure is in the mean square over the face, weighted by the wear coefficients.
    Wear rates are those of the basis, continuous or not: ``A p' = d' b - K p``, ``b . p = 1``, in
    modes of the pencil (A, K) on the pressures without force.

    Raises
    ------
    SolverError
        if the pressures of the basis are not independent
    """
    middles = (space.breakpoints[1:] + space.breakpoints[:-1]) / 2
    mass = space.mass(rings.wear_coefficients[ring_of(rings.ring_edges, middles)])
    try:
        root = np.linalg.cholesky((basis.T @ mass @ basis).toarray())
    except LinAlgError as error:
        raise SolverError("the pressures of a pair are not independent") from error
    displaced = solve_triangular(root, factor.T, lower=True).T
    weights = solve_triangular(root, basis.T @ space.weights, lower=True)
    rate = float(1 / (weights @ weights))
    steady = rate * weights
    forceless = np.linalg.qr(weights[:, None], mode="complete")[0][:, 1:]
    moved, of_steady = displaced @ forceless, displaced @ steady
    relaxation, modes = eigh(moved.T @ moved)
    kept = relaxation > EXCITED * relaxation[-1]
    relaxation, modes = relaxation[kept], modes[:, kept]
    amplitudes = -(modes.T @ (moved.T @ of_steady)) / relaxation
    excited = np.exp(-TIMES[:, None] / relaxation) * amplitudes
    pressures = steady + excited @ modes.T @ forceless.T
    depths = rate * TIMES + pressures @ displaced.T @ of_steady
    coefficients = solve_triangular(root, pressures.T, lower=True, trans="T")
    of_depth = float(np.abs(depths / exact.indentation - 1).max())
    return of_depth, _pressure_error(space, (basis @ coefficients).T, rings, exact)


def _pressure_error(
    space: PressureSpace, pressures: Sequence[Array], rings: Rings, exact: Worn
) -> float:
    cuts = np.union1d(space.breakpoints, exact.space.breakpoints)
    node, weight = gauss(exact.space.top + 2)
    half = np.diff(cuts)[:, None] / 2
    radii = (cuts[:-1, None] + half * (1 + node)).ravel()
    weights = 2 * np.pi * radii * (half * weight).ravel()
    weights *= rings.wear_coefficients[ring_of(rings.ring_edges, radii)]
    found, true = space.matrix(radii) @ np.transpose(pressures), exact.space.matrix(radii)
    true = true @ exact.pressure.T
    squares = weights @ (found - true) ** 2 / (weights @ true**2)
    return float(np.sqrt(squares.max()))
