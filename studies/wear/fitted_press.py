"""Static contact on a mesh fitted to its edges.

High degrees, graded to where the pressure is singular.

The contact is one or more intervals of the radius. Each of their edges is either fixed, a corner of
the punch face at which the pressure is infinite, or free: there the pressure falls to zero as a
root, and the stress intensity vanishes, which the coefficient of the pressure at the edge measures.
With the edges given, all is linear: ``A p = d b - m``. The coefficient at the outermost free edge
gives d; those at the others and the load are as many equations as there are free edges.

The half-space has no length of its own: the compliance on a disc of radius c is ``c^3`` times that
of the unit disc under the same intervals, scaled. Where the one free edge is the outermost, one
compliance serves every radius. Non-dimensional.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ...mdr import energy
from ...meshes.compliance import Compliance
from ...meshes.contact_cells import fitted_space
from ...meshes.errors import SolverError
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array, Indices
from ..problem.profile import InitialProfile
from .moments import moments
from .unilateral import Interval, Load

# (edges from 0 to 1 that every pressure space must be broken at, which of them the pressure is
# infinite at) -> compliance
CompliancesOn = Callable[[tuple[float, ...], tuple[bool, ...]], Compliance]


@dataclass(frozen=True, eq=False)
class FittedPress:
    """A punch pressed on, its edges found.

    Parameters
    ----------
    intervals : of contact
    compliance : on the disc of the outermost edge, scaled to radius 1
    pressure : (size,) coefficients on its space
    indentation, force : one of them as given
    gap : least mean gap over a cell between parts of the contact; infinite if nothing is between
    evaluations : compliances that were solved with
    """

    intervals: tuple[Interval, ...]
    compliance: Compliance
    pressure: Array
    indentation: float
    force: float
    gap: float
    evaluations: int

    @property
    def radius(self) -> float:
        """The outermost edge."""
        return self.intervals[-1].outer

    def check(self) -> None:
        """Refuse what is no contact.

        Raises
        ------
        SolverError
            if pressures are negative somewhere, beyond what their polynomials do at edges
        """
        radii, _, _ = self.compliance.space.quadrature
        pressure = self.compliance.space.matrix(radii.ravel()) @ self.pressure
        if pressure.min() < -1e-3 * self.force / (np.pi * self.radius**2):
            raise SolverError("the contact has more parts than were found")
        if self.gap < -1e-3 * self.indentation:
            raise SolverError("the punch touches between the parts of the contact")

    def pressure_at(self, radii: Array) -> Array:
        """Pressures at radii of the punch; zero outside the contact."""
        inside = radii <= self.radius
        scaled = np.where(inside, radii, 0.0) / self.radius
        return np.asarray(
            np.where(inside, self.compliance.space.matrix(scaled) @ self.pressure, 0.0)
        )

    def ring_forces(self, ring_edges: Array) -> Array:
        """(N,) force on each ring."""
        scaled = np.minimum(ring_edges / self.radius, 1.0)
        used = np.append(True, np.diff(scaled) > 0)
        out = np.zeros(len(ring_edges) - 1)
        forces = self.radius**2 * self.compliance.space.ring_forces(scaled[used]) @ self.pressure
        out[: len(forces)] = forces
        return out


def fit_presses(
    profile: InitialProfile,
    load: Load,
    intervals: tuple[Interval, ...],
    compliances: tuple[CompliancesOn, CompliancesOn],
) -> tuple[FittedPress, FittedPress]:
    """Press an unworn punch on pressures of a higher and of a lower degree.

    Parameters
    ----------
    profile, load : of the punch
    intervals : where it touches, about
    compliances : of the higher degree, and of the lower, which shows what it errs by

    Raises
    ------
    SolverError
        if the edges of the contact are not found
    """
    presses: list[FittedPress] = []
    contact = FittedContact(profile, load, _roughly)
    intervals = contact.press(intervals).intervals
    for on_edges in reversed(compliances):
        contact = FittedContact(profile, load, on_edges, contact.inverse)
        press = contact.press(intervals)
        press.check()
        presses.append(press)
        intervals = press.intervals
    return presses[1], presses[0]


def _roughly(edges: tuple[float, ...], infinite: tuple[bool, ...]) -> Compliance:
    """Return a compliance that takes no time, by which edges are sought first."""
    return energy.compliance(fitted_space(edges, infinite, 4, 1e-2 * min(np.diff(edges))))


class FittedContact:
    """A punch and a half-space whose contact edges are sought."""

    def __init__(
        self,
        profile: InitialProfile,
        load: Load,
        compliances: CompliancesOn,
        inverse: Array | None = None,
    ) -> None:
        self.profile, self.load, self.compliances = profile, load, compliances
        # of the derivatives of the residuals by the edges, where they are about the same
        self.inverse = inverse
        self.evaluations = 0

    def press(self, start: tuple[Interval, ...]) -> FittedPress:
        """Find the edges from a start that has as many of them, and each near.

        Raises
        ------
        SolverError
            if they are not found: the contact is of another kind than the start
        """
        if not start:
            raise SolverError("nothing touches that cells could feel")
        if len(start) > 6:
            raise SolverError(f"the contact has {len(start)} parts, too many to fit a mesh to")
        free = _free(start)
        if not free:
            return self._solved(start, None)[0]
        in_turn = np.array(
            [0.0, *(edge for part in start for edge in (part.inner, part.outer)), 1.0]
        )
        at = np.array([2 * n + 1 + (side == "outer") for n, side in free])

        def moved(edges: Array) -> tuple[Interval, ...]:
            in_turn[at] = edges
            ends = in_turn[1:-1].reshape(-1, 2).tolist()
            return tuple(
                replace(part, inner=inner, outer=outer)
                for part, (inner, outer) in zip(start, ends, strict=True)
            )

        def room(edges: Array) -> Array:
            """Return the distance of free edges to the nearer of the edges beside them."""
            in_turn[at] = edges
            gaps = np.diff(in_turn)
            return np.minimum(gaps[at - 1], gaps[at])

        def residual(edges: Array) -> Array:
            return self._solved(moved(edges), free[-1])[1]

        edges = in_turn[at]
        if min(room(edges)) <= 0:
            raise SolverError("the edges of the contact cross each other or leave the punch")
        wrong = residual(edges)
        if self.inverse is None:
            steps = np.diag(-1e-3 * room(edges))
            changes = [(residual(edges + step) - wrong) / step.sum() for step in steps]
            self.inverse = np.linalg.pinv(np.transpose(changes))
        for _ in range(30):
            step = -self.inverse @ wrong
            step *= min(1.0, float(np.min(0.5 * room(edges) / np.maximum(np.abs(step), 1e-300))))
            edges = edges + step
            # it converges faster than linearly: the error is far below the last step
            if (np.abs(step) <= 1e-7 * room(edges) + 1e-12).all():
                # d by the load, of which an edge a little off takes nothing in the first order
                return self._solved(moved(edges), None)[0]
            before, wrong = wrong, residual(edges)
            # Broyden's formula
            felt = self.inverse @ (wrong - before)
            if not step @ felt:
                break
            self.inverse += np.outer(step - felt, step @ self.inverse) / (step @ felt)
        raise SolverError("the edges of the contact were not found")

    def _solved(
        self, intervals: tuple[Interval, ...], sets: tuple[int, str] | None
    ) -> tuple[FittedPress, Array]:
        """The press with these edges, and the residuals.

        Of the load, then of each free edge but the one that sets d.
        """
        self.evaluations += 1
        radius = intervals[-1].outer
        edges, infinite = _scaled(intervals, self.profile.kinks)
        compliance = self.compliances(edges, infinite)
        space = compliance.space
        carries = _carrying(space, intervals, radius)
        matrix = compliance.matrix[np.ix_(carries, carries)] * radius**3
        weights = space.weights[carries] * radius**2
        of_profile = moments(self.profile, space, radius)[carries] * radius**2
        try:
            factor = cho_factor(matrix)
        except np.linalg.LinAlgError as error:
            raise SolverError(
                f"the compliance of the contact is not positive definite: {error}"
            ) from error
        by_weights, by_moments = cho_solve(factor, weights), cho_solve(factor, of_profile)
        position = np.full(space.size, -1)
        position[carries] = np.arange(len(carries))
        at_edges = {key: position[_dof(space, intervals, key)] for key in _free(intervals)}
        if sets is not None:
            place = at_edges[sets]
            indentation = by_moments[place] / by_weights[place]
        elif self.load.force is not None:
            indentation = (self.load.force + weights @ by_moments) / (weights @ by_weights)
        else:
            indentation = float(self.load.indentation or 0.0)
        inside = indentation * by_weights - by_moments
        force = float(weights @ inside)
        pressure = np.zeros(space.size)
        pressure[carries] = inside
        mean = abs(force) / (np.pi * radius**2)
        if self.load.force is not None:
            of_load = force / self.load.force - 1
        else:
            of_load = indentation / float(self.load.indentation or 1.0) - 1
        # a root of slope one, however deep the mesh resolves it
        others = [
            inside[place] / mean * np.sqrt(_size_at(space, intervals, key))
            for key, place in at_edges.items()
            if key != sets
        ]
        gap = self._least_gap(compliance, pressure, radius, float(indentation), carries)
        press = FittedPress(
            intervals, compliance, pressure, float(indentation), force, gap, self.evaluations
        )
        return press, np.array([of_load, *others])

    def _least_gap(
        self,
        compliance: Compliance,
        pressure: Array,
        radius: float,
        indentation: float,
        carries: Indices,
    ) -> float:
        """The least mean gap under the hats that do not carry."""
        space = compliance.space
        apart = np.setdiff1d(np.flatnonzero(space.uniform), carries)
        displaced = radius * compliance.factor[:, apart].T @ (compliance.factor @ pressure)
        gap = (displaced + moments(self.profile, space, radius)[apart]) / space.weights[
            apart
        ] - indentation
        return float(gap.min(initial=np.inf))


def _free(intervals: tuple[Interval, ...]) -> list[tuple[int, str]]:
    return [
        (n, side)
        for n, part in enumerate(intervals)
        for side in ("inner", "outer")
        if getattr(part, f"{side}_free")
    ]


def _scaled(
    intervals: tuple[Interval, ...], kinks: tuple[float, ...]
) -> tuple[tuple[float, ...], tuple[bool, ...]]:
    """Edges over the outermost, the axis first, kinks of the face between them.

    And where pressures are infinite.
    """
    radius = intervals[-1].outer
    infinite = {0.0: False}
    for part in intervals:
        if part.inner > 0:
            infinite[part.inner] = not part.inner_free
        infinite[part.outer] = not part.outer_free
        # the pressure goes as x log x at a kink, which ring forces would feel by 2e-4
        near = 1e-2 * (part.outer - part.inner)
        within = [kink for kink in kinks if part.inner + near < kink < part.outer - near]
        infinite |= dict.fromkeys(within if len(within) <= 4 else (), False)
    edges = sorted(infinite)
    return tuple(edge / radius for edge in edges), tuple(infinite[edge] for edge in edges)


def _carrying(space: PressureSpace, intervals: tuple[Interval, ...], radius: float) -> Indices:
    """Functions on elements in contact."""
    middle = radius * (space.breakpoints[1:] + space.breakpoints[:-1]) / 2
    inside = np.zeros(len(middle), dtype=bool)
    for part in intervals:
        inside |= (middle > part.inner) & (middle < part.outer)
    used = np.unique(space.dofs[inside])
    return np.asarray(used[used < space.size])


def _element(space: PressureSpace, intervals: tuple[Interval, ...], key: tuple[int, str]) -> int:
    n, side = key
    edge = getattr(intervals[n], side) / intervals[-1].outer
    place = int(np.abs(space.breakpoints - edge).argmin())
    return place - 1 if side == "outer" else place


def _dof(space: PressureSpace, intervals: tuple[Interval, ...], key: tuple[int, str]) -> int:
    """The hat at an edge, on its side in contact."""
    return int(space.dofs[_element(space, intervals, key), 1 if key[1] == "outer" else 0])


def _size_at(space: PressureSpace, intervals: tuple[Interval, ...], key: tuple[int, str]) -> float:
    element = _element(space, intervals, key)
    return float(space.breakpoints[element + 1] - space.breakpoints[element])
