"""Press a punch on any compliance: the flat start and the steady state. Non-dimensional, force 1.

The flat start is sought among pressures that suit it, ``p = sum_j c_j P_2j(t) / t`` with ``t =
sqrt(1 - r^2)`` and Legendre polynomials `P_2j`: infinite at the rim as a root, and smooth
elsewhere. Ring edges are not felt before anything has worn, and the small elements beside them,
which later times need, would lose the start to roundoff. The exact compliance of the half-space is
diagonal on these functions, and only the first of them carries force
(tests/physics/test_flat_punch.py). Those of a hollow punch are the pressure of the flat annulus
times Legendre polynomials in ``r^2``.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.linalg import solve_triangular

from ...mdr.flat_punch import DiscSeries, FlatPunch, disc_functions
from ...meshes.compliance import Compliance
from ...meshes.errors import SolverError
from ...meshes.pressure_space import PressureSpace, shapes
from ...meshes.radial import Array, unit_gauss
from .modes import BandedCholesky
from .unilateral import Interval

# functions that a flat start is sought among: what a compliance adds to the first of them is an
# error of its own
MOST_FUNCTIONS = 3
# part by which the mean displacement under the first function may differ from that weighted by its
# pressure: beyond it the compliance is not that of a half-space
UNEVEN = 0.1


@dataclass(frozen=True, eq=False)
class FlatStart:
    """The flat punch (Eqs. 10 and 11), or the flat annulus, solved by the method at hand.

    Parameters
    ----------
    coefficients : (J,) of ``P_2j(t) / t``; of a hollow punch, of ``p r dr = sum_j c_j cos(j angle)
        d(angle)`` (`ringwear.mdr.annulus`)
    pressure : (size,) their projection on the pressure space
    indentation : that of the closed form but for the error of the method
    inner_radius : of the hole; 0 if there is none
    """

    coefficients: Array
    pressure: Array
    indentation: float
    inner_radius: float = 0.0
    force: float = 1.0

    @property
    def intervals(self) -> tuple[Interval, ...]:
        """Where it presses."""
        return (Interval(self.inner_radius, 1.0),)

    @cached_property
    def _in_closed_form(self) -> FlatPunch:
        if not self.inner_radius:
            return DiscSeries(self.indentation, self.coefficients)
        from ...mdr.annulus import FlatAnnulus  # full punches do not need it

        return FlatAnnulus(self.inner_radius, self.indentation, self.coefficients)

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressures at radii (R,) of the face; infinite at the rim and at a hole."""
        return self._in_closed_form.pressure_at(radii)

    def extremes_on(self, ring_edges: Array) -> tuple[Array, Array]:
        """Return the least and the greatest pressure (N,) on each ring between edges (N+1,)."""
        return self._in_closed_form.extremes_on(ring_edges)

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force on each of the N rings between edges (N+1,)."""
        return self._in_closed_form.ring_forces(ring_edges)


@lru_cache(maxsize=8)  # punches that differ in wear alone begin alike
def flat_start(
    compliance: Compliance, indentation: float | None = None
) -> "FlatStart | FittedPress":
    """Press the unworn punch: solve ``A c = d b`` on the functions that suit a flat start.

    Either ``b . c = 1`` or d is given. Under these functions a half-space is displaced uniformly.
    What is displaced otherwise (a foundation of springs, say) is pressed by the pressures of the
    space itself.

    Raises
    ------
    SolverError
        if the compliance is not positive definite
    """
    space = compliance.space
    count = max(1, min(MOST_FUNCTIONS, space.size // 3))
    series, forces = _functions(space.inner_radius, count, compliance.flat_series)
    projected = BandedCholesky(space.mass()).solve(_moments(space, len(series)) @ series)
    displaced = compliance.factor @ projected
    factor = np.asarray(np.linalg.qr(displaced, mode="r"))
    coefficients, depth = _press(factor, forces, indentation)
    # the mean displacement under the first of them, and that weighted by its pressure
    first, of_uniform = displaced[:, 0], compliance.factor @ space.uniform
    mean = of_uniform @ first / (space.weights @ space.uniform)
    if abs(mean / (first @ first / forces[0]) - 1) > UNEVEN:
        return press_flat(compliance, indentation)
    return FlatStart(series @ coefficients, projected @ coefficients, depth, space.inner_radius)


def _functions(
    inner_radius: float, count: int, flat_series: tuple[float, ...]
) -> tuple[Array, Array]:
    """Return the functions that suit a flat start, (J, count) by columns, and their forces.

    The first is the pressure of the flat punch itself.
    """
    if not inner_radius:
        series = np.eye(max(count, len(flat_series)))[:, :count]
        series[: len(flat_series), 0] = flat_series
        return series, 2 * np.pi * series[0]
    from ...mdr.annulus import flat_annulus_series  # full punches do not need it

    series = flat_annulus_series(inner_radius, count)
    return series, 2 * np.pi**2 * series[0]


@dataclass(frozen=True, eq=False)
class FittedPress:
    """A punch pressed on a pressure space that is fitted to its contact.

    Parameters
    ----------
    space : on the disc of the outermost edge, scaled to radius 1
    pressure : (size,) coefficients on it
    indentation, force : one of them as given
    intervals : of contact
    """

    space: PressureSpace
    pressure: Array
    indentation: float
    force: float = 1.0
    intervals: tuple[Interval, ...] = (Interval(0.0, 1.0),)

    @property
    def radius(self) -> float:
        """The outermost edge."""
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
        return np.asarray(self.radius**2 * self.space.ring_forces(scaled) @ self.pressure)


@lru_cache(maxsize=8)
def press_flat(compliance: Compliance, indentation: float | None = None) -> FittedPress:
    """Press a flat punch by the pressures of the space itself, continuous across ring edges.

    Studies of spaces and meshes look at it: it shows what elements at the rim can hold. Smaller
    elements elsewhere make it worse by roundoff; the start of a history is `flat_start`.

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

    A is given by its triangular factor, ``A = R^T R``: rows of all sizes keep their digits.
    """
    least = np.abs(np.diag(factor)).min()
    if not (np.isfinite(factor).all() and least > 0):
        raise SolverError("the compliance is not positive definite; ask for less extreme sizes")
    half = solve_triangular(factor, forces, trans=1)
    if indentation is None:
        indentation = float(1 / (half @ half))
    return indentation * solve_triangular(factor, half), indentation


def _suited(
    inner_radius: float, from_hole: Array, to_rim: Array, count: int
) -> tuple[Array, Array]:
    """Return functions (..., count), and the factor (...) that makes pressures of them.

    By the distances of radii from the hole, or from the axis, and from the rim: ``P_2j(t) / t``, or
    the cosines of an annulus.
    """
    if inner_radius:
        from ...mdr.annulus import cosine_pressures  # full punches do not need it

        return cosine_pressures(inner_radius, from_hole, to_rim, count)
    return disc_functions(to_rim, count)


def _moments(space: PressureSpace, count: int) -> Array:
    """Return ``int phi_i p_j dA`` of the functions that suit a flat start, (size, count).

    In the elements at the rim and at a hole the root of the distance is the variable of
    integration, in which nothing is singular.
    """
    # the root is one element away, where each point gains a factor of seven; functions oscillate
    node, weight = unit_gauss(space.top + 18 + 2 * max(count, MOST_FUNCTIONS))
    elements, rim = np.flatnonzero(space.degrees > 0), len(space.degrees)
    if space.hollow and len(elements) < 2:
        raise SolverError("the face of a hollow punch needs two elements: ask for smaller sizes")
    size = space.widths[elements, None]
    along, weights = (np.tile(part, (len(elements), 1)) for part in (node, weight))
    along[-1], weights[-1] = 1 - node**2, 2 * node * weight
    if space.hollow:
        along[0], weights[0] = node**2, 2 * node * weight
    # distances from both edges, to all digits
    from_hole = space.distance(np.full(len(elements), elements[0]), elements)[:, None]
    from_hole = from_hole + size * along
    to_rim = space.distance(elements, np.full(len(elements), rim))[:, None] - size * along
    to_rim[-1] = size[-1] * node**2
    radii = space.breakpoints[elements, None] + size * along
    functions, factor = _suited(space.inner_radius, from_hole, to_rim, count)
    values = np.einsum(
        "eq,eqj,eqi->eij",
        2 * np.pi * weights * radii * size * factor,
        functions,
        shapes(2 * along - 1, space.top),
        optimize=True,
    )
    moments = np.zeros((space.size + 1, count))
    np.add.at(moments, space.dofs[elements], values)
    return moments[:-1]


@dataclass(frozen=True, eq=False)
class SteadyState:
    """The state that wear tends to (Eqs. 23 to 27): one wear rate, and the displacement it makes.

    Parameters
    ----------
    pressure, displacement : coefficients on the pressure space
    moments : (size,) the displacement against each pressure
    wear_rate : the common ``k p``
    """

    pressure: Array
    displacement: Array
    moments: Array
    wear_rate: float
