"""Predict what another program would print in a given setting."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from ....meshes import Array
from ...crosscheck import QUANTITIES, Problem, Results, Sampler, UnitNames
from .comparison import Comparison
from .histories import LENGTHS, Histories, Solve
from .setting import Setting, computed_settings
from .table import Table

# numbers of time steps in the longest interval between results, at which the error of first-order
# steps is measured; integers, so that no step there is shorter than its nominal length
STEP_COUNTS = np.array([64.0, 48, 40, 32, 25, 20, 16, 13, 10, 8, 6, 5, 4, 3, 2])
# greatest number of times at which these steps end
MAX_STEP_ENDS = 1000
# part of the radius at which errors by large elements at the rim are predicted
RIM_PART = 0.02
# greatest relative difference of the tables to our results that is corrected by a factor
MAX_TABLE_ERROR = 0.02
# relative error of the start on a clamped half-space, times R / a, by Poisson's ratio (`study
# truncation`)
TRUNCATION_ERRORS = ([0, 0.3, 0.45, 0.5], [0.94, 1.09, 1.51, 1.91])


@dataclass(frozen=True, eq=False)
class Model:
    """A model of another program: it predicts the printed numbers from our histories.

    S, R, K and Q are the numbers of times, radii, compared numbers and quantities in a
    `Comparison`, T and M the numbers of times and radii of the tables.

    Parameters
    ----------
    comparison : results of the other program and ours
    solve : solves a problem
    """

    comparison: Comparison
    solve: Solve
    _tables: dict[object, Table] = field(default_factory=dict)
    _interpolations: dict[float, csr_matrix] = field(default_factory=dict)

    @property
    def problem(self) -> Problem:
        """The problem of the scene."""
        return self.comparison.scene.problem

    @property
    def names(self) -> UnitNames:
        """The units of the scene, in which numbers are written."""
        return self.comparison.scene.unit_names

    @property
    def flat(self) -> bool:
        """Whether the history scales with force, radius and modulus, as that of a flat punch."""
        return self.problem.full_contact and not self.problem.loading.varies

    @property
    def pressed_by_force(self) -> bool:
        """Whether the force is prescribed, not the indentation."""
        return self.problem.indentation is None

    @cached_property
    def at_indentation(self) -> bool:
        """Whether the other program prescribes the indentation, so that its forces may be wrong.

        It has solved the scene so if it prints forces, but no displacements, although the scene has
        a force: it prescribes our displacements, as decks do.
        """
        quantities = {*self.comparison.quantities}
        displaced = {"displacement", "indentation"} & quantities
        return not self.pressed_by_force or ("normal_force" in quantities and not displaced)

    @cached_property
    def times(self) -> Array:
        """(S,) non-dimensional times that are compared."""
        return self.comparison.times[self.comparison.time_rows] / self.problem.units.time

    @property
    def has_later_times(self) -> bool:
        """Whether times after the start are compared."""
        return bool((self.times > 0).any())

    @cached_property
    def _histories(self) -> Histories:
        """Our histories on all grounds, and of changed scenes."""
        return Histories(self.comparison.scene, self.times, self.solve)

    def histories(self, setting: Setting) -> Results:
        """Return fields (T, M) and numbers (T,) of a setting: `Histories.of`."""
        return self._histories.of(setting)

    def _interpolation(self, factor: float) -> csr_matrix:
        """Return the matrix (R, M) that interpolates from the M radii of the tables to theirs.

        The radii of the other program are multiplied by the factor.
        """
        if factor not in self._interpolations:
            radii, nodes = self.comparison.radii / self.problem.units.length, self._histories.radii
            radii = np.clip(radii * factor, nodes[0], nodes[-1])
            right = np.clip(np.searchsorted(nodes, radii), 1, len(nodes) - 1)
            fraction = (radii - nodes[right - 1]) / (nodes[right] - nodes[right - 1])
            rows = np.arange(len(radii))
            self._interpolations[factor] = csr_matrix(
                (
                    np.concatenate([1 - fraction, fraction]),
                    (np.concatenate([rows, rows]), np.concatenate([right - 1, right])),
                ),
                shape=(len(radii), len(nodes)),
            )
        return self._interpolations[factor]

    def _compared_numbers(self, histories: Results, factor: float) -> Array:
        """Return the numbers (T, K) that are compared, with radii times a factor."""
        means, columns = None, []
        if len(self.comparison.radii):
            means = (self._interpolation(factor).T @ self.comparison.part_means.T).T
        for name in self.comparison.quantities:
            values = histories[name]
            reduced = values[:, None] if means is None or values.ndim < 2 else values @ means.T
            columns.append(reduced)
        return np.concatenate(columns, axis=1)

    def _table(self, setting: Setting) -> Table:
        """Return the compared numbers, and the force in the last column, on a setting's ground."""
        (first, _), *more = nodes = computed_settings(setting)
        if more:
            tables = [(self._table(node), weight) for node, weight in nodes]
            values = np.sum([weight * table.values for table, weight in tables], axis=0)
            return replace(tables[0][0], values=values)
        setting = first
        factor = setting.table_radii / setting.radius
        key = (setting.ground, setting.layer, setting.swapped, setting.scene_change, factor)
        if key not in self._tables:
            histories = self.histories(setting)
            columns = self._compared_numbers(histories, factor)
            values = np.column_stack([columns, histories["normal_force"]])
            growing = np.append(self._is_length, False)
            self._tables[key] = Table(self._histories.times, values, growing)
        return self._tables[key]

    @cached_property
    def _is_length(self) -> NDArray[np.bool_]:
        """(K,) whether a number is a displacement, a worn height or an indentation."""
        return np.isin(self.comparison.column_names, LENGTHS)

    @cached_property
    def _is_depth(self) -> NDArray[np.bool_]:
        """(K,) whether a number is a displacement or an indentation."""
        return np.isin(self.comparison.column_names, ("displacement", "indentation"))

    @cached_property
    def _kind(self) -> Array:
        """(K,) 0 for lengths, 1 for pressures, 2 for forces."""
        kinds = {"pressure": 1, "normal_force": 2}
        return np.array([kinds.get(name, 0) for name in self.comparison.column_names], dtype=int)

    @cached_property
    def _units(self) -> Array:
        """(K,) units of the non-dimensional numbers, in the units of the scene."""
        units, names = self.problem.units, self.comparison.column_names
        return np.array([getattr(units, QUANTITIES[name].unit) for name in names])

    def scales(self, setting: Setting) -> tuple[float, float, float]:
        """Return the factors of a setting on lengths, pressures and forces."""
        stiff, size, force = setting.stiffness, setting.radius, setting.force
        if self.pressed_by_force:
            return force / size / stiff, force / size**2, force
        return 1.0, stiff / size, stiff * size

    def history_times(self, setting: Setting, times: Array) -> Array:
        """Return the times (S,) of our history for those of a setting, both non-dimensional."""
        delay = setting.start_delay / self.problem.units.time
        since_start = np.maximum(times * setting.table_time - delay, 0.0)
        return since_start * (setting.wear * setting.stiffness / setting.radius)

    def predict(self, setting: Setting) -> Array:
        """Return the numbers (S, K) that are compared, in the units of the scene."""
        table = self._table_if_clamped(setting, self._table(setting))
        values = table.at(self.history_times(setting, self.times))
        if any(setting.rim):
            values = values + self._rim_errors(setting)
        if setting.truncation and self.at_indentation and self.pressed_by_force:
            # the same displacements press as if the flat punch were deeper by the lowered length
            depth = -self._added_depth(setting._replace(stiffness=1.0), values[:, -1])
            start = self._table(setting).values[0]
            values = values + np.outer(
                depth / self._start_depth, np.where(np.append(self._is_length, False), 0.0, start)
            )
        scales = self.scales(setting)
        values, force = values[:, :-1] * np.array(scales)[self._kind], values[:, -1] * scales[2]
        if setting.ground == "ours":
            values = values * self._table_correction
        if setting.step:
            values = values + self.time_step_error(setting.step)
        lowered = setting.truncation and not (self.at_indentation and self.pressed_by_force)
        if lowered or setting.depth_offset:
            values = values + self._added_depth(setting, force)[:, None] * self._is_depth
        factors = setting.lengths, setting.pressure, setting.normal_force
        values = values * (np.array(factors)[self._kind] * self._units)
        if setting.column[0]:
            own = np.array(self.comparison.column_names) == setting.column[0]
            values = values * np.where(own, setting.column[1], 1.0)
        if setting.units or setting.signs:
            values = values * self.fitted_factors(setting, values)
        return np.asarray(values)

    @cached_property
    def _table_correction(self) -> Array:
        """(S, K) our results over the tables, which are less accurate; 1 if they differ much."""
        values = self._table(Setting()).at(self.times)[:, :-1] * self._units
        with np.errstate(all="ignore"):
            ratio = self.comparison.expected / values
        return np.where(np.abs(ratio - 1) < MAX_TABLE_ERROR, ratio, 1.0)

    @cached_property
    def _start_depth(self) -> float:
        """The first indentation, non-dimensional."""
        return float(self.histories(Setting())["indentation"][0])

    def _rim_errors(self, setting: Setting) -> Array:
        """Return the errors (S, K + 1) by large elements at the rim.

        The first pressures are those of a greater punch; displacements are lower by this part, or
        forces higher if the indentation is prescribed. The errors decrease like the pressure near
        the rim. The last column is the force.
        """
        part, next_to_rim = setting.rim
        right = setting._replace(rim=(0.0, 0.0))
        greater = right._replace(table_radii=setting.table_radii / (1 + RIM_PART))
        start, of_greater = (self._table(each).values[0] for each in (right, greater))
        # by kind: pressures, displacements, worn heights, which have no error, and forces
        pressure, length, depth = (
            np.append(which, False) for which in (self._kind == 1, self._is_length, self._is_depth)
        )
        errors = np.where(pressure, (of_greater / (1 + RIM_PART) ** 2 - start) / RIM_PART, 0.0)
        errors += (
            np.where(~length, start, 0.0) if self.at_indentation else np.where(depth, -start, 0)
        )
        errors *= part
        if pressure.any():
            last = np.flatnonzero(pressure)[-1]
            errors[last] += next_to_rim * start[last]
        near_rim = self.histories(right)["pressure"][
            :, np.searchsorted(self._histories.radii, 1 - RIM_PART)
        ]
        decrease = (near_rim - near_rim[-1]) / (near_rim[0] - near_rim[-1])
        times = self.history_times(setting, self.times)
        return np.outer(np.interp(times, self._histories.times, decrease), errors)

    def _added_depth(self, setting: Setting, force: Array) -> Array:
        """Return the depth (S,) by which the surface lies deeper than ours, at forces (S,).

        Both are non-dimensional. A half-space that is clamped at a distance is displaced less, by
        the same length everywhere, so that this depth is negative.
        """
        low = setting.truncation * np.interp(self.problem.poisson_ratio, *TRUNCATION_ERRORS)
        offset = setting.depth_offset * setting.force
        return np.asarray(offset - low * force / (2 * setting.stiffness))

    def _table_if_clamped(self, setting: Setting, table: Table) -> Table:
        """Return the history at a prescribed indentation on a half-space that is clamped.

        Without clamping, or under a prescribed force, the table is returned as it is.
        """
        indentation = self.problem.indentation
        if not setting.truncation or indentation is None:
            return table
        low = -float(self._added_depth(setting, np.array(setting.stiffness * setting.radius)))
        return table.with_lowered_surface(low / indentation)

    def time_step_error(self, step: float) -> Array:
        """Return the error (S, K) of implicit time steps of a length, or of explicit ones if < 0.

        The error over the length is measured at some lengths, and linear in the logarithm of the
        length between them.
        """
        lengths, errors = self._time_step_errors
        position = np.interp(np.log(abs(step)), np.log(lengths), np.arange(len(lengths)))
        lower = int(min(position, len(lengths) - 2))
        fraction = position - lower
        error_over_length = errors[lower] * (1 - fraction) + errors[lower + 1] * fraction
        return np.asarray(step * error_over_length)

    @cached_property
    def _time_step_errors(self) -> tuple[Array, Array]:
        """Lengths (L,) of implicit steps in the units of the scene; errors (L, S, K) over them.

        A step ends at each time of the other program, or at `MAX_STEP_ENDS` of them.
        """
        unit, comparison = self.problem.units.time, self.comparison
        _, wear = self._histories.solution
        assert wear is not None  # the solution of a flat punch has it
        count, compared = len(comparison.times), comparison.time_rows
        spread = np.linspace(0, count - 1, min(count, MAX_STEP_ENDS)).round().astype(int)
        ends = np.union1d(spread, compared)
        times, rows = comparison.times[ends] / unit, np.searchsorted(ends, compared)
        lengths = float(np.diff(times, prepend=0.0).max()) / STEP_COUNTS
        sampler = Sampler(self._histories.problem, wear.compliance.space, wear.compliance)
        force = {"normal_force": np.ones(len(compared))}
        exact, *stepped = (
            self._compared_numbers(force | sampler.history(history[rows]), 1.0)
            for history in (
                wear.modal(times),
                *(wear.history(times, "implicit", length) for length in lengths.tolist()),
            )
        )
        errors = [numbers - exact for numbers in stepped]
        scene_lengths = lengths * unit
        return scene_lengths, np.stack(errors) / scene_lengths[:, None, None]

    def fitted_factors(self, setting: Setting, values: Array) -> Array:
        """Return the sign and the power of a thousand (K,) that fit the other program best.

        They multiply predicted values (S, K). All lengths have the same power, unless columns have
        their own units.
        """
        comparison = self.comparison
        present, quantities = comparison.present, comparison.quantities
        theirs = np.where(present, comparison.observed, 0.0)
        values = np.where(present, values, 0.0)
        squares = [
            (first * second).sum(axis=0) @ comparison.membership.T
            for first, second in ((theirs, theirs), (values, values), (theirs, values))
        ]
        with np.errstate(all="ignore"):
            logs = np.log10(squares[0] / squares[1]) / 2
        logs = np.where(np.isfinite(logs), logs, 0.0)
        length = np.isin(quantities, LENGTHS)
        if setting.units != "columns":
            logs[length] = logs[length].mean() if length.any() else 0.0
        powers = 1000.0 ** np.round(logs / 3) if setting.units else np.ones(len(quantities))
        signs = np.where(setting.signs & (squares[2] < 0), -1.0, 1.0)
        return np.asarray((powers * signs) @ comparison.membership)

    def factors_by_name(self, setting: Setting) -> dict[str, float]:
        """Return the fitted sign and power of a thousand of each quantity: `fitted_factors`."""
        values = self.predict(setting._replace(signs=False, units=""))
        factors = self.fitted_factors(setting, values)
        return dict(zip(self.comparison.column_names, factors.tolist(), strict=True))

    def mean_history(self, setting: Setting, times: Array) -> dict[str, Array]:
        """Return every quantity (N,) at non-dimensional times (N,), in the units of the scene.

        Fields are averaged over the radii of the tables.
        """
        histories = self.histories(setting)
        columns = [each.mean(axis=1) if each.ndim == 2 else each for each in histories.values()]
        growing = np.isin(list(histories), LENGTHS)
        table = Table(self._histories.times, np.stack(columns, axis=1), growing)
        rows = self._table_if_clamped(setting, table).at(self.history_times(setting, times))
        lengths, pressure, force = self.scales(setting)
        scales = dict.fromkeys(LENGTHS, lengths) | {"pressure": pressure, "normal_force": force}
        means = {name: rows[:, column] * scales[name] for column, name in enumerate(histories)}
        for name in ("displacement", "indentation"):
            means[name] += self._added_depth(setting, means["normal_force"])
        units = self.problem.units
        return {name: each * getattr(units, QUANTITIES[name].unit) for name, each in means.items()}

    def pressure_ratio(self, setting: Setting) -> Array:
        """Return the pressures (S, R) of a setting at their times and radii, over ours."""
        pressure_pair = []
        for each in (setting, Setting()):
            pressures = self.histories(each)["pressure"]
            table = Table(
                self._histories.times, pressures, np.zeros(pressures.shape[1], dtype=bool)
            )
            at_times = table.at(self.history_times(each, self.times)) * self.scales(each)[1]
            interpolation = self._interpolation(each.table_radii / each.radius)
            pressure_pair.append((interpolation @ at_times.T).T)
        with np.errstate(all="ignore"):
            ratio = pressure_pair[0] / pressure_pair[1] * setting.pressure
        ratio *= self.factors_by_name(setting).get("pressure", 1.0)
        return np.asarray(np.where(np.isfinite(ratio), ratio, 1.0))
