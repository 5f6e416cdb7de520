"""Hold the result of a march of a punch whose contact opens, closes and spreads."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....meshes.pressure_space import PressureSpace
from ....meshes.radial import Array
from .full_face import FullFace
from .history import History, Instant, Steps
from .unilateral import Mask, Press

# contact area over that of the face from which contact counts as full; the difference is roundoff
FULL_AREA = 1 - 1e-12
# time in full contact, over the slowest relaxation time, after which what edges of the contact have
# left in the shape of the face has decayed to less than 1e-10
SETTLED = 24.0


@dataclass(frozen=True, eq=False)
class Marched:
    """The result of a march of a punch whose contact opens, closes and spreads.

    Parameters
    ----------
    times : (T,) array
        Requested times.
    instants : tuple of Instant
        States at the start and after each adaptive step; or at the requested times, if the march
        takes equal steps.
    estimate_times : (W,) array
        Times at which errors are estimated: the requested times and some between.
    estimate_history : History
        History at these times.
    face : FullFace
        The punch in full contact.
    path : (S, 4) array
        Time, indentation, force, and contact area over that of the face, at the start and after
        each step.
    full_since : Instant, optional
        State after the step from which all of the face stays in contact, if there is one.
    later : History, optional
        History in full contact after the steps, at 64 times.
    """

    times: Array
    instants: tuple[Instant, ...]
    estimate_times: Array
    estimate_history: History
    face: FullFace
    path: Array
    full_since: Instant | None = None
    later: History | None = None

    @cached_property
    def history(self) -> History:
        """The history at the requested times."""
        return self.estimate_history[np.flatnonzero(np.isin(self.estimate_times, self.times))]

    @property
    def between(self) -> History:
        """The history after every step, continued in full contact."""
        history = history_of_instants(self.instants, self.face)
        return history if self.later is None else history.then(self.later)

    @property
    def space(self) -> PressureSpace:
        """The pressure space of the march."""
        return self.face.compliance.space

    @cached_property
    def time_of_full_contact(self) -> float:
        """The time from which all of the face stays in contact; NaN if there is none.

        It lies between the ends of two steps and is found by extrapolating the contact area
        linearly from the last two steps in partial contact.
        """
        if self.full_since is None:
            return np.nan
        times, _, _, areas = self.path.T
        partial = np.flatnonzero(areas < FULL_AREA)
        if len(partial) < 2 or partial[-1] + 1 == len(times):
            return self.full_since.time
        last = partial[-1]
        growth = (areas[last] - areas[last - 1]) / (times[last] - times[last - 1])
        ahead = (1 - areas[last]) / growth if growth > 0 else np.inf
        return float(min(times[last] + ahead, times[last + 1]))

    def settled(self, times: Array) -> Mask:
        """Return at which times (T,) nothing is left of what edges of the contact did to the face.

        The whole face has then been in contact for `SETTLED` times its slowest relaxation time,
        under a constant load.
        """
        loading = self.face.loading
        since = np.inf if loading.varies else self.time_of_full_contact
        return np.asarray(times > since + SETTLED * self.face.slowest_time)

    @property
    def always_full(self) -> bool:
        """Whether all of the face is in contact at every step."""
        return bool((self.path[:, 3] >= FULL_AREA).all())

    def remainder(self) -> tuple[Array, Array]:
        """Return the times of the steps (S,), and the remaining change to the limit then (S,)."""
        times, depth, force, _ = self.path.T
        return times, self.face.remainder(depth - self.face.even_wear(times), force)

    def remainder_in_full_contact(self, times: Array) -> Array:
        """Return the remaining change to the limit at times (T,) in full contact.

        Raises
        ------
        ValueError
            if contact has never become full
        """
        if self.full_since is None:
            raise ValueError("contact has not become full")
        history = self.face.history_since(self.full_since, times)
        return self.face.remainder(history.depth, history.force)


def path_row(time: float, press: Press, weights: Array) -> tuple[float, float, float, float]:
    """Return a row of `Marched.path`: time, indentation, force, and relative contact area.

    Parameters
    ----------
    time : float
        Time of the row.
    press : Press
        Solution of the contact problem.
    weights : (size,) array
        Area of each node.
    """
    area = float(weights[press.contact].sum() / weights.sum())
    return time, press.indentation, press.force, area


def history_of_instants(
    instants: Sequence[Instant], face: FullFace, steps: Steps | None = None
) -> History:
    """Return the history that consists of the states at T instants.

    Parameters
    ----------
    instants : sequence of Instant
        States of the punch.
    face : FullFace
        Face of the punch.
    steps : Steps, optional
        Statistics of the march.
    """
    space = face.compliance.space
    integrals = np.reshape([instant.integral for instant in instants], (-1, space.size))
    presses = [instant.press for instant in instants]
    return History(
        np.array([instant.time for instant in instants]),
        np.array([instant.distance for instant in instants]),
        np.reshape([press.pressure for press in presses], integrals.shape),
        integrals * space.at_vertices(face.wear_coefficients),
        np.array([press.indentation for press in presses]),
        np.array([press.force for press in presses]),
        np.reshape([press.gap for press in presses], integrals.shape),
        np.reshape([press.contact for press in presses], integrals.shape).astype(bool),
        np.zeros(len(presses)),
        space.uniform,
        steps=steps or Steps(),
    )
