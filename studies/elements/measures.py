"""Measurements of a pair of spaces: eigenvalues, and errors at the start and while it wears.

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

from ...fem.far_field import enough_poles
from ...fem.stability import refuse_singular
from ...mdr.flat_punch import D0
from ...meshes.half_space import truncation
from ...meshes.radial import gauss, graded_breakpoints, ring_of, values_on_rings
from ..crosscheck import (
    Array,
    AxisymmetricElasticity,
    Ground,
    HalfSpace,
    PressureSpace,
    Rings,
    RunningIn,
    SolverError,
    energy,
    flat_punch,
)
from ..crosscheck.verdict.operators import least_ratio_of_energies
from ..tables import Row
from .pairs import Displacement, full_pressure_space

TIMES = np.geomspace(0.1, 20.0, 4)
"""Times in a/(E* k_max v0) at which the errors of wear are measured."""
HIGHEST_POISSON_RATIO = 0.4999999
"""Greatest Poisson's ratio that the solid takes here; in runs it is smaller."""
FAR_FIELD_ERROR = 1e-9
"""Relative error of the energy that poles may leave of the truncation; it sets their number."""
EXTRA_GAUSS_POINTS = 6
"""Gauss points on an element, in addition to the degree of its pressures.

The singularity of the exact pressure at the rim needs them.
"""
LEAST_RELAXATION = 1e-14
"""Least relaxation time that is more than roundoff, relative to the greatest one."""


