"""The march of a punch whose contact opens, closes and spreads. Non-dimensional.

Each step solves contact and wear together (`stages.py`), in lengths that suit a tolerance
(`step_control.py`). Steps end where the load bends, and where it changes at a stop the punch is
pressed anew. Once all of the face carries, the rest is linear, and modes give it exactly at any
time (`full_face.py`). What a march yields is a value (`marched.py`).
"""

import numpy as np

from ...meshes.compliance import Compliance
from ...meshes.errors import SceneError
from ...meshes.radial import Array
from ..problem.loading import Loading
from ..problem.regimes import MOVING_CONTACT
from ..sizes.marching import steps_between
from ..wear.history import History, Moment, Steps
from ..wear.unilateral import Load
from .full_face import FullFace
from .marched import Marched, history_of, path_row
from .stages import ContactStages
from .step_control import StepControl

# part of the first force below which, at a fixed indentation, nothing presses but roundoff
SPENT = 1e-12
# part of the distance until a time that is roundoff
ROUNDOFF = 1e-14
# steps after which a moment is watched for estimates of errors, where the load varies
WATCHED_EVERY = 12


class ContactMarch:
    """Compute the wear of a shaped punch in steps, while contact opens, closes and spreads.

    A `ContactMarch` combines a `Compliance` of piecewise linear pressures, wear coefficients, the
    moments of the face and a load. `adaptive` marches in steps that suit a tolerance, `implicit`
    in equal ones. The paraboloid below has worn by the volume k F t at every time.

    >>> from ringwear.mdr import energy
    >>> from ringwear.meshes.pressure_space import PressureSpace
    >>> r = np.linspace(0, 1, 21)
    >>> space = PressureSpace(r, np.ones(20, dtype=int), ring_edges=r[[0, -1]])
    >>> march = ContactMarch(energy.compliance(space), np.ones(1), space.mass() @ r**2, Load(0.1))
    >>> march.adaptive(np.array([0.0, 1.0, 2.0]), 1e-3).history.profile @ space.weights
    array([0. , 0.1, 0.2])

    Parameters
    ----------
    compliance : Compliance
        On a space of degree 1.
    wear_coefficients : (N,) or (2, N) array
        Of the rings of that space; or at the inner and outer edge of each, linear between.
    moments : (size,) array
        Of the initial profile.
    load : Load
        Greatest force, or indentation.
    loading : Loading, optional
        Part of that force, and the sliding speed, over time.
    """

    def __init__(
        self,
        compliance: Compliance,
        wear_coefficients: Array,
        moments: Array,
        load: Load,
        loading: Loading | None = None,
    ) -> None:
        self.face = FullFace(compliance, wear_coefficients, moments, load, loading or Loading())
        self._stages = ContactStages(self.face)

    def adaptive(self, times: Array, tolerance: float) -> Marched:
        """March in steps of second order that suit a tolerance, until contact is full.

        Parameters
        ----------
        times : (T,) array
            Increasing; a step ends on each.
        tolerance : float
            Root mean square error of the worn depth that a step may add, over the indentation.

        Returns
        -------
        Marched
            The history at these times and at some between, and all of the steps.

        Raises
        ------
        SceneError
            If it takes too many steps.
        """
        stages, face = self._stages, self.face
        load, loading = face.load, face.loading
        before = now = stages.unworn()
        spent = SPENT * now.press.force if load.force is None else 0.0
        # after each step; at the times asked for and after some steps between
        moments, watched, iterations = [now], list[Moment](), list[int]()
        events = np.union1d(times, loading.times[loading.times < times[-1]])
        distances = loading.at(events).distance
        control = StepControl(tolerance, float(distances[-1]))

        def marched(full_since: Moment | None = None, full: History | None = None) -> Marched:
            """Return what the march has yielded, with the history in full contact after it."""
            steps = Steps(control.taken, control.rejected, tuple(iterations))
            history, then = history_of(watched, face, steps), times[:0]
            later = None
            if full is not None:
                then = times[times >= event]
                history, later = history.then(full[: len(then)]), full[len(then) :]
            at = np.append([moment.time for moment in watched], then)
            rows = [path_row(moment.time, moment.press, stages.weights) for moment in moments]
            path = np.array(rows)
            return Marched(times, tuple(moments), at, history, face, path, full_since, later)

        for event, until in zip(events, distances, strict=True):
            knot = max(int(np.searchsorted(loading.times, event)) - 1, 0)
            carried, work = stages.at(float(event))
            while (left := until - now.distance) > ROUNDOFF * until:
                if max(now.press.force, carried.force or 0.0) <= spent:
                    break
                if knot == len(loading.times) - 1 and now.press.contact.all():
                    full = face.history_if_full(now, times[times >= event])
                    if full is not None:
                        return marched(now, full)
                dt = control.next_towards(left)
                time = loading.time_at(now.distance + dt, knot) if dt < left else float(event)
                middle, after, error = stages.two_stages(dt, time, before, now)
                iterations += (middle.press.iterations, after.press.iterations)
                if control.accepts(dt, error, after.press.indentation):
                    before, now = middle, after
                    moments.append(now)
                    further = not watched or time > 2 * watched[-1].time
                    # where loads vary, late times have as much to show as early ones
                    in_turn = loading.varies and control.taken % WATCHED_EVERY == 0
                    if dt < left and (further or in_turn):
                        watched.append(now)
                if control.taken + control.rejected > MOVING_CONTACT.most_steps:
                    raise SceneError(
                        f"the march took more than {MOVING_CONTACT.most_steps} steps to a sliding "
                        f"distance of {now.distance:.3g}: give a larger rtol"
                    )
            if carried.force is not None and now.press.force != carried.force:
                before = now = now._replace(press=stages.pressed(now.integral, carried))
            now = now._replace(time=float(event), distance=float(until), work=work)
            if event > moments[-1].time:
                moments.append(now)
            if event in times:
                watched.append(now)
        return marched()

    def implicit(self, times: Array, step: float) -> Marched:
        """March by implicit Euler in equal steps of at most `step` between output times.

        Raises
        ------
        SceneError
            If it would take too many steps.
        """
        counts = steps_between(times, step).astype(int)
        if counts.sum() > MOVING_CONTACT.most_steps:
            raise SceneError(
                f"{counts.sum()} steps are needed, more than {MOVING_CONTACT.most_steps}: "
                "give a larger wear.step"
            )
        stages, face = self._stages, self.face
        before = now = stages.unworn()
        states, moments, iterations = list[Moment](), [now], list[int]()
        path = [path_row(0.0, now.press, stages.weights)]
        for time, count, length in zip(times, counts, np.diff(times, prepend=0.0), strict=True):
            dt = length / max(count, 1)
            for _ in range(count):
                distance = now.distance + dt
                after = stages.stage(dt, distance, now.integral, face.load, before, now)
                iterations.append(after.press.iterations)
                before, now = now, after
                path.append(path_row(now.distance, now.press, stages.weights))
            now = now._replace(time=float(time), distance=float(time))
            states.append(now)
            if time > 0:
                moments.append(now)
        steps = Steps(int(counts.sum()), iterations=tuple(iterations))
        history = history_of(states, face, steps)
        return Marched(times, tuple(moments), times, history, face, np.array(path))
