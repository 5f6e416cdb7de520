"""Static contact in closed form.

A punch ``f = c r^n`` on a half-space, any ``n > 0``; the sphere and the cone among them.

Sneddon, The relation between load and penetration in the axisymmetric Boussinesq problem for a
punch of arbitrary profile, Int. J. Engng Sci. 3 (1965) 47, doi 10.1016/0020-7225(65)90019-4; by the
one-dimensional profile ``g = kappa c x^n`` of Eq. 3 also in Popov and Hess, Method of
Dimensionality Reduction in Contact Mechanics and Friction (2015), chapter 3. With the radius of
contact a,

    kappa = sqrt(pi) Gamma(n/2 + 1) / Gamma((n + 1)/2),       d = kappa c a^n,
    F = 2 E* kappa c a^(n+1) n / (n + 1),
    p(r) = (n E* kappa c / pi) a^(n-2) s 2F1(1, 1 - n/2; 3/2; s^2 / a^2),       s^2 = a^2 - r^2.

A sphere of radius R has n = 2 and c = 1/(2 R), a cone n = 1 and its slope. Plane strain modulus 1.
The annulus and the worn sphere
have no exact closed form, but limits.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1, gamma, hyp2f1


@dataclass(frozen=True)
class PowerPunch:
    """The punch ``f = coefficient r^exponent`` in contact on a disc."""

    coefficient: float
    exponent: float

    @property
    def kappa(self):
        n = self.exponent
        return float(np.sqrt(np.pi) * gamma(n / 2 + 1) / gamma((n + 1) / 2))

    def indentation(self, radius):
        """By the radius of contact."""
        return self.kappa * self.coefficient * radius**self.exponent

    def force(self, radius):
        """By the radius of contact."""
        n = self.exponent
        return 2 * self.kappa * self.coefficient * radius ** (n + 1) * n / (n + 1)

    def contact_radius(self, force):
        return float((force / self.force(1.0)) ** (1 / (self.exponent + 1)))

    def pressure(self, radius, radii):
        """At radii, by the radius of contact; zero outside."""
        n, inside = self.exponent, np.minimum(np.abs(radii) / radius, 1.0)
        depth = np.sqrt((1 - inside) * (1 + inside))
        shape = depth * hyp2f1(1.0, 1 - n / 2, 1.5, depth**2)
        return np.asarray(n * self.kappa * self.coefficient / np.pi * radius ** (n - 1) * shape)


@dataclass(frozen=True)
class RoundedPunch:
    """A flat face of radius b that falls away beyond it as a parabola, ``f = (r - b)^2 / (2 R)``.

    M. Ciavarella, Indentation by nominally flat or conical indenters with rounded corners, Int. J.
    Solids Struct. 36 (1999) 4149; first by G. Schubert, Ing.-Arch. 13 (1942) 132. By the
    one-dimensional profile ``g(x) = x int_b^x f'(r) dr / sqrt(x^2 - r^2)`` it is, with ``cos(phi) =
    b / c``, ``g(c) = c b (tan(phi) - phi) / R = d``, and ``F = 2 E* (d c - int_b^c g dx)``.
    """

    flat_radius: float
    curvature_radius: float

    def indentation(self, radius):
        """By the radius of contact."""
        phi = np.arccos(self.flat_radius / radius)
        return radius * self.flat_radius * (np.tan(phi) - phi) / self.curvature_radius

    def force(self, radius):
        """By the radius of contact."""
        b, phi = self.flat_radius, np.arccos(self.flat_radius / radius)
        s = b * np.tan(phi)
        under = s**3 / 3 + b**2 * s / 2 - b * radius**2 * phi / 2
        return 2 * (self.indentation(radius) * radius - under / self.curvature_radius)

    def contact_radius(self, force):
        b = self.flat_radius
        return float(brentq(lambda c: self.force(c) - force, b * (1 + 1e-9), 1e3 * b, xtol=1e-15))


@dataclass(frozen=True)
class TruncatedCone:
    """A cone of slope s without its tip, ``f = s (r - b)`` beyond the flat face of radius b.

    By the one-dimensional profile ``g(x) = s x arccos(b / x)``; Popov, Hess and Willert, Handbook
    of Contact Mechanics (2019), section 2.5.9. Plane strain modulus 1.
    """

    flat_radius: float
    slope: float

    def indentation(self, radius):
        """By the radius of contact."""
        return self.slope * radius * np.arccos(self.flat_radius / radius)

    def force(self, radius):
        """By the radius of contact, ``2 (d c - int_b^c g dx)``."""
        b, c = self.flat_radius, radius
        under = c**2 / 2 * np.arccos(b / c) - b / 2 * np.sqrt((c - b) * (c + b))
        return 2 * (self.indentation(c) * c - self.slope * under)


@dataclass(frozen=True)
class TruncatedParaboloid:
    """A paraboloid without its tip, ``f = (r^2 - b^2) / (2 R)`` beyond the flat face of radius b.

    By ``g(x) = x sqrt(x^2 - b^2) / R``; the same handbook, section 2.5.10. Plane strain modulus 1.
    """

    flat_radius: float
    curvature_radius: float

    def indentation(self, radius):
        """By the radius of contact."""
        b, c = self.flat_radius, radius
        return c * np.sqrt((c - b) * (c + b)) / self.curvature_radius

    def force(self, radius):
        """By the radius of contact, ``2 (d c - int_b^c g dx)``."""
        b, c = self.flat_radius, radius
        under = ((c - b) * (c + b)) ** 1.5 / (3 * self.curvature_radius)
        return 2 * (self.indentation(c) * c - under)


def annulus_stiffness(hole):
    """``F / (2 E* a d)`` of a flat annulus with a small hole, by the ratio e of its radii, to the
    order of ``e^8``.

    W. D. Collins, On the solution of some axisymmetric boundary value problems by means of integral
    equations, VIII. Potential problems for a circular annulus, Proc. Edinburgh Math. Soc. 13 (1963)
    235: the capacitance of an annulus over that of the disc, which is the stiffness of the punch
    over that of the punch without a hole.
    """
    e, square = hole, np.pi**2
    odd = 4 * e**3 / 3 + 8 * e**5 / 15 + 92 * e**7 / 315
    even = 16 * e**6 / 27 + 448 * e**8 / 675
    return float(1 - odd / square - even / square**2)


def thin_ring_stiffness(inner, outer):
    """``F / (E* d)`` of a flat ring much narrower than its radius.

    A ring of mean radius R and half-width w whose pressure goes as ``(w^2 - x^2)^(-1/2)``: with ``K
    -> ln(8 R / |x|)`` in Eq. 19 and the mean of ``ln |x|`` over that pressure, ``ln(w/2)``, it is
    ``pi^2 R / ln(16 R / w)``.
    """
    mean, half = (outer + inner) / 2, (outer - inner) / 2
    return float(np.pi**2 * mean / np.log(16 * mean / half))


def worn_sphere(curvature_radius, wear_coefficient, force, contact):
    """Time and indentation at which a sphere of one material has worn to a radius of contact, at
    sliding speed 1.

    The worn face is flat but for what the half-space yields under a uniform pressure ``F / (pi
    c^2)``: its edge stands at the height of the sphere, ``d = c^2 / (2 R) + u(c)`` with ``u(c) = 4
    F / (pi^2 c)``, and what has worn off is the cap less the volume of that displacement, ``pi c^4
    / (4 R) = k F t + 4 F c / (3 pi)``. It tends to the truth as wear flattens the pressure.
    """
    c = contact
    time = (np.pi * c**4 / (4 * curvature_radius) - 4 * force * c / (3 * np.pi)) / (
        wear_coefficient * force
    )
    return float(time), float(c**2 / (2 * curvature_radius) + 4 * force / (np.pi**2 * c))


@dataclass(frozen=True)
class FrettedSphere:
    """A sphere at a fixed indentation d, worn outside a radius c of stick until none there presses.

    V. L. Popov, Analytic solution for the limiting shape of profiles due to fretting wear, Sci.
    Rep. 4 (2014) 3749, doi 10.1038/srep03749: the one-dimensional profile ``x^2 / R`` stays inside
    c and carries alone, ``F = 2 E* int_0^c (d - x^2 / R) dx``; the face outside is where the
    half-space is under it, or unworn beyond.
    """

    curvature_radius: float
    indentation: float
    stick: float

    @property
    def force(self):
        c = self.stick
        return 2 * (self.indentation * c - c**3 / (3 * self.curvature_radius))

    def heights(self, radii):
        """Of the face, from its foremost point."""
        c, unworn = self.stick, radii**2 / (2 * self.curvature_radius)
        outside = np.maximum(radii, c)
        tail = c * np.sqrt((outside - c) * (outside + c)) / (2 * self.curvature_radius)
        beyond = outside**2 / (2 * self.curvature_radius)
        half_space = (self.indentation - beyond) * np.arcsin(c / outside) + tail
        worn = self.indentation - 2 / np.pi * half_space
        return np.where(radii > c, np.maximum(worn, unworn), unworn)


def disc_energies(discs):
    """(N, N) ``int u_a p_b dA`` of unit pressures on discs of radii a and b.

    The energy of one in the field of the other. Plane strain modulus 1.
    """
    outer, inner = np.maximum(discs[:, None], discs), np.minimum(discs[:, None], discs)
    square = (inner / outer) ** 2
    # (a^2 - b^2) K tends to zero as the discs become one, where K itself is infinite
    complement = (outer - inner) * (outer + inner)
    second = complement * ellipkm1(np.maximum(complement / outer**2, np.finfo(float).tiny))
    return 8 / 3 * outer * ((outer**2 + inner**2) * ellipe(square) - second)
