"""Displacements and stresses inside the half-space, by finite elements, at chosen times.

Stresses converge half as fast as the indentation, so that they may need a higher degree than the
contact: the first degree at which their own error estimate is small enough. This estimate is the
difference to a solution with one degree and one pole less on the same mesh, times a factor; both
solutions compute their own contact pressures. On quadrilaterals, one more degree reduces the error
by a factor of three or more, so that the difference is two to six times the error
(`tests/physics/test_stresses.py`). Points within `NEAR` of an edge of the contact or of a ring are
left out of the estimate, because stresses are infinite or jump there. So are points within `NEAR`
of a crease of the unworn face, such as the tip of a cone, except in the steady state, in which
creases are worn off.

If the contact opens, closes and spreads, the triangles are those of the march, with one degree
more. Its pressures are those of a march on the compliance of the contact solution. The coarser
solution is on the half-space of the march, and its pressures come from a march on every second
cell.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, log
from typing import TYPE_CHECKING

import numpy as np
from threadpoolctl import threadpool_limits

from .....mdr.flat_punch import flat_punch_of
from .....meshes.compliance import Compliance
from .....meshes.radial import Array, Indices
from ...problem.problem import Problem
from ...problem.quantities import FIELDS
from ...progress import LOG
from ...scene.scene import Scene
from ...sizes.finite_elements import coarser_pole_orders
from ...wear.full_contact import RunningIn
from ..base import Solution
from ..error_factors import error_factor
from ..evaluation import FullContact
from ..moving_evaluation import MovingContact

if TYPE_CHECKING:
    from .....fem.half_space import HalfSpace

# Error of stresses, over the mean pressure, that is allowed per relative error `rtol` of the
# indentation.
STRESS_ERROR_PER_RTOL = 10
# Distance from edges of the contact and of rings, and from creases of the unworn face, in radii of
# the contact, beyond which the error estimates are valid.
NEAR = 0.2
# Name of the steady state among the states.
STEADY_LABEL = "steady"
# Grid of the far field beyond the mesh: ratio of neighbouring distances from the centre, number of
# angles; and number of poles. At the smallest distance, 2.5 a, the poles that are left out
# contribute 1e-10.
FAR_GROWTH, FAR_ANGLES, FAR_POLES = 1.15, 33, 12


@dataclass(frozen=True, eq=False)
class Interior:
    """Fields of the half-space, and their error estimates; non-dimensional.

    Each element is divided into small triangles; fields are not averaged between elements.

    Parameters
    ----------
    points, triangles : (2, n) radius and depth of points, and (3, m) indices of the corners of the
        small triangles
    displacement : (states, n, 2) radial displacement, and displacement into the half-space
    stress : (states, n, 4) rr, zz, rz, hoop
    labels : names of the states, `t=...` and `steady`
    degree : degree of the displacement
    reach : (states,) radius of the contact; 1 if nothing touches
    parts : for each state, (n, 2) inner and outer radii of the parts of the contact
    errors : for each field, by its name, (states,) estimates of its largest error farther than
        `NEAR` from edges of contact and rings, and from `creases`; displacements are relative to
        the indentation of a flat punch as wide as the contact, stresses to the mean pressure
    layers : (n,) index of the layer that each point belongs to, 0 without layers
    creases : (k,) radii at which the slope of the unworn face jumps, such as 0 for the tip of a
        cone, and stresses are singular while something presses there
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
    creases: Array

    @cached_property
    def von_mises(self) -> Array:
        """(states, n) von Mises equivalent stress."""
        from .....fem.stresses import von_mises

        return von_mises(self.stress)


def has_inside(scene: Scene, fem: Solution) -> bool:
    """Return whether fields inside the half-space are wanted, and finite elements have them.

    If the contact changes, they need a history by finite elements.
    """
    problem = scene.problem
    if not (any(map(problem.wants, FIELDS)) or scene.output.field_times) or fem.half_space is None:
        return False
    return problem.full_contact or fem.evolution is not None


