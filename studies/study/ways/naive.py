"""Naive finite elements: a solver that one would write in an afternoon, for comparison.

It uses scikit-fem's triangles of degree 2 with elements of one size on the face, and an outer
boundary that is clamped at a few radii. Displacements of the face are prescribed in its nodes, so
that every node sticks to the punch and may pull. Pressures follow from the reactions. Wear is
computed in the nodes, by explicit Euler with one fixed step in the unit of the scene. The mesh is
not graded at edges, nothing is made non-dimensional, and no error is estimated.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu
from skfem import (
    Basis,
    BilinearForm,
    ElementLineP2,
    ElementTriP2,
    ElementVector,
    MeshLine,
    MeshTri,
    asm,
)

from ....meshes import Array, SolverError
from ...crosscheck import Problem, Results

DEFAULT_CELLS = 20
"""Elements on the radius of the punch."""
OUTER = 10.0
"""Radius and depth at which the half-space is clamped, in punch radii."""
STEP = 4e-4
"""Time step in the unit of the scene, whatever that unit is."""
MOST_STEPS = 6000
"""Greatest number of steps: a run that would need more has longer steps."""
GROWTH = 1.3
"""Ratio of neighbouring element sizes outside the punch, where sizes grow."""
HIGHEST_POISSON_RATIO = 0.4999999999
"""Poisson's ratio that replaces 1/2, for which Lame's first constant is infinite."""


@dataclass(frozen=True, eq=False)
class Face:
    """The face of the punch on a uniform mesh, with the half-space condensed to its nodes.

    Parameters
    ----------
    stiffness : (n, n) vertical reactions of the nodes per vertical displacement of each node
    mesh : mesh of the radius, with one element for each facet of the face
    """

    stiffness: Array
    mesh: MeshLine

    @cached_property
    def basis(self) -> Basis:
        """Quadratic basis functions of the radius."""
        return Basis(self.mesh, ElementLineP2())

    @cached_property
    def order(self) -> NDArray[np.int64]:
        """(n,) indices of the basis functions, sorted by the radius of their nodes."""
        return np.argsort(self.basis.doflocs[0])

    @property
    def radii(self) -> Array:
        """(n,) radii of the nodes, increasing."""
        return self.basis.doflocs[0][self.order]

    @cached_property
    def mass(self) -> Array:
        """(n, n) reactions per nodal pressure: ``int v_i v_j dA``."""
        mass = asm(BilinearForm(lambda u, v, w: 2 * np.pi * w.x[0] * u * v), self.basis)
        return mass.toarray()[np.ix_(self.order, self.order)]

    def values_at(self, radii: Array, nodal: Array) -> Array:
        """Return the values (T, R) of functions at radii (R,) from their nodal values (T, n)."""
        inside = np.clip(radii, *self.mesh.p[0, [0, -1]])
        return np.asarray(self.basis.probes(inside[None]).tocsc()[:, self.order] @ nodal.T).T


@lru_cache(maxsize=8)
def press(
    radius: float,
    inner_radius: float,
    modulus: float,
    poisson_ratio: float,
    outer: float,
    cells: int,
) -> Face:
    """Return the face of a punch on a half-space of uniform triangles.

    Parameters
    ----------
    radius, inner_radius : of the punch, in one unit of length
    modulus : plane strain modulus
    poisson_ratio : up to `HIGHEST_POISSON_RATIO`
    outer : radius and depth at which the half-space is clamped, in punch radii
    cells : number of elements on the radius of the punch, or on the width of a hollow one

    Raises
    ------
    SolverError
        if the stiffness is singular
    """
    ratio = min(poisson_ratio, HIGHEST_POISSON_RATIO)
    shear = modulus * (1 - ratio) / 2
    lame = 2 * shear * ratio / (1 - 2 * ratio)
    on_face = np.linspace(0.0, radius, cells + 1)
    if inner_radius:
        in_hole = np.linspace(0.0, inner_radius, max(round(cells * inner_radius / radius), 1) + 1)
        on_face = np.append(in_hole[:-1], np.linspace(inner_radius, radius, cells + 1))
    count = int(np.ceil(np.log1p((outer - 1) * cells * (GROWTH - 1)) / np.log(GROWTH)))
    outside = radius + (outer - 1) * radius * (GROWTH ** np.arange(1, count + 1) - 1) / (
        GROWTH**count - 1
    )
    line = np.append(on_face, outside)
    basis = Basis(MeshTri.init_tensor(line, line), ElementVector(ElementTriP2()), intorder=4)

    @BilinearForm
    def elasticity(u, v, w):  # type: ignore[no-untyped-def]
        r = w.x[0]
        strain_u, strain_v = (np.stack([f.grad[0, 0], f.grad[1, 1], f[0] / r]) for f in (u, v))
        slip_u, slip_v = (f.grad[0, 1] + f.grad[1, 0] for f in (u, v))
        normal = lame * strain_u.sum(axis=0) * strain_v.sum(axis=0)
        normal = normal + 2 * shear * (strain_u * strain_v).sum(axis=0)
        return 2 * np.pi * r * (normal + shear * slip_u * slip_v)

    full_stiffness = asm(elasticity, basis).tocsc()
    end = line[-1]
    clamped = basis.get_dofs(lambda x: (x[0] == end) | (x[1] == end)).all()
    axis = basis.get_dofs(lambda x: x[0] == 0).all("u^1")
    contact = basis.get_dofs(lambda x: (x[1] == 0) & (x[0] > inner_radius) & (x[0] < radius)).all(
        "u^2"
    )
    contact = contact[np.argsort(basis.doflocs[0, contact])]
    interior = np.setdiff1d(
        np.arange(full_stiffness.shape[0]), np.concatenate([clamped, axis, contact])
    )
    try:
        # Schur complement of the interior nodes
        response = splu(full_stiffness[interior][:, interior]).solve(
            full_stiffness[interior][:, contact].toarray()
        )
    except RuntimeError as error:
        raise SolverError(f"the naive stiffness cannot be factorised: {error}") from None
    stiffness = (
        full_stiffness[contact][:, contact].toarray()
        - full_stiffness[contact][:, interior] @ response
    )
    on_punch = line[(line >= inner_radius) & (line <= radius)]
    return Face(stiffness, MeshLine(on_punch))


def pressed(problem: Problem, outer: float, cells: int) -> tuple[Face, Array]:
    """Return the face of a problem, and the non-dimensional wear coefficients in its nodes (n,)."""
    length, hole = problem.units.length, problem.inner_radius
    face = press(length, hole * length, problem.units.modulus, problem.poisson_ratio, outer, cells)
    return face, problem.merged.at(np.clip(face.radii / length, hole, 1.0))


def solve(
    problem: Problem, outer: float = OUTER, cells: int = DEFAULT_CELLS, step: float = STEP
) -> Results:
    """Return the non-dimensional indentation and pressure at the times of a problem.

    The values overflow if the march is unstable.

    Parameters
    ----------
    problem : with its times; it is solved in the units of its scene
    outer : radius and depth at which the half-space is clamped, in punch radii
    cells : number of elements on the radius of the punch
    step : time step in the unit of the scene
    """
    units = problem.units
    length = units.length
    face, wear = pressed(problem, outer, cells)
    radii = face.radii / length
    # wear rate per pressure, in the units of the scene
    wear = wear * units.wear_rate / units.pressure
    heights = (problem.profile(radii) + problem.profile.standoff) * units.displacement
    pressure_per_height = np.linalg.solve(face.mass, face.stiffness)
    pressure_per_depth = pressure_per_height.sum(axis=1)
    force_per_height = face.stiffness.sum(axis=0)

    def state(now: float) -> tuple[Array, float]:
        """Return the nodal pressures and the indentation at a time in the unit of the scene."""
        if problem.indentation is not None:
            depth = (problem.indentation + problem.profile.standoff) * units.displacement
        else:
            force = float(np.interp(now / units.time, loading.times, loading.forces)) * units.force
            depth = (force + force_per_height @ heights) / force_per_height.sum()
        return pressure_per_depth * depth - pressure_per_height @ heights, depth

    loading, now, depths, pressures = problem.loading, 0.0, [], []
    greatest = problem.times[-1] * units.time
    step = max(step, greatest / MOST_STEPS)
    with np.errstate(all="ignore"):
        for time in problem.times * units.time:
            count = int(np.ceil((time - now) / step - 1e-9))
            for number in range(count):
                at = now + (time - now) * number / count
                speed = np.interp(at / units.time, loading.times, loading.speeds)
                heights = heights + (time - now) / count * speed * wear * state(at)[0]
                if not np.isfinite(heights).all():
                    break
            now = time
            pressure, depth = state(now)
            depths.append(depth)
            pressures.append(pressure)
    values = face.values_at(problem.face.radii * length, np.array(pressures))
    return {
        "time": problem.times,
        "indentation": np.array(depths) / units.displacement,
        "pressure": values / units.pressure,
    }


def stable_step(problem: Problem, cells: int) -> float:
    """Return the greatest stable step of explicit Euler in a/(E* k_max v0).

    It is two over the greatest rate at which wear makes pressures decay at a fixed indentation.
    """
    face, wear = pressed(problem, OUTER, cells)
    scale = problem.units.displacement / problem.units.pressure
    pressures = np.linalg.solve(face.mass, face.stiffness) * scale
    return float(2 / np.abs(np.linalg.eigvals(pressures * wear[:, None])).max())
