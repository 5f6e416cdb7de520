"""An independent reference solution of Archard's wear by discontinuous Legendre polynomials.

With ``s = 1 - r^2`` the line density of the MDR is Abel's integral ``q(x) = int_0^x p(s) / sqrt(x -
s) ds``, the energy is ``int u p dA = int_0^1 q^2 / sqrt(1 - x) dx``, and the element of area is
``pi ds``. The mesh is graded to every ring edge. Legendre polynomials that are orthonormal with the
wear coefficient as weight turn the law of wear into one singular value problem. Neither pressure
nor wear rate needs to be continuous, and no half-space, mesh, basis or quadrature is shared with
any method. Coordinates are distances from the nearest ring edge, so that elements may be far
thinner than the roundoff of `s`.
"""

from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import legder, leggauss, legroots, legval, legvander
from scipy.linalg import svd

from ringwear import Scene, Stages, differences, method


def graded_elements(edges, smallest, factor):
    """Return elements from the rim (s = 0) to the axis, graded by a factor towards every ring edge.

    For each element: the nearest ring edge, both ends as distances from it, and the number of its
    ring, counted from the rim.
    """
    rows, smallest = [], np.append(smallest, np.inf)  # the axis is no edge
    for ring, (left, right) in enumerate(pairwise(edges)):
        half = (right - left) / 2
        for edge, size in ((left, smallest[ring]), (right, smallest[ring + 1])):
            count = max(0, int(np.ceil(np.log(min(size / half, 1)) / np.log(factor))))
            ends = np.append(0.0, half * factor ** np.arange(count, -1.0, -1))
            ends = ends if edge == left else -ends[::-1]
            rows += [(edge, low, high, ring) for low, high in pairwise(ends)]
    return np.transpose(rows)


