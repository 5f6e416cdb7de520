"""What a march of a contact that opens, closes and spreads has yielded: a value."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array
from ..wear.history import History, Moment, Steps
from ..wear.unilateral import Press
from .full_face import FullFace

# part of the face that may be missing from the area of contact by roundoff
WHOLE = 1 - 1e-12


@dataclass(frozen=True, eq=False)
class Marched:
    """A march of a punch whose contact opens, closes and spreads.

    Parameters
    ----------
    times : (T,) asked for
    moments : at the start and, in adaptive steps, after each of them; else at the times asked for
    watched_times : (W,) the times asked for, and some between, where errors are estimated
    watched : the history at these
    face : what the punch does once all of its face carries
    path : (S, 4) time, indentation, force, and area of contact over that of the face, at the start
        and after each step
    full_since : the step since which all of the face carries for good, if there is one
    later : from then on, the history after the steps, at 64 times in place of sliding distances
    """

    times: Array
    moments: tuple[Moment, ...]
    watched_times: Array
    watched: History
    face: FullFace
    path: Array
    full_since: Moment | None = None
    later: History | None = None

    @cached_property
    def history(self) -> History:
        """The history at the times asked for."""
        return self.watched[np.flatnonzero(np.isin(self.watched_times, self.times))]

    @property
    def between(self) -> History:
        """The history at every step, and in full contact after them; times for distances."""
        history = history_of(self.moments, self.face)
        history = replace(history, distances=np.array([moment.time for moment in self.moments]))
        return history if self.later is None else history.then(self.later)

    @property
    def space(self) -> PressureSpace:
        """The cells that the punch is marched on."""
        return self.face.compliance.space

    @cached_property
    def time_of_full_contact(self) -> float:
        """When all of the face began to carry for good; NaN if it never did.

        Steps end before and after; the area of contact grows in a straight line in between.
        """
        if self.full_since is None:
            return np.nan
        times, _, _, areas = self.path.T
        partial = np.flatnonzero(areas < WHOLE)
        if len(partial) < 2 or partial[-1] + 1 == len(times):
            return self.full_since.time
        last = partial[-1]
        growth = (areas[last] - areas[last - 1]) / (times[last] - times[last - 1])
        ahead = (1 - areas[last]) / growth if growth > 0 else np.inf
        return float(min(times[last] + ahead, times[last + 1]))

    def remainder(self) -> tuple[Array, Array]:
        """Return the times of the steps (S,), and how far the punch is from its limit at each."""
        times, depth, force, _ = self.path.T
        return times, self.face.remainder(times, depth, force)

    def remainder_later(self, times: Array) -> Array:
        """Return how far the punch is from its limit at times (T,) after contact is full.

        Raises
        ------
        ValueError
            if contact has never become full
        """
        if self.full_since is None:
            raise ValueError("contact has not become full")
        history = self.face.history_since(self.full_since, times)
        return self.face.remainder(times, history.indentation, history.force)


def path_row(time: float, press: Press, weights: Array) -> tuple[float, float, float, float]:
    """Return time, indentation, force, and area of contact over that of the face.

    Parameters
    ----------
    weights : (size,) areas of the nodes
    """
    area = float(weights[press.contact].sum() / weights.sum())
    return time, press.indentation, press.force, area


def history_of(moments: Sequence[Moment], face: FullFace, steps: Steps | None = None) -> History:
    """Return the history of a punch at some moments.

    Parameters
    ----------
    moments : T of them
    face : of the punch
    steps : how the march went
    """
    space = face.compliance.space
    integrals = np.reshape([moment.integral for moment in moments], (-1, space.size))
    presses = [moment.press for moment in moments]
    return History(
        np.array([moment.distance for moment in moments]),
        np.reshape([press.pressure for press in presses], integrals.shape),
        integrals * space.at_vertices(face.wear_coefficients),
        np.array([press.indentation for press in presses]),
        np.array([press.force for press in presses]),
        np.reshape([press.gap for press in presses], integrals.shape),
        np.reshape([press.contact for press in presses], integrals.shape).astype(bool),
        steps=steps or Steps(),
    )
