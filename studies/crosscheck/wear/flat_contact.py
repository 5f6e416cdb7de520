"""Press a punch on any compliance: the flat start and the steady state.

All quantities are non-dimensional, and the force is 1.

The pressure of the unworn flat punch is expanded in ``p = sum_j c_j P_2j(t) / t`` with ``t = sqrt(1
- r^2)`` and Legendre polynomials `P_2j`. These functions have the square-root singularity at the
rim and are smooth elsewhere. Before any wear the pressure is smooth across ring edges, so the small
elements there, which later times need, are not used: on them the start would be lost in roundoff.
The exact compliance of the half-space is diagonal on these functions, and only the first of them
carries force (tests/physics/test_flat_punch.py). For a hollow punch, the functions are the pressure
of the flat annulus times Legendre polynomials in ``r^2``.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import solve_triangular

from ....mdr.flat_punch import DiscSeries, FlatPunch, disc_functions
from ....meshes.compliance import Compliance
from ....meshes.errors import SolverError
from ....meshes.ground.ground import Ground
from ....meshes.ground.line_energy import flat_series
from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array, unit_gauss
from .unilateral import Interval

# Greatest number of functions in the expansion of the flat start. In exact arithmetic the first one
# suffices; the coefficients of the others are errors of the method's compliance.
MOST_FUNCTIONS = 3
# Greatest relative difference between the mean displacement under the first function and its mean
# weighted by the pressure. If it is exceeded, the displacement is not uniform, so the compliance is
# not that of a half-space.
UNIFORMITY_TOLERANCE = 0.1


@dataclass(frozen=True, eq=False)
class FlatStart:
    """The flat punch (Eqs. 10 and 11) or the flat annulus, solved with the compliance of a method.

    Parameters
    ----------
    coefficients : (J,) array
        Coefficients of ``P_2j(t) / t``. For a hollow punch they are those of ``p r dr = sum_j c_j
        cos(j angle) d(angle)`` (`ringwear.mdr.annulus`).
    pressure : (size,) array
        Projection of this pressure on the pressure space.
    indentation : float
        Indentation; it differs from the closed form by the error of the method.
    inner_radius : float
        Radius of the hole; 0 if there is none.
    force : float
        Force of this pressure.
    """

    coefficients: Array
    pressure: Array
    indentation: float
    inner_radius: float = 0.0
    force: float = 1.0

    @property
    def intervals(self) -> tuple[Interval, ...]:
        """The contact: all of the face."""
        return (Interval(self.inner_radius, 1.0),)

    @cached_property
    def _closed_form(self) -> FlatPunch:
        if not self.inner_radius:
            return DiscSeries(self.indentation, self.coefficients)
        from ....mdr.annulus import FlatAnnulus  # full punches do not need it

        return FlatAnnulus(self.inner_radius, self.indentation, self.coefficients)

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressures (R,) at radii (R,); they are infinite at the rim and at a hole."""
        return self._closed_form.pressure_at(radii)

    def extremes_on(self, ring_edges: Array) -> tuple[Array, Array]:
        """Return the least and the greatest pressure (N,) on each ring between edges (N+1,)."""
        return self._closed_form.extremes_on(ring_edges)

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force on each of the N rings between edges (N+1,)."""
        return self._closed_form.ring_forces(ring_edges)


@lru_cache(maxsize=8)  # punches that differ only in their wear coefficients have the same start
def flat_start(
    compliance: Compliance, indentation: float | None = None
) -> "FlatStart | FittedPress":
    """Press the unworn flat punch: solve ``A c = d b`` on the functions of the expansion.

    The first of these pressures displaces a half-space uniformly. If the given compliance is not
    displaced uniformly (for example a foundation of springs), the problem is solved on the pressure
    space itself instead (`press_flat`).

    Parameters
    ----------
    compliance : Compliance
        Compliance of the half-space on a pressure space.
    indentation : float, optional
        Indentation d. If it is not given, the force is 1, ``b . c = 1``.

    Raises
    ------
    SolverError
        if the compliance is not positive definite
    """
    space = compliance.space
    count = max(1, min(MOST_FUNCTIONS, space.size // 3))
    series, forces = _start_series(space.inner_radius, count, compliance.ground)
    projected = space.projected(_moments(space, len(series)) @ series)
    displacements = compliance.factor @ projected
    factor = np.asarray(np.linalg.qr(displacements, mode="r"))
    coefficients, depth = _press(factor, forces, indentation)
    # compare the mean displacement under the first function with its mean weighted by the pressure
    first_displacement = displacements[:, 0]
    uniform_displacement = compliance.factor @ space.uniform
    mean = uniform_displacement @ first_displacement / (space.weights @ space.uniform)
    if abs(mean / (first_displacement @ first_displacement / forces[0]) - 1) > UNIFORMITY_TOLERANCE:
        return press_flat(compliance, indentation)
    return FlatStart(series @ coefficients, projected @ coefficients, depth, space.inner_radius)


def _start_series(inner_radius: float, count: int, ground: Ground) -> tuple[Array, Array]:
    """Return the functions of the flat start, as coefficients (J, count), and forces (count,).

    Each column is a function. The first one is the pressure of the flat punch itself.
    """
    if not inner_radius:
        punch = flat_series(ground)
        series = np.eye(max(count, len(punch)))[:, :count]
        series[: len(punch), 0] = punch
        return series, 2 * np.pi * series[0]
    from ....mdr.annulus import flat_annulus_series  # full punches do not need it

    of_annulus = flat_annulus_series(inner_radius, count, ground)
    return of_annulus, 2 * np.pi**2 * of_annulus[0]


@dataclass(frozen=True, eq=False)
class FittedPress:
    """A pressed punch whose pressure space is fitted to the edges of its contact.

    Parameters
    ----------
    space : PressureSpace
        Space on the disc inside the outermost contact edge, scaled to radius 1.
    pressure : (size,) array
        Coefficients of the pressure on that space.
    indentation, force : float
        Indentation and force. The load prescribes one of them.
    intervals : tuple of Interval
        Parts of the contact, outwards.
    unresolved_height : float
        Largest difference of the face from what the elements resolve, if its kinks are too many to
        fit the elements to them.
    """

    space: PressureSpace
    pressure: Array
    indentation: float
    force: float = 1.0
    intervals: tuple[Interval, ...] = (Interval(0.0, 1.0),)
    unresolved_height: float = 0.0

    @property
    def radius(self) -> float:
        """The radius of the outermost contact edge."""
        return self.intervals[-1].outer

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressures at radii (R,) of the punch; zero outside the contact."""
        inside = radii <= self.radius
        pressures = self.space.matrix(np.minimum(radii / self.radius, 1.0)) @ self.pressure
        return np.where(inside, pressures, 0.0)

    def extremes_on(self, ring_edges: Array) -> tuple[Array, Array]:
        """Return the least and the greatest pressure on each ring, taken at its edges (N+1,)."""
        at_edges = self.pressure_at(ring_edges)
        return np.minimum(at_edges[:-1], at_edges[1:]), np.maximum(at_edges[:-1], at_edges[1:])

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force on each of the N rings between edges (N+1,)."""
        scaled = np.minimum(ring_edges / self.radius, 1.0)
        return self.radius**2 * self.space.ring_forces(scaled) @ self.pressure


@lru_cache(maxsize=8)
def press_flat(compliance: Compliance, indentation: float | None = None) -> FittedPress:
    """Press a flat punch with pressures of the space itself, continuous across ring edges.

    Studies of pressure spaces and meshes use this solution because it shows how well the elements
    at the rim represent the singular pressure. Small elements elsewhere add roundoff; histories
    therefore start from `flat_start`.

    Raises
    ------
    SolverError
        if the compliance is not positive definite
    """
    continuous = compliance.space.joined()
    weights = continuous.T @ compliance.space.weights
    factor = np.asarray(np.linalg.qr((continuous.T @ compliance.factor.T).T, mode="r"))
    coefficients, indentation = _press(factor, weights, indentation)
    return FittedPress(
        compliance.space,
        continuous @ coefficients,
        indentation,
        intervals=(Interval(compliance.space.inner_radius, 1.0),),
    )


def _press(factor: Array, forces: Array, indentation: float | None) -> tuple[Array, float]:
    """Return the c and d of ``A c = d b``, with ``b . c = 1`` if d is not given.

    A is given by its triangular factor R, ``A = R^T R``, so that rows of very different sizes keep
    all of their digits.
    """
    least = np.abs(np.diag(factor)).min()
    if not (np.isfinite(factor).all() and least > 0):
        raise SolverError("the compliance is not positive definite; ask for less extreme sizes")
    half = solve_triangular(factor, forces, trans=1)
    if indentation is None:
        indentation = float(1 / (half @ half))
    return indentation * solve_triangular(factor, half), indentation


def _start_functions(
    inner_radius: float, hole_distance: Array, rim_distance: Array, count: int
) -> tuple[Array, Array]:
    """Return the functions of the flat start (..., count), and their common factor (...).

    The factor times a function is a pressure. The functions are ``P_2j(t)`` with the factor ``1 /
    t``, or for a hollow punch the cosines of the annulus.

    Parameters
    ----------
    inner_radius : float
        Radius of the hole; 0 if there is none.
    hole_distance, rim_distance : (...) arrays
        Distances of the radii from the hole, or from the axis, and from the rim.
    count : int
        Number of functions.
    """
    if inner_radius:
        from ....mdr.annulus import cosine_pressures  # full punches do not need it

        return cosine_pressures(inner_radius, hole_distance, rim_distance, count)
    return disc_functions(rim_distance, count)


def _moments(space: PressureSpace, count: int) -> Array:
    """Return ``int phi_i p_j dA`` (size, count) for the functions p_j of the flat start.

    In the elements at the rim and at a hole, the variable of integration is the square root of the
    distance from that edge, which removes the singularity.

    Raises
    ------
    SolverError
        if a hollow punch has fewer than two elements
    """
    # the singularity is at least one element away, so each Gauss point reduces the error sevenfold;
    # functions of higher degree oscillate and need more points
    node, weight = unit_gauss(space.top + 18 + 2 * max(count, MOST_FUNCTIONS))
    elements, rim = np.arange(len(space.degrees)), len(space.degrees)
    if space.inner_radius and rim < 2:
        raise SolverError("the face of a hollow punch needs two elements: ask for smaller sizes")
    size = space.widths[:, None]
    fraction, weights = (np.tile(part, (rim, 1)) for part in (node, weight))
    fraction[-1], weights[-1] = 1 - node**2, 2 * node * weight
    if space.inner_radius:
        fraction[0], weights[0] = node**2, 2 * node * weight
    # distances from both edges without cancellation
    hole_distance = space.distance(np.zeros_like(elements), elements)[:, None]
    hole_distance = hole_distance + size * fraction
    rim_distance = space.distance(elements, np.full(rim, rim))[:, None] - size * fraction
    rim_distance[-1] = size[-1] * node**2
    radii = space.breakpoints[:-1, None] + size * fraction
    functions, factor = _start_functions(space.inner_radius, hole_distance, rim_distance, count)
    areas = 2 * np.pi * weights * radii * size
    values = (areas * factor)[..., None] * functions
    return space.moments(elements, 2 * fraction - 1, values)


@dataclass(frozen=True, eq=False)
class SteadyState:
    """The steady state of wear (Eqs. 23 to 27), in which the wear rate is the same everywhere.

    Parameters
    ----------
    pressure, displacement : (size,) arrays
        Coefficients on the pressure space.
    moments : (size,) array
        Integrals of the displacement times each basis function, ``A p``.
    wear_rate : float
        The common value of ``k p``.
    """

    pressure: Array
    displacement: Array
    moments: Array
    wear_rate: float