def interior(scene: Scene, fem: Solution) -> Interior:
    """Return the inside of the half-space at the scene's field times, and in the steady state.

    The degree is raised until the error estimate of the stresses is at most `STRESS_ERROR_PER_RTOL`
    times `rtol`, unless the scene sets the degree or the poles. It starts at the degree of the
    contact solution, whose half-space is assembled already.
    """
    from .....fem.far_field import enough_poles
    from .....meshes.half_space import truncation

    LOG.info("  output  computing the inside of the half-space ...")
    of_contact, problem, times = fem.half_space, scene.problem, scene.output.field_times
    assert of_contact is not None
    # `refinements`: how often each element is refined to show its polynomials; `highest`: highest
    # degree that is worth its cost
    refinements, highest = (2, 4) if len(of_contact.solid.mesh.t) == 3 else (3, 14)
    full_contact, steady = problem.full_contact, problem.steady and problem.indentation is None
    if times is None:
        # a flat start is in closed form, and the last time is near the steady state
        times = [0.0] if steady and full_contact else first_and_last_in_contact(scene)
    labels = tuple(f"t={time:g}" for time in np.unique(times)) + (STEADY_LABEL,) * steady
    problem_inside = replace(problem, times=np.unique(times) / problem.units.time, steady=steady)
    # the truncation error of the poles is a share of the energy; that of stresses is its root
    accuracy = 1e-3 * min(STRESS_ERROR_PER_RTOL * problem.rtol, 1e-3) ** 2
    poles = enough_poles(truncation(of_contact.solid.mesh), accuracy)
    # with a lower degree there may be no stable pressures
    degree = max(of_contact.solid.degree, 3) + (not full_contact)
    # sizes that the scene sets are not changed, and a higher degree does not reduce errors of
    # truncation or of cells
    if problem.fem.degree or problem.fem.poles or not (of_contact.poles and full_contact):
        highest = degree
    with threadpool_limits(1):
        while True:
            spaces = fine_and_coarser(problem, of_contact, degree, poles)
            fine = spaces[0]
            if full_contact:
                assert fem.wear is not None
                compliances = [
                    fem.wear.compliance if each is of_contact else each.compliance()
                    for each in spaces
                ]
                pressures = [
                    pressures_in_full_contact(problem_inside, compliance)
                    for compliance in compliances
                ]
            else:
                pressures = pressures_of_marches(problem_inside, fem)
            result = compare_half_spaces(problem, spaces, pressures, labels, refinements)
            excess = result.errors["stress"].max() / (STRESS_ERROR_PER_RTOL * problem.rtol)
            # matrices of more pressures are dense, and too expensive for the fields inside alone
            if excess <= 1 or degree >= highest or fine.space.size > 1500:
                depth = (scene.output.depth or 0.0) / problem.units.length
                return add_far_field(result, fine, pressures[0], depth)
            # each degree makes stresses three times as accurate
            degree = min(degree + ceil(log(excess, 3)), highest)


def fine_and_coarser(
    problem: Problem, of_contact: "HalfSpace", degree: int, wanted_poles: tuple[int, ...]
) -> list["HalfSpace"]:
    """Return the half-space of a degree, and the coarser one, with one degree less, on its mesh.

    The half-space of the contact solution is one of the two where it can be, because it is
    assembled already.

    Parameters
    ----------
    problem : the problem
    of_contact : half-space of the contact solution
    degree : degree of the finer half-space
    wanted_poles : orders of the poles with which the truncation error of the stresses is negligible
    """
    from .....fem.half_space import HalfSpace, pressure_space

    poles = of_contact.poles
    if not poles:
        # A clamped boundary is compared with one that is not clamped: the difference is the error
        # itself, far greater than any other.
        orders: tuple[tuple[int, ...], ...] = ((), wanted_poles)
    elif problem.full_contact:
        if len(poles) < len(wanted_poles) and not problem.fem.poles:
            poles = wanted_poles
        orders = (poles, coarser_pole_orders(poles))
    else:
        # more poles in the coarser half-space show the error of the truncation as well as fewer do
        if len(poles) <= len(wanted_poles):
            poles = coarser_pole_orders(wanted_poles)
        orders = (wanted_poles, poles)
    half_spaces = []
    for lowered, pole_orders in enumerate(orders):
        solid, space = of_contact.solid, of_contact.space
        if degree - lowered != solid.degree:
            solid = replace(solid, degree=degree - lowered)
            if problem.full_contact:
                space = pressure_space(solid, problem.merged.ring_edges)
        half_space = HalfSpace(solid, space, pole_orders).without_dependent_poles()
        assembled = solid is of_contact.solid and half_space.poles == of_contact.poles
        half_spaces.append(of_contact if assembled else half_space)
    return half_spaces


def first_and_last_in_contact(scene: Scene) -> list[float]:
    """Return the start and the last time; or, if nothing presses then, the nearest of the times.

    Without any time at which something presses, the start and the last time are returned.
    """
    problem = scene.problem
    times = np.union1d(0.0, scene.wear.times)
    pressing = times[problem.loading.at(times / problem.units.time).force > 0]
    ends = pressing if len(pressing) else times
    return [float(ends[0]), float(ends[-1])]


def pressures_in_full_contact(problem: Problem, compliance: Compliance) -> Array:
    """Return the pressures (states, size) at the times of a problem, and in the steady state."""
    wear = FullContact(problem, compliance).wear
    # no modes are needed for the start
    pressures = np.outer(problem.loading.at(problem.times).force, wear.flat.pressure)
    if problem.earliest:
        pressures = wear.modal(problem.times).pressure
    return _with_steady_state(problem, wear, pressures)


