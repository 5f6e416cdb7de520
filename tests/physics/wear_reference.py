"""An independent reference.

Archard's wear by broken Legendre polynomials in ``1 - r^2``, and nothing of what it judges.

With ``s = 1 - r^2`` the line density of the MDR is Abel's integral ``q(x) = int_0^x p(s) / sqrt(x -
s) ds``, the energy is ``int u p dA = int_0^1 q^2 / sqrt(1 - x) dx``, and an area ``pi ds``. On a
mesh graded to every ring edge Legendre polynomials, orthonormal with the wear coefficient as
weight, turn the law of wear into one singular value problem: no continuity is asked of pressure or
wear rate, and no half-space, mesh, basis or quadrature is shared with any method. Coordinates are
distances from the nearest ring edge, so that layers may be far thinner than `s` itself could tell.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple, Self

import numpy as np
import xarray
from numpy.polynomial.legendre import legder, leggauss, legval, legvander
from scipy.linalg import qr, svd
from scipy.special import roots_jacobi

from ringwear import Scene
from ringwear.mdr import direct
from ringwear.meshes.radial import Array, Indices, ring_of
from ringwear.studies.crosscheck.run import Result
from ringwear.studies.methods.quantities import QUANTITIES, differences, labelled
from ringwear.studies.problem.problem import D0, Problem


class Layers(NamedTuple):
    """Elements from the rim (s = 0) to the axis.

    Parameters
    ----------
    edge : (n,) the nearest ring edge of each element, in s
    low, high : (n,) its ends, as distances from that edge
    ring : (n,) its ring, counted from the rim
    between : (n,) how many elements are between it and the edge
    """

    edge: Array
    low: Array
    high: Array
    ring: Indices
    between: Indices

    @classmethod
    def graded(cls, edges: Array, smallest: Array, factor: float) -> Self:
        """Elements that shrink by a factor towards every ring edge, down to a size at each.

        The axis is no edge.
        """
        pieces: list[Layers] = []
        for ring, (left, right) in enumerate(pairwise(edges)):
            half = (right - left) / 2
            for edge, beside in ((left, ring), (right, ring + 1)):
                at_axis = beside == len(smallest)
                ratio = 1.0 if at_axis else smallest[beside] / half
                count = max(0, int(np.ceil(np.log(ratio) / np.log(factor))))
                ends = np.append(0.0, half * factor ** np.arange(count, -1.0, -1))
                between = np.arange(len(ends) - 1) + (len(pieces[-1].low) if at_axis else 0)
                piece = cls(
                    np.full(len(between), edge),
                    ends[:-1],
                    ends[1:],
                    np.full(len(between), ring),
                    between,
                )
                pieces.append(piece if edge == left else piece.mirrored())
        return cls(*(np.concatenate(parts) for parts in zip(*pieces, strict=True)))

    def mirrored(self) -> Self:
        """The same on the other side of the edge."""
        return self._replace(low=-self.high[::-1], high=-self.low[::-1], between=self.between[::-1])

    @property
    def widths(self) -> Array:
        return self.high - self.low

    @property
    def breakpoints(self) -> Array:
        """(n+1,) element boundaries in s, to the digits of s."""
        return np.append(self.edge + self.low, 1.0)


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


def exact_results(problem: Problem, finer: float = 0.01) -> xarray.Dataset:
    """Return what a problem asks for at the times that are checked, on the face of the punch.

    To `finer` times its accuracy; the start and the steady state are closed forms.
    """
    rings, times = problem.merged, problem.times[problem.checked]
    error = finer * problem.rtol
    # wear blunts the pressure beside an edge as the slower ring wears
    slower = np.minimum(rings.wear_coefficients, np.append(rings.wear_coefficients[1:], np.inf))
    narrowest = np.minimum(rings.widths.min(), slower * (problem.earliest or np.inf))
    # in s; thinner layers would be felt by slopes alone, and by little
    smallest = np.maximum(0.1 * error * narrowest, 1e-12 * finer)
    degree = int(np.ceil(np.log(1 / error) / np.log(3))) + 1
    punch = Reference(rings.ring_edges, rings.wear_coefficients, smallest, degree)
    parts = [steady_results(problem)] if problem.steady else []
    if len(times):
        relaxation = {"relaxation_time": ("mode", punch.relaxation_times[:20])}
        parts += [history_results(problem, punch, times), xarray.Dataset(relaxation)]
    return xarray.merge(parts)


def steady_results(problem: Problem) -> xarray.Dataset:
    """Return the steady state in closed form, on the face."""
    edges, wear = problem.merged
    pressures, radii = direct.steady_pressures(edges, wear), problem.face.radii
    greatest = direct.greatest_displacement(edges, pressures)
    values = {
        "steady_pressure": pressures[ring_of(edges, radii)],
        "steady_profile": greatest - direct.displacement(edges, pressures, radii),
        "steady_displacement_max": greatest,
        "steady_rms_slope": direct.rms_slope(edges, pressures, problem.gradient_average),
        "steady_wear_rate": wear[0] * pressures[0],
    }
    return labelled(values, radii)


def history_results(problem: Problem, punch: Reference, times: Array) -> xarray.Dataset:
    """Return the history, on the face."""
    pressure, worn, indentation = punch.at(times[times > 0])
    radii, edges = problem.face.radii, problem.ring_edges

    def with_start(later: Array, start: Array | float) -> Array:
        values = np.empty((len(times), *later.shape[1:]))
        values[times > 0], values[times == 0] = later, start
        return values

    unworn = 1 / (2 * np.pi * np.sqrt((1 - radii) * (1 + radii)))
    profile = with_start(punch.worn(worn, radii), 0.0)
    d = with_start(indentation, D0)
    values = {
        "pressure": with_start(punch.values(pressure, radii), unworn),
        "profile": profile,
        "displacement": d[:, None] - profile,
        "indentation": d,
        "displacement_centre": with_start(indentation - punch.worn(worn, np.zeros(1))[:, 0], D0),
        "displacement_max": with_start(punch.greatest(worn, indentation), D0),
        "rms_slope": with_start(punch.rms_slopes(worn, problem.gradient_average), 0.0),
    }
    if len(edges) == len(problem.merged.ring_edges):
        start = -np.diff(np.sqrt((1 - edges) * (1 + edges)))
        values["ring_force"] = with_start(punch.ring_forces(pressure), start)
    return labelled(values, radii, times)


def true_errors(result: Result) -> dict[str, dict[str, tuple[Array, Array]]]:
    """Return (error, estimate) at the checked times, by method and quantity of a run.

    Beyond what the reference is known to, which is how far a coarser one is from it; of relaxation
    times, the three slowest.
    """
    problem = result.scene.problem
    exact = exact_results(problem)
    unsure = differences(exact_results(problem, finer=0.03), exact, problem.face)
    errors: dict[str, dict[str, tuple[Array, Array]]] = {}
    for name, solution in result.solutions.items():
        errors[name] = {}
        for quantity, error in differences(solution.checked, exact, problem.face).items():
            estimate, dims = solution.errors[quantity], QUANTITIES[quantity].dims
            if "time" in dims:
                estimate = estimate[problem.checked]
            parts = [np.atleast_1d(part) for part in (error, estimate, unsure[quantity])]
            shown = min(3 if "mode" in dims else np.inf, *map(len, parts))
            error, estimate, doubt = (part[:shown] for part in parts)
            errors[name][quantity] = np.maximum(error - 2 * doubt, 0.0), estimate
    return errors


def random_scenes(seed: int, count: int, most_rings: int, **changes: Any) -> Iterator[Scene]:
    """Rings 1 to `most_rings`, widths to 1e-4, wear ratios 1e-6 to 1e6, nu -0.5 to 0.5, rtol 1e-2
    to 1e-8; seven times from 1e-8 to 1e3 natural ones, about half with the start.
    """
    draw = np.random.default_rng(seed)
    for _ in range(count):
        rings = int(np.exp(draw.uniform(0, np.log(most_rings + 1))))
        widths = 10 ** draw.uniform(-draw.uniform(0, 4), 0, rings)
        edges = np.cumsum(np.maximum(widths / widths.sum(), 1e-4))
        power = draw.uniform(-6, 6)
        if rings == 1:
            wear = np.ones(1)
        elif rings == 2 or draw.random() < 1 / 3:  # two materials, or one for each ring
            wear = np.resize([1.0, 10**power], rings)
        else:
            wear = 10 ** draw.uniform(-abs(power), 0, rings)
        first = 10 ** draw.uniform(-8, 1)
        times = np.geomspace(first, first * 10 ** draw.uniform(0.3, 3 - np.log10(first)), 7)
        if draw.random() < 0.5:
            times = np.append(0.0, times)
        usual = draw.random() < 0.7
        ratio = draw.uniform(-0.5, 0.5) if usual else draw.choice((0.5, 0.49, 0.3))
        punch = {"radius": 1.0, "ring_edges": (edges / edges[-1]).tolist()}
        yield Scene.load("five_rings").changed(
            punch=punch | {"wear_coefficients": wear.tolist()},
            half_space__poisson_ratio=float(ratio),
            wear={"times": (times / wear.max()).tolist()},
            accuracy__rtol=float(10 ** draw.uniform(-8, -2)),
            **{"methods": ["mdr", "direct", "fem"]} | changes,
        )
