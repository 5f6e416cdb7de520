"""An independent solution of flat punches: rings or k(r), loads that vary, a given indentation.

It shares no code with any method. With ``s = 1 - r^2`` the line density of the MDR is Abel's
integral of the pressure, which has a closed form for Legendre polynomials. The energy is the
integral of its square, by Gauss's rule. Elements become smaller towards every ring edge, every kink
of k(r) and the rim. Their degree rises with the distance from these, but is the highest one
wherever k varies, because the steady pressure 1/k has a pole there beside the interval. Worn
heights are projected without k: k times a polynomial cannot be constant, and has wrong slopes where
k is steep. In the inner product with weight k, the law of wear is one singular value problem, so
the history is exact in time: each mode decays exponentially, and a force that varies enters as an
integral of its rate times this decay.

The contact must stay full. `Punch.least_pressure` shows whether it does while a force falls.
"""

from itertools import pairwise

import numpy as np
from independent_load import Load
from numpy.polynomial.legendre import legder, leggauss, legroots, legval
from scipy.linalg import solve_triangular, svd
from scipy.optimize import brentq
from scipy.sparse import block_diag, csr_matrix

from ringwear import differences

Array = np.ndarray
# ratio of the sizes of neighbouring elements
FACTOR = 0.2
# lower limit of the highest polynomial degree
LEAST_DEGREE = 14
# smallest element at a step of k, in s = 1 - r^2
ROUNDOFF = 1e-14
# a force and a speed that do not vary
CONSTANT = Load(np.zeros(1), np.ones(1), np.ones(1))


class Pieces:
    """Intervals of the radius in which k is linear: their edges, from 0 to 1, and k at both ends.

    Parameters
    ----------
    edges : (N + 1,) radii, from 0 to 1
    inner, outer : (N,) wear coefficients at the inner and outer end of each interval
    """

    def __init__(self, edges: Array, inner: Array, outer: Array) -> None:
        self.edges, self.inner, self.outer = edges, inner, outer
        self.slope = (outer - inner) / np.diff(edges)

    @classmethod
    def of(cls, problem) -> "Pieces":
        """Return the pieces of a problem without a hole; each is in one ring."""
        rings = problem.graded or problem.rings
        return cls(rings.ring_edges, *rings.wear_coefficients)

    def at(self, piece: Array, radii: Array) -> Array:
        """Return k at radii, each in the interval of the given number."""
        return self.inner[piece] + self.slope[piece] * (radii - self.edges[piece])


def elements(pieces: Pieces, smallest: Array, degree: int) -> list[tuple]:
    """Return the elements from the rim to the axis.

    Parameters
    ----------
    smallest : size of the smallest element in s at each edge

    Returns
    -------
    list of (nearest edge in s, both ends as distances from that edge, number of the piece, degree)
    """
    s = ((1 - pieces.edges) * (1 + pieces.edges))[::-1]
    sizes, count, rows = smallest[::-1], len(pieces.inner), []
    for number, (left, right) in enumerate(pairwise(s)):
        half = (right - left) / 2
        for edge, size in ((left, sizes[number]), (right, sizes[number + 1])):
            layers = max(0, int(np.ceil(np.log(min(size / half, 1)) / np.log(FACTOR))))
            ends = np.append(0.0, half * FACTOR ** np.arange(layers, -1.0, -1))
            rise = (degree - 4) / max(0.7 * layers, 1)
            nearest = 0 if layers else degree
            elements_made = []
            for layer, (low, high) in enumerate(pairwise(ends)):
                order = int(min(degree, 4 + np.ceil(rise * layer) + nearest))
                if pieces.slope[count - 1 - number]:
                    order = degree
                ends_of = (low, high) if edge == left else (-high, -low)
                elements_made.append((edge, *ends_of, count - 1 - number, order))
            rows += elements_made if edge == left else elements_made[::-1]
    return rows


