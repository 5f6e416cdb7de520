"""What happens inside the half-space.

Displacements and stresses of the finite elements at chosen times.

Stresses converge half as fast as the indentation, so they have a degree of their own, the first
that is accurate enough by their own estimate. It is how far the fields are from those of one degree
and one pole less, on the same mesh: both computed from the contact on, the pressures with them. On
quadrilaterals the error falls by a factor of three or more per degree, which makes the difference
two to six times the error (`tests/physics/test_stresses.py`). Points within `NEAR` of an edge of
the contact or of a ring, where stresses are infinite or jump, are left out of the estimate.

Under a contact that opens, closes and spreads, the triangles are those of its march, a degree
higher, and what they are held against has a degree and a pole less, and pressures on every second
cell, which it has marched with by itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, log
from typing import TYPE_CHECKING

import numpy as np
from threadpoolctl import threadpool_limits

from ...mdr.flat_punch import D0, P0
from ...meshes.radial import Array, Indices
from ..methods.base import Solution
from ..methods.error_factors import error_factor
from ..methods.evaluation import FullContact
from ..methods.moving_evaluation import MovingContact
from ..problem.problem import Problem
from ..scene.scene import Scene
from ..sizes import defaults
from ..wear.full_contact import RunningIn

if TYPE_CHECKING:
    from ...fem.half_space import HalfSpace

# error of stresses, over the mean pressure, that goes with a relative error of the indentation
SHARE = 10
# distance from edges of contact and rings, in radii of the contact, from which on estimates hold
NEAR = 0.2
# of the far field beyond the mesh: ratio of distances, angles, and poles, of which at the least
# distance, 2.5 a, 1e-10 is left out
FAR_GROWTH, FAR_ANGLES, FAR_POLES = 1.15, 33, 12


@dataclass(frozen=True, eq=False)
class Interior:
    """Fields of the half-space, and how good they are; non-dimensional.

    On small triangles within each element, not averaged between elements.

    Parameters
    ----------
    points, triangles : (2, n) radius and depth, and the small triangles (3, m) between them
    displacement : (states, n, 2) radial, and into the half-space
    stress : (states, n, 4) rr, zz, rz, hoop
    labels : of the states, `t=...` and `steady`
    degree : of the displacement
    reach : (states,) radius of the contact; 1 where nothing touches
    parts : inner and outer radius (n, 2) of the parts of the contact in each state
    errors : of each field, by its name, in each state (states,): estimate of its greatest error
        further than `NEAR` from edges of contact and rings; of displacements over the indentation
        of a flat punch as wide as the contact, of stresses over the mean pressure
    layers : (n,) number of the layer that each point belongs to, 0 without layers
    """

    points: Array
    triangles: Indices
    displacement: Array
    stress: Array
    labels: tuple[str, ...]
    degree: int
    reach: Array
    parts: tuple[Array, ...]
    errors: dict[str, Array]
    layers: Indices

    @cached_property
    def von_mises(self) -> Array:
        """(states, n) equivalent stress."""
        from ...fem.stresses import von_mises

        return von_mises(self.stress)


def interior(scene: Scene, fem: Solution) -> Interior:
    """Return the inside of the half-space at the scene's field times, and when steady.

    Its degree is raised until the estimate of the stresses is `SHARE` times `rtol`, unless the user
    has given it, or poles. It starts at the one that is enough for five rings and for a flat punch
    at every `rtol`, or at that of the contact if that is lower.
    """
    from ...fem.far_field import enough_poles
    from ...fem.half_space import HalfSpace, pressure_space
    from ...meshes.half_space import truncation

    half_space, problem, times = fem.half_space, scene.problem, scene.output.field_times
    assert half_space is not None
    # times that each element is refined to show what its polynomials say, highest degree worth its
    # cost, and what stands for Poisson's ratio 1/2: inside, its error shows, but triangles lock the
    # more the closer it is
    refinements, highest, ratio = 3, 14, 0.499999
    if len(half_space.solid.mesh.t) == 3:
        refinements, highest, ratio = 2, 4, 0.49999
    elif problem.ground is not None:
        ratio = half_space.solid.highest_ratio
    flat, steady = problem.full_contact, problem.steady and problem.indentation is None
    if times is None:
        # a flat start is in closed form, and the end near the steady state
        times = [0.0] if steady and flat else [0.0, scene.wear.times[-1]]
    labels = tuple(f"t={time:g}" for time in np.unique(times)) + ("steady",) * steady
    inside = replace(problem, times=np.unique(times) / problem.units.time, steady=steady)
    # what the poles leave to the truncation is of the energy, where stresses feel its root
    accuracy = 1e-3 * min(SHARE * problem.rtol, 1e-3) ** 2
    poles = enough_poles(truncation(half_space.solid.mesh), accuracy)
    if problem.fem.poles:
        poles = half_space.poles
    # a clamped boundary is judged by one that is not: the difference is the error itself, far
    # greater than any other
    orders = (poles, defaults.coarser_pole_orders(poles)) if half_space.poles else ((), poles)
    # of a lower degree there may be no stable pressures
    degree = max(half_space.solid.degree, 3) + (not flat)
    # what the user has given stays, and no degree mends the truncation, or cells
    if problem.fem.degree or problem.fem.poles or not (half_space.poles and flat):
        highest = degree
    elif problem.poisson_ratio <= 0.499:
        # estimates on quadrilaterals are 8 / 3^degree; closer to incompressible they take more
        degree = max(min(degree, ceil(log(8 / (SHARE * problem.rtol), 3))), 3)
    with threadpool_limits(1):
        while True:
            spaces = []
            for lower, tied in enumerate(orders):
                solid = replace(
                    half_space.solid, degree=degree - lower, highest_ratio=ratio, lowered_degrees=0
                )
                ring_edges = problem.merged.ring_edges
                hollow = problem.merged.hollow
                space = pressure_space(solid, ring_edges, hollow) if flat else half_space.space
                spaces.append(HalfSpace(solid, space, tied).without_dependent_poles())
            fine, coarse = spaces
            pressures = (
                pressures_of(inside, fine, coarse=False),
                pressures_of(inside, coarse, coarse=True),
            )
            result = held_against(problem, spaces, pressures, labels, refinements)
            excess = result.errors["stress"].max() / (SHARE * problem.rtol)
            # matrices of more pressures are dense, and not worth it for the sake of the inside
            if excess <= 1 or degree >= highest or fine.space.size > 1500:
                depth = (scene.output.depth or 0.0) / problem.units.length
                return extended(result, fine, pressures[0], depth)
            # three times as accurate by each degree
            degree = min(degree + ceil(log(excess, 3)), highest)


def pressures_of(problem: Problem, half_space: "HalfSpace", coarse: bool) -> Array:
    """Return the pressures (states, size) at a problem's times, and when steady.

    If `coarse`, the pressures of a shaped punch are those of a march on every second cell, whose
    steps in time may err by more.
    """
    compliance, space = half_space.compliance(), half_space.space
    if problem.full_contact:
        within, wear = space, FullContact(problem, compliance).wear
        # no modes are needed for the start
        pressures = np.outer(problem.loading.at(problem.times).force, wear.flat.pressure)
        if problem.earliest:
            pressures = wear.modal(problem.times).pressure
    else:
        within = space.coarser() if coarse else space
        compliance = compliance.restricted(within)
        wear = RunningIn(compliance, problem.merged.wear_coefficients, continuous=False)
        factor_of_steps = error_factor("steps of the coarser march") if coarse else 1.0
        pressures = MovingContact(
            problem, compliance, step_tolerance_factor=factor_of_steps
        ).history.pressure
    if problem.steady:
        pressures = np.vstack([pressures, problem.loading.forces[-1] * wear.steady.pressure])
    return np.asarray(pressures @ space.embedding(within).T)


def held_against(
    problem: Problem,
    spaces: Sequence["HalfSpace"],
    pressures: Sequence[Array],
    labels: tuple[str, ...],
    refinements: int,
) -> Interior:
    """Return the inside of a half-space under (states, size) pressures, and its estimated errors.

    They are one and a half times the greatest difference to a coarser half-space on the same mesh,
    under pressures of its own, and what Poisson's ratio 1/2 adds to it.
    """
    from ...fem.stresses import sample_fields, von_mises

    fine, coarse = (
        sample_fields(half_space, of_states, refinements)
        for half_space, of_states in zip(spaces, pressures, strict=True)
    )
    (r, z), solid, space = fine[0], spaces[0].solid, spaces[0].space
    # fields are in proportion to 1 - 2 nu, plus a constant, and neither is much more than the unit
    modelled = 2 * max(0.0, problem.poisson_ratio - solid.highest_ratio)
    factor = error_factor("inside of the half-space")
    middles, reaches = space.on_elements(np.zeros(1)), np.ones(len(labels))
    parts = list[Array]()
    errors = {name: np.zeros(len(labels)) for name in ("displacement", "stress", "von_mises")}
    for state, pressure in enumerate(pressures[0]):
        carried = middles @ pressure > 0
        ends = space.breakpoints[np.diff(carried, prepend=False, append=False)]
        parts.append(ends.reshape(-1, 2))
        edges = np.union1d(problem.merged.ring_edges, ends)[1:]
        reaches[state] = reach = float(ends.max(initial=0.0)) or 1.0
        force = float(space.weights @ pressure) or 1.0
        far = np.hypot(r - edges[:, None], z).min(axis=0) > NEAR * reach
        moved, stress = (fine[at][state, far] - coarse[at][state, far] for at in (2, 3))
        mean = 2 * P0 * force / reach**2
        # a norm: that of the difference is at least the difference of two
        differences = moved * reach / (D0 * force), stress / mean, von_mises(stress) / mean
        for stated, difference in zip(errors.values(), differences, strict=True):
            stated[state] = factor * np.abs(difference).max() + modelled
    layers = np.repeat(solid.layers, len(r) // solid.mesh.nelements)
    return Interior(*fine, labels, solid.degree, reaches, tuple(parts), errors, layers)


def extended(inside: Interior, half_space: "HalfSpace", pressures: Array, depth: float) -> Interior:
    """Return the inside with the exact far field beyond the mesh, up to a depth in punch radii.

    Nothing is added if the mesh goes as far.

    Parameters
    ----------
    pressures : (states, size) on the space of the half-space
    """
    from ...fem.far_field import fields_beyond
    from ...meshes.half_space import truncation

    edge, solid, space = truncation(half_space.solid.mesh), half_space.solid, half_space.space
    if depth <= edge:
        return inside
    rings = max(2, 1 + ceil(log(depth / edge) / log(FAR_GROWTH)))
    distance, angle = np.meshgrid(
        np.geomspace(edge, depth, rings), np.linspace(0.0, np.pi / 2, FAR_ANGLES), indexing="ij"
    )
    points = np.stack([distance * np.sin(angle), distance * np.cos(angle)]).reshape(2, -1)
    # sines and cosines leave roundoff on the surface and on the axis
    points[points < 1e-14 * depth] = 0.0
    radii, lengths, local = space.quadrature
    areas = (2 * np.pi * radii * lengths).ravel()
    at_points = (space.on_elements(local) @ pressures.T).T * areas
    moments = at_points @ radii.ravel()[:, None] ** (2 * np.arange(FAR_POLES))
    ratio = solid.poisson_ratio
    displacement, stress = fields_beyond(points.T, moments, ratio, (1 - ratio) / 2)
    corners = np.arange(points.shape[1]).reshape(rings, FAR_ANGLES)
    first, second, third, fourth = (
        part.ravel()
        for part in (corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:])
    )
    triangles = np.hstack([np.stack([first, second, third]), np.stack([first, third, fourth])])
    return replace(
        inside,
        points=np.hstack([inside.points, points]),
        triangles=np.hstack([inside.triangles, triangles + inside.points.shape[1]]),
        displacement=np.concatenate([inside.displacement, displacement], axis=1),
        stress=np.concatenate([inside.stress, stress], axis=1),
        layers=np.append(inside.layers, np.zeros(points.shape[1], dtype=np.int64)),
    )
