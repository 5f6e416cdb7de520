"""An independent reference.

Archard's wear by broken Legendre polynomials in ``1 - r^2``, and nothing of what it judges.

With ``s = 1 - r^2`` the line density of the MDR is Abel's integral ``q(x) = int_0^x p(s) / sqrt(x -
s) ds``, the energy is ``int u p dA = int_0^1 q^2 / sqrt(1 - x) dx``, and an area ``pi ds``. On a
mesh graded to every ring edge Legendre polynomials, orthonormal with the wear coefficient as
weight, turn the law of wear into one singular value problem: no continuity is asked of pressure or
wear rate, and no half-space, mesh, basis or quadrature is shared with any method. Coordinates are
distances from the nearest ring edge, so that layers may be far thinner than `s` itself could tell.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray
from numpy.polynomial.legendre import legder, leggauss, legval, legvander
from scipy.linalg import qr, svd
from scipy.special import roots_jacobi

from ...meshes.radial import Array, Indices
from ..methods.direct import steady
from ..methods.quantities import labelled
from ..problem.problem import D0, Problem
from .layers import Layers

# elements, in s: thinner layers would be felt by slopes alone, and by little
SMALLEST = 1e-14


@dataclass(frozen=True, eq=False)
class Reference:
    """A punch (non-dimensional, force 1) worn from its flat start.

    Parameters
    ----------
    ring_edges, wear_coefficients : of the punch, from 0 to 1
    smallest : (N,) smallest element at each edge but the centre, in s, the rim last
    degree : highest degree
    factor : by which elements shrink towards ring edges and rim
    """

    ring_edges: Array
    wear_coefficients: Array
    smallest: Array
    degree: int = 12
    factor: float = 0.25

    @cached_property
    def edges(self) -> Array:
        """Ring edges in s, from the rim inwards."""
        return ((1 - self.ring_edges) * (1 + self.ring_edges))[::-1]

    @cached_property
    def _layers(self) -> Layers:
        return Layers.graded(self.edges, self.smallest[::-1], self.factor)

    @cached_property
    def degrees(self) -> Indices:
        """Of each element: rising with the distance from ring edges and rim, in elements."""
        return np.minimum(4 + self._layers.between, self.degree)

    @cached_property
    def _starts(self) -> Indices:
        return np.concatenate([[0], np.cumsum(self.degrees + 1)])

    @cached_property
    def _wear(self) -> Array:
        """Wear coefficient of each element."""
        return self.wear_coefficients[::-1][self._layers.ring]

    def _scale(self, element: int) -> Array:
        """Factors that make the Legendre polynomials of an element orthonormal in the mass of
        weight `k`.
        """
        per_area = np.pi * self._layers.widths[element] * self._wear[element]
        return np.sqrt((2 * np.arange(self.degrees[element] + 1.0) + 1) / per_area)

    @cached_property
    def _positions(self) -> tuple[Array, Array, Array]:
        """Positions x (an edge, and the distance from it) and weights for energies.

        Root singularities are on the right of every breakpoint and at the axis.
        """
        count = 2 * self.degree + 12
        node, weight = leggauss(count)
        y, w = (1 + node) / 2, weight / 2
        base, low, width = (
            part[:, None] for part in (self._layers.edge, self._layers.low, self._layers.widths)
        )
        distance = low + width * y**2
        weights = width * 2 * y * w / np.sqrt(1 - base - distance)
        # the last panel ends at the axis: 1 - x = width (1 - y) (1 + y)
        node, weight = roots_jacobi(count + 12, -0.5, 0)
        y, w = (1 + node) / 2, weight / np.sqrt(2)
        edge = np.append(np.repeat(base[:-1], count), np.repeat(base[-1], count + 12))
        distance = np.append(distance[:-1].ravel(), low[-1] + width[-1] * y**2)
        return (
            edge,
            distance,
            np.append(weights[:-1].ravel(), np.sqrt(width[-1]) * 2 * y * w / np.sqrt(1 + y)),
        )

    def _factor(self) -> Array:
        """(positions, size) factor H of the energy."""
        (edge, distance, weights), layers = self._positions, self._layers
        out = np.zeros((len(weights), self._starts[-1]))
        far_node, far_weight = leggauss(self.degree + 24)
        near_node, near_weight = leggauss(self.degree + 2)
        for element, (base, low, width) in enumerate(
            zip(layers.edge, layers.low, layers.widths, strict=True)
        ):
            half, degree, scale = width / 2, self.degrees[element], self._scale(element)
            columns = slice(self._starts[element], self._starts[element + 1])
            # from the left end of the element to each position
            beyond = (edge - base) + (distance - low)
            far = np.flatnonzero(beyond > 2 * width)
            kernel = half * far_weight / np.sqrt(beyond[far, None] - half * (1 + far_node))
            out[far, columns] = kernel @ legvander(far_node, degree) * scale
            near = np.flatnonzero((beyond > 0) & (beyond <= 2 * width))
            gap = beyond[near]
            last, first = np.sqrt(gap), np.sqrt(np.maximum(gap - width, 0))
            v = (last + first)[:, None] / 2 + (last - first)[:, None] / 2 * near_node
            local = (gap[:, None] - v**2) / half - 1
            values = legvander(local, degree) * ((last - first)[:, None] * near_weight)[:, :, None]
            out[near, columns] = values.sum(axis=1) * scale
        return np.sqrt(weights)[:, None] * out

    @cached_property
    def _weights(self) -> Array:
        """(size,) force of each function."""
        out = np.zeros(self._starts[-1])
        for element, start in enumerate(self._starts[:-1]):
            out[start] = np.pi * self._layers.widths[element] * self._scale(element)[0]
        return out

    @cached_property
    def _triangle(self) -> Array:
        """(size, size) factor of the energy as small as can be."""
        return qr(self._factor(), mode="r", check_finite=False, overwrite_a=True)[0][
            : self._starts[-1]
        ]

    @cached_property
    def _modes(self) -> tuple[Array, Array, Array, Array]:
        """Relaxation times, modes (size, m) orthonormal in K, the steady state, and its moments."""
        triangle = self._triangle
        axis = self._weights / np.linalg.norm(self._weights)
        steady = self._weights / (self._weights @ self._weights)
        moments = triangle.T @ (triangle @ steady)
        axis[0] += np.copysign(1.0, axis[0])
        axis /= np.linalg.norm(axis)
        reflected = triangle - 2 * np.outer(triangle @ axis, axis)
        _, singular, right = svd(
            reflected[:, 1:], full_matrices=False, check_finite=False, lapack_driver="gesdd"
        )
        shapes = np.concatenate([np.zeros((1, len(singular))), right.T])
        shapes -= 2 * np.outer(axis, axis @ shapes)
        return singular**2, shapes, steady, moments

    @property
    def relaxation_times(self) -> Array:
        return self._modes[0]

    @property
    def wear_rate(self) -> float:
        """Of the steady state."""
        return float(1 / (self._weights @ self._weights))

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Pressure and worn height, (T, size) coefficients, and indentation (T,) at times > 0."""
        relaxation, shapes, steady, moments = self._modes
        amplitudes = shapes.T @ moments
        decay = times[:, None] / relaxation
        pressure = steady - (np.exp(-decay) * amplitudes / relaxation) @ shapes.T
        indentation = pressure @ moments + self.wear_rate * times
        worn = indentation[:, None] * self._weights - (pressure @ self._triangle.T) @ self._triangle
        return pressure, worn, indentation

    def _element_of(self, radii: Array) -> tuple[Indices, Array]:
        s = (1 - radii) * (1 + radii)
        # a radius on a ring edge belongs to the ring outside it, which is the lesser s
        element = np.clip(
            np.searchsorted(self._layers.breakpoints, s, side="left") - 1, 0, len(self.degrees) - 1
        )
        base, low, widths = (
            part[element] for part in (self._layers.edge, self._layers.low, self._layers.widths)
        )
        return element, np.clip(2 * ((s - base) - low) / widths - 1, -1, 1)

    def values(self, coefficients: Array, radii: Array) -> Array:
        """(T, len(radii)) values of functions."""
        element, local = self._element_of(radii)
        out = np.empty((len(coefficients), len(radii)))
        for e in np.unique(element):
            here = element == e
            columns = slice(self._starts[e], self._starts[e + 1])
            out[:, here] = (coefficients[:, columns] * self._scale(e)) @ legvander(
                local[here], self.degrees[e]
            ).T
        return out

    def worn(self, coefficients: Array, radii: Array) -> Array:
        """(T, len(radii)) worn heights, from their coefficients."""
        return self.values(coefficients, radii) * self._wear[self._element_of(radii)[0]]

    def ring_forces(self, pressure: Array) -> Array:
        """(T, N) force on each ring, from the centre."""
        force = pressure[:, self._starts[:-1]] * self._weights[self._starts[:-1]]
        out = np.zeros((len(pressure), len(self.wear_coefficients)))
        np.add.at(out.T, self._layers.ring, force.T)
        return out[:, ::-1]

    def rms_slopes(self, worn: Array, average: str = "line") -> Array:
        """(T,) root mean square of the slope of worn heights."""
        node, weight = leggauss(2 * self.degree + 4)
        total = np.zeros(len(worn))
        for e, (left, half) in enumerate(
            zip(self._layers.breakpoints[:-1], self._layers.widths / 2, strict=True)
        ):
            columns = slice(self._starts[e], self._starts[e + 1])
            series = (worn[:, columns] * self._scale(e) * self._wear[e]).T
            y, w = node, weight
            if e == len(self._layers.widths) - 1 and average == "line":
                # the root of 1 - s at the axis
                x, w = leggauss(2 * self.degree + 4)
                y, w = 1 - (1 - x) ** 2 / 2, w * (1 - x)
            slope = legval(y, legder(series)) / half
            square = 1 - left - half * (1 + y)
            measure = 2 * np.sqrt(square) if average == "line" else 4 * square
            total += (slope**2) @ (measure * w * half)
        return np.sqrt(total)

    def greatest(self, coefficients: Array, shift: Array) -> Array:
        """(T,) greatest value of ``shift - f`` over the punch.

        Samples, and the top of a parabola through the best three.
        """
        within = (1 - np.cos(np.pi * np.arange(1, 400) / 400)) / 2
        left, width = self._layers.breakpoints[:-1, None], self._layers.widths[:, None]
        s = np.unique(np.append([0.0, 1.0], (left + width * within).ravel()))
        values = shift[:, None] - self.worn(coefficients, np.sqrt(1 - s))
        row, best = np.arange(len(values)), np.clip(values.argmax(axis=1), 1, len(s) - 2)
        y0, y1, y2 = values[row, best - 1], values[row, best], values[row, best + 1]
        a, b = s[best] - s[best - 1], s[best + 1] - s[best]
        first, second = (y1 - y0) / a, (y2 - y1) / b
        curve = (second - first) / (a + b)
        slope = first + curve * a
        top = y1 - np.where(curve < 0, slope**2 / (4 * np.minimum(curve, -1e-300)), 0.0)
        return np.where(
            (curve < 0) & (np.abs(slope) <= -2 * curve * np.maximum(a, b)),
            np.maximum(top, y1),
            values.max(axis=1),
        )