class Punch:
    """A non-dimensional flat punch with its relaxation modes.

    Parameters
    ----------
    pieces : wear coefficient along the radius, relative to the greatest one
    smallest : size of the smallest element in s at each edge
    degree : highest degree of the polynomials
    fixed_indentation : whether the indentation is fixed at 1/2; otherwise the force is given
    """

    def __init__(
        self, pieces: Pieces, smallest: Array, degree: int, fixed_indentation: bool = False
    ) -> None:
        self.pieces, self.fixed_indentation = pieces, fixed_indentation
        rows = elements(pieces, smallest, degree)
        edge, low, high, piece, order = map(np.array, zip(*rows, strict=True))
        self.edge, self.low, self.width = edge, low, high - low
        self.piece, self.order = piece.astype(int), order.astype(int)
        first = np.concatenate([[0], np.cumsum(self.order + 1)])
        self.columns = [slice(*ends) for ends in pairwise(first)]
        self._place_points(low, high)
        # (points, n) values and slopes of the Legendre polynomials
        self.values, self.rises = self._at_points(), self._at_points(derivative=True)
        # pressures are in functions that are orthonormal with the weight k
        measure = np.pi * self.length * self.wear
        mass = self.values.T @ self.values.multiply(measure[:, None])
        self.lower = np.linalg.cholesky(mass.toarray())
        # int P dA; worn volume = these times the coefficients of worn heights
        self.volumes = np.zeros(first[-1])
        self.volumes[first[:-1]] = np.sqrt(np.pi * self.width)
        # force of each function: of the Legendre polynomials only the constant carries a force
        self.weights = self.orthonormal(self.volumes)
        self.triangle = self._triangular_energy()
        self._solve()

    def _place_points(self, low: Array, high: Array) -> None:
        """Compute Gauss points s = low cos^2 + high sin^2 of all elements, in one array."""
        parts = []
        for number, order in enumerate(self.order):
            node, weight = leggauss(2 * order + 12)
            angle = np.pi / 4 * (1 + node)
            distance = low[number] * np.cos(angle) ** 2 + high[number] * np.sin(angle) ** 2
            length = np.pi / 4 * weight * np.sin(2 * angle) * self.width[number]
            square = (1 - self.edge[number]) - distance
            owner = np.full(len(node), number)
            parts.append((owner, -np.cos(2 * angle), distance, square, length))
        owner, *others = map(np.concatenate, zip(*parts, strict=True))
        self.owner = owner.astype(int)
        self.local, self.distance, self.square, self.length = others
        self.radius = np.sqrt(self.square)
        self.wear = self.pieces.at(self.piece[self.owner], self.radius)

    def _scale(self, number: int) -> Array:
        """Return the factors (n,) by which Legendre polynomials are orthonormal by area."""
        return np.sqrt((2 * np.arange(self.order[number] + 1) + 1) / (np.pi * self.width[number]))

    def _legendre(self, number: int, local: Array, derivative: bool = False) -> Array:
        """Return (points, n) Legendre polynomials, orthonormal by area, or derivatives in `s`."""
        every = np.diag(self._scale(number))
        if derivative:
            every = (
                legder(every, axis=0) / (self.width[number] / 2) if len(every) > 1 else 0 * every
            )
        return legval(local, every).T

    def _at_points(self, derivative: bool = False) -> csr_matrix:
        """Return (points, n) Legendre polynomials, or derivatives in `s`, at the Gauss points."""
        numbers = range(len(self.order))
        return block_diag(
            [self._legendre(each, self.local[self.owner == each], derivative) for each in numbers],
            format="csr",
        )

    def orthonormal(self, of_legendre: Array, transposed: bool = False) -> Array:
        """Return integrals (n, ...) with the functions of the pressure by those with Legendre's.

        The transpose returns coefficients of Legendre polynomials by those of the functions.
        """
        return solve_triangular(self.lower, of_legendre, lower=True, trans=int(transposed))

    def _triangular_energy(self) -> Array:
        """Return the triangular factor of the energy.

        DLMF 18.17.46 and the generating function of the Legendre polynomials give the integrals
        ``int P_n(t) / sqrt(x - t) dt = Re sqrt(2) exp(-(n + 1/2) arcosh x) / (n + 1/2)``.
        """
        density = np.zeros((len(self.owner), len(self.weights)))
        for number, half in enumerate(self.width / 2):
            order = np.arange(self.order[number] + 1) + 0.5
            from_edge = self.edge[self.owner] - self.edge[number]
            x = (from_edge + (self.distance - self.low[number])) / half - 1
            after = np.flatnonzero((x > -1) & (self.owner >= number))
            depth = np.arccosh(x[after].astype(complex))
            integral = np.sqrt(2) * np.exp(-np.outer(depth, order)).real / order
            density[after, self.columns[number]] = integral * np.sqrt(order / np.pi)
        density *= np.sqrt(self.length / self.radius)[:, None]
        return np.linalg.qr(self.orthonormal(density.T).T, mode="r")

    def _solve(self) -> None:
        flat = self.weights
        self.wear_rate = 1 / (flat @ flat)
        self.steady = flat * self.wear_rate
        self.moments = self.triangle.T @ (self.triangle @ self.steady)
        if self.fixed_indentation:
            _, singular, shapes = svd(self.triangle)
            self.times, self.shapes = singular**2, shapes.T
            self.excited = (shapes @ flat) * 0.5 / self.times
            return
        across = flat / np.linalg.norm(flat)
        projected = self.triangle - np.outer(self.triangle @ across, across)
        _, singular, shapes = svd(projected, full_matrices=False, overwrite_a=True)
        self.times, self.shapes = singular[:-1] ** 2, shapes[:-1].T
        self.shapes = self.shapes - np.outer(across, across @ self.shapes)
        self.excited = (self.shapes.T @ self.moments) / self.times

    def pressures(self, load: Load, times: Array) -> Array:
        """Return coefficients (T, n) of the pressure at times > 0."""
        force, distance, _ = load.at(times)
        if self.fixed_indentation:
            left = np.exp(-distance[:, None] / self.times) * self.excited
            return left @ self.shapes.T
        left = load.decayed(times, self.times) * self.excited
        return np.outer(force, self.steady) - left @ self.shapes.T

    def depths(self, load: Load, times: Array, pressures: Array) -> Array:
        """Return the indentation (T,)."""
        if self.fixed_indentation:
            return np.full(len(times), 0.5)
        return pressures @ self.moments + self.wear_rate * load.at(times)[2]

    def worn(self, depths: Array, pressures: Array) -> Array:
        """Return coefficients (T, n) of the worn heights d - u in Legendre polynomials."""
        moments = depths[:, None] * self.weights - (pressures @ self.triangle.T) @ self.triangle
        return moments @ self.lower.T

    def fields(self, radii: Array) -> tuple[Array, Array, Array]:
        """Return pressures and heights (R, n) of the functions, and k (R,), at radii."""
        s, square = (1 - radii) * (1 + radii), radii**2
        # near the axis, only the squares of the radii resolve the elements
        from_rim = np.searchsorted(self.edge + self.low, s) - 1
        from_axis = np.searchsorted(-((1 - self.edge) - self.low), -square) - 1
        number = np.clip(np.where(s < 0.5, from_rim, from_axis), 0, len(self.edge) - 1)
        heights = np.zeros((len(radii), len(self.weights)))
        for each in np.unique(number):
            on = number == each
            from_edge = np.where(s < 0.5, s - self.edge[each], (1 - self.edge[each]) - square)
            within = from_edge[on] - self.low[each]
            local = (2 * within / self.width[each] - 1).clip(-1, 1)
            heights[on, self.columns[each]] = self._legendre(each, local)
        return self.orthonormal(heights.T).T, heights, self.pieces.at(self.piece[number], radii)

    def rms_slopes(self, worn: Array, average: str) -> Array:
        """Return the root mean square slope (T,) of the worn face."""
        slopes = -2 * self.radius * (self.rises @ worn.T).T
        measure = 1 / (2 * self.radius) if average == "line" else 1.0
        return np.sqrt(slopes**2 @ (self.length * measure))

    def least(self, worn: Array) -> Array:
        """Return the least worn height (T,), by samples and the bends of the polynomials there."""
        samples = np.cos(np.pi * np.linspace(1, 0, 80))
        lowest = np.array(
            [
                (worn[:, of_element] @ self._legendre(number, samples).T).min(axis=1)
                for number, of_element in enumerate(self.columns)
            ]
        )
        least = lowest.min(axis=0)
        for row, number in enumerate(lowest.argmin(axis=0)):
            for near in range(max(number - 1, 0), min(number + 2, len(self.columns))):
                series = worn[row, self.columns[near]] * self._scale(near)
                roots = legroots(legder(series))
                roots = roots.real[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) < 1)]
                least[row] = min(least[row], *legval(roots, series), np.inf)
        return least

    def by_ring(self, parts: Array, ring_edges: Array) -> Array:
        """Return sums (T, N) over each ring of contributions (T, n) of the functions."""
        middle = (self.pieces.edges[1:] + self.pieces.edges[:-1]) / 2
        ring_of_piece = np.searchsorted(ring_edges, middle) - 1
        of_function = np.repeat(ring_of_piece[self.piece], self.order + 1)
        on_rings = of_function == np.arange(len(ring_edges) - 1)[:, None]
        return parts @ on_rings.T

    def least_pressure(self, pressures: Array) -> float:
        """Return the least ratio, over time, of the least pressure to the greatest pressure."""
        values = self.values @ self.orthonormal(pressures.T, transposed=True)
        return float((values.min(axis=0) / values.max(axis=0)).min())

    def left(self, distance: float) -> float:
        """Return the fraction of the running-in that remains at a distance; it is 1 at the start.

        At a fixed indentation, return the force instead.
        """
        if self.fixed_indentation:
            return float(
                np.exp(-distance / self.times) @ (self.excited * (self.weights @ self.shapes))
            )
        parts = self.excited**2 * self.times
        way = self.steady @ self.moments - 0.5
        return float(np.exp(-distance / self.times) @ parts / way)

    def time_left(self, part: float) -> float:
        """Return the distance at which `left` has a given value."""
        longest = 50 * self.times[0]
        root = brentq(
            lambda power: np.log(max(self.left(10**power), 1e-300) / part),
            *(np.log10(longest) - 20, np.log10(longest)),
            xtol=1e-13,
        )
        return float(10**root)


