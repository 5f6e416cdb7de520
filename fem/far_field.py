"""Boussinesq multipoles: the exact exterior of a half-space loaded near the origin.

An axisymmetric load on ``r < 1`` is seen from afar as a point force, its horizontal Laplacian, and so on; the pole
of order ``n`` (0, 2, 4, ...) decays as ``1/rho^(n+1)``. In the Hankel form of Boussinesq's solution a horizontal
Laplacian multiplies by ``-s^2``, so each pole is a pair of Legendre functions and needs no derivation of its own:

    2G u_z =  2(1-nu) L_n + z L_(n+1),     L_n = int s^n exp(-sz) J_0(sr) ds = n! P_n(cos t) / rho^(n+1)
    2G u_r = -(1-2nu) M_n + z M_(n+1),     M_n = int s^n exp(-sz) J_1(sr) ds = (n-1)! sin t P_n'(cos t) / rho^(n+1)

with z the depth, ``rho`` and ``t`` the spherical radius and the angle from the axis. The surface is free of traction
but for the origin. The fields and their stresses are finite for every Poisson's ratio up to and including 1/2.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

from meshes.radial import Array


def _moments(r: Array, z: Array, order: int) -> tuple[Array, Array]:
    """L_order and M_order / r, finite on the axis, at the points."""
    rho = np.hypot(r, z)
    scale = rho ** -(order + 1.0)
    if order == 0:
        return scale, scale / (rho + z)
    values = legvander(z / rho, order)
    lower = np.arange(order - 1, -1, -2)
    slope = values[:, lower] @ (2.0 * lower + 1)
    factorial = math.factorial(order - 1)
    return order * factorial * values[:, order] * scale, factorial * slope * scale / rho


def pole(points: Array, order: int, poisson_ratio: float, shear_modulus: float) -> tuple[Array, Array]:
    """Displacement and stress of the pole of even `order`, normalised to size one at unit distance.

    Parameters
    ----------
    points : (n, 2) radius and depth, off the origin

    Returns
    -------
    displacement : (n, 2) radial and into the half-space
    stress : (n, 4) rr, zz, rz, hoop
    """
    r, z = points[:, 0], points[:, 1]
    nu, double = poisson_ratio, 2 * shear_modulus
    (l0, m0_r), (l1, m1_r), (l2, m2_r) = (_moments(r, z, order + i) for i in range(3))
    norm = math.factorial(order)
    hoop = z * m1_r - (1 - 2 * nu) * m0_r
    radial, axial = r * hoop, 2 * (1 - nu) * l0 + z * l1
    strain_rr = z * (l2 - m1_r) - (1 - 2 * nu) * (l1 - m0_r)
    strain_zz = -(1 - 2 * nu) * l1 - z * l2
    pressure_part = -2 * nu * l1  # lambda div u: finite at nu = 1/2
    shear = -z * r * m2_r  # (d u_r/dz + d u_z/dr) / 2
    stress = np.stack([pressure_part + strain_rr, pressure_part + strain_zz, shear, pressure_part + hoop], axis=1)
    return np.stack([radial, axial], axis=1) / (double * norm), stress / norm


def exterior_stiffness(segments: Array, orders: tuple[int, ...], poisson_ratio: float, shear_modulus: float) -> Array:
    """(k, k) energy of the poles outside a polygon, ``-int t_i . u_j dA`` over its sides.

    Parameters
    ----------
    segments : (m, 2, 2) end points of the sides, (radius, depth)
    orders : orders of the k poles
    """
    node, weight = leggauss(12)
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    points = (start[:, None] + (1 + node)[:, None] / 2 * along[:, None]).reshape(-1, 2)
    # normal times length; it points out of the meshed polygon, away from the origin
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    normal *= np.sign(np.sum(normal * start, axis=1))[:, None]
    normals = np.repeat(normal, len(node), axis=0)
    weights = 2 * np.pi * points[:, 0] * np.tile(weight / 2, len(segments))
    fields = [pole(points, order, poisson_ratio, shear_modulus) for order in orders]
    displacement = np.array([u for u, _ in fields])
    traction = np.array(
        [
            np.stack(
                [s[:, 0] * normals[:, 0] + s[:, 2] * normals[:, 1], s[:, 2] * normals[:, 0] + s[:, 1] * normals[:, 1]],
                axis=1,
            )
            for _, s in fields
        ]
    )
    stiffness = -np.einsum("ipx,p,jpx->ij", traction, weights, displacement, optimize=True)
    return (stiffness + stiffness.T) / 2
