"""Values of functions on the punch, from coefficients on a pressure space. Non-dimensional."""

from functools import lru_cache

import numpy as np
from scipy.sparse import csr_matrix

from .....meshes.compliance import Compliance
from .....meshes.pressure_space import PressureSpace
from .....meshes.radial import Array, ring_areas, unit_gauss
from ...problem.face import radial_weight
from ...problem.problem import Problem
from ...wear.history import History, Start
from ...wear.worn_face import WornFace

# Gauss points in each element for the moment of an unworn punch
START_POINTS = 24


# cached, because problems on the same space are sampled at the same radii
@lru_cache(maxsize=32)
def _matrix(space: PressureSpace, radii: bytes, derivative: bool = False) -> csr_matrix:
    return space.matrix(np.frombuffer(radii), derivative)


@lru_cache(maxsize=8)
def _ring_forces(space: PressureSpace, ring_edges: bytes) -> Array:
    return space.ring_forces(np.frombuffer(ring_edges))


@lru_cache(maxsize=8)
def _moments(space: PressureSpace) -> Array:
    """Return the integral (size,) of the radius times each function over the face."""
    radii, lengths, local = space.quadrature
    weights = 2 * np.pi * radii**2 * lengths
    return space.on_elements(local).T @ weights.ravel()


def _moment_of_start(start: Start, breakpoints: Array) -> float:
    """Return the integral of the radius times the pressure of an unworn punch.

    It is integrated by parts, because the force within a radius is smoother than the pressure,
    which may be infinite at edges. The variable is an angle in which roots at both ends of each
    element are smooth.

    Parameters
    ----------
    start : the unworn punch
    breakpoints : (n+1,) radii, edges and kinks of the contact among them
    """
    node, weight = unit_gauss(START_POINTS)
    angle = np.pi * node
    middle = (breakpoints[1:, None] + breakpoints[:-1, None]) / 2
    half = np.diff(breakpoints)[:, None] / 2
    radii = (middle - half * np.cos(angle)).ravel()
    lengths = (half * np.sin(angle) * np.pi * weight).ravel()
    edges = np.concatenate([breakpoints[:1], radii, breakpoints[-1:]])
    within = np.cumsum(start.ring_forces(edges))
    return float(breakpoints[-1] * within[-1] - lengths @ within[:-1])


@lru_cache(maxsize=8)
def _slopes(space: PressureSpace) -> csr_matrix:
    return space.on_elements(space.quadrature[2], derivative=True)


@lru_cache(maxsize=8)
def _samples(space: PressureSpace) -> Array:
    """Return the radii at which functions of a space are sampled to find their maximum.

    There are enough in each element that a cubic between two of them has the maximum to nine
    digits.
    """
    count = 3 * (space.top + 2)
    within = (1 - np.cos(np.pi * np.arange(count) / count)) / 2
    starts, widths = space.breakpoints[:-1, None], np.diff(space.breakpoints)[:, None]
    return np.append((starts + widths * within).ravel(), 1.0)