class Reference:
    """Non-dimensional history of a flat punch under the force 1.

    Fields are coefficients (T, E, degree + 1) of polynomials on E elements from the rim (s = 0) to
    the axis. The polynomials are orthonormal with the weight k.

    Parameters
    ----------
    ring_edges, wear_coefficients : those of the punch, both from 0 to 1
    smallest : (N,) size in s of the smallest element at each edge except the centre, the rim last
    degree : degree of the polynomials
    factor : ratio of sizes of neighbouring elements towards ring edges and rim
    """

    def __init__(self, ring_edges, wear_coefficients, smallest, degree=12, factor=0.2):
        edges = ((1 - ring_edges) * (1 + ring_edges))[::-1]
        self.edge, self.low, high, ring = graded_elements(edges, smallest[::-1], factor)
        self.ring, self.width = len(smallest) - 1 - ring.astype(int), high - self.low
        self.wear, self.order = wear_coefficients[self.ring], np.arange(degree + 1)
        # factors that make the Legendre polynomials of each element orthonormal with the weight k
        areas = np.pi * self.width * self.wear
        self.scale = np.sqrt((2 * self.order + 1) / areas[:, None])
        # force of each function: only the constant of each element carries a force
        self.weights = np.pi * self.width[:, None] * self.scale * (self.order == 0)
        # points x (E, Q) = low cos^2 w + high sin^2 w: square roots at both ends are smooth in w.
        # They occur where line densities of lower elements end, and at the axis
        node, weight = leggauss(2 * degree + 12)
        angle = np.pi / 4 * (1 + node)
        self.local = -np.cos(2 * angle)
        self.distance = np.outer(self.low, np.cos(angle) ** 2) + np.outer(high, np.sin(angle) ** 2)
        self.square = (1 - self.edge)[:, None] - self.distance  # 1 - x, the squared radius
        self.integral = np.pi / 4 * weight * np.sin(2 * angle) * self.width[:, None]
        self.triangle = self._triangular_energy()
        flat = self.weights.ravel()
        self.wear_rate = 1 / (flat @ flat)
        self.steady = flat * self.wear_rate
        self.moments = self.triangle.T @ (self.triangle @ self.steady)
        # relaxation modes carry no force; the last singular vector has no energy and is dropped
        across = flat / np.linalg.norm(flat)
        projected = self.triangle - np.outer(self.triangle @ across, across)
        _, singular, shapes = svd(projected, full_matrices=False, overwrite_a=True)
        self.relaxation_times, self.shapes = singular[:-1] ** 2, shapes[:-1].T
        # remove the remaining force, which is roundoff
        self.shapes -= np.outer(across, across @ self.shapes)

    def _triangular_energy(self):
        """Return the triangular factor of the energy.

        It needs ``int P_n(t) / sqrt(x - t) dt = Re sqrt(2) exp(-(n + 1/2) arcosh x) / (n + 1/2)``
        from t = -1 up to 1 or x, by DLMF 18.17.46 and, beyond the element, by the generating
        function of the Legendre polynomials.
        """
        order, points = self.order + 0.5, self.distance.size
        density = np.zeros((points, *self.scale.shape))
        for element, half in enumerate(self.width / 2):
            from_edge = (self.edge - self.edge[element])[:, None]
            x = (from_edge + (self.distance - self.low[element])) / half - 1
            after = np.flatnonzero(x > -1)
            depth = np.arccosh(x.flat[after].astype(complex))
            integral = np.sqrt(2) * np.exp(-np.outer(depth, order)).real / order
            density[after, element] = np.sqrt(half) * integral * self.scale[element]
        density *= np.sqrt(self.integral / np.sqrt(self.square)).reshape(-1, 1, 1)
        return np.linalg.qr(density.reshape(points, -1), mode="r")

    def at(self, times):
        """Return coefficients of pressure and worn height over k, and indentation, at times > 0."""
        relaxation, excited = self.relaxation_times, self.shapes.T @ self.moments
        amplitudes = np.exp(-times[:, None] / relaxation) * excited / relaxation
        pressure = self.steady - amplitudes @ self.shapes.T
        indentation = pressure @ self.moments + self.wear_rate * times
        moved = (pressure @ self.triangle.T) @ self.triangle
        worn = indentation[:, None] * self.weights.ravel() - moved
        shape = (len(times), *self.weights.shape)
        return pressure.reshape(shape), worn.reshape(shape), indentation

    def values(self, coefficients, radii):
        """Return (T, len(radii)) values of a field."""
        s = (1 - radii) * (1 + radii)
        # a radius on a ring edge belongs to the outer ring, which has the smaller s
        element = np.maximum(np.searchsorted(self.edge + self.low, s) - 1, 0)
        within = (s - self.edge[element]) - self.low[element]
        local = (2 * within / self.width[element] - 1).clip(-1, 1)
        functions = legvander(local, self.order[-1]) * self.scale[element]
        return np.einsum("trn,rn->tr", coefficients[:, element], functions)

    def worn(self, worn, radii):
        """Return (T, len(radii)) worn heights."""
        return self.values(worn * self.wear[:, None], radii)

    def legendre(self, worn):
        """Return coefficients of worn heights for Legendre polynomials without normalisation."""
        return worn * self.scale * self.wear[:, None]

    def ring_forces(self, pressure):
        """Return the (T, N) force on each ring, from the centre outwards."""
        rings = self.ring == np.arange(self.ring.max() + 1)[:, None]
        return (pressure * self.weights).sum(axis=2) @ rings.T

    def rms_slopes(self, worn, average="line"):
        """Return the (T,) root mean square slope of the worn face."""
        slopes = legder(self.legendre(worn), axis=2) @ legvander(self.local, self.order[-2]).T
        slopes /= self.width[:, None] / 2
        measure = 2 * np.sqrt(self.square) if average == "line" else 4 * self.square
        return np.sqrt(np.sum(slopes**2 * measure * self.integral, axis=(1, 2)))

    def lowest(self, worn):
        """Return the (T,) least worn height, at ends of elements or where the slope vanishes."""

        def least(height):
            stationary = legroots(legder(height)).real.clip(-1, 1)
            return legval(np.append(stationary, [-1, 1]), height).min()

        return np.array([min(map(least, elements)) for elements in self.legendre(worn)])