def load_of(problem) -> Load:
    """Return the load of a non-dimensional problem."""
    loading = problem.loading
    return Load(loading.times, loading.forces, loading.speeds)


def solved(
    problem, error: float, roundoff: float = ROUNDOFF
) -> tuple[dict[str, Array], dict[str, Array], Punch]:
    """Return results over the face, the answer, and the punch.

    Parameters
    ----------
    problem : non-dimensional problem of a scene without a hole
    error : approximate relative error of the solution
    roundoff : smallest size of elements at steps of k. Smaller layers are not resolved, which only
        a solution with another value shows
    """
    pieces, load, average = Pieces.of(problem), load_of(problem), problem.gradient_average
    times = problem.times[problem.compared_rows]
    fixed_indentation = problem.indentation is not None
    later = times[times > 0]
    distances = load.at(later)[1]
    earliest = min(distances, default=np.inf)
    smallest = _sizes(pieces, earliest, error, roundoff)
    # all eight relaxation times may belong to one piece, which needs at least this degree
    degree = max(int(np.ceil(np.log(1 / error) / np.log(3))) + 1, LEAST_DEGREE)
    punch = Punch(pieces, smallest, degree, fixed_indentation)
    results = {"relaxation_time": punch.times[:8]}
    if len(times):
        results |= _history(problem, punch, load, times, average)
    if problem.steady:
        # under the last force and speed
        force, speed = load.forces[-1], load.speeds[-1]
        steady = _steady(problem, punch, average)
        results |= {name: force * value for name, value in steady.items()}
        results["steady_wear_rate"] = speed * results["steady_wear_rate"]
    return results, _answer(problem, punch, results, load), punch


