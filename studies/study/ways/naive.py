"""Naive finite elements: a solver that one would write in an afternoon, for comparison.

It uses scikit-fem's triangles of degree 2 with elements of one size on the face, and an outer
boundary that is clamped at a few radii. Displacements of the face are prescribed in its nodes, so
that every node sticks to the punch and may pull. Pressures follow from the reactions. Wear is
computed in the nodes, by explicit Euler with one fixed step. The mesh is not graded at edges, and
no error is estimated.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, BilinearForm, ElementLineP2, ElementTriP2, MeshLine, MeshTri, asm

from ....fem import AxisymmetricElasticity, HalfSpace, pressure_space
from ....meshes import Array, Ground
from ...crosscheck import Problem, Results

DEFAULT_CELLS = 20
"""Elements on the radius of the punch."""
OUTER = 10.0
"""Radius and depth at which the half-space is clamped, in punch radii."""
MOST_STEPS = 6000
"""Greatest number of steps: a run that would need more has longer steps."""
GROWTH = 1.3
"""Ratio of neighbouring element sizes outside the punch, where sizes grow."""
HIGHEST_POISSON_RATIO = 0.4999999999
"""Poisson's ratio that replaces 1/2, for which Lame's first constant is infinite."""


class Face(NamedTuple):
    """The face of the punch on a uniform mesh, with the half-space condensed to its nodes.

    Parameters
    ----------
    basis : quadratic basis functions of the radius, with one element for each facet of the face
    order : (n,) indices of the basis functions, sorted by the radius of their nodes
    stiffness : (n, n) vertical reactions of the nodes per vertical displacement of each node
    pressure_per_height : (n, n) pressures of the nodes per vertical displacement of each node
    """

    basis: Basis
    order: NDArray[np.int64]
    stiffness: Array
    pressure_per_height: Array

    @property
    def radii(self) -> Array:
        """(n,) radii of the nodes."""
        return self.basis.doflocs[0][self.order]

    def wear_coefficients(self, problem: Problem) -> Array:
        """Return the wear coefficients (n,) in the nodes."""
        return problem.merged.at(np.clip(self.radii, problem.inner_radius, 1.0))

    def values_at(self, radii: Array, nodal: Array) -> Array:
        """Return the values (T, R) of functions at radii (R,) from their nodal values (T, n)."""
        inside = np.clip(radii, *self.radii[[0, -1]])
        return np.asarray(self.basis.probes(inside[None]).tocsc()[:, self.order] @ nodal.T).T


@lru_cache(maxsize=8)
def press(inner_radius: float, poisson_ratio: float, outer: float, cells: int) -> Face:
    """Return the face of a punch on a half-space of uniform triangles.

    Parameters
    ----------
    inner_radius : of the punch
    poisson_ratio : up to `HIGHEST_POISSON_RATIO`
    outer : radius and depth at which the half-space is clamped, in punch radii
    cells : number of elements on the radius of the punch, or on the width of a hollow one

    Raises
    ------
    SolverError
        if the stiffness is singular
    """
    face = np.linspace(inner_radius, 1.0, cells + 1)
    in_hole = np.linspace(0.0, inner_radius, max(round(cells * inner_radius), 1) + 1)
    count = int(np.ceil(np.log1p((outer - 1) * cells * (GROWTH - 1)) / np.log(GROWTH)))
    growing = (GROWTH ** np.arange(1, count + 1) - 1) / (GROWTH**count - 1)
    line = np.concatenate([in_hole[:-1] * bool(inner_radius), face, 1 + (outer - 1) * growing])
    line, edges = np.unique(line), face[[0, -1]]
    mesh = MeshTri.init_tensor(line, line).with_boundaries(
        {
            "contact": lambda x: (x[1] == 0) & (x[0] > inner_radius) & (x[0] < 1),
            "axis": lambda x: x[0] == 0,
            "far": lambda x: (x[0] == outer) | (x[1] == outer),
        }
    )
    ground = Ground.half_space(min(poisson_ratio, HIGHEST_POISSON_RATIO))
    solid = AxisymmetricElasticity(mesh, 2, ground, ElementTriP2(), HIGHEST_POISSON_RATIO)
    half_space = HalfSpace(solid, pressure_space(solid, edges), poles=())
    stiffness, basis = half_space.contact_stiffness(), Basis(MeshLine(face), ElementLineP2())
    order = np.argsort(basis.doflocs[0])
    mass = asm(BilinearForm(lambda u, v, w: 2 * np.pi * w.x[0] * u * v), basis)
    pressures = np.linalg.solve(mass.toarray()[np.ix_(order, order)], stiffness)
    return Face(basis, order, stiffness, pressures)


def solve(
    problem: Problem, outer: float = OUTER, cells: int = DEFAULT_CELLS, step: float = 0.0
) -> Results:
    """Return the indentation and pressure at the times of a problem.

    The values overflow if the march is unstable.

    Parameters
    ----------
    problem : with its times
    outer : radius and depth at which the half-space is clamped, in punch radii
    cells : number of elements on the radius of the punch
    step : time step; by default that of `MOST_STEPS`
    """
    face = press(problem.inner_radius, problem.poisson_ratio, outer, cells)
    wear, loading, profile = face.wear_coefficients(problem), problem.loading, problem.profile
    heights = profile(face.radii) + profile.standoff
    pressure_per_depth = face.pressure_per_height.sum(axis=1)
    force_per_height = face.stiffness.sum(axis=0)

    def state(time: float) -> tuple[Array, float]:
        """Return the nodal pressures and the indentation at a time."""
        if problem.indentation is not None:
            depth = problem.indentation + profile.standoff
        else:
            force = np.interp(time, loading.times, loading.forces)
            depth = (force + force_per_height @ heights) / force_per_height.sum()
        return pressure_per_depth * depth - face.pressure_per_height @ heights, depth

    now, depths, pressures = 0.0, [], []
    step = max(step, problem.times[-1] / MOST_STEPS)
    with np.errstate(all="ignore"):
        for time in problem.times:
            count = int(np.ceil((time - now) / step - 1e-9))
            for number in range(count):
                at = now + (time - now) * number / count
                speed = np.interp(at, loading.times, loading.speeds)
                heights = heights + (time - now) / count * speed * wear * state(at)[0]
                if not np.isfinite(heights).all():
                    break
            now = time
            pressure, depth = state(now)
            depths.append(depth)
            pressures.append(pressure)
    values = face.values_at(problem.face.radii, np.array(pressures))
    return {"time": problem.times, "indentation": np.array(depths), "pressure": values}


def stable_step(problem: Problem, cells: int) -> float:
    """Return the greatest stable step of explicit Euler in a/(E* k_max v0).

    It is two over the greatest rate at which wear makes pressures decay at a fixed indentation.
    """
    face = press(problem.inner_radius, problem.poisson_ratio, OUTER, cells)
    rates = face.pressure_per_height * face.wear_coefficients(problem)[:, None]
    return float(2 / np.abs(np.linalg.eigvals(rates)).max())