class Functions:
    """Evaluates functions on the punch from their coefficients on a pressure space.

    Parameters
    ----------
    problem, space : the problem, and the space of the coefficients
    compliance : compliance on that space; needed for fields of a contact that moves
    """

    def __init__(
        self, problem: Problem, space: PressureSpace, compliance: Compliance | None = None
    ) -> None:
        self.problem, self.space, self.compliance = problem, space, compliance

    def at(self, radii: Array, functions: Array, derivative: bool = False) -> Array:
        """Return values (T, R), or slopes, at radii (R,) by coefficients (T, size)."""
        return (_matrix(self.space, radii.tobytes(), derivative) @ functions.T).T

    def matrix(self, radii: Array) -> csr_matrix:
        """Return the values (R, size) of all functions of the space at radii (R,)."""
        return _matrix(self.space, radii.tobytes())

    def on_face(self, functions: Array) -> Array:
        """Return values (T, R) at the radii of the face by coefficients (T, size)."""
        return self.at(self.problem.face.radii, functions)

    def greatest(self, functions: Array) -> Array:
        """Return the maximum (T,) over the punch of functions with coefficients (T, size).

        It is the maximum of the cubic between two samples that has their values and slopes.
        """
        radii, row = _samples(self.space), np.arange(len(functions))
        samples, slopes = self.at(radii, functions), self.at(radii, functions, derivative=True)
        best = samples.argmax(axis=1)
        left = np.clip(np.where(slopes[row, best] > 0, best, best - 1), 0, samples.shape[1] - 2)
        width = radii[left + 1] - radii[left]
        start, rise = samples[row, left], samples[row, left + 1] - samples[row, left]
        first, last = width * slopes[row, left], width * slopes[row, left + 1]
        # start + first t + b t^2 + c t^3, with the value and slope of the right sample at t = 1;
        # its maximum is at t = top if the slope changes sign
        b, c = 3 * rise - 2 * first - last, first + last - 2 * rise
        inside = (first > 0) & (last < 0)
        root = np.sqrt(np.where(inside, b * b - 3 * c * first, 1.0))
        top = np.divide(first, root - b, out=np.zeros(len(row)), where=inside)
        return np.maximum(samples[row, best], start + top * (first + top * (b + top * c)))

    def rms_slopes(self, functions: Array) -> Array:
        """Return the root mean square slopes (T,) of functions with coefficients (T, size)."""
        radii, lengths, _ = self.space.quadrature
        average = self.problem.gradient_average, self.problem.inner_radius
        weights = lengths * radial_weight(radii, *average)
        # not by a Gram matrix: it would sum the square of a constant over a small element, which
        # leaves only roundoff
        return np.sqrt(((_slopes(self.space) @ functions.T).T) ** 2 @ weights.ravel())

    def pressures(self, history: History, radii: Array) -> Array:
        """Return pressures (T, R) at radii.

        The start is sampled in its own space, if it has one. Negative values of polynomials next to
        an edge are artefacts, and are replaced by zero.
        """
        if (pressed := history.pressed) is None:
            return np.maximum(self.at(radii, history.pressure), 0.0)
        pressures, rows = np.maximum(self.at(radii, pressed.rest), 0.0), pressed.force > 0
        # pressures of the start may be infinite at the rim
        scale = pressed.force[rows] / pressed.start.force
        pressures[rows] += np.outer(scale, pressed.start.pressure_at(radii))
        return pressures

    def ring_forces(self, history: History) -> Array:
        """Return the force (T, N) on each ring."""
        ring_edges = self.problem.ring_edges
        on_rings = _ring_forces(self.space, ring_edges.tobytes()).T
        if (pressed := history.pressed) is None:
            return history.pressure @ on_rings
        scale = pressed.force / pressed.start.force
        return pressed.rest @ on_rings + np.outer(scale, pressed.start.ring_forces(ring_edges))

    def moments(self, history: History) -> Array:
        """Return the integrals (T,) of the radius times the pressure over the face."""
        of_functions = _moments(self.space)
        if (pressed := history.pressed) is None:
            return history.pressure @ of_functions
        start, profile = pressed.start, self.problem.profile
        edges = [edge for part in start.intervals for edge in (part.inner, part.outer)]
        breakpoints = np.union1d(self.problem.ring_edges, [*edges, *profile.kinks])
        breakpoints = breakpoints[(breakpoints >= self.problem.inner_radius) & (breakpoints <= 1)]
        of_start = _moment_of_start(start, breakpoints)
        return pressed.rest @ of_functions + pressed.force / start.force * of_start

    def worn_volumes(self, history: History) -> Array:
        """Return the volume worn off each ring (T, N).

        In full contact the worn depth is in the space. Else it is k times the integral of the
        pressure over the sliding distance, and only the latter is in the space.
        """
        ring_edges, space = self.problem.ring_edges, self.space
        if self.problem.full_contact:
            worn = history.shape @ _ring_forces(space, ring_edges.tobytes()).T
        else:
            rings = self.problem.merged
            of_functions = space.mass(rings.wear_coefficients) @ space.ring_indicator()
            first = np.searchsorted(rings.ring_edges, ring_edges[:-1])
            worn = np.add.reduceat(history.integral @ of_functions, first, axis=1)
        return np.asarray(worn) + np.outer(history.even_wear, ring_areas(ring_edges))

    def worn_face(self, history: History) -> WornFace:
        """Return the worn face of a punch whose contact moves.

        Raises
        ------
        ValueError
            if there is no compliance
        """
        if self.compliance is None:
            raise ValueError("fields of a contact that moves need the compliance")
        return WornFace(self.problem.profile, self.compliance, history)

    @property
    def centre(self) -> Array:
        """(1,) radius of the centre, 0; for a hollow punch, the inner edge of its face."""
        return self.problem.ring_edges[:1]