def _sizes(pieces: Pieces, earliest: float, error: float, roundoff: float) -> Array:
    """Return the size in s of the smallest element at each edge.

    It is proportional to the length over which wear has smoothed the pressure at the earliest time.
    """
    none, infinite = np.append, np.inf
    inner, outer, widths = pieces.inner, pieces.outer, np.diff(pieces.edges)
    slower = np.minimum(none(outer, infinite), none(infinite, inner))
    # k may nearly vanish within a small part of the width of a piece
    ratios = np.maximum(inner, outer) / np.minimum(inner, outer)
    widths = widths / ratios
    beside = np.minimum(none(widths, infinite), none(infinite, widths))
    sizes = 0.1 * error * np.minimum(beside, slower * earliest)
    before, after = none(np.nan, outer), none(inner, np.nan)
    bend = none(np.nan, pieces.slope) != none(pieces.slope, np.nan)
    # at steps of k, at kinks of k, and at ring edges where k is smooth
    kink = 0.1 * np.sqrt(error) * beside
    sizes = np.where(before == after, np.where(bend, kink, np.inf), np.maximum(sizes, roundoff))
    # k is a cone at the axis, r = sqrt(1 - s): a square root for polynomials in s
    sizes[0] = np.inf
    if pieces.slope[0]:
        cone = pieces.inner[0] / abs(pieces.slope[0])
        sizes[0] = np.clip((0.1 * error * cone) ** 2, 1e-24, 1.0)
    return sizes