def pressures_of_marches(problem: Problem, fem: Solution) -> list[Array]:
    """Return the pressures (states, size) of a shaped punch by two marches, both on one space.

    The first march is that of a solution, unless it ends too early. The second one has every second
    cell of its compliance, and longer time steps.
    """
    assert fem.evolution is not None
    evolution, compliance = fem.evolution, fem.evolution.punch.compliance
    if problem.times[-1] > evolution.times[-1]:
        evolution = MovingContact(problem, compliance).evolution
    space, coarser = compliance.space, compliance.space.coarser()
    length = error_factor("steps of the coarser march")
    restricted = compliance.restricted(coarser)
    marches = (
        evolution,
        MovingContact(problem, restricted, step_length=length).evolution,
    )
    return [
        _with_steady_state(problem, each.punch.running_in, each.at(problem.times).pressure)
        @ space.embedding(each.punch.space).T
        for each in marches
    ]


def _with_steady_state(problem: Problem, wear: RunningIn, pressures: Array) -> Array:
    """Return pressures (T, size) and, if a problem has one, the steady state."""
    if not problem.steady:
        return pressures
    return np.vstack([pressures, problem.loading.forces[-1] * wear.steady.pressure])


def compare_half_spaces(
    problem: Problem,
    spaces: Sequence["HalfSpace"],
    pressures: Sequence[Array],
    labels: tuple[str, ...],
    refinements: int,
) -> Interior:
    """Return the inside of a half-space under given pressures, and its error estimates.

    The estimates are the largest difference to a coarser half-space on the same mesh, under its own
    pressures, times a factor, and at least the error of an extrapolation to Poisson's ratio 1/2.

    Parameters
    ----------
    problem : the problem
    spaces : the fine and the coarser half-space
    pressures : (states, size) of each of them
    labels : names of the states
    refinements : how often each element is refined
    """
    from .....fem.stresses import sample_fields, von_mises

    fine, coarse = (
        sample_fields(half_space, state_pressures, refinements)
        for half_space, state_pressures in zip(spaces, pressures, strict=True)
    )
    (r, z), solid, space = fine[0], spaces[0].solid, spaces[0].space
    floor = error_factor("incompressible inside") if solid.more_compressible else 0.0
    factor = error_factor("inside of the half-space")
    middles, reaches = space.on_elements(np.zeros(1)), np.ones(len(labels))
    parts = list[Array]()
    errors: dict[str, Array] = {
        name: np.zeros(len(labels)) for name in ("displacement", "stress", "von_mises")
    }
    creases = problem.profile.creases
    for state, pressure in enumerate(pressures[0]):
        in_contact = middles @ pressure > 0
        ends = space.breakpoints[np.diff(in_contact, prepend=False, append=False)]
        parts.append(ends.reshape(-1, 2))
        edges = np.union1d(problem.merged.ring_edges, ends)
        edges = edges[edges > 0]
        if labels[state] != STEADY_LABEL:
            edges = np.union1d(edges, creases)
        reaches[state] = reach = float(ends.max(initial=0.0)) or 1.0
        force = float(space.weights @ pressure) or 1.0
        far = np.hypot(r - edges[:, None], z).min(axis=0) > NEAR * reach
        displacement_difference, stress_difference = (
            fine[field][state, far] - coarse[field][state, far] for field in (2, 3)
        )
        area = np.pi * np.diff(parts[-1] ** 2).sum() or np.pi
        mean = force / area
        ground = problem.ground.in_units_of(reach)
        indentation = flat_punch_of(0.0, ground).indentation * force / reach
        # the von Mises stress is a norm: that of the difference is at least the difference of the
        # two
        differences = (
            displacement_difference / indentation,
            stress_difference / mean,
            von_mises(stress_difference) / mean,
        )
        for estimate, difference in zip(errors.values(), differences, strict=True):
            estimate[state] = max(factor * np.abs(difference).max(), floor)
    layers = np.repeat(solid.layers, len(r) // solid.mesh.nelements)
    return Interior(*fine, labels, solid.degree, reaches, tuple(parts), errors, layers, creases)


def add_far_field(
    inside: Interior, half_space: "HalfSpace", pressures: Array, depth: float
) -> Interior:
    """Return the inside with the exact far field beyond the mesh, down to a depth.

    Nothing is added if the mesh is that deep.

    Parameters
    ----------
    inside : the fields on the mesh
    half_space : the half-space
    pressures : (states, size) on the space of the half-space
    depth : depth of the far field, in punch radii
    """
    from .....fem.far_field import fields_beyond
    from .....meshes.half_space import truncation

    mesh_radius, solid, space = (
        truncation(half_space.solid.mesh),
        half_space.solid,
        half_space.space,
    )
    if depth <= mesh_radius:
        return inside
    rings = max(2, 1 + ceil(log(depth / mesh_radius) / log(FAR_GROWTH)))
    distance, angle = np.meshgrid(
        np.geomspace(mesh_radius, depth, rings),
        np.linspace(0.0, np.pi / 2, FAR_ANGLES),
        indexing="ij",
    )
    points = np.stack([distance * np.sin(angle), distance * np.cos(angle)]).reshape(2, -1)
    # on the surface and on the axis, sines and cosines give roundoff instead of zero
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
