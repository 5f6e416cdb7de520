"""A shaped punch once all of its face carries: the rest is linear, and exact in time.

The modes of the pencil (A, K) give ``A p' = d' b - K p`` at any time, as those of a flat punch do
(`full_contact.py`).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..problem.loading import Loading
from ..wear.full_contact import RunningIn
from ..wear.history import History, Moment
from ..wear.unilateral import Load

# instants after the last time asked for at which contact has to stay full
INSTANTS = 64


@dataclass(frozen=True, eq=False)
class FullFace:
    """The face of a shaped punch, all of which carries.

    Parameters
    ----------
    compliance : on a space of degree 1
    wear_coefficients : (N,) or (2, N) of the rings of that space
    moments : (size,) of the initial profile
    load : greatest force, or indentation
    loading : part of that force, and the sliding speed, over time
    """

    compliance: Compliance
    wear_coefficients: Array
    moments: Array
    load: Load
    loading: Loading

    @cached_property
    def running_in(self) -> RunningIn:
        """The modes in which the pressure tends to its steady state."""
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

    def history_since(self, since: Moment, times: Array) -> History:
        """Return the history at times after a moment, if contact stays full."""
        force = 1.0 if self.load.force is None else since.press.force
        worn = self.compliance.space.mass(self.wear_coefficients) @ since.integral
        return self.running_in.from_full_contact(
            self.loading.at(times).distance, since.distance, since.work, self.moments, worn, force
        )

    def history_if_full(self, since: Moment, times: Array) -> History | None:
        """Return the history at times if contact stays full from a moment on; None otherwise.

        After these times the history has `INSTANTS` more, between that moment and the last time.
        There, it holds the times themselves in place of their sliding distances.
        """
        slowed, after = float(self.loading.speeds[-1]), times - since.time
        fastest = float(self.running_in.relaxation_times[-1]) / slowed
        # contact is full while no pressure is negative
        between = since.time + np.geomspace(min(fastest, after[0]), after[-1], INSTANTS)
        history = self.history_since(since, np.append(times, between))
        if history.pressure.min() < 0:
            return None
        distances = np.append(history.distances[: len(times)], between)
        return replace(history, distances=distances)

    def remainder(self, times: Array, indentation: Array, force: Array) -> Array:
        """Return how far the punch is from where wear tends to, at times (T,).

        By the approach less steady wear, which may cross that, or by the force at a fixed
        indentation.
        """
        if self.load.force is None:
            return force
        greatest, steady = self.load.force, self.running_in.steady
        limit = steady.pressure @ (greatest * steady.moments + self.moments)
        return np.asarray(indentation - greatest * steady.wear_rate * times - limit)