def _history(problem, punch: Punch, load: Load, times: Array, average: str) -> dict[str, Array]:
    later, edges, face = times[times > 0], problem.ring_edges, problem.face
    pressures = punch.pressures(load, later)
    depths = punch.depths(load, later, pressures)
    worn = punch.worn(depths, pressures)
    of_pressures, of_heights, _ = punch.fields(face.radii)
    _, at_centre, _ = punch.fields(np.zeros(1))
    profile = worn @ of_heights.T
    values = {
        "pressure": pressures @ of_pressures.T,
        "profile": profile,
        "displacement": depths[:, None] - profile,
        "indentation": depths,
        "displacement_centre": depths - (worn @ at_centre.T)[:, 0],
        "displacement_max": depths - punch.least(worn),
        "rms_slope": punch.rms_slopes(worn, average),
        "ring_force": punch.by_ring(pressures * punch.weights, edges),
        "ring_worn_volume": punch.by_ring(worn * punch.volumes, edges),
        "normal_force": pressures @ punch.weights if punch.fixed_indentation else load.at(later)[0],
        "contact_radius": np.ones(len(later)),
        "time": load.at(later)[1],
        "pressed": np.zeros(len(later), bool),
    }
    if times[0] == 0:
        force = 1.0 if punch.fixed_indentation else load.forces[0]
        radii = face.radii
        start = {
            "pressure": force / (2 * np.pi * np.sqrt((1 - radii) * (1 + radii))),
            "profile": 0 * radii,
            "displacement": 0 * radii + 0.5 * force,
            "ring_force": -np.diff(np.sqrt((1 - edges) * (1 + edges))) * force,
            "ring_worn_volume": np.zeros(len(edges) - 1),
            **dict.fromkeys(
                ("indentation", "displacement_centre", "displacement_max"), 0.5 * force
            ),
            **{"rms_slope": 0.0, "normal_force": force, "contact_radius": 1.0, "time": 0.0},
            "pressed": True,
        }
        values = {
            name: np.concatenate([np.asarray(start[name])[None], value])
            for name, value in values.items()
        }
    return values


def _steady(problem, punch: Punch, average: str) -> dict[str, Array]:
    _, of_heights, wear = punch.fields(problem.face.radii)
    # u = A p_s; the steady profile max(u) - u has the minimum 0
    moved = punch.worn(np.zeros(1), punch.steady[None])
    greatest = -punch.least(moved)[0]
    profile = greatest + (moved @ of_heights.T)[0]
    return {
        "steady_pressure": punch.wear_rate / wear,
        "steady_profile": np.maximum(profile, 0.0),
        "steady_displacement_max": np.asarray(greatest),
        "indentation_steady": np.asarray(greatest),
        "steady_rms_slope": punch.rms_slopes(moved, average)[0],
        "steady_wear_rate": np.asarray(punch.wear_rate),
    }