def known(problem: Problem, finer: float = 0.01) -> xarray.Dataset:
    """What a problem asks for at the times that are checked, on the face of the punch, to `finer`
    times its accuracy.

    The start and the steady state are closed forms.
    """
    rings, face, times = problem.merged, problem.face, problem.times[problem.checked]
    error = finer * problem.rtol
    # wear blunts the pressure beside an edge as the slower ring wears
    slower = np.minimum(rings.wear_coefficients, np.append(rings.wear_coefficients[1:], np.inf))
    narrowest = np.minimum(rings.widths.min(), slower * (problem.earliest or np.inf))
    smallest = np.maximum(0.1 * error * narrowest, SMALLEST * finer / 0.01)
    degree = int(np.ceil(np.log(1 / error) / np.log(3))) + 1
    punch = Reference(rings.ring_edges, rings.wear_coefficients, smallest, degree)
    parts = [steady(problem, face.radii)] if problem.steady else []
    if len(times):
        parts += [
            _history(problem, punch, times),
            xarray.Dataset({"relaxation_time": ("mode", punch.relaxation_times[:20])}),
        ]
    return xarray.merge(parts)


def _history(problem: Problem, punch: Reference, times: Array) -> xarray.Dataset:
    pressure, worn, indentation = punch.at(times[times > 0])
    face, ring_edges = problem.face, problem.ring_edges
    profile = punch.worn(worn, face.radii)

    def with_start(later: Array, start: Array | float) -> Array:
        out = np.empty((len(times), *later.shape[1:]))
        out[times > 0], out[times == 0] = later, start
        return out

    unworn = 2 * np.pi * np.sqrt((1 - face.radii) * (1 + face.radii))
    profile, d = with_start(profile, 0.0), with_start(indentation, D0)
    values = {
        "pressure": with_start(punch.values(pressure, face.radii), 1 / unworn),
        "profile": profile,
        "displacement": d[:, None] - profile,
        "indentation": d,
        "displacement_centre": with_start(indentation - punch.worn(worn, np.zeros(1))[:, 0], D0),
        "displacement_max": with_start(punch.greatest(worn, indentation), D0),
        "rms_slope": with_start(punch.rms_slopes(worn, problem.gradient_average), 0.0),
    }
    if len(ring_edges) == len(problem.merged.ring_edges):
        start = -np.diff(np.sqrt((1 - ring_edges) * (1 + ring_edges)))
        values["ring_force"] = with_start(punch.ring_forces(pressure), start)
    return labelled(values, face.radii, times)