class WearHistory(NamedTuple):
    """Indentations and pressures of a punch while it wears.

    Parameters
    ----------
    space : pressure space
    indentation : (T,) indentations at `TIMES`, in F/(a E*)
    pressure : (T, size) coefficients of the pressures at `TIMES`
    """

    space: PressureSpace
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
    seconds : wall time of condensing
    """

    half_space: HalfSpace
    fem_factor: Array
    mdr_factor: Array
    seconds: float

    @property
    def space(self) -> PressureSpace:
        """The full pressure space: all pressures of the degree, broken at every vertex."""
        return self.half_space.space

    def factors_of(self, basis: csr_matrix) -> tuple[Array, Array]:
        """Return the factors (m, n) by finite elements and by MDR on a basis (size, n)."""
        return (basis.T @ self.fem_factor.T).T, (basis.T @ self.mdr_factor.T).T


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
    start = time.perf_counter()
    degree = displacement.degree
    solid = AxisymmetricElasticity(
        mesh,
        degree,
        Ground.half_space(poisson_ratio),
        displacement.element,
        highest_ratio=HIGHEST_POISSON_RATIO,
    )
    full_space = full_pressure_space(mesh, rings.ring_edges, degree)
    half_space = HalfSpace(solid, full_space, enough_poles(truncation(mesh), FAR_FIELD_ERROR))
    fem_factor = half_space.condensed()
    seconds = time.perf_counter() - start
    return Condensed(half_space, fem_factor, energy.compliance(full_space).factor, seconds)


def exact_wear(rings: Rings) -> WearHistory:
    """Return the reference history by MDR of degree 10 with smallest elements of 1e-8 radii."""
    breakpoints = graded_breakpoints(rings.ring_edges, 1e-8, 1e-9, 0.25)
    degrees = np.full(len(breakpoints) - 1, 10)
    space = PressureSpace(breakpoints, degrees, rings.ring_edges)
    history = RunningIn(energy.compliance(space), rings.wear_coefficients).modal(TIMES)
    return WearHistory(space, history.indentation, history.pressure)


def measure(
    condensed: Condensed, basis: csr_matrix, rings: Rings, exact: WearHistory | None
) -> Row:
    """Return the row of a pair of spaces: eigenvalues, errors and condition number.

    Parameters
    ----------
    condensed : half-space in the displacement space of the pair
    basis : (size, n) basis of the pressure space of the pair
    rings : of the punch
    exact : history that wear is compared with; None leaves wear out

    Returns
    -------
    row : errors are relative; a singular pair has a remark in place of errors
    """
    contact = len(condensed.fem_factor) - len(condensed.half_space.poles)
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


def start_error(space: PressureSpace, pressures: Array) -> float:
    """Return the relative error of the pressure of the flat start, in a weighted mean square.

    The weight is ``1 - r^2``, because the square of the exact pressure has no finite integral.

    Parameters
    ----------
    space : full pressure space
    pressures : (size,) coefficients
    """
    node, weight = gauss(space.top + EXTRA_GAUSS_POINTS)
    half = space.widths[:, None] / 2
    radii = space.breakpoints[:-1, None] + half * (1 + node)
    weights = 2 * np.pi * radii * half * weight * (1 - radii) * (1 + radii)
    exact = flat_punch(0.0).pressure_at(radii.ravel()).reshape(radii.shape)
    error = (space.on_elements(node) @ pressures).reshape(radii.shape) - exact
    return float(np.sqrt((weights * error**2).sum() / (weights * exact**2).sum()))


def wear_errors(
    space: PressureSpace, basis: csr_matrix, factor: Array, rings: Rings, exact: WearHistory
) -> tuple[float, float]:
    """Return the greatest relative errors over `TIMES` of the indentation and of the pressure.

    The error of the pressure is a mean square over the face, weighted by the wear coefficients.
    The history solves ``A p' = d' b - K p``, ``b . p = 1`` on the basis, by modes of the pencil
    (A, K) on pressures that carry no force. So wear rates are continuous only if the basis is.

    Parameters
    ----------
    space : full pressure space
    basis : (size, n) basis of the pressure space
    factor : (m, n) factor of the compliance A on it
    rings : of the punch
    exact : history to compare with

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
        root = np.linalg.cholesky((basis.T @ mass @ basis).toarray())
    except LinAlgError as error:
        raise SolverError("the pressures of a pair are not independent") from error
    displaced = solve_triangular(root, factor.T, lower=True).T
    weights = solve_triangular(root, basis.T @ space.weights, lower=True)
    rate = float(1 / (weights @ weights))
    steady = rate * weights
    forceless = np.linalg.qr(weights[:, None], mode="complete")[0][:, 1:]
    forceless_factor, steady_factor = displaced @ forceless, displaced @ steady
    relaxation, modes = eigh(forceless_factor.T @ forceless_factor)
    resolved = relaxation > LEAST_RELAXATION * relaxation[-1]
    relaxation, modes = relaxation[resolved], modes[:, resolved]
    amplitudes = -(modes.T @ (forceless_factor.T @ steady_factor)) / relaxation
    decaying = np.exp(-TIMES[:, None] / relaxation) * amplitudes
    pressures = steady + decaying @ modes.T @ forceless.T
    depths = rate * TIMES + pressures @ displaced.T @ steady_factor
    coefficients = solve_triangular(root, pressures.T, lower=True, trans="T")
    indentation_error = float(np.abs(depths / exact.indentation - 1).max())
    return indentation_error, _pressure_error(space, (basis @ coefficients).T, rings, exact)


def _pressure_error(
    space: PressureSpace, pressures: Sequence[Array], rings: Rings, exact: WearHistory
) -> float:
    """Return the greatest error over `TIMES` of pressures (T, size), as in `wear_errors`."""
    cuts = np.union1d(space.breakpoints, exact.space.breakpoints)
    node, weight = gauss(exact.space.top + 2)
    half = np.diff(cuts)[:, None] / 2
    radii = (cuts[:-1, None] + half * (1 + node)).ravel()
    weights = 2 * np.pi * radii * (half * weight).ravel()
    weights *= rings.at(radii)
    values = space.matrix(radii) @ np.transpose(pressures)
    exact_values = exact.space.matrix(radii) @ exact.pressure.T
    squares = weights @ (values - exact_values) ** 2 / (weights @ exact_values**2)
    return float(np.sqrt(squares.max()))