def _answer(problem, punch: Punch, results: dict, load: Load) -> dict[str, Array]:
    """Return the non-dimensional numbers of the answer, NaN if a number does not exist."""
    edges, pieces = problem.ring_edges, punch.pieces
    root = np.sqrt((1 - edges) * (1 + edges))
    start = [
        1 / (2 * np.pi * root[:-1]),
        np.append(1 / (2 * np.pi * root[1:-1]), np.inf),
        -np.diff(root),
    ]
    steady = np.full((3, len(edges) - 1), np.nan)
    if problem.steady:
        ends = np.array([pieces.inner, pieces.outer])
        for number, (inner, outer) in enumerate(pairwise(edges)):
            # a piece may cover several rings
            on = ends[:, (pieces.edges[:-1] < outer) & (pieces.edges[1:] > inner)]
            steady[:2, number] = punch.wear_rate / on.max(), punch.wear_rate / on.min()
        steady[:2] *= load.forces[-1]
        steady[2] = punch.by_ring((punch.steady * punch.weights)[None], edges)[0]
    both = np.stack([start, steady], axis=1)
    answer = {
        "indentation_start": 0.5,
        "running_in_time": punch.times[0],
        "pressure_min": both[0],
        "pressure_max": both[1],
        "force_share": both[2],
    }
    if problem.steady:
        answer |= {
            name: results[name]
            for name in ("indentation_steady", "steady_wear_rate", "steady_rms_slope")
        }
    if len(problem.times):
        answer["worn_volume"] = results["ring_worn_volume"][-1]
    if punch.fixed_indentation:
        answer["force_end"] = results["normal_force"][-1]
        answer["force_start"] = 1.0
        answer["time_to_half_force"] = punch.time_left(0.5) / load.speeds[0]
    elif not np.ptp(load.forces) and not np.ptp(load.speeds):
        answer["time_to_90"], answer["time_to_99"] = punch.time_left(0.1), punch.time_left(0.01)
    return {name: np.asarray(value, float) for name, value in answer.items()}


def exact_results(problem, finer: float = 0.01) -> dict[str, Array]:
    """Return results and answer with errors of `finer` rtol."""
    results, answer, _ = solved(problem, finer * problem.rtol, finer * 1e-12)
    return results | answer


def errors_less_doubts(solution, problem, exact: dict, doubts: dict, modes: int):
    """Yield the name and the errors of each quantity, less twice the uncertainty of the exact one.

    So many relaxation times, the slowest, are compared.
    """
    for name, error in differences(solution.compared, exact, problem.face).items():
        error, doubt = np.atleast_1d(error), np.atleast_1d(doubts[name])
        shown = min(modes if name == "relaxation_time" else np.inf, len(error), len(doubt))
        yield name, np.maximum(error[:shown] - 2 * doubt[:shown], 0.0)


def true_errors(result) -> dict[str, dict[str, tuple[Array, Array]]]:
    """Return errors and estimates at the compared times, for each method and quantity of a run.

    The uncertainty of the independent solution is its difference to a coarser one.
    """
    problem = result.scene.problem
    exact = exact_results(problem)
    doubts = differences(exact_results(problem, 0.03), exact, problem.face)
    errors: dict = {}
    for method, solution in result.solutions.items():
        errors[method] = {}
        for name, error in errors_less_doubts(solution, problem, exact, doubts, 3):
            if name in solution.errors:
                estimate = np.atleast_1d(solution.compared_error(problem, name))[: len(error)]
                error = error[: len(estimate)]
                # a number of the answer has NaN where the method does not give it
                given = ~np.isnan(error)
                errors[method][name] = error[given], estimate[given]
    return errors
