"""Compute our histories at the times and radii of the tables, on all grounds."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from ....meshes import HALF_SPACE, Array
from ...crosscheck import QUANTITIES, Problem, Results, Rings, RunningIn, Scene
from . import grounds
from .setting import Setting, computed_settings
from .table import Table

# discretisation of the interpolated tables: rtol of the solution, least number of radii on a ring,
# and about the least number of radii on all rings
TABLE_RTOL, MIN_RING_RADII, MIN_RADII = 1e-3, 6, 100
# rtol of changed scenes, whose results are interpolated
CHANGED_RTOL = 1e-2
# times of the tables: from this part of the first time after the start, to this multiple of the
# last time, and their number; beyond them tables are extrapolated
TABLE = (1e-2, 4.0, 80)
# the same for the unchanged scene in full contact: times may be in minutes or hours, not in seconds
WIDE_TABLE = (2e-4, 5e3, 160)
# greatest number of rings up to which wide tables, and solutions of changed scenes, are affordable
MAX_RINGS = 24
Solve: TypeAlias = Callable[[Problem], tuple[Results, RunningIn | None]]
"""A function that returns the results of a problem and, in full contact, the running-in."""
LENGTHS = ("displacement", "profile", "indentation")
PRINTED = (*LENGTHS, "pressure", "normal_force")


@dataclass(frozen=True, eq=False)
class Histories:
    """Histories of a scene, and of changes of it, each computed once.

    T and M are the numbers of times and radii of the tables. All numbers are non-dimensional, in
    the units of the unchanged scene.

    Parameters
    ----------
    scene : that both programs have solved
    compared_times : (S,) non-dimensional times that are compared
    solve : solves a problem
    """

    scene: Scene
    compared_times: Array
    solve: Solve
    _computed: dict[object, Results] = field(default_factory=dict)

    @cached_property
    def radii(self) -> Array:
        """Non-dimensional radii of the tables, between the ring edges and dense beside them."""
        edges = self._unchanged.ring_edges
        count = max(MIN_RING_RADII, MIN_RADII // (len(edges) - 1))
        fractions = (1 - np.cos(np.pi * np.linspace(0.01, 0.99, count))) / 2
        inner, outer = edges[:-1, None], edges[1:, None]
        return np.asarray((inner + (outer - inner) * fractions).ravel())

    @cached_property
    def times(self) -> Array:
        """(T,) non-dimensional times of the tables."""
        few_rings = len(self._unchanged.ring_edges) <= MAX_RINGS + 1
        is_wide = self._unchanged.full_contact and few_rings
        return self._times_of_table(*(WIDE_TABLE if is_wide else TABLE))

    @cached_property
    def _changed_times(self) -> Array:
        """Times of the tables at which changed scenes are solved."""
        return self._times_of_table(*TABLE)

    def _times_of_table(self, start: float, end: float, count: int) -> Array:
        """Return the start, `count` times, and the compared ones.

        The times lie between `start` times the first and `end` times the last compared time after
        the start.
        """
        later = self.compared_times[self.compared_times > 0]
        if not len(later):
            return np.append(0.0, np.geomspace(1e-6, 1e-3, 4))
        between = np.geomspace(start * later.min(), end * later.max(), count)
        return np.unique(np.concatenate([[0.0], between, later]))

    @property
    def _unchanged(self) -> Problem:
        """The problem of the scene."""
        return self.scene.problem

    @cached_property
    def problem(self) -> Problem:
        """The problem of the scene at the times, radii and accuracy of the tables."""
        return self._sampled(self._unchanged)

    def _sampled(self, problem: Problem) -> Problem:
        """Return a problem at the times, radii and accuracy of the tables."""
        return replace(
            problem,
            rtol=TABLE_RTOL,
            steady=False,
            quantities=frozenset(PRINTED),
            compared_on=None,
            times=self.times,
            output_radii=self.radii,
        )

    @cached_property
    def solution(self) -> tuple[Results, RunningIn | None]:
        """Our results for the tables and, in full contact, the running-in."""
        return self.solve(self.problem)

    def _history_of_changed_scene(self, setting: Setting) -> Results:
        """Return the history of a changed scene, in the non-dimensional units of the scene."""
        change = setting.scene_change
        assert change is not None  # because the caller has checked it
        changed = change.change(self.scene, change.size).problem
        changed_units, units, times = changed.units, self.problem.units, self._changed_times
        problem = replace(
            self._sampled(changed),
            rtol=CHANGED_RTOL,
            times=times * (units.time / changed_units.time),
            output_radii=self.radii * (units.length / changed_units.length),
        )
        if setting.swapped:
            problem = replace(problem, rings=swapped(problem.rings))
        results = _printed(self.solve(problem)[0], problem)
        histories = Results()
        for name, values in results.items():
            kind = QUANTITIES[name].unit
            factor = getattr(changed_units, kind) / getattr(units, kind)
            columns = values.reshape(len(times), -1) * factor
            growing = np.full(columns.shape[1], name in LENGTHS)
            at_all_times = Table(times, columns, growing).at(self.times)
            histories[name] = at_all_times.reshape(len(self.times), *values.shape[1:])
        return histories

    def of(self, setting: Setting) -> Results:
        """Return fields (T, M) and numbers (T,) on the ground, or in the scene, of a setting.

        They are non-dimensional; the exchange of materials is included.
        """
        if setting.scene_change:
            (setting, _), *more = nodes = computed_settings(setting)
            if more:
                histories = [(self.of(node), weight) for node, weight in nodes]
                return {
                    name: np.sum([weight * each[name] for each, weight in histories], axis=0)
                    for name in histories[0][0]
                }
        key = (setting.ground, setting.layer, setting.swapped, setting.scene_change)
        if key not in self._computed:
            self._computed[key] = self._history_on_ground(setting)
        return self._computed[key]

    def _history_on_ground(self, setting: Setting) -> Results:
        if setting.scene_change:
            return self._history_of_changed_scene(setting)
        rings, problem = self.problem.graded or self.problem.rings, self.problem
        if setting.swapped:
            rings = swapped(rings)
            problem = replace(problem, rings=rings)
        if setting.ground == "homogeneous":
            problem = replace(problem, ground=HALF_SPACE)
        if setting.ground in ("ours", "homogeneous"):
            results, _ = self.solution if problem is self.problem else self.solve(problem)
            return _printed(results, problem)
        ground = grounds.plane_strain(rings)
        if setting.ground == "layer":
            ground = grounds.layered(rings, *setting.layer, self.problem.poisson_ratio)
        points = grounds.elements(rings.ring_edges)
        element = np.clip(np.searchsorted(points, self.radii) - 1, 0, len(points) - 2)
        pressure, worn, depth = ground.history(self.times)
        profile = worn[:, element]
        return {
            "pressure": pressure[:, element],
            "profile": profile,
            "displacement": depth[:, None] - profile,
            "indentation": depth,
            "normal_force": np.ones(len(depth)),
        }


def swapped(rings: Rings) -> Rings:
    """Return rings with the greatest and the least wear coefficient exchanged."""
    wear = rings.wear_coefficients
    return rings._replace(wear_coefficients=wear.min() + wear.max() - wear)


def _printed(results: Results, problem: Problem) -> Results:
    """Return the compared quantities (T, ...) of results, with the force if prescribed."""
    prescribed = {"normal_force": problem.loading.at(problem.times).force}
    return {name: np.asarray((prescribed | results)[name]) for name in PRINTED}
