"""March a punch whose contact opens, closes and spreads in time. Non-dimensional.

Each step solves contact and wear together (`stages.py`), and the step length follows a tolerance
(`step_control.py`). Steps end at the knots of the load. If the force changes while the punch does
not slide, the contact problem is solved again without wear. Once all of the face is in contact, the
problem is linear, and relaxation modes solve it exactly at any time (`full_face.py`). The result of
a march is a `Marched` (`marched.py`).
"""

import numpy as np

from ....meshes.compliance import Compliance
from ....meshes.errors import SceneError
from ....meshes.radial import Array
from ..problem.loading import Loading
from ..sizes.marching import MOST_STEPS, steps_between
from .full_face import FullFace
from .history import History, Instant, Steps
from .marched import Marched, history_of_instants, path_row
from .stages import ContactStages
from .step_control import StepControl
from .unilateral import Load

# at a fixed indentation, a force below this fraction of the first force is roundoff
NEGLIGIBLE_FORCE = 1e-12
# a remaining distance below this fraction of the total distance is roundoff
ROUNDOFF = 1e-14
# Under a varying load, errors are estimated after every so many accepted steps.
STEPS_BETWEEN_ESTIMATES = 12
# Least number of steps between a time that is recorded for error estimates and the times before and
# after it at which steps end. The coarser march ends its steps at all of them; with fewer, its
# steps would be as short as those of the march itself, and their errors alike.
STEPS_BESIDE_ESTIMATES = 4


class ContactMarch:
    """Compute the wear of a shaped punch in steps, while contact opens, closes and spreads.

    A `ContactMarch` combines a `Compliance` of piecewise linear pressures, wear coefficients, the
    moments of the face and a load. `adaptive` takes steps that follow a tolerance, `implicit` takes
    equal steps. In the example, the worn volume of a paraboloid is k F t at every time.

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
        Compliance on a space of degree 1.
    wear_coefficients : (N,) or (2, N) array
        Wear coefficient of each ring of that space; or those at the inner and outer edge of each
        ring, linear between.
    moments : (size,) array
        Moments of the initial profile.
    load : Load
        Greatest force, or indentation.
    loading : Loading, optional
        Force over the greatest force, and sliding speed, over time; constant if not given.
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

    def adaptive(self, times: Array, tolerance: float, slope_tolerance: float = np.inf) -> Marched:
        """March in steps of second order that follow a tolerance, until contact is full.

        Parameters
        ----------
        times : (T,) array
            Increasing times; a step ends on each.
        tolerance : float
            Root mean square error of the worn depth that a step may add, over the greatest
            indentation so far.
        slope_tolerance : float
            Root mean square error of the slope of the face that a step may add, over that slope. It
            matters for the thin layers that wear makes at ring edges and at the rim.

        Returns
        -------
        Marched
            The history at these times and at some between, and all of the steps.

        Raises
        ------
        SceneError
            if the march takes too many steps
        """
        stages, face = self._stages, self.face
        load, loading = face.load, face.loading
        previous = current = stages.press_unworn()
        negligible_force = NEGLIGIBLE_FORCE * current.press.force if load.force is None else 0.0
        # `instants`: after each step; `watched`: at the requested times and after some steps
        instants, watched, iterations = [current], list[Instant](), list[int]()
        events = loading.step_ends(times)
        distances = loading.at(events).distance
        control = StepControl(tolerance, float(distances[-1]), slope_tolerance)

        def result(full_since: Instant | None = None, full: History | None = None) -> Marched:
            """Return the result of the march, continued by a history in full contact if given."""
            steps = Steps(control.taken, control.rejected, tuple(iterations))
            history, later_times = history_of_instants(watched, face, steps), times[:0]
            later = None
            if full is not None:
                later_times = times[times >= event]
                history, later = history.then(full[: len(later_times)]), full[len(later_times) :]
            result_times = np.append([instant.time for instant in watched], later_times)
            rows = [path_row(instant.time, instant.press, stages.weights) for instant in instants]
            path = np.array(rows)
            return Marched(
                times, tuple(instants), result_times, history, face, path, full_since, later
            )

        for event, end_distance in zip(events, distances, strict=True):
            knot = max(int(np.searchsorted(loading.times, event)) - 1, 0)
            load_at_event, work = stages.at(float(event))
            last_end = control.taken
            while (remaining := end_distance - current.distance) > ROUNDOFF * end_distance:
                if max(current.press.force, load_at_event.force or 0.0) <= negligible_force:
                    break
                if knot == len(loading.times) - 1 and current.press.contact.all():
                    full = face.history_if_full(current, times[times >= event])
                    if full is not None:
                        return result(current, full)
                dt = control.next_towards(remaining)
                time = (
                    loading.time_at(current.distance + dt, knot) if dt < remaining else float(event)
                )
                middle, following, error = stages.solve_two_stages(
                    dt, time, previous, current, with_slopes=np.isfinite(slope_tolerance)
                )
                iterations += (middle.press.iterations, following.press.iterations)
                if control.accepts(dt, error, following.press.indentation):
                    previous, current = middle, following
                    instants.append(current)
                    doubled = not watched or time > 2 * watched[-1].time
                    # under a varying load, late times matter as much as early ones
                    due = loading.varies and control.taken % STEPS_BETWEEN_ESTIMATES == 0
                    steps_left = (end_distance - current.distance) / control.step
                    apart = min(control.taken - last_end, steps_left) >= STEPS_BESIDE_ESTIMATES
                    if dt < remaining and apart and (doubled or due):
                        watched.append(current)
                        last_end = control.taken
                if control.taken + control.rejected > MOST_STEPS[False]:
                    raise SceneError(
                        f"the march took more than {MOST_STEPS[False]} steps to a sliding "
                        f"distance of {current.distance:.3g}: give a larger rtol"
                    )
            if load_at_event.force is not None and current.press.force != load_at_event.force:
                previous = current = current._replace(
                    press=stages.press_worn(current.integral, load_at_event)
                )
            current = current._replace(time=float(event), distance=float(end_distance), work=work)
            if event > instants[-1].time:
                instants.append(current)
            if event in times:
                watched.append(current)
        return result()

    def implicit(self, times: Array, step: float) -> Marched:
        """March by implicit Euler in equal steps of at most `step` between output times.

        Raises
        ------
        SceneError
            if the march would take too many steps
        """
        counts = steps_between(times, step).astype(int)
        if counts.sum() > MOST_STEPS[False]:
            raise SceneError(
                f"{counts.sum()} steps are needed, more than {MOST_STEPS[False]}: "
                "give a larger wear.step"
            )
        stages, face = self._stages, self.face
        previous = current = stages.press_unworn()
        states, instants, iterations = list[Instant](), [current], list[int]()
        path = [path_row(0.0, current.press, stages.weights)]
        for time, count, length in zip(times, counts, np.diff(times, prepend=0.0), strict=True):
            dt = length / max(count, 1)
            for _ in range(count):
                distance = current.distance + dt
                following = stages.solve_stage(
                    dt, distance, current.integral, face.load, previous, current
                )
                iterations.append(following.press.iterations)
                previous, current = current, following
                path.append(path_row(current.distance, current.press, stages.weights))
            current = current._replace(time=float(time), distance=float(time))
            states.append(current)
            if time > 0:
                instants.append(current)
        steps = Steps(int(counts.sum()), iterations=tuple(iterations))
        history = history_of_instants(states, face, steps)
        return Marched(times, tuple(instants), times, history, face, np.array(path))
