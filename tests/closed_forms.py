"""Closed forms of static contact.

The main one is that of a punch ``f = c r^n`` with any ``n > 0`` on a half-space; it includes the
sphere and the cone. Source: Sneddon, The relation between load and penetration in the axisymmetric
Boussinesq problem for a punch of arbitrary profile, Int. J. Engng Sci. 3 (1965) 47, doi
10.1016/0020-7225(65)90019-4. Popov and Hess, Method of Dimensionality Reduction in Contact
Mechanics and Friction (2015), chapter 3, derive it from the one-dimensional profile ``g = kappa c
x^n`` of Eq. 3. With the contact radius a,

    kappa = sqrt(pi) Gamma(n/2 + 1) / Gamma((n + 1)/2),       d = kappa c a^n,
    F = 2 E* kappa c a^(n+1) n / (n + 1),
    p(r) = (n E* kappa c / pi) a^(n-2) s 2F1(1, 1 - n/2; 3/2; s^2 / a^2),       s^2 = a^2 - r^2.

A sphere of radius R has n = 2 and c = 1/(2 R); a cone has n = 1, and c is its slope. All functions
have the plane strain modulus 1. The annulus and the worn sphere have no exact closed form, only
the limits that are given here. The steady state of wear along the radius is an integral.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.special import ellipe, ellipkm1, gamma, hyp2f1

from ringwear import direct


@dataclass(frozen=True)
class PowerPunch:
    """Contact of the punch ``f = coefficient r^exponent`` on a disc."""

    coefficient: float
    exponent: float

    @property
    def kappa(self):
        n = self.exponent
        return float(np.sqrt(np.pi) * gamma(n / 2 + 1) / gamma((n + 1) / 2))

    def indentation(self, radius):
        """Return the indentation at a contact radius."""
        return self.kappa * self.coefficient * radius**self.exponent

    def force(self, radius):
        """Return the force at a contact radius."""
        n = self.exponent
        return 2 * self.kappa * self.coefficient * radius ** (n + 1) * n / (n + 1)

    def contact_radius(self, force):
        return float((force / self.force(1.0)) ** (1 / (self.exponent + 1)))

    def pressure(self, radius, radii):
        """Return the pressure at radii for a contact radius; it is zero outside the contact."""
        n, inside = self.exponent, np.minimum(np.abs(radii) / radius, 1.0)
        depth = np.sqrt((1 - inside) * (1 + inside))
        shape = depth * hyp2f1(1.0, 1 - n / 2, 1.5, depth**2)
        return np.asarray(n * self.kappa * self.coefficient / np.pi * radius ** (n - 1) * shape)


# F / (E* a d) of flat annuli by the ratio of radii b/a, to nine digits
ANNULI = {0.3: 1.992418655, 0.6: 1.930144257, 0.9: 1.642059559}


def thin_ring_stiffness(inner, outer):
    """Return ``F / (E* d)`` of a flat ring that is much narrower than its radius.

    The ring has the mean radius R and the half-width w, and its pressure is proportional to ``(w^2
    - x^2)^(-1/2)``. In Eq. 19, ``K -> ln(8 R / |x|)``, and the mean of ``ln |x|`` over that
    pressure is ``ln(w/2)``. Hence the stiffness is ``pi^2 R / ln(16 R / w)``.
    """
    mean, half = (outer + inner) / 2, (outer - inner) / 2
    return float(np.pi**2 * mean / np.log(16 * mean / half))


def worn_sphere(curvature_radius, wear_coefficient, force, contact):
    """Return time and indentation at which a sphere has worn to a contact radius c.

    The sphere has one material and the sliding speed is 1. The formula assumes that the pressure is
    uniform, ``F / (pi c^2)``. The contact edge is on the unworn sphere, hence ``d = c^2 / (2 R) +
    u(c)`` with ``u(c) = 4 F / (pi^2 c)``. The worn volume is that of the cap minus that of the
    displacement, hence ``pi c^4 / (4 R) = k F t + 4 F c / (3 pi)``. The error tends to zero as wear
    makes the pressure uniform.
    """
    c = contact
    time = (np.pi * c**4 / (4 * curvature_radius) - 4 * force * c / (3 * np.pi)) / (
        wear_coefficient * force
    )
    return float(time), float(c**2 / (2 * curvature_radius) + 4 * force / (np.pi**2 * c))


@dataclass(frozen=True)
class FrettedSphere:
    """Limiting shape of a sphere at a fixed indentation d that wears outside a stick radius c only.

    V. L. Popov, Analytic solution for the limiting shape of profiles due to fretting wear, Sci.
    Rep. 4 (2014) 3749, doi 10.1038/srep03749. In the limit the pressure outside c is zero. The
    one-dimensional profile ``x^2 / R`` is unchanged inside c and carries the whole force, ``F = 2
    E* int_0^c (d - x^2 / R) dx``. Outside c, the worn face lies on the surface of the half-space;
    where that is below the unworn face, the face is unworn.
    """

    curvature_radius: float
    indentation: float
    stick: float

    @property
    def force(self):
        c = self.stick
        return 2 * (self.indentation * c - c**3 / (3 * self.curvature_radius))

    def heights(self, radii):
        """Return heights of the face at radii, measured from its foremost point."""
        c, unworn = self.stick, radii**2 / (2 * self.curvature_radius)
        outside = np.maximum(radii, c)
        tail = c * np.sqrt((outside - c) * (outside + c)) / (2 * self.curvature_radius)
        beyond = outside**2 / (2 * self.curvature_radius)
        half_space = (self.indentation - beyond) * np.arcsin(c / outside) + tail
        worn = self.indentation - 2 / np.pi * half_space
        return np.where(radii > c, np.maximum(worn, unworn), unworn)


def disc_energies(discs):
    """Return the (N, N) energies ``int u_a p_b dA`` of unit pressures on discs of radii a and b.

    Each is the energy of one pressure in the displacement of the other. Plane strain modulus 1.
    """
    outer, inner = np.maximum(discs[:, None], discs), np.minimum(discs[:, None], discs)
    square = (inner / outer) ** 2
    # (a^2 - b^2) K tends to zero for equal discs, although K itself is infinite there
    complement = (outer - inner) * (outer + inner)
    second = complement * ellipkm1(np.maximum(complement / outer**2, np.finfo(float).tiny))
    return 8 / 3 * outer * ((outer**2 + inner**2) * ellipe(square) - second)


@dataclass(frozen=True, eq=False)
class GradedSteadyState:
    """Steady state of wear under the force 1 if k is linear between radii, and jumps at equal ones.

    The wear rate ``w = k p`` is constant, so that ``1 / w = int dA / k``. The pressure is a sum of
    discs under uniform pressures: ``p(1)`` on the whole punch, ``-p'(c) dc`` on each radius c, and
    the jumps of p. Displacement and slope of a disc are those of `direct`, which is tested by
    itself, and the sum is an integral over c. Gauss's rule is used between points that approach the
    ends of intervals and the radius of the result geometrically, and between which k grows by at
    most half.

    Parameters
    ----------
    radii, values : k along the radius, from 0 (or from the hole) to 1
    """

    radii: np.ndarray
    values: np.ndarray

    @property
    def intervals(self):
        """Intervals (inner radius, outer radius, k at both) in which k is linear."""
        rows = zip(pairwise(self.radii), pairwise(self.values), strict=True)
        return [(*ends, *wear) for ends, wear in rows if ends[1] > ends[0]]

    @property
    def jumps(self):
        """Radii of uniformly loaded discs of finite pressure, and these pressures times w."""
        discs = {1.0: 1 / self.intervals[-1][3]}
        for left, right in pairwise(self.intervals):
            discs[left[1]] = 1 / left[3] - 1 / right[2]
        if self.radii[0] > 0:
            discs[self.radii[0]] = -1 / self.intervals[0][2]
        return np.array(list(discs)), np.array(list(discs.values()))

    @cached_property
    def wear_rate(self):
        rows = [(interval, *quadrature(*interval)) for interval in self.intervals]
        areas = (2 * np.pi * np.sum(w * c / wear_in(interval, c)) for interval, c, w in rows)
        return 1 / sum(areas)

    def displacement(self, radii):
        """Return the displacement of the surface at radii."""
        return np.array([self._sum(radius, direct.disc_displacement) for radius in radii])

    def rms_slope(self, average="line"):
        """Return the root mean square slope of the face, over the radius or over its area."""
        square = 0.0
        for interval in self.intervals:
            radii, lengths = quadrature(*interval)
            slopes = np.array([self._sum(radius, direct.disc_slope) for radius in radii])
            square += lengths @ (slopes**2 * (1 if average == "line" else 2 * radii))
        hole = self.radii[0]
        return float(np.sqrt(square / (1 - (hole if average == "line" else hole**2))))

    def _sum(self, radius, of_disc):
        discs, pressures = self.jumps
        total = pressures @ of_disc(discs, radius)
        for interval in self.intervals:
            inner, outer, first, last = interval
            if first != last:
                c, lengths = quadrature(*interval, towards=radius)
                falls = (last - first) / (outer - inner) / wear_in(interval, c) ** 2
                total += lengths @ (falls * of_disc(c, radius))
        return self.wear_rate * total


def wear_in(interval, radii):
    """Return k at radii of an interval in which it is linear."""
    inner, outer, first, last = interval
    return first + (last - first) * (radii - inner) / (outer - inner)


def quadrature(inner, outer, first, last, towards=None):
    """Return Gauss points and weights of an interval in which k is linear."""
    width, count = outer - inner, int(np.ceil(abs(np.log(last / first)) / np.log(1.5)))
    points = [np.array([inner, outer])]
    if count > 1:
        wear = np.geomspace(first, last, count + 1)[1:-1]
        points.append(inner + width * (wear - first) / (last - first))
    distances = width * 0.3 ** np.arange(40.0)
    distances = distances[distances > 1e-14]
    for place in (inner, outer, towards):
        if place is not None and inner <= place <= outer:
            points += [place - distances, [place], place + distances]
    ends = np.unique(np.concatenate(points))
    ends = ends[(ends >= inner) & (ends <= outer)]
    node, weight = leggauss(12)
    half = np.diff(ends)[:, None] / 2
    return (ends[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()


def potentials(r, z, poisson_ratio, radius):
    """Return complex displacements (n, 2) and stresses rr, zz, rz, hoop (n, 4).

    Their imaginary parts are the fields under a flat punch of the given radius, with the force ``2
    pi radius`` and E* = 1. Sneddon, Boussinesq's problem for a flat-ended cylinder, Proc. Camb.
    Phil. Soc. 42 (1946), gives Hankel integrals with the transform ``sin(s)/(2 pi s)`` of the
    pressure. They are imaginary parts of Laplace transforms of ``J_0(sr)`` and ``J_1(sr)`` at ``z -
    i``, that is of functions such as ``1/R``, where R is the distance from a source at the complex
    depth i (for radius 1).
    """
    source = z - 1j * radius
    # the root with a positive real part; under the punch, where that is 0, the limit from below
    squared = r**2 + source**2
    under = (squared.imag == 0) & (squared.real < 0)
    distance = np.where(under, -1j * np.sqrt(np.abs(squared)), np.sqrt(squared))
    both = distance + source
    sides = (1 - 2 * poisson_ratio) / both - z / (distance * both)
    stress = np.stack(
        [
            -1 / distance + z * source / distance**3 + sides,
            -1 / distance - z * source / distance**3,
            -z * r / distance**3,
            -2 * poisson_ratio / distance - sides,
        ],
        axis=-1,
    )
    axial = -2 * (1 - poisson_ratio) * np.log(both) + z / distance
    return np.stack([-r * sides, axial], axis=-1) / (1 - poisson_ratio), stress


def flat_punch(r, z, poisson_ratio):
    """Return displacements and stresses under the flat punch, F = a = E* = 1, except at its rim."""
    return tuple(field.imag / (2 * np.pi) for field in potentials(r, z, poisson_ratio, 1.0))
