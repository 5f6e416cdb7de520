"""Solve a punch whose contact opens, closes or spreads, by one march that is sampled at any time.

Non-dimensional. Under a constant load, a march is computed in the unit of time in which the first
wear coefficient is 1.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator, make_smoothing_spline

from ...mdr import energy
from ...meshes import Array
from ..crosscheck import MovingContact, Problem, Sampler, choose_spaces

# number of times per decade at which a march is sampled, and factor by which it begins before and
# ends after the times that are needed
TIMES_PER_DECADE, TIME_SPAN = 12, 4.0
# relative difference of two times below which they are the same
ROUNDOFF = 1e-9
# number of radii, besides those of the data, between which fields are linear
RADII = 100
# name of the width of the cell at the edge of the contact, among the results
CELL = "contact_cell"
# quantities that are known to a part of a cell
EDGES = ("contact_radius", "scar_diameter")
# a function of time
Curve: TypeAlias = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class March:
    """A march, interpolated in time and along the radius.

    Parameters
    ----------
    clock : unit of its times, in non-dimensional times of the problem
    earliest, latest : range of the times after 0 at which it can be evaluated
    radii : (R,) increasing, at which fields are sampled
    results : (T, R), (T,) or (T, rings) by quantity
    times : (T,)
    smooth : whether the history is smooth in the fourth root of time: under a constant load the
        contact radius grows approximately with this root from a contact at a point
    """

    clock: float
    earliest: float
    latest: float
    radii: Array
    results: dict[str, Array]
    times: Array
    smooth: bool

    @classmethod
    def compute(
        cls, problem: Problem, clock: float, earliest: float, latest: float, radii: Array
    ) -> "March":
        """Return the march of a problem.

        Parameters
        ----------
        problem : at whose tolerance it is computed
        clock : unit of the times, in non-dimensional times of the problem
        earliest, latest : first and last time after the start that are needed
        radii : at which fields are needed exactly
        """
        earliest, latest = earliest / TIME_SPAN, latest * TIME_SPAN
        decades = np.log10(latest / earliest)
        times = np.geomspace(earliest, latest, int(np.ceil(TIMES_PER_DECADE * decades)) + 2)
        if problem.loading.varies:
            knots = problem.loading.times[1:] / clock
            own = np.union1d(knots, problem.times / clock)
            times = np.union1d(times, own[(own > earliest) & (own < latest)])
            # times that differ only by the roundoff of units are one time
            times = times[np.diff(times, prepend=0.0) > ROUNDOFF * times]
        times = np.append(0.0, times)
        even = np.linspace(problem.inner_radius, 1.0, RADII + 2)[1:-1]
        radii = np.union1d(even, radii[(radii >= problem.inner_radius) & (radii <= 1)])
        # for other parameters, contact may be lost
        problem = replace(
            problem,
            times=times * clock,
            steady=False,
            quantities=None,
            keeps_contact=False,
            output_radii=radii,
        )
        compliance = energy.compliance(choose_spaces(problem).fine, problem.ground)
        history = MovingContact(problem, compliance).history
        results = Sampler(problem, compliance.space, compliance).history(history)
        forces = np.asarray(history.force, dtype=float)
        results["normal_force"], results["worn_volume"] = forces, results["ring_worn_volume"]
        # a scar does not become smaller under a force that falls
        radius = results["contact_radius"]
        results["scar_diameter"] = 2 * np.maximum.accumulate(radius)
        cells = compliance.space.breakpoints
        last = np.clip(np.searchsorted(cells, radius), 1, len(cells) - 1)
        results[CELL] = np.diff(cells)[last - 1]
        return cls(clock, earliest, latest, radii, results, times, not problem.loading.varies)

    @cached_property
    def _curves(self) -> dict[str, Curve]:
        return {}

    def _curve(self, name: str) -> Curve:
        if name not in self._curves:
            values = self.results[name]
            if self.smooth and name != "pressure":
                roots = self.times**0.25
                if name in EDGES:
                    # an edge of the contact is located to a part of a cell
                    spline = make_smoothing_spline(roots, values)
                else:
                    spline = CubicSpline(roots, values, axis=0)
                self._curves[name] = lambda times: np.asarray(spline(times**0.25))
            else:
                # without overshooting where the load has a kink, or contact begins
                self._curves[name] = PchipInterpolator(self.times, values, axis=0)
        return self._curves[name]

    def sample(
        self, times: Array, radii: Array, step: float = 0.0, names: Collection[str] = ()
    ) -> dict[str, Array]:
        """Return quantities by name, as `modes.FlatHistory.sample` does; steps have no effect."""
        results, own_times = {}, np.minimum(times / self.clock, self.latest)
        for name in names:
            values = self._curve(name)(own_times)
            if name in ("pressure", "profile", "displacement"):
                values = np.array([np.interp(radii, self.radii, row) for row in values])
            results[name] = values
        return results
