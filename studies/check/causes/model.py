"""What another program would print if it had modelled something else."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....meshes.radial import Array
from ...methods.base import Solution, method
from ...problem.problem import Problem
from ...problem.quantities import QUANTITIES
from ...progress import Stages
from ...sampling.norms import Results
from ...sampling.sampler import Sampler
from . import grounds
from .comparison import Comparison
from .setting import Setting
from .table import Table

# of the tables that are interpolated: accuracy, times and radii
ACCURACY, TIMES, OF_A_RING, RADII = 1e-3, 80, 6, 100
# the tables reach from a part of the first time to times the last one; beyond it they are straight
BEFORE_FIRST, AFTER_LAST = 1e-2, 4.0
# steps in the longest time between results, by which errors of first order are measured; whole
# ones, so that none is shorter there than its length
STEPS = np.array([64.0, 48, 40, 32, 25, 20, 16, 13, 10, 8, 6, 5, 4, 3, 2])
# layers that are computed, by thickness over the punch radius and modulus over that below; others
# lie between
THICKNESSES = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)
STIFFNESSES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
LENGTHS = ("displacement", "profile", "indentation")
PRINTED = (*LENGTHS, "pressure", "normal_force")
# by how much tables may differ from ours, relative, by their own accuracy
TABLES_ERR = 0.02
# of relative errors of the start of a clamped half-space over a/R, by Poisson's ratio (`study
# truncation`)
CLAMPED = ([0, 0.3, 0.45, 0.5], [0.94, 1.09, 1.51, 1.91])


@dataclass(frozen=True, eq=False)
class Model:
    """Predicts what a program prints that differs from ours in a setting."""

    comparison: Comparison
    _histories: dict[object, Results] = field(default_factory=dict)
    _tables: dict[object, Table] = field(default_factory=dict)
    _sampled: dict[float, Array] = field(default_factory=dict)

    @property
    def problem(self) -> Problem:
        """The problem of the scene."""
        return self.comparison.scene.problem

    @property
    def flat(self) -> bool:
        """Whether the history scales with force, radius and modulus, as that of a flat punch."""
        return self.problem.full_contact and not self.problem.loading.varies

    @property
    def pressed_by_force(self) -> bool:
        """Whether the force is given, not the indentation."""
        return self.problem.indentation is None

    @cached_property
    def times(self) -> Array:
        """Non-dimensional times looked at."""
        return self.comparison.times[self.comparison.rows] / self.problem.units.time

    @cached_property
    def _radii(self) -> Array:
        """Radii of the tables, on both sides of each ring edge."""
        edges = self.problem.ring_edges
        count = max(OF_A_RING, RADII // (len(edges) - 1))
        within = (1 - np.cos(np.pi * np.linspace(0.01, 0.99, count))) / 2
        inner, outer = edges[:-1, None], edges[1:, None]
        return np.asarray((inner + (outer - inner) * within).ravel())

    @cached_property
    def _grid(self) -> Array:
        later = self.times[self.times > 0]
        if not len(later):
            return np.append(0.0, np.geomspace(1e-6, 1e-3, 4))
        first, last = BEFORE_FIRST * later.min(), AFTER_LAST * later.max()
        return np.unique(np.concatenate([[0.0], np.geomspace(first, last, TIMES), later]))

    @cached_property
    def _own_problem(self) -> Problem:
        """The problem of the tables."""
        return replace(
            self.problem,
            rtol=ACCURACY,
            steady=False,
            quantities=frozenset(PRINTED) - self.problem.quantities_missing,
            compared_on=None,
            times=self._grid,
            output_radii=self._radii,
        )

    @cached_property
    def _own(self) -> Solution:
        """Ours, for the tables."""
        return method("mdr").solve(self._own_problem, Stages("mdr"))

    def _printed(self, results: Results) -> Results:
        """Return what is compared of non-dimensional results at the times of the tables."""
        given = {"normal_force": self.problem.loading.at(self._grid).force}
        return {name: np.asarray((given | results)[name]) for name in PRINTED}

    def histories(self, setting: Setting) -> Results:
        """Return fields (T, R) and numbers (T,) of the tables, on the ground of a setting."""
        key = (setting.ground, setting.layer, setting.swapped)
        if key not in self._histories:
            self._histories[key] = self._history_on_ground(setting)
        return self._histories[key]

    def _history_on_ground(self, setting: Setting) -> Results:
        rings, problem = self.problem.graded or self.problem.rings, self._own_problem
        if setting.swapped:
            wear = rings.wear_coefficients
            rings = rings._replace(wear_coefficients=wear.min() + wear.max() - wear)
            problem = replace(problem, rings=rings)
        if setting.ground == "homogeneous":
            problem = replace(problem, ground=None)
        if setting.ground in ("ours", "homogeneous"):
            ours = problem is self._own_problem
            solved = self._own if ours else method("mdr").solve(problem, Stages("mdr"))
            return self._printed(solved.results)
        ground = grounds.plane_strain(rings)
        if setting.ground == "layer":
            ground = grounds.layered(rings, *setting.layer, self.problem.poisson_ratio)
        points = grounds.elements(rings.ring_edges)
        element = np.clip(np.searchsorted(points, self._radii) - 1, 0, len(points) - 2)
        pressure, worn, depth = ground.history(self._grid)
        profile = worn[:, element]
        return {
            "pressure": pressure[:, element],
            "profile": profile,
            "displacement": depth[:, None] - profile,
            "indentation": depth,
            "normal_force": np.ones(len(depth)),
        }

    def _points(self, factor: float) -> Array:
        """Return what interpolates (R, M) from the radii of the tables to theirs."""
        if factor not in self._sampled:
            at = self.comparison.radii / self.problem.units.length * factor
            at = np.clip(at, self._radii[0], self._radii[-1])
            after = np.clip(np.searchsorted(self._radii, at), 1, len(self._radii) - 1)
            share = (at - self._radii[after - 1]) / (self._radii[after] - self._radii[after - 1])
            sampled = np.zeros((len(at), len(self._radii)))
            sampled[np.arange(len(at)), after - 1] = 1 - share
            sampled[np.arange(len(at)), after] = share
            self._sampled[factor] = sampled
        return self._sampled[factor]

    def _reduced(self, histories: Results, factor: float) -> Array:
        """Return the numbers (T, K) that are compared."""
        parts = self.comparison.parts @ self._points(factor) if len(self.comparison.radii) else None
        columns = []
        for name in self.comparison.names:
            values = histories[name]
            columns.append(
                values[:, None] if parts is None or values.ndim < 2 else values @ parts.T
            )
        return np.concatenate(columns, axis=1)

    def _table(self, setting: Setting) -> Table:
        """Return the numbers that are compared, and the force last, on the ground of a setting."""
        if setting.ground == "layer" and not _computed(setting.layer):
            return self._between_layers(setting)
        factor = setting.radii / setting.radius
        key = (setting.ground, setting.layer, setting.swapped, factor)
        if key not in self._tables:
            histories = self.histories(setting)
            columns = self._reduced(histories, factor)
            values = np.column_stack([columns, histories["normal_force"]])
            growing = np.append(self._lengths, False)
            self._tables[key] = Table(self._grid, values, growing)
        return self._tables[key]

    def _between_layers(self, setting: Setting) -> Table:
        """Return what is linear in the logarithms of thickness and modulus between four layers."""
        values = np.zeros(1)
        for thickness, first in _neighbours(setting.layer[0], THICKNESSES):
            for stiffness, second in _neighbours(setting.layer[1], STIFFNESSES):
                corner = self._table(setting._replace(layer=(thickness, stiffness)))
                values = values + first * second * corner.values
        return Table(corner.times, values, corner.growing)

    @cached_property
    def _lengths(self) -> NDArray[np.bool_]:
        """(K,) whether a number is a displacement, a worn height or an indentation."""
        return np.isin(self.comparison.fields, LENGTHS)

    @cached_property
    def _depths(self) -> NDArray[np.bool_]:
        """(K,) whether it is a displacement or an indentation."""
        return np.isin(self.comparison.fields, ("displacement", "indentation"))

    @cached_property
    def _kind(self) -> Array:
        """(K,) 0 of lengths, 1 of pressures, 2 of forces."""
        kinds = {"pressure": 1, "normal_force": 2}
        return np.array([kinds.get(name, 0) for name in self.comparison.fields], dtype=int)

    @cached_property
    def _units(self) -> Array:
        """(K,) units of the numbers in those of the scene."""
        units = self.problem.units
        return np.array([getattr(units, QUANTITIES[name].unit) for name in self.comparison.fields])

    def scales(self, setting: Setting) -> tuple[float, float, float]:
        """Return by what lengths, pressures and forces differ, and how much faster time runs."""
        stiff, size, force = setting.stiffness, setting.radius, setting.force
        if self.pressed_by_force:
            return force / size / stiff, force / size**2, force
        return 1.0, stiff / size, stiff * size

    def own_times(self, setting: Setting, times: Array) -> Array:
        """Return non-dimensional times of our history at those of a setting."""
        late = setting.late / self.problem.units.time
        began = np.maximum(times * setting.time - late, 0.0)
        return began * (setting.wear * setting.stiffness / setting.radius)

    def predict(self, setting: Setting) -> Array:
        """Return the numbers (S, K) that are compared, in the units of the scene."""
        values = self._clamped(setting, self._table(setting)).at(
            self.own_times(setting, self.times)
        )
        scales = self.scales(setting)
        values, force = values[:, :-1] * np.array(scales)[self._kind], values[:, -1] * scales[2]
        if setting.ground == "ours":
            values = values * self._correction
        if setting.step:
            values = values + self.error_by_steps(setting.step)
        if setting.box or setting.depth:
            values = values + self._lift(setting, force)[:, None] * self._depths
        factors = setting.lengths, setting.pressure, setting.normal_force
        values = values * (np.array(factors)[self._kind] * self._units)
        if setting.units or setting.signs:
            values = values * self.fitted_factors(setting, values)
        return np.asarray(values)

    @cached_property
    def _correction(self) -> Array:
        """(S, K) ours over the tables, which are less accurate."""
        tabled = self._table(Setting()).at(self.times)[:, :-1] * self._units
        with np.errstate(all="ignore"):
            ratio = self.comparison.expected / tabled
        return np.where(np.abs(ratio - 1) < TABLES_ERR, ratio, 1.0)

    def _lift(self, setting: Setting, force: Array) -> Array:
        """Return by how much (T,) the surface lies deeper than in ours, by non-dimensional forces.

        A half-space that is clamped at a distance is displaced less, by one length.
        """
        low = setting.box * np.interp(self.problem.poisson_ratio, *CLAMPED)
        return np.asarray(setting.depth * setting.force - low * force / (2 * setting.stiffness))

    def _clamped(self, setting: Setting, table: Table) -> Table:
        """Return a history under our indentation, if the half-space is clamped."""
        given = self.problem.indentation
        if not setting.box or given is None:
            return table
        low = -float(self._lift(setting, np.array(setting.stiffness * setting.radius)))
        return table.lowered(low / given)

    def error_by_steps(self, step: float) -> Array:
        """Return the error (S, K) of implicit steps, or below 0 of explicit ones, of a length.

        Between lengths at which it is measured it is linear in the logarithm of the length, over
        the length.
        """
        lengths, errors = self._errors_by_steps
        place = np.interp(np.log(abs(step)), np.log(lengths), np.arange(len(lengths)))
        before = int(min(place, len(lengths) - 2))
        share = place - before
        over = errors[before] * (1 - share) + errors[before + 1] * share
        return np.asarray(step * over)

    @cached_property
    def _errors_by_steps(self) -> tuple[Array, Array]:
        """Lengths (L,) of implicit steps in the units of the scene, and errors (L, S, K) over them.

        Steps end at each time that is given.
        """
        comparison, wear, unit = self.comparison, self._own.wear, self.problem.units.time
        assert wear is not None  # a flat punch has one
        times = comparison.times / unit
        lengths = float(np.diff(times, prepend=0.0).max()) / STEPS
        sampler = Sampler(self._own_problem, wear.compliance.space, wear.compliance)
        force = {"normal_force": np.ones(len(comparison.rows))}
        exact, *stepped = (
            self._reduced(force | sampler.history(history[comparison.rows]), 1.0)
            for history in (
                wear.modal(times),
                *(wear.history(times, "implicit", length) for length in lengths.tolist()),
            )
        )
        errors = [of - exact for of in stepped]
        units = lengths * unit
        return units, np.stack(errors) / units[:, None, None]

    def fitted_factors(self, setting: Setting, values: Array) -> Array:
        """Return the sign and power of a thousand (K,) by which numbers of theirs differ.

        Lengths have one power.
        """
        comparison = self.comparison
        given, names = comparison.given, comparison.names
        theirs = np.where(given, comparison.observed, 0.0)
        values = np.where(given, values, 0.0)
        squares = [
            (first * second).sum(axis=0) @ comparison.members.T
            for first, second in ((theirs, theirs), (values, values), (theirs, values))
        ]
        with np.errstate(all="ignore"):
            logs = np.log10(squares[0] / squares[1]) / 2
        logs = np.where(np.isfinite(logs), logs, 0.0)
        length = np.isin(names, LENGTHS)
        logs[length] = logs[length].mean() if length.any() else 0.0
        powers = 1000.0 ** np.round(logs / 3) if setting.units else np.ones(len(names))
        signs = np.where(setting.signs & (squares[2] < 0), -1.0, 1.0)
        return np.asarray((powers * signs) @ comparison.members)

    def factors_by_name(self, setting: Setting) -> dict[str, float]:
        """Return the sign and power of a thousand by which each quantity of theirs differs."""
        values = self.predict(setting._replace(signs=False, units=False))
        factors = self.fitted_factors(setting, values)
        return dict(zip(self.comparison.fields, factors.tolist(), strict=True))

    def mean_history(self, setting: Setting, times: Array) -> dict[str, Array]:
        """Return every quantity (T,) at non-dimensional times, fields as means over the radius.

        In the units of the scene.
        """
        histories = self.histories(setting)
        columns = [of.mean(axis=1) if of.ndim == 2 else of for of in histories.values()]
        growing = np.isin(list(histories), LENGTHS)
        table = Table(self._grid, np.stack(columns, axis=1), growing)
        rows = self._clamped(setting, table).at(self.own_times(setting, times))
        lengths, pressure, force = self.scales(setting)
        scales = dict.fromkeys(LENGTHS, lengths) | {"pressure": pressure, "normal_force": force}
        found = {name: rows[:, column] * scales[name] for column, name in enumerate(histories)}
        for name in ("displacement", "indentation"):
            found[name] += self._lift(setting, found["normal_force"])
        units = self.problem.units
        return {name: of * getattr(units, QUANTITIES[name].unit) for name, of in found.items()}

    def pressure_ratio(self, setting: Setting) -> Array:
        """Return pressures (S, R) in a setting at their times and radii, over ours."""
        found = []
        for one in (setting, Setting()):
            pressures = self.histories(one)["pressure"] @ self._points(one.radii / one.radius).T
            table = Table(self._grid, pressures, np.zeros(pressures.shape[1], dtype=bool))
            found.append(table.at(self.own_times(one, self.times)) * self.scales(one)[1])
        with np.errstate(all="ignore"):
            ratio = found[0] / found[1] * setting.pressure
        ratio *= self.factors_by_name(setting).get("pressure", 1.0)
        return np.asarray(np.where(np.isfinite(ratio), ratio, 1.0))


def _computed(layer: tuple[float, float]) -> bool:
    """Return whether a layer is one of those that are computed."""
    return layer[0] in THICKNESSES and layer[1] in STIFFNESSES


def _neighbours(size: float, sizes: tuple[float, ...]) -> list[tuple[float, float]]:
    """Return the computed sizes on both sides of a size, each with its share."""
    place = float(np.interp(np.log(size), np.log(sizes), np.arange(len(sizes))))
    before = min(int(place), len(sizes) - 2)
    return [(sizes[before], 1 - place + before), (sizes[before + 1], place - before)]
