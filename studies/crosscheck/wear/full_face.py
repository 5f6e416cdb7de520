"""Compute the history of a shaped punch once all of its face is in contact.

From then on the problem is linear. The modes of the pencil (A, K) solve ``A p' = d' b - K p``
exactly at any time, as for a flat punch (`full_contact.py`).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....meshes.compliance import Compliance
from ....meshes.radial import Array
from ..problem.loading import Loading
from .full_contact import RunningIn
from .history import History, Instant
from .unilateral import Load

# number of additional times, between the beginning of full contact and the last requested time, at
# which the pressure is checked to be positive
INSTANTS = 64


@dataclass(frozen=True, eq=False)
class FullFace:
    """The face of a shaped punch in full contact.

    Parameters
    ----------
    compliance : Compliance
        Compliance on a space of degree 1.
    wear_coefficients : (N,) or (2, N) array
        Wear coefficient of each ring of that space; or those at the inner and outer edge of each
        ring, linear between.
    moments : (size,) array
        Moments of the initial profile.
    load : Load
        Greatest force, or indentation.
    loading : Loading
        Force over the greatest force, and sliding speed, over time.
    """

    compliance: Compliance
    wear_coefficients: Array
    moments: Array
    load: Load
    loading: Loading

    @cached_property
    def running_in(self) -> RunningIn:
        """The relaxation modes and the steady state of the full face."""
        return RunningIn(
            self.compliance,
            self.wear_coefficients,
            continuous=False,
            indentation=self.load.indentation,
        )

    @property
    def slowest_time(self) -> float:
        """The slowest relaxation time."""
        return float(self.running_in.slowest_times[0])

    def history_since(self, start: Instant, times: Array) -> History:
        """Return the history at times (T,) after `start`, provided that contact stays full."""
        force = 1.0 if self.load.force is None else start.press.force
        worn = self.compliance.space.mass(self.wear_coefficients) @ start.integral
        distances = self.loading.at(times).distance
        return self.running_in.from_full_contact(
            times, distances, start.distance, start.work, self.moments, worn, force
        )

    def history_if_full(self, start: Instant, times: Array) -> History | None:
        """Return the history at times (T,) if contact stays full after `start`; otherwise None.

        The history also contains `INSTANTS` additional times between `start` and the last time,
        appended after the requested ones.
        """
        final_speed, elapsed = float(self.loading.speeds[-1]), times - start.time
        fastest_time = float(self.running_in.relaxation_times[-1]) / final_speed
        # contact stays full if no pressure becomes negative
        check_times = start.time + np.geomspace(
            min(fastest_time, elapsed[0]), elapsed[-1], INSTANTS
        )
        history = self.history_since(start, np.append(times, check_times))
        return None if history.pressure.min() < 0 else history

    def even_wear(self, times: Array) -> Array:
        """Return the depth (T,) that a constant force wears at the steady rate until some times."""
        return (self.load.force or 0.0) * self.running_in.steady.wear_rate * times

    def remainder(self, depth: Array, force: Array) -> Array:
        """Return the remaining change to the steady state at T times.

        Under a force it is ``d(t) - w t`` minus its limit, with the steady wear rate w; it may
        change its sign. At a fixed indentation it is the force.

        Parameters
        ----------
        depth : (T,) array
            Indentation less the even wear.
        force : (T,) array
            Force.
        """
        if self.load.force is None:
            return force
        steady = self.running_in.steady
        limit = steady.pressure @ (self.load.force * steady.moments + self.moments)
        return np.asarray(depth - limit)
