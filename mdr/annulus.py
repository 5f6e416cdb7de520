"""The flat annulus accurate to roundoff: a reference for hollow punches, by the ring kernel alone.

A frictionless flat annulus ``b <= r <= 1`` has no closed form. Its integral equation

    int_b^1 4 / (pi (r + s)) K(m) p(s) s ds = d,    m = 4 r s / (r + s)^2

with the complete elliptic integral K is solved by Nystroem's method. Layers of ground add to the
kernel the smooth function ``2 int_0^inf (Phi(k) - 1) J_0(k r) J_0(k s) dk``, where Phi is their
relative surface compliance. The angle in
``cos(angle) = ln(b / r^2) / ln b``, 0 at the hole and pi at the rim, makes ``p r dr = g d(angle)``
smooth although the pressure is infinite at both edges. The logarithm of the kernel is integrated
exactly, so that the error decreases geometrically with the number of points. The outer radius and
the plane strain modulus are 1.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import legvander

from ..meshes.ground.ground import HALF_SPACE, Ground, spectrum
from ..meshes.radial import Array

# number of quadrature angles; 36 of them already give 15 digits of the stiffness for b from 1e-4 to
# .9999
POINTS = 64
# quadrature angles per thickness of the first layer across the annulus
# (unit/mdr/test_annulus.py::test_the_flat_annulus_on_layers)
POINTS_PER_THICKNESS = 12.0
# radii on each ring among which extremes of the pressure are sought
SAMPLES_PER_RING = 200
# wave numbers at a time, to limit the memory for Bessel functions
BLOCK = 4096


@dataclass(frozen=True, eq=False)
class FlatAnnulus:
    """A flat annulus under the force 1.

    Parameters
    ----------
    inner_radius : inner radius b, between 0 and 1
    indentation : indentation d
    coefficients : (J,) of ``p r dr = sum_j c_j cos(j angle) d(angle)``
    """

    inner_radius: float
    indentation: float
    coefficients: Array

    def pressure_at(self, radii: Array) -> Array:
        """Return the pressure at radii (R,) on the annulus, which is infinite at both edges."""
        cosines, rate = cosine_pressures(
            self.inner_radius, radii - self.inner_radius, 1 - radii, len(self.coefficients)
        )
        return cosines @ self.coefficients * rate

    def ring_forces(self, ring_edges: Array) -> Array:
        """Return the force (N,) on each ring between edges (N+1,)."""
        _, angle = _sine_and_angle(
            self.inner_radius, ring_edges - self.inner_radius, 1 - ring_edges
        )
        order = np.arange(1, len(self.coefficients))
        waves = np.sin(angle[:, None] * order) / order @ self.coefficients[1:]
        return 2 * np.pi * np.diff(angle * self.coefficients[0] + waves)

    def extremes_on(self, ring_edges: Array) -> tuple[Array, Array]:
        """Return the least and the greatest pressure (N,) on each ring between edges (N+1,).

        On a homogeneous half-space the pressure falls from the hole to a single minimum and then
        rises to the rim; on layers it may have several extremes. Each is sought between the
        samples beside the smallest or the largest of several on each ring.
        """
        at_edges, extremes = self.pressure_at(ring_edges), np.empty((2, len(ring_edges) - 1))
        for number, bounds in enumerate(pairwise(ring_edges.tolist())):
            samples = np.linspace(*bounds, SAMPLES_PER_RING)
            for row, sign in enumerate((1.0, -1.0)):
                ends = sign * at_edges[number : number + 2]
                extremes[row, number] = sign * min(self._least(samples, sign), *ends)
        return extremes[0], extremes[1]

    def _least(self, samples: Array, sign: float) -> float:
        """Return the least of the pressure, or of its negative, between radii (S,)."""
        from scipy.optimize import minimize_scalar

        inside = 1 + int(np.argmin(sign * self.pressure_at(samples[1:-1])))
        bounds = samples[inside - 1], samples[inside + 1]
        found = minimize_scalar(
            lambda radius: sign * float(self.pressure_at(np.array([radius]))[0]),
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-9 * (bounds[1] - bounds[0])},
        )
        return float(found.fun)


@lru_cache(maxsize=64)
def flat_annulus(
    inner_radius: float, points: int | None = None, ground: Ground = HALF_SPACE
) -> FlatAnnulus:
    """Solve the flat annulus by Nystroem's method.

    Parameters
    ----------
    inner_radius : ratio of the inner to the outer radius, between 0 and 1
    points : number of quadrature angles; by default as many as suit the ground
    ground : layers
    """
    from scipy.special import ellipk, ellipkm1  # full punches do not need it

    points = points or _suitable_points(inner_radius, ground)
    angle, radius = _angles_and_radii(inner_radius, points)
    log_ratio = -np.log(inner_radius)
    order = np.arange(1, points)
    waves = np.cos(angle[:, None] * order)
    # weights of ln(4 (cos t - cos t')^2) in t'
    logarithm = -(np.pi / points) * (4 * waves / order) @ waves.T
    radius_sum = radius[:, None] + radius
    # difference of cosines without cancellation; ln r is linear in the cosine
    cosine_difference = (
        -2 * np.sin((angle[:, None] + angle) / 2) * np.sin((angle[:, None] - angle) / 2)
    )
    complement = np.tanh(cosine_difference * log_ratio / 4) ** 2
    np.fill_diagonal(cosine_difference, 1.0)
    np.fill_diagonal(complement, 0.5)
    # K(1 - complement) = smooth + factor * ln(4 cosine_difference^2)
    factor = -ellipk(complement) / np.pi
    smooth = ellipkm1(complement) - factor * np.log(4 * cosine_difference**2)
    np.fill_diagonal(factor, -0.5)
    np.fill_diagonal(smooth, np.log(32 / log_ratio))
    kernel = 4 / np.pi / radius_sum * (logarithm * factor + np.pi / points * smooth)
    kernel += np.pi / points * _kernel_of_layers(ground, radius)
    density = np.linalg.solve(kernel, np.ones(points))
    stiffness = float(2 * np.pi**2 * density.mean())
    coefficients = _cosines(angle, density / stiffness)
    return FlatAnnulus(inner_radius, 1 / stiffness, coefficients)


def _suitable_points(inner_radius: float, ground: Ground) -> int:
    """Return the number of quadrature angles; pressures vary over the thickness of a layer."""
    return max(POINTS, int(POINTS_PER_THICKNESS * (1 - inner_radius) / ground.first_thickness))


def _kernel_of_layers(ground: Ground, radii: Array) -> Array:
    """Return ``2 int_0^inf (Phi(k) - 1) J_0(k r) J_0(k s) dk`` (R, R) at radii (R,)."""
    from scipy.special import j0

    s, weights = spectrum(ground)
    kernel = np.zeros((len(radii), len(radii)))
    for part in np.array_split(np.arange(len(s)), 1 + len(s) // BLOCK):
        waves = j0(np.outer(radii, s[part]))
        kernel += (waves * (2 * weights[part])) @ waves.T
    return kernel


def flat_annulus_series(inner_radius: float, count: int, ground: Ground = HALF_SPACE) -> Array:
    """Return cosine coefficients of the flat annulus's pressure times Legendre polynomials.

    The polynomials are in ``r^2``; the coefficients (J, count) have one column for each polynomial.
    A method represents the pressure of a flat hollow punch by these functions, as it represents
    that of a full punch by ``P_2j(t) / t``.
    """
    annulus = flat_annulus(inner_radius, ground=ground)
    angle, radius = _angles_and_radii(inner_radius, len(annulus.coefficients))
    order = np.arange(len(annulus.coefficients))
    density = np.cos(angle[:, None] * order) @ annulus.coefficients
    squared_inner_radius, squared_width = inner_radius**2, (1 - inner_radius) * (1 + inner_radius)
    polynomials = legvander((2 * radius**2 - 1 - squared_inner_radius) / squared_width, count - 1)
    return _cosines(angle, density[:, None] * polynomials)


def cosine_pressures(
    inner_radius: float, from_hole: Array, to_rim: Array, count: int
) -> tuple[Array, Array]:
    """Return cosines (..., count), and the factor (...) that turns them into pressures.

    Parameters
    ----------
    inner_radius : inner radius b
    from_hole, to_rim : (...) distances of the radii from both edges; next to an edge the radius
        alone would have too few digits
    count : number of cosines
    """
    sine, angle = _sine_and_angle(inner_radius, from_hole, to_rim)
    radius = np.where(from_hole < to_rim, inner_radius + from_hole, 1 - to_rim)
    with np.errstate(divide="ignore"):
        factor = -2 / (np.log(inner_radius) * radius**2 * sine)
    return np.cos(angle[..., None] * np.arange(count)), factor


def _angles_and_radii(inner_radius: float, points: int) -> tuple[Array, Array]:
    """Return the angles of the quadrature and the radii that belong to them."""
    angle = (np.arange(points) + 0.5) * np.pi / points
    return angle, inner_radius ** ((1 + np.cos(angle)) / 2)


def _sine_and_angle(inner_radius: float, from_hole: Array, to_rim: Array) -> tuple[Array, Array]:
    """Return the sine and the angle at radii, without cancellation.

    The radii are given by their distances from the two edges.
    """
    inside, outside = np.log1p(from_hole / inner_radius), -np.log1p(-to_rim)
    log_ratio = -np.log(inner_radius)
    sine = 2 * np.sqrt(np.maximum(inside * outside, 0.0)) / log_ratio
    return sine, np.arctan2(sine, (outside - inside) / log_ratio)


def _cosines(angle: Array, density: Array) -> Array:
    """Return the cosine coefficients (P, ...) of densities (P, ...) at the quadrature angles."""
    count = len(angle)
    coefficients = 2 / count * np.cos(np.arange(count)[:, None] * angle) @ density
    coefficients[0] /= 2
    return coefficients
