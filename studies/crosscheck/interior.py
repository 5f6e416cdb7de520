"""What happens inside the half-space.

Displacements and stresses of the finite elements at chosen times.

Stresses converge half as fast as the indentation, so they have a degree of their own, the first
that is accurate enough by their own estimate. It is how far the fields are from those of one degree
and one pole less, on the same mesh: both computed from the contact on, the pressures with them. On
quadrilaterals the error falls by a factor of three or more per degree, which makes the difference
two to six times the error (`tests/physics/test_stresses.py`). Points within `NEAR` of the rim or a
ring edge, where stresses are infinite or jump, are left out of the estimate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, log
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from ...meshes.radial import Array, Indices
from ..methods.base import Solution
from ..problem.problem import D0, P0, Problem, Units
from ..problem.scene import Scene
from ..wear.full_contact import RunningIn

if TYPE_CHECKING:
    from ...fem.half_space import HalfSpace

# error of stresses, over the mean pressure, that goes with a relative error of the indentation
SHARE = 10
# distance from the rim and from ring edges, in a, from which on the estimate holds
NEAR = 0.2


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
    errors : of each field, by its name, in each state (states,): estimate of its greatest error
        further than `NEAR` from the rim and from ring edges; of displacements over a flat punch's
        indentation, of stresses over the mean pressure
    """

    points: Array
    triangles: Indices
    displacement: Array
    stress: Array
    labels: tuple[str, ...]
    degree: int
    errors: dict[str, Array]

    @cached_property
    def von_mises(self) -> Array:
        """(states, n) equivalent stress."""
        from ...fem.stresses import von_mises

        return von_mises(self.stress)


def interior(scene: Scene, fem: Solution) -> Interior:
    """The inside of the half-space at the scene's field times, and when steady.

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
    if times is None:
        times = [0.0] if problem.steady else [0.0, scene.wear.times[-1]]
    labels = [f"t={time:g}" for time in times] + ["steady"] * problem.steady
    # what the poles leave to the truncation is of the energy, where stresses feel its root
    accuracy = 1e-3 * min(SHARE * problem.rtol, 1e-3) ** 2
    poles = enough_poles(truncation(half_space.solid.mesh), accuracy)
    if problem.fem.poles:
        poles = half_space.poles
    # a clamped boundary is judged by one that is not: the difference is the error itself, far
    # greater than any other
    orders = (poles, poles[:-1]) if half_space.poles else ((), poles)
    # of a lower degree there may be no stable pressures
    degree = max(half_space.solid.degree, 3)
    # what the user has given stays, and no degree mends the truncation
    given = problem.fem.degree or problem.fem.poles or not half_space.poles
    highest = degree if given else max(degree, highest)
    # closer to incompressible, it takes that of the contact
    if not given and problem.poisson_ratio <= 0.499:
        # estimates on quadrilaterals are 6 / 3^degree
        degree = max(min(degree, ceil(log(6 / (SHARE * problem.rtol), 3))), 3)

    def refine(degree: int) -> list[HalfSpace]:
        solids = [
            replace(half_space.solid, degree=lower, highest_ratio=ratio)
            for lower in (degree, degree - 1)
        ]
        return [
            HalfSpace(solid, pressure_space(solid, problem.merged.ring_edges), tied)
            for solid, tied in zip(solids, orders, strict=True)
        ]

    with threadpool_limits(1):
        while True:
            fine, coarse = (
                sample(problem, refined, np.array(times) / problem.units.time, refinements)
                for refined in refine(degree)
            )
            errors = estimate(problem, fine, coarse, ratio)
            excess = errors["stress"].max() / (SHARE * problem.rtol)
            result = Interior(*fine, tuple(labels), degree, errors)
            if excess <= 1 or degree == highest:
                return result
            # three times as accurate by each degree
            degree = min(degree + ceil(log(excess, 3)), highest)
            # matrices of more pressures are dense, and not worth it for the sake of the inside
            if refine(degree)[0].space.size > 2000:
                return result


def sample(
    problem: Problem, half_space: "HalfSpace", times: Array, refinements: int
) -> tuple[Array, Indices, Array, Array]:
    """Return the fields of a half-space at non-dimensional times, and when steady, all from its
    pressures.
    """
    from ...fem.stresses import sampled

    loading = problem.loading
    force, distances, *_ = loading.at(times)
    earliest = float(min(distances[distances > 0], default=0.0))
    rings = problem.merged
    wear = RunningIn(half_space.compliance(), rings.wear_coefficients, earliest, loading=loading)
    # no modes are needed for the start
    pressures = list(np.outer(force, wear.flat.pressure))
    if distances.any():
        pressures = list(wear.modal(times).pressure)
    if problem.steady:
        pressures.append(wear.steady.pressure)
    return sampled(half_space, np.array(pressures), refinements)


def estimate(
    problem: Problem, fine: Sequence[Any], coarse: Sequence[Any], highest_ratio: float
) -> dict[str, Array]:
    """Return the error estimate of each field in each state, by its name.

    It is one and a half times the greatest difference, and what Poisson's ratio 1/2 adds to it.
    """
    from ...fem.stresses import von_mises

    r, z = fine[0]
    far = np.hypot(r - problem.merged.ring_edges[1:, None], z).min(axis=0) > NEAR
    # fields are in proportion to 1 - 2 nu, plus a constant, and neither is much more than the unit
    modelled = 2 * max(0.0, problem.poisson_ratio - highest_ratio)
    moved, stress = (
        part[:, far] - other[:, far] for part, other in zip(fine[2:], coarse[2:], strict=True)
    )
    differences = {
        "displacement": moved / D0,
        "stress": stress / (2 * P0),
        # a norm: that of the difference is at least the difference of two
        "von_mises": von_mises(stress)[..., None] / (2 * P0),
    }
    # with the factor of safety of the contact's own estimates
    return {name: 1.5 * np.abs(of).max(axis=(1, 2)) + modelled for name, of in differences.items()}


def write_half_space(fields: Interior, units: Units, path: Path) -> None:
    """Write the fields as VTU, in the scene's units and upright.

    X is the radius, y the height (depth is negative).
    """
    import meshio

    data: dict[str, Array] = {}
    r, z = fields.points * units.length
    nothing = np.zeros_like(r)
    for state, label in enumerate(fields.labels):
        radial, down = fields.displacement[state].T * units.displacement
        data[f"displacement {label}"] = np.stack([radial, -down, nothing], axis=1)
        stress = fields.stress[state] * [1, 1, -1, 1] * units.pressure
        for name, values in zip(("rr", "zz", "rz", "hoop"), stress.T, strict=True):
            data[f"stress_{name} {label}"] = values
        data[f"von_mises {label}"] = fields.von_mises[state] * units.pressure
    upright = np.stack([r, -z, nothing], axis=1)
    meshio.Mesh(upright, [("triangle", fields.triangles.T)], point_data=data).write(
        path, file_format="vtu", compression=None
    )