def exact_results(problem, finer=0.01):
    """Return the results of a problem at its compared times, on the face of the punch.

    Errors are about `finer` rtol. The start and the steady state are closed forms.
    """
    rings, times = problem.merged, problem.times[problem.compared_rows]
    edges, (wear, _) = rings
    error = finer * problem.rtol
    # the slower ring sets the length over which wear has smoothed the pressure at an edge
    slower = np.minimum(wear, np.append(wear[1:], np.inf))
    narrowest = np.minimum(rings.widths.min(), slower * (problem.earliest or np.inf))
    # sizes in s; thinner elements would change slopes only, and by little
    smallest = np.maximum(0.1 * error * narrowest, 1e-12 * finer)
    degree = int(np.ceil(np.log(1 / error) / np.log(3))) + 1
    results = method("direct").solve(problem, Stages("direct")).compared if problem.steady else {}
    if len(times):
        punch = Reference(edges, wear, smallest, degree)
        history = _later(problem, punch, times[times > 0])
        if times[0] == 0:
            start = _start(problem)
            history = {name: np.concatenate([start[name], history[name]]) for name in history}
        results = results | history | {"relaxation_time": punch.relaxation_times[:20]}
    return results


def _start(problem):
    """Return the flat start (Eqs. 10 and 11)."""
    radii, edges = problem.face.radii, problem.ring_edges
    values = {
        "pressure": 1 / (2 * np.pi * np.sqrt((1 - radii) * (1 + radii))),
        "profile": 0 * radii,
        "displacement": 0 * radii + 0.5,
        "ring_force": -np.diff(np.sqrt((1 - edges) * (1 + edges))),
        "rms_slope": 0.0,
        **dict.fromkeys(("indentation", "displacement_centre", "displacement_max"), 0.5),
    }
    values |= {"even_wear": 0.0, "depth": values["indentation"], "shape": values["profile"]}
    values = {name: np.asarray(value)[None] for name, value in values.items()}
    return values | {"time": np.zeros(1)}


def _later(problem, punch, times):
    pressure, worn, indentation = punch.at(times)
    radii, profile = problem.face.radii, punch.worn(worn, problem.face.radii)
    values = {
        "pressure": punch.values(pressure, radii),
        "profile": profile,
        "displacement": indentation[:, None] - profile,
        "indentation": indentation,
        "displacement_centre": indentation - punch.worn(worn, np.zeros(1))[:, 0],
        "displacement_max": indentation - punch.lowest(worn),
        "rms_slope": punch.rms_slopes(worn, problem.gradient_average),
        "ring_force": punch.ring_forces(pressure),
    }
    # even wear, apart from which shapes are compared
    even = times / np.sum(np.pi * np.diff(problem.ring_edges**2) / problem.wear_coefficients)
    heights = {"even_wear": even, "depth": indentation - even, "shape": profile - even[:, None]}
    return values | heights | {"time": times}


def true_errors(result):
    """Return (error, estimate) at the compared times, for each method and quantity of a run.

    Twice the uncertainty of the reference, its difference to a coarser one, is subtracted from the
    errors. Three relaxation times, the slowest, are compared.
    """
    problem = result.scene.problem
    exact = exact_results(problem)
    unsure = differences(exact_results(problem, finer=0.03), exact, problem.face)
    errors = {}
    for name, solution in result.solutions.items():
        errors[name] = {}
        for quantity, error in differences(solution.compared, exact, problem.face).items():
            estimate, dims = solution.errors[quantity], result.dataset[quantity].dims
            if "time" in dims:
                estimate = estimate[problem.compared_rows]
            parts = [np.atleast_1d(part) for part in (error, estimate, unsure[quantity])]
            shown = min(3 if "mode" in dims else np.inf, *map(len, parts))
            error, estimate, doubt = (part[:shown] for part in parts)
            # a number of the answer has NaN where the method does not give it
            given = ~np.isnan(error)
            error, estimate, doubt = (part[given] for part in (error, estimate, doubt))
            errors[name][quantity] = np.maximum(error - 2 * doubt, 0.0), estimate
    return errors


def random_scenes(seed, count, most_rings, **changes):
    """Yield random scenes of flat punches with 1 to `most_rings` rings.

    Widths are 1e-4 or more, wear ratios 1e-6 to 1e6, Poisson's ratios -0.5 to 0.5, and rtol 1e-2 to
    1e-8. Seven times lie between 1e-8 and 1e3 natural units; about half of the scenes also have the
    start.
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
