"""Press a punch on any compliance: the flat start and the steady state. Non-dimensional, force 1.

The flat start is sought among pressures that suit it, ``p = sum_j c_j P_2j(t) / t`` with ``t =
sqrt(1 - r^2)`` and Legendre polynomials `P_2j`: infinite at the rim as a root, and smooth
elsewhere. Ring edges are not felt before anything has worn, and the small elements beside them,
which later times need, would lose the start to roundoff. The exact compliance of the half-space is
diagonal on these functions, and only the first of them carries force
(tests/physics/test_flat_punch.py).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import legval, legvander
from scipy.linalg import cho_factor, cho_solve

from ...meshes.compliance import Compliance
from ...meshes.errors import SolverError
from ...meshes.pressure_space import PressureSpace, shapes
from ...meshes.radial import Array, unit_gauss
from .modes import BandedCholesky
from .unilateral import Interval


@dataclass(frozen=True, eq=False)
class FlatStart:
    """The flat punch (Eqs. 10 and 11), solved by the method at hand.

    Parameters
    ----------
    coefficients : (J,) of ``P_2j(t) / t``
    pressure : (size,) their projection on the pressure space
    indentation : F / (2 a E*) but for the error of the method
    """

    coefficients: Array
    pressure: Array
    indentation: float
    intervals: tuple[Interval, ...] = (Interval(0.0, 1.0),)
    force: float = 1.0

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressures at radii (R,); infinite at the rim."""
        root = np.sqrt((1 - radii) * (1 + radii))
        with np.errstate(divide="ignore"):
            return np.asarray(
                _even_legendre(root, len(self.coefficients)) @ self.coefficients / root
            )

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force on each of the N rings between edges (N+1,)."""
        series = np.zeros(2 * len(self.coefficients))
        series[::2] = self.coefficients
        root = np.sqrt((1 - ring_edges) * (1 + ring_edges))
        return np.asarray(-2 * np.pi * np.diff(legval(root, np.polynomial.legendre.legint(series))))


@lru_cache(maxsize=8)  # punches that differ in wear alone begin alike
def flat_start(
    compliance: Compliance, indentation: float | None = None
) -> "FlatStart | FittedPress":
    """Press the unworn punch: ``A c = d b`` on the functions that suit it, with ``b . c = 1`` or d
    as given.

    Under them a half-space is displaced uniformly. What is displaced otherwise (a foundation of
    springs, say) is pressed by the pressures of the space itself.

    Raises
    ------
    SolverError
        if the compliance is not positive definite
    """
    space = compliance.space
    # what a compliance adds to the first of them is an error of its own
    count = max(1, min(3, space.size // 3))
    projected = BandedCholesky(space.mass()).solve(_moments(space, count))
    forces = np.zeros(count)
    forces[0] = 2 * np.pi
    displaced = compliance.factor @ projected
    coefficients, depth = _press(displaced.T @ displaced, forces, indentation)
    # the mean displacement under the first of them, and that weighted by its pressure
    uniform = compliance.factor @ space.uniform
    mean, weighted = (
        uniform @ displaced[:, 0] / np.pi,
        displaced[:, 0] @ displaced[:, 0] / forces[0],
    )
    if abs(mean / weighted - 1) > 0.1:
        return press_flat(compliance, indentation)
    return FlatStart(coefficients, projected @ coefficients, depth)


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
    matrix = continuous.T @ compliance.matrix @ continuous
    coefficients, indentation = _press(matrix, weights, indentation)
    return FittedPress(compliance.space, continuous @ coefficients, indentation)


def _press(matrix: Array, forces: Array, indentation: float | None) -> tuple[Array, float]:
    """Return the c and d of ``A c = d b``, with ``b . c = 1`` if d is not given."""
    try:
        solution = cho_solve(cho_factor(matrix), forces)
    except np.linalg.LinAlgError as error:
        raise SolverError(
            f"the compliance is not positive definite: {error}; ask for less extreme sizes"
        ) from error
    if indentation is None:
        indentation = float(1 / (forces @ solution))
    return indentation * solution, indentation


def _even_legendre(root: Array, count: int) -> Array:
    """Return ``P_2j(t)`` for j below a count along a new last axis."""
    return np.asarray(legvander(root, 2 * count - 2)[..., ::2])


def _moments(space: PressureSpace, count: int) -> Array:
    """Return ``int phi_i P_2j(t) / t dA``, (size, count).

    At the rim `t` itself is the variable of integration, ``r dr = -t dt``, in which nothing is
    singular.
    """
    # the root is one element away, where each point gains a factor of seven
    node, weight = unit_gauss(space.top + 24)
    inner, size = space.breakpoints[:-1, None], space.widths[:, None]
    radii = inner + size * node
    local = np.tile(2 * node - 1, (len(size), 1))
    # from the rim, to all digits
    last = np.full(len(size), len(size))
    away = space.distance(np.arange(len(size)), last)[:, None] - size * node
    root = np.sqrt(away * (1 + radii))
    greatest = np.sqrt(size[-1] * (1 + inner[-1]))
    root[-1] = greatest * node
    weights = 2 * np.pi * weight * radii * size / root
    weights[-1] = 2 * np.pi * weight * greatest
    distance = root[-1] ** 2 / (1 + np.sqrt((1 - root[-1]) * (1 + root[-1])))
    local[-1] = 1 - 2 * distance / size[-1]
    values = np.einsum(
        "eq,eqj,eqi->eij",
        weights,
        _even_legendre(root, count),
        shapes(local, space.top),
        optimize=True,
    )
    moments = np.zeros((space.size + 1, count))
    np.add.at(moments, space.dofs, values)
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
