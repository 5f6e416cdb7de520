"""Test the refinement of a user-defined mesh.

It is a box mesh of scikit-fem, refined towards the rim of the punch and mapped to a quarter disc.
"""

import numpy as np
from skfem import MeshTri

from ringwear.fem import AxisymmetricElasticity, HalfSpace, enough_poles, pressure_space
from ringwear.meshes import as_half_space

# lengths in punch radii; each ring edge must be a vertex of the surface
ring_edges, outer = np.array([0.0, 0.5, 1.0]), 4.0
box = MeshTri.init_tensor(np.linspace(0, outer, 9), np.linspace(0, outer, 9))
for refined in range(8):
    length = np.maximum(np.hypot(*box.p), 1e-300)
    disc = as_half_space(MeshTri(box.p * box.p.max(axis=0) / length, box.t), ring_edges)
    solid = AxisymmetricElasticity(disc, degree=3)
    half = HalfSpace(solid, pressure_space(solid, ring_edges), enough_poles(outer, 1e-6))
    # flat punch under the force 1 with a continuous pressure: A p = d b, b . p = 1
    continuous = half.space.joined()
    factor, force = half.compliance().factor @ continuous, half.space.weights @ continuous
    indentation = 1 / (force @ np.linalg.solve(factor.T @ factor, force))
    triangles, error = box.nelements, indentation / 0.5 - 1
    print(f"{refined} times: {triangles:5d} triangles, relative error of F/(2 a E*) {error:+.1e}")
    # refine near the rim, where the pressure is infinite
    to_rim = np.hypot(box.p[0, box.t].mean(axis=0) - 1, box.p[1, box.t].mean(axis=0))
    box = box.refined(np.flatnonzero(to_rim < 1.2 * 0.6**refined))
