"""Boussinesq multipoles: the exact exterior of a half-space loaded near the origin.

Far away, an axisymmetric load on ``r < 1`` acts as a point force, its horizontal Laplacian, and so
on. The pole of order ``n`` (0, 2, 4, ...) decays as ``1/rho^(n+1)``. In the Hankel form of
Boussinesq's solution a horizontal Laplacian is a multiplication by ``-s^2``. Each pole is therefore
a pair of Legendre functions, and no separate derivation is needed:

    2G u_z =  2(1-nu) L_n + z L_(n+1)
    2G u_r = -(1-2nu) M_n + z M_(n+1)
    L_n = int s^n exp(-sz) J_0(sr) ds = n! P_n(cos t) / rho^(n+1)
    M_n = int s^n exp(-sz) J_1(sr) ds = (n-1)! sin t P_n'(cos t) / rho^(n+1)

with z the depth, ``rho`` and ``t`` the spherical radius and the angle from the axis. The surface is
free of traction except at the origin. The fields and their stresses are finite for every Poisson's
ratio up to and including 1/2.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.polynomial.legendre import legvander

from ..meshes.radial import Array, unit_gauss

# function that returns displacements (k, n, 2) and stresses (k, n, 4) of k solutions at n points
Fields = Callable[[Array], tuple[Array, Array]]


def enough_poles(truncation: float, negligible: float) -> tuple[int, ...]:
    """Return the orders of the poles that make the error of the truncation negligible.

    Parameters
    ----------
    truncation : radius R of the outer boundary, in units of the punch radius `a`
    negligible : acceptable relative error of the energy

    Notes
    -----
    With n poles, the first one neglected contributes the fraction ``(a/R)^(4n+1)`` of the energy
    (`ringwear study truncation`).
    """
    count = max(1, math.ceil((math.log(1 / negligible) / math.log(truncation) - 1) / 4))
    return tuple(range(0, 2 * count, 2))


def _moments(points: Array, highest: int) -> tuple[Array, Array]:
    """Return L_n / n! and M_n / (r n!) (highest + 1, n) at the points, both finite on the axis."""
    r, z = points.T
    rho = np.hypot(r, z)
    order = np.arange(highest + 1)[:, None]
    scale = rho ** -(order + 1.0)
    values = legvander(z / rho, highest).T
    # P_n' is the sum of (2k + 1) P_k over k = n - 1, n - 3, ...
    coefficients = np.where(
        (order > order.T) & ((order - order.T) % 2 == 1), 2 * order.T + 1.0, 0.0
    )
    slopes = (coefficients @ values) * scale / rho / np.maximum(order, 1)
    slopes[0] = scale[0] / (rho + z)
    return values * scale, slopes


def poles(
    points: Array, orders: tuple[int, ...], poisson_ratio: float, shear_modulus: float
) -> tuple[Array, Array]:
    """Return the displacements and stresses of poles of even orders.

    Each pole is normalised to size 1 at unit distance from the origin.

    Parameters
    ----------
    points : (n, 2) radius and depth, away from the origin
    orders : even orders of the poles
    poisson_ratio, shear_modulus : elastic constants of the half-space

    Returns
    -------
    displacement : (k, n, 2) radial, and axial (positive into the half-space)
    stress : (k, n, 4) rr, zz, rz, hoop
    """
    r, z = points.T
    order = np.array(orders, dtype=np.int64)
    first, second = (order + 1.0)[:, None], ((order + 1.0) * (order + 2))[:, None]
    (l0, l1, l2), (m0_r, m1_r, m2_r) = (
        (moments[order], first * moments[order + 1], second * moments[order + 2])
        for moments in _moments(points, int(order.max(initial=0)) + 2)
    )
    displacement, stress = fields_of_waves(r, z, (l0, l1, l2), (m0_r, m1_r, m2_r), poisson_ratio)
    return displacement / (2 * shear_modulus), stress


def fields_of_waves(
    r: Array,
    z: Array,
    cosines: tuple[Array, Array, Array],
    sines: tuple[Array, Array, Array],
    poisson_ratio: float,
) -> tuple[Array, Array]:
    """Return displacements times twice the shear modulus, and stresses, of loads on the surface.

    Parameters
    ----------
    r, z : radii and depths, which broadcast with the integrals
    cosines : integrals of ``s^n exp(-s z) J_0(s r)`` times the transform of the load, n = 0, 1, 2
    sines : integrals of ``s^n exp(-s z) J_1(s r) / r`` times it
    poisson_ratio : of the half-space

    Returns
    -------
    displacement : (..., 2) radial, and axial (positive into the half-space)
    stress : (..., 4) rr, zz, rz, hoop
    """
    nu, (l0, l1, l2), (m0_r, m1_r, m2_r) = poisson_ratio, cosines, sines
    hoop = z * m1_r - (1 - 2 * nu) * m0_r
    radial, axial = r * hoop, 2 * (1 - nu) * l0 + z * l1
    strain_rr = z * (l2 - m1_r) - (1 - 2 * nu) * (l1 - m0_r)
    strain_zz = -(1 - 2 * nu) * l1 - z * l2
    dilatation_part = -2 * nu * l1  # lambda div u: finite at nu = 1/2
    shear = -z * r * m2_r  # (d u_r/dz + d u_z/dr) / 2
    stress = np.stack(
        [dilatation_part + strain_rr, dilatation_part + strain_zz, shear, dilatation_part + hoop],
        axis=-1,
    )
    return np.stack([radial, axial], axis=-1), stress


def fields_beyond(
    points: Array, moments: Array, poisson_ratio: float, shear_modulus: float
) -> tuple[Array, Array]:
    """Return displacements and stresses far away from the pressures on ``r < 1`` that cause them.

    The displacement has the shape (states, n, 2), the stress (states, n, 4).

    Parameters
    ----------
    points : (n, 2) radius and depth, at a distance of more than 1 from the origin
    moments : (states, K) ``int p r^2k dA``
    poisson_ratio, shear_modulus : elastic constants of the half-space

    Notes
    -----
    From the Taylor series of the Hankel transform of the pressure, the pole of order 2k has the
    amplitude ``(2k)! (-1)^k / (4^k k!^2) int p r^2k dA / (2 pi)``. With K poles, the neglected part
    decreases as ``1 / rho^(2K)``.
    """
    count = moments.shape[1]
    orders = tuple(range(0, 2 * count, 2))
    # (2k)! / (4^k k!^2) is a product of (2i - 1) / (2i)
    halves = np.arange(1, count)
    sizes = np.append(1.0, np.cumprod(-(2 * halves - 1) / (2 * halves))) / (2 * np.pi)
    displacement, stress = poles(points, orders, poisson_ratio, shear_modulus)
    amplitudes = moments * sizes
    return (
        np.einsum("sk,knx->snx", amplitudes, displacement),
        np.einsum("sk,knx->snx", amplitudes, stress),
    )


def exterior_stiffness(segments: Array, fields: Fields) -> Array:
    """Return the energy matrix (k, k) of k solutions in the region outside a polygon.

    Its entries are the integrals ``-int t_i . u_j dA`` over the sides of the polygon, with the
    traction t and the displacement u of the solutions, for example poles.

    Parameters
    ----------
    segments : (m, 2, 2) end points of the sides, (radius, depth)
    fields : function that returns displacements and stresses at points
    """
    node, weight = unit_gauss(12)
    start, side_vectors = segments[:, 0], segments[:, 1] - segments[:, 0]
    points = (start[:, None] + node[:, None] * side_vectors[:, None]).reshape(-1, 2)
    # normal times length; it points out of the meshed polygon, away from the origin
    normal = np.stack([side_vectors[:, 1], -side_vectors[:, 0]], axis=1)
    normal *= np.sign(np.sum(normal * start, axis=1))[:, None]
    n_r, n_z = np.repeat(normal, len(node), axis=0).T
    weights = 2 * np.pi * points[:, 0] * np.tile(weight, len(segments))
    displacement, stress = fields(points)
    rr, zz, rz, _ = np.moveaxis(stress, -1, 0)
    traction = np.stack([rr * n_r + rz * n_z, rz * n_r + zz * n_z], axis=-1)
    stiffness = -np.einsum("ipx,p,jpx->ij", traction, weights, displacement, optimize=True)
    return (stiffness + stiffness.T) / 2
