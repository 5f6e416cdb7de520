"""Predict measured numbers by solving the changed scene.

Scenes that are similar (other force, modulus, radius, speed, unit of time) have one non-dimensional
history, which is computed once: they differ by `problem.units` only. Wear coefficients of a flat
punch need new modes on the same discretisation. Whatever needs a new discretisation or a march is
solved at the nodes of a lattice in the coordinates on which it depends, and is interpolated.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import prod
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from scipy.interpolate import BarycentricInterpolator

from ...meshes import Array, SceneError
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
# number of histories that are stored, and of what is stored of any other kind
STORED = 300


History: TypeAlias = FlatHistory | March | Strips
"""A non-dimensional history."""


class Weighted(NamedTuple):
    """A history among those whose weighted sum is another one, and its problem."""

    weight: float
    history: History
    problem: Problem


def is_flat(problem: Problem) -> bool:
    """Return whether the contact is full for all parameters, not only predicted to be."""
    return problem.full_contact and not problem.keeps_contact


def clock_of(problem: Problem) -> float:
    """Return the unit of time in which the first wear coefficient is 1; 1 if the load varies."""
    return 1.0 if problem.loading.varies else float(1 / problem.wear_coefficients[0])


def wear_coefficients(scene: Scene) -> Array:
    """Return the wear coefficients (N,) of rings, or values of a table, over the greatest."""
    if table := scene.punch.table:
        return np.array(table.values) / scene.problem.units.wear_coefficient
    return scene.problem.wear_coefficients


def load_numbers(problem: Problem) -> Array:
    """Return the numbers that describe a load that varies, and a prescribed indentation."""
    loading = problem.loading
    loads = [loading.times, loading.forces, loading.speeds] if loading.varies else []
    return np.concatenate([*loads, [problem.indentation or 0.0]])


def shape_numbers(scene: Scene) -> Array:
    """Return the numbers on which a discretisation depends and, if the contact moves, a march.

    The former are edges, layers and radii of a table. The latter are 0 if the contact does not
    move.
    """
    problem, table, ground = scene.problem, scene.punch.table, scene.problem.ground
    layers = ground.share, *ground.thicknesses, *ground.poisson_ratios
    moduli = np.minimum(ground.shear_moduli, 1e9)
    graded = np.array(table.radii if table else ()) / problem.units.length
    wear = wear_coefficients(scene)
    radii = np.linspace(problem.inner_radius, 1.0, HEIGHTS)
    of_march = [load_numbers(problem), np.log(wear / wear[0]), problem.profile(radii)]
    moves = not is_flat(problem)
    return np.concatenate(
        [
            problem.ring_edges,
            *[layers, moduli] * ground.layered,
            graded,
            moves * np.concatenate(of_march),
        ]
    )


def written(numbers: Array) -> bytes:
    """Return numbers without their roundoff, and zeros without a sign, as a key."""
    return (numbers + 0.0).astype(np.float32).tobytes()


@dataclass(frozen=True, eq=False)
class Model:
    """Predict measurements at coordinates (m,) of parameters.

    Parameters
    ----------
    scene : with the initial values of the parameters
    parameters : m parameters
    measurements : that are predicted
    rtol : tolerance to which scenes are solved
    origin : (m,) coordinates of a point of the lattice, at which nothing is interpolated
    known : accurate values of each measurement in the scene as it is, if there are any: predictions
        are multiplied by their ratio to those of the model, whose tolerance is loose
    mesh_errors : relative errors of each measurement on a linear mesh, if they are known; a reading
        tells which part of them a table has
    rough : whether lattices of two dimensions are interpolated linearly
    direct : whether every scene is solved, and nothing is interpolated
    stored : what has been computed, which models share that differ in other fields
    """

    scene: Scene
    parameters: tuple[Parameter, ...]
    measurements: tuple[Measurement, ...]
    rtol: float
    origin: Array
    known: tuple[Array, ...] = ()
    mesh_errors: tuple[Array, ...] = ()
    rough: bool = False
    direct: bool = False
    stored: dict[str, dict[object, Any]] = field(default_factory=dict)

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
        if not scene.problem.loading.varies:
            # the times of the measurements count, and a scene with one time is changed faster
            last = max(float(each.times.max()) for each in measurements)
            scene = scene.changed(wear__times=[last])
        origin = np.zeros(len(parameters)) if origin is None else origin
        return cls(scene, parameters, measurements, rtol, origin, rough=rough)

    def for_measurements(self, measurements: tuple[Measurement, ...]) -> "Model":
        """Return the model that predicts other measurements, at about these times and radii."""
        return replace(self, measurements=measurements)

    def with_parameters(self, parameters: tuple[Parameter, ...]) -> "Model":
        """Return the model with other parameters; it shares all solutions."""
        origin = [each.coordinate(each.values[0]) if each.values else 0.0 for each in parameters]
        return replace(self, parameters=parameters, origin=np.array(origin))

    @property
    def interpolates(self) -> bool:
        """Whether histories are interpolated."""
        return not self.direct and bool(len(self._lattice[0]))

    def solved_directly(self) -> "Model":
        """Return the model without interpolation; it shares all solutions."""
        return replace(self, direct=True)

    def once(self, kind: str, key: object, compute: Callable[[], Any]) -> Any:
        """Return what is stored of a kind under a key, or else what is computed, and store it."""
        kept = self.stored.setdefault(kind, {})
        if key not in kept:
            while len(kept) >= STORED:
                del kept[next(iter(kept))]
            kept[key] = compute()
        return kept[key]

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
        pairs = zip(self.known, alone.predict(np.zeros(0)), strict=True)
        with np.errstate(all="ignore"):
            ratios = [known / own for known, own in pairs]
        return [np.where(np.abs(each - 1) < MAX_CORRECTION, each, 1.0) for each in ratios]

    def _situation(self, x: Array) -> Situation:
        """Return the scene and the reading at coordinates (m,); each scene is made once."""
        parameters = np.array(self.parameters, dtype=object)
        of_scene = np.array([each.of_scene for each in parameters], dtype=bool)
        scene, reading = self.once(
            "scene",
            (*parameters[of_scene], x[of_scene].tobytes()),
            lambda: situation(self.scene, parameters[of_scene], x[of_scene]),
        )
        return situation(scene, parameters[~of_scene], x[~of_scene], reading)

    def history(self, scene: Scene, reading: Reading) -> History:
        """Return the history of a scene; each non-dimensional problem is solved once."""
        problem = scene.problem
        times = np.concatenate([each.times for each in self.measurements])
        # of a table that has only the start, any times
        times = reading.times(times[times > 0]) / problem.units.time
        times = times[times > 0] if (times > 0).any() else np.array([1e-3, 1.0])
        if reading.plane_strain:
            return Strips.of(problem)
        if not is_flat(problem):
            return self._march(scene, problem, times)
        distances = problem.loading.at(times).distance
        distances = distances[distances > 0]
        earliest, latest = float(distances.min()), float(distances.max())
        # volumes count as fields
        fields = any(
            each.quantity not in ("indentation", "normal_force") for each in self.measurements
        )
        shape, added = shape_numbers(scene), 0.0
        if problem.indentation is not None:
            added = reading.ground_compliance * problem.units.force / problem.units.displacement
        numbers = shape, wear_coefficients(scene), load_numbers(problem), [added]
        compliance = self.once(
            "compliance",
            written(shape),
            lambda: discretise(replace(problem, rtol=self.rtol), earliest, latest, fields),
        )
        flat: FlatHistory = self.once(
            "history",
            written(np.concatenate(numbers)),
            lambda: FlatHistory(
                problem,
                with_uniform(compliance, added) if added else compliance,
                earliest / 10,
            ),
        )
        return flat

    def _march(self, scene: Scene, problem: Problem, times: Array) -> History:
        clock, key = clock_of(problem), written(shape_numbers(scene))
        earliest, latest = float(times.min()) / clock, float(times.max()) / clock
        marches = self.stored.setdefault("march", {})
        if stored := marches.get(key):
            if stored.earliest <= earliest and latest <= stored.latest:
                return stored
            earliest, latest = min(earliest, stored.earliest), max(latest, stored.latest)
        given = [each.radii for each in self.measurements if each.radii is not None]
        radii = np.unique(np.concatenate([*given, [problem.units.length]])) / problem.units.length
        coarse = replace(problem, rtol=MARCH_RTOL_FACTOR * self.rtol)
        marches[key] = March.compute(coarse, clock, earliest, latest, radii)
        LOG.info("     fit  %d marches ...", len(marches))
        return marches[key]

    def _histories(self, x: Array) -> list[Weighted]:
        """Return histories and their weights in the one at coordinates (m,).

        There is only one history, with the weight 1, if no interpolation is needed.
        """
        situations = [(weight, *self._situation(node)) for weight, node in self._nodes(x)]
        return [
            Weighted(weight, self.history(scene, reading), scene.problem)
            for weight, scene, reading in situations
        ]

    def _nodes(self, x: Array) -> Iterator[tuple[float, Array]]:
        """Yield the lattice points (m,) around coordinates (m,), each with its weight."""
        if self.direct:
            yield 1.0, x
            return
        to_lattice, from_lattice, ends = self._lattice
        positions = to_lattice @ (x - self.origin)
        # at a lattice point, the weights of all other points become exactly 0
        rounded = np.round(positions)
        exact = np.where(np.abs(positions - rounded) < 1e-9, rounded, positions)
        stencil = SHORT_STENCIL if self.rough and len(positions) > 1 else STENCIL
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

        The lattice has the K directions in which the shape changes. They are those of parameters,
        and end where these do, if no more parameters than these change it.

        Raises
        ------
        SceneError
            if there are too many dimensions
        """

        def shape(shift: Array) -> Array:
            return shape_numbers(self._situation(self.origin + shift)[0])

        spacing = np.array([each.spacing for each in self.parameters])
        continuous = np.array([not each.values for each in self.parameters], dtype=float)
        changes = np.zeros((len(spacing), len(shape(0 * spacing))))
        for number, shift in enumerate(STEP * np.diag(spacing * continuous)):
            changes[number] = (shape(shift) - shape(-shift)) / (2 * STEP)
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
            directions = np.eye(len(spacing))[effective]
            reach = np.array([each.reach for each in self.parameters])
            ends = np.maximum(np.round(reach / spacing, 6)[effective] // 1, 2)
        return directions / spacing, spacing[:, None] * directions.T, ends

    def _read(
        self, problem: Problem, reading: Reading, histories: Sequence[Weighted]
    ) -> list[Array]:
        """Return the values (n,) of each measurement that a reading of a problem has."""
        units, values = problem.units, list[Array]()
        names = tuple(sorted({"normal_force", *(each.quantity for each in self.measurements)}))
        for each in self.measurements:
            since = reading.times(each.times[:1] if each.has_offset else each.times)
            # those of all measurements at these times, which are sampled at once
            radii = next(
                (
                    other.radii * (reading.radius_scale / units.length)
                    for other in self.measurements
                    if other.radii is not None and np.array_equal(other.times, each.times)
                ),
                np.empty(0),
            )
            if each.bias:
                # radii beyond the rim, or in a hole, have the values at the edge
                radii = np.clip(radii, problem.inner_radius + 1e-4, 1 - 1e-4)
            samples = [
                (part.weight, self._sample(part, problem, since, radii, reading.step, names))
                for part in histories
            ]
            predicted, force = (
                np.sum([weight * sample[name] for weight, sample in samples], axis=0)
                for name in (each.quantity, "normal_force")
            )
            if each.quantity == "worn_volume":
                predicted = predicted.sum(axis=1) if each.ring is None else predicted[:, each.ring]
            predicted = predicted * unit_of(units, each.quantity)
            if each.quantity in ("indentation", "displacement"):
                compliance = reading.compliance
                if problem.indentation is None:
                    compliance += reading.ground_compliance
                shift = reading.offset + compliance * units.force * force
                predicted = (predicted.T + shift).T
            if each.means is not None:
                predicted = predicted @ each.means.T
            values.append(predicted.ravel() * reading.factors.get(each.quantity, 1.0))
        return values

    def _sample(
        self,
        part: Weighted,
        problem: Problem,
        since: Array,
        radii: Array,
        step: float,
        names: tuple[str, ...],
    ) -> dict[str, Array]:
        """Return quantities of a history, at times of a problem that it is a part of.

        Histories are alike in the time in which their first wear coefficients are 1; if the load
        varies, all have to have the load of the same time.
        """
        unit = (part.problem if problem.loading.varies else problem).units.time
        times = since / (unit * clock_of(problem) / clock_of(part.problem))
        step /= problem.units.time
        sampled: dict[str, Array] = self.once(
            "sample",
            (part.history, times.tobytes(), radii.tobytes(), step, names),
            lambda: part.history.sample(times, radii, step, names),
        )
        return sampled


def unit_of(units: object, quantity: str) -> float:
    """Return the unit of a quantity, in the units of the scene."""
    kind = {"worn_volume": "volume", "scar_diameter": "length", CELL: "length"}.get(quantity)
    return float(getattr(units, kind or QUANTITIES[quantity].unit))


def lagrange(position: float, stencil: Array = STENCIL) -> Array:
    """Return the weights of the values at the points of a stencil in the polynomial through them.

    They are those at a position, usually between 0 and 1.
    """
    return BarycentricInterpolator(stencil, np.eye(len(stencil)))(position)
