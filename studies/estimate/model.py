"""Predict measured numbers by solving the changed scene.

Scenes that are similar (other force, modulus, radius, speed, unit of time) have one non-dimensional
history, which is computed once: they differ by `problem.units` only. Wear coefficients of a flat
punch need new modes on the same discretisation. Whatever needs a new discretisation or a march is
solved at the nodes of a lattice in the coordinates on which it depends, and is interpolated.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import prod
from typing import NamedTuple, TypeAlias

import numpy as np

from ...meshes import Array, Compliance, SceneError
from ..crosscheck import LOG, QUANTITIES, Problem, Scene
from .histories import CELL, FlatHistory, March, Strips, discretise, with_uniform
from .measurement import Measurement
from .parameter import Parameter, Reading, Situation, situation

# rtol of a march over the rtol of the model, because marches are less smooth than modes
MARCH_RTOL_FACTOR = 0.1
# step of the coordinates in central differences
STEP = 1e-4
# greatest number of dimensions of the lattice: each one multiplies the number of solutions by four
MAX_DIMENSIONS = 2
# lattice points through which a cubic, or a straight line, is laid, relative to the point below
STENCIL, SHORT_STENCIL = np.array([-1, 0, 1, 2]), np.array([0, 1])
# number of heights that represent the unworn face among the numbers on which a march depends
HEIGHTS = 24
# greatest relative error of the model that is corrected
MAX_CORRECTION = 0.1
# numbers of stored histories, and of stored scenes
STORED, STORED_SITUATIONS = 300, 5000


History: TypeAlias = FlatHistory | March | Strips
"""A non-dimensional history."""


class Weighted(NamedTuple):
    """A history among those whose weighted sum is another one, and its problem."""

    weight: float
    history: History
    problem: Problem


@dataclass(frozen=True, eq=False)
class Solver:
    """Solve scenes, each non-dimensional problem once.

    Parameters
    ----------
    rtol : tolerance
    times : times of the data after the start, for which discretisations are made
    radii : radii of the data, over the radius of the punch
    fields : whether fields or volumes are needed, not only the indentation
    rough : whether lattices of two dimensions are interpolated linearly
    direct : whether every scene is solved, and nothing is interpolated
    """

    rtol: float
    times: Array
    radii: Array
    fields: bool
    rough: bool = False
    direct: bool = False
    situations: dict[object, Situation] = field(default_factory=dict)
    nodes: dict[object, tuple[History, Problem]] = field(default_factory=dict)
    _samples: dict[object, dict[str, Array]] = field(default_factory=dict)
    _compliances: dict[object, Compliance] = field(default_factory=dict)
    _histories: dict[object, History] = field(default_factory=dict)

    def history(self, scene: Scene, reading: Reading) -> History:
        """Return the history of a scene."""
        problem = scene.problem
        times = reading.times(self.times) / problem.units.time
        times = times[times > 0] if (times > 0).any() else np.array([1e-3, 1.0])
        if reading.plane_strain:
            return self._strips(scene)
        if is_flat(problem):
            return self._flat_history(scene, problem, times, reading)
        return self._march(scene, problem, times)

    def sample(
        self, history: History, times: Array, radii: Array, step: float, names: tuple[str, ...]
    ) -> dict[str, Array]:
        """Return the named quantities of a history; those that were sampled before are stored."""
        key = history, times.tobytes(), radii.tobytes(), step, names
        if key not in self._samples:
            if len(self._samples) > STORED:
                self._samples.clear()
            # all kinds of histories have the same names, so that they can be interpolated
            found = history.sample(times, radii, step, names)
            self._samples[key] = {name: found[name] for name in names}
        return self._samples[key]

    def _flat_history(
        self, scene: Scene, problem: Problem, times: Array, reading: Reading
    ) -> History:
        distances = problem.loading.at(times).distance
        distances = distances[distances > 0]
        ends = float(distances.min()), float(distances.max())
        geometry = written(ground_numbers(scene))
        if geometry not in self._compliances:
            coarse = replace(problem, rtol=self.rtol)
            self._compliances[geometry] = discretise(coarse, *ends, self.fields)
        added = 0.0
        if problem.indentation is not None:
            added = reading.ground_compliance * problem.units.force / problem.units.displacement
        wear = wear_coefficients(scene) / problem.units.wear_coefficient
        numbers = wear, load_numbers(problem), np.array([added])
        key = geometry, written(np.concatenate(numbers))
        if key not in self._histories:
            while len(self._histories) >= STORED:
                del self._histories[next(iter(self._histories))]
            compliance = self._compliances[geometry]
            if added:
                compliance = with_uniform(compliance, added)
            self._histories[key] = FlatHistory(problem, compliance, ends[0] / 10)
        return self._histories[key]

    def _strips(self, scene: Scene) -> History:
        numbers = scene.problem.ring_edges, wear_coefficients(scene)
        key = "strips", written(np.concatenate(numbers))
        if key not in self._histories:
            self._histories[key] = Strips.of(scene.problem)
        return self._histories[key]

    def _march(self, scene: Scene, problem: Problem, times: Array) -> History:
        clock, key = clock_of(problem), written(shape_numbers(scene))
        earliest, latest = float(times.min()) / clock, float(times.max()) / clock
        stored = self._histories.get(key)
        if isinstance(stored, March):
            if stored.earliest <= earliest and latest <= stored.latest:
                return stored
            earliest, latest = min(earliest, stored.earliest), max(latest, stored.latest)
        coarse = replace(problem, rtol=MARCH_RTOL_FACTOR * self.rtol)
        march = March.compute(coarse, clock, earliest, latest, self.radii)
        self._histories[key] = march
        LOG.info("     fit  %d marches ...", len(self._histories))
        return march


def is_flat(problem: Problem) -> bool:
    """Return whether the contact is full for all parameters, not only predicted to be."""
    return problem.full_contact and not problem.keeps_contact


def clock_of(problem: Problem) -> float:
    """Return the unit of time in which the first wear coefficient is 1; 1 if the load varies."""
    return 1.0 if problem.loading.varies else float(1 / problem.wear_coefficients[0])


def wear_coefficients(scene: Scene) -> Array:
    """Return the wear coefficients (J,) of the rings of a scene, or the values of its table."""
    values = np.array(scene.punch.coefficients)
    return values if scene.punch.table else np.resize(values, len(scene.problem.wear_coefficients))


def ground_numbers(scene: Scene) -> Array:
    """Return the numbers on which a discretised half-space depends: ring edges and layers."""
    problem = scene.problem
    layers = np.empty(0)
    if (ground := problem.ground).layered:
        shear = np.array(ground.shear_moduli) / ground.shear_moduli[0]
        numbers = *ground.thicknesses, *np.minimum(shear, 1e9), *ground.poisson_ratios
        layers = np.array([ground.share, *numbers])
    graded = np.array(scene.punch.table.radii if scene.punch.table else ())
    return np.concatenate([problem.ring_edges, layers, graded / problem.units.length])


def load_numbers(problem: Problem) -> Array:
    """Return the numbers that describe a load that varies, and a prescribed indentation."""
    loading = problem.loading
    loads = [loading.times, loading.forces, loading.speeds] if loading.varies else []
    return np.concatenate([*loads, [problem.indentation or 0.0]])


def shape_numbers(scene: Scene) -> Array:
    """Return the numbers on which a discretisation depends and, if the contact moves, a march.

    The latter are 0 if it does not move.
    """
    problem = scene.problem
    radii = np.linspace(problem.inner_radius, 1.0, HEIGHTS)
    contrasts = wear_coefficients(scene)
    of_march = [load_numbers(problem), np.log(contrasts / contrasts[0]), problem.profile(radii)]
    moves = not is_flat(problem)
    return np.concatenate([ground_numbers(scene), moves * np.concatenate(of_march)])


def written(numbers: Array) -> tuple[str, ...]:
    """Return numbers as texts without their roundoff, as a key."""
    return tuple(f"{number:.8e}" for number in numbers)


@dataclass(frozen=True, eq=False)
class Model:
    """Predict measurements at coordinates (m,) of parameters.

    Parameters
    ----------
    scene : with the initial values of the parameters
    parameters : m parameters
    measurements : that are predicted
    solver : with the histories that have been computed
    origin : (m,) coordinates of a point of the lattice, at which nothing is interpolated
    known : accurate values of each measurement in the scene as it is, if there are any: predictions
        are multiplied by their ratio to those of the model, whose tolerance is loose
    mesh_errors : relative errors of each measurement on a linear mesh, if they are known; a reading
        tells which part of them a table has
    """

    scene: Scene
    parameters: tuple[Parameter, ...]
    measurements: tuple[Measurement, ...]
    solver: Solver
    origin: Array
    known: tuple[Array, ...] = ()
    mesh_errors: tuple[Array, ...] = ()

    @classmethod
    def of(
        cls,
        scene: Scene,
        parameters: tuple[Parameter, ...],
        measurements: tuple[Measurement, ...],
        rtol: float,
        origin: Array | None = None,
        rough: bool = False,
    ) -> "Model":
        """Return the model of a scene, with a tolerance."""
        times = np.concatenate([each.times for each in measurements])
        solver = Solver(rtol, times[times > 0], *_needs(scene, measurements), rough)
        if not scene.problem.loading.varies:
            # the times of the measurements count, and a scene with one time is changed faster
            scene = scene.changed(wear__times=[float(times.max())])
        zeros = np.zeros(len(parameters))
        return cls(scene, parameters, measurements, solver, zeros if origin is None else origin)

    @property
    def rtol(self) -> float:
        """The tolerance to which the model is solved."""
        return self.solver.rtol

    def for_measurements(self, measurements: tuple[Measurement, ...]) -> "Model":
        """Return the model that predicts other measurements."""
        radii, fields = _needs(self.scene, measurements)
        if fields > self.solver.fields or not np.isin(radii, self.solver.radii).all():
            return Model.of(self.scene, self.parameters, measurements, self.rtol, self.origin)
        return replace(self, measurements=measurements)

    def with_parameters(self, parameters: tuple[Parameter, ...]) -> "Model":
        """Return the model with other parameters; it shares all solutions."""
        origin = [each.coordinate(each.values[0]) if each.values else 0.0 for each in parameters]
        return replace(self, parameters=parameters, origin=np.array(origin))

    @property
    def interpolates(self) -> bool:
        """Whether histories are interpolated."""
        return not self.solver.direct and bool(len(self._lattice[0]))

    def solved_directly(self) -> "Model":
        """Return the model without interpolation; it shares all solutions."""
        return replace(self, solver=replace(self.solver, direct=True))

    def predict(self, x: Array) -> list[Array]:
        """Return the values (n,) of each measurement at coordinates (m,)."""
        scene, reading = self._situation(x)
        values = self._read(scene.problem, reading, self._histories(x))
        if self.known:
            values = [each * ratio for each, ratio in zip(values, self._ratios, strict=True)]
        if reading.mesh:
            errors = zip(values, self.mesh_errors, strict=True)
            values = [each * (1 + reading.mesh * error) for each, error in errors]
        return values

    @cached_property
    def _ratios(self) -> list[Array]:
        """Ratios of known values to those of the model in the scene as it is; 1 if far from 1."""
        alone = replace(self, parameters=(), origin=np.zeros(0), known=(), mesh_errors=())
        ratios = []
        for known, own in zip(self.known, alone.predict(np.zeros(0)), strict=True):
            with np.errstate(all="ignore"):
                ratio = known / own
            near = np.abs(ratio - 1) < MAX_CORRECTION
            ratios.append(np.where(near, ratio, 1.0))
        return ratios

    def _situation(self, x: Array) -> Situation:
        """Return the scene and the reading at coordinates (m,); each scene is made once."""
        pairs = list(zip(self.parameters, x.tolist(), strict=True))
        key = tuple(pair for pair in pairs if pair[0].of_scene)
        stored = self.solver.situations
        if key not in stored:
            if len(stored) > STORED_SITUATIONS:
                stored.clear()
            stored[key] = situation(self.scene, [each for each, _ in key], [x for _, x in key])
        rest = [pair for pair in pairs if not pair[0].of_scene]
        scene, reading = stored[key]
        return situation(scene, [each for each, _ in rest], [x for _, x in rest], reading)

    def _histories(self, x: Array) -> list[Weighted]:
        """Return histories and their weights in the one at coordinates (m,).

        There is only one history, with the weight 1, if no interpolation is needed.
        """
        histories, nodes = [], self.solver.nodes
        for weight, node in self._nodes(x):
            key = self.parameters, node.tobytes()
            if key not in nodes:
                if len(nodes) > STORED:
                    nodes.clear()
                scene, reading = self._situation(node)
                nodes[key] = self.solver.history(scene, reading), scene.problem
            histories.append(Weighted(weight, *nodes[key]))
        return histories

    def _nodes(self, x: Array) -> Iterator[tuple[float, Array]]:
        """Yield the lattice points (m,) around coordinates (m,), each with its weight."""
        if self.solver.direct:
            yield 1.0, x
            return
        to_lattice, from_lattice, ends = self._lattice
        positions = to_lattice @ (x - self.origin)
        # at a lattice point, the weights of all other points become exactly 0
        rounded = np.round(positions)
        exact = np.where(np.abs(positions - rounded) < 1e-9, rounded, positions)
        stencil = SHORT_STENCIL if self.solver.rough and len(positions) > 1 else STENCIL
        # no point is outside the range of the parameters
        below = np.clip(np.floor(exact), -ends - stencil[0], ends - stencil[-1])
        weights = [lagrange(float(fraction), stencil) for fraction in exact - below]
        for corner in product(range(len(stencil)), repeat=len(positions)):
            weight = prod(each[number] for each, number in zip(weights, corner, strict=True))
            if weight:
                point = below + stencil[list(corner)]
                # directions without an effect on the shape keep their coordinates; rounded, so that
                # a point has the same coordinates from wherever it is reached
                yield weight, np.round(x + from_lattice @ (point - positions), 10)

    @cached_property
    def _lattice(self) -> tuple[Array, Array, Array]:
        """Matrices from coordinates to positions in the lattice (K, m), and back (m, K); ends (K,).

        The lattice has the K directions in which the shape changes. Its ends are those of the
        parameters if each of these directions is that of one parameter; otherwise infinite.

        Raises
        ------
        SceneError
            if there are too many dimensions
        """
        count = len(self.parameters)
        spacing = np.array([each.spacing for each in self.parameters])
        continuous = np.flatnonzero([not each.values for each in self.parameters])
        changes = np.zeros((count, len(shape_numbers(self._situation(self.origin)[0]))))
        for number in continuous:
            shift = np.zeros(count)
            shift[number] = STEP * spacing[number]
            above, below = (
                shape_numbers(self._situation(self.origin + each)[0]) for each in (shift, -shift)
            )
            changes[number] = (above - below) / (2 * STEP)
        effective = np.linalg.norm(changes, axis=1) > 1e-6
        _, singular, right = np.linalg.svd(changes.T, full_matrices=False)
        rank = int(np.sum(singular > 1e-6))
        if rank > MAX_DIMENSIONS:
            raise SceneError(
                f"a fit of a punch whose contact changes, or whose half-space does, depends on "
                f"{rank} parameters besides the scale of time, and can have at most "
                f"{MAX_DIMENSIONS} (--parameters)"
            )
        directions, ends = right[:rank], np.full(rank, np.inf)
        if rank == effective.sum():
            directions = np.eye(count)[effective]
            reach = np.array([each.reach for each in self.parameters])
            ends = np.round((reach / spacing)[effective], 6) // 1
            ends = np.maximum(ends, 2)
        return directions / spacing, spacing[:, None] * directions.T, ends

    def _radii_at(self, times: Array) -> Array:
        """Return the radii (R,) of the measurements at the same times that have radii."""
        return next(
            (
                each.radii
                for each in self.measurements
                if each.radii is not None and np.array_equal(each.times, times)
            ),
            np.empty(0),
        )

    def _read(
        self, problem: Problem, reading: Reading, histories: Sequence[Weighted]
    ) -> list[Array]:
        """Return the values (n,) of each measurement that a reading of a problem has."""
        units, values = problem.units, list[Array]()
        # histories are alike in the time in which their first wear coefficients are 1; if the load
        # varies, all have to have the load of the same time
        seconds = [
            part.problem.units.time
            if problem.loading.varies
            else units.time * clock_of(problem) / clock_of(part.problem)
            for part in histories
        ]
        names = tuple(sorted({"normal_force", *(each.quantity for each in self.measurements)}))
        for each in self.measurements:
            times = each.times[:1] if each.has_offset else each.times
            radii = self._radii_at(each.times)
            since = reading.times(times)
            own_radii = radii * (reading.radius_scale / units.length)
            if any(other.means is not None for other in self.measurements):
                # radii beyond the rim, or in a hole, have the values at the edge
                own_radii = np.clip(own_radii, problem.inner_radius + 1e-4, 1 - 1e-4)
            step = reading.step / units.time
            samples = weighted(
                [
                    (
                        part.weight,
                        self.solver.sample(part.history, since / second, own_radii, step, names),
                    )
                    for part, second in zip(histories, seconds, strict=True)
                ]
            )
            predicted = samples[each.quantity]
            if each.quantity == "worn_volume":
                predicted = predicted.sum(axis=1) if each.ring is None else predicted[:, each.ring]
            predicted = predicted * unit_of(units, each.quantity)
            if each.quantity in ("indentation", "displacement"):
                compliance = reading.compliance
                if problem.indentation is None:
                    compliance += reading.ground_compliance
                shift = reading.offset + compliance * units.force * samples["normal_force"]
                predicted = predicted + (shift if predicted.ndim == 1 else shift[:, None])
            if each.means is not None:
                predicted = predicted @ each.means.T
            values.append(predicted.ravel() * reading.factors.get(each.quantity, 1.0))
        return values


def _needs(scene: Scene, measurements: Sequence[Measurement]) -> tuple[Array, bool]:
    """Return the radii of measurements, over the punch radius, and whether fields are needed.

    Volumes count as fields.
    """
    radii = [each.radii / scene.punch.radius for each in measurements if each.radii is not None]
    fields = any(each.quantity not in ("indentation", "normal_force") for each in measurements)
    return np.unique(np.concatenate([[1.0], *radii])), fields


def unit_of(units: object, quantity: str) -> float:
    """Return the unit of a quantity, in the units of the scene."""
    kind = {"worn_volume": "volume", "scar_diameter": "length", CELL: "length"}.get(quantity)
    return float(getattr(units, kind or QUANTITIES[quantity].unit))


def weighted(samples: list[tuple[float, dict[str, Array]]]) -> dict[str, Array]:
    """Return the weighted sum of samples, which have the same names."""
    if len(samples) == 1:
        return samples[0][1]
    return {
        name: np.sum([weight * each[name] for weight, each in samples], axis=0)
        for name in samples[0][1]
    }


def lagrange(position: float, stencil: Array = STENCIL) -> tuple[float, ...]:
    """Return the weights of the values at the points of a stencil in the polynomial through them.

    They are those at a position, usually between 0 and 1.
    """
    points = stencil.astype(float)
    return tuple(
        float(np.prod([(position - other) / (each - other) for other in points if other != each]))
        for each in points
    )
