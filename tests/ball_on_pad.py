"""Press a ball on a layer bonded to a rigid base, by Fredholm's equation of the second kind.

The derivation and the formulas are independent of those of ringwear's methods. The line density phi
of the pressure, whose Hankel transform is ``int phi(t) cos(s t) dt``, satisfies on the contact
``0 < x < c``, with the plane strain modulus 1 (Lebedev and Ufliand, J. Appl. Math. Mech. 22, 1958,
442),

    phi(x) - 1/pi int (K(x - t) + K(x + t)) phi(t) dt = (d - g(x)) / pi,
    K(t) = int (1 - kernel(s h)) cos(s t) ds,   g(x) = x/2 log((R + x) / (R - x)),

where g is the profile of the ball in the method of dimensionality reduction. The indentation d
follows from phi(c) = 0. The force is ``2 pi int phi dt``, and the pressure at r is ``-int phi'(x) /
sqrt(x^2 - r^2) dx`` from r to c. Nystroem's method with Gauss's quadrature solves the equation.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from independent_layer import kernel
from layered_disc import gauss, wave_numbers
from scipy.optimize import brentq

POINTS = 24
"""Number of Gauss points on each panel."""


class Ball(NamedTuple):
    """Describe a ball on a bonded layer; the unit of length is arbitrary."""

    ball_radius: float
    thickness: float
    poisson_ratio: float
    compliance: Callable | None = None
    """Compliance to wave numbers relative to a half-space, in place of that of one layer."""


class Pressed(NamedTuple):
    """Contain what a contact radius requires, and the pressure at a radius."""

    normal_force: float
    contact_radius: float
    indentation: float
    pressure: float


def pressed_to(ball: Ball, contact_radius: float, radius: float) -> Pressed:
    """Return the force and the indentation at a contact radius, and the pressure at a radius."""
    panels = max(int(np.ceil(contact_radius / ball.thickness)), 4)
    edges = np.linspace(0.0, contact_radius, panels + 1)
    x, lengths = gauss(edges, POINTS)
    s, widths = wave_numbers(ball.thickness, 2 * contact_radius)
    one_layer = kernel(s * ball.thickness, ball.poisson_ratio)
    spectrum = widths * (1 - (ball.compliance(s) if ball.compliance else one_layer))
    cosines = np.cos(np.outer(x, s))
    added = 2 / np.pi * (cosines * spectrum) @ cosines.T * lengths
    profile, _ = _profile(x, ball.ball_radius)
    right = np.stack([np.ones_like(x), profile], axis=1) / np.pi
    unit, shape = np.linalg.solve(np.eye(len(x)) - added, right).T
    # phi = d unit - shape is zero at the edge of the contact
    at_edge = 2 / np.pi * (np.cos(contact_radius * s) * spectrum) @ cosines.T * lengths
    height, _ = _profile(np.array(contact_radius), ball.ball_radius)
    indentation = (height / np.pi + at_edge @ shape) / (1 / np.pi + at_edge @ unit)
    density = (indentation * unit - shape) * lengths
    # x^2 = r^2 + y^2, so that dx / sqrt(x^2 - r^2) = dy / x
    y, steps = gauss(edges * np.sqrt(1 - (radius / contact_radius) ** 2), POINTS)
    x = np.hypot(radius, y)
    _, slope = _profile(x, ball.ball_radius)
    derivative = slope + 2 * (np.sin(np.outer(x, s)) * s * spectrum) @ (cosines.T @ density)
    force, pressure = 2 * np.pi * density.sum(), (derivative / x) @ steps / np.pi
    return Pressed(float(force), contact_radius, float(indentation), float(pressure))


def pressed_by(ball: Ball, normal_force: float, radius: float) -> Pressed:
    """Return the contact under a force, and the pressure at a radius."""
    # on a half-space the contact is largest
    highest = 1.01 * (0.75 * normal_force * ball.ball_radius) ** (1 / 3)
    if ball.compliance:
        # to long waves, the ground is as compliant as its base
        highest *= max(float(ball.compliance(np.array([1e-6]))[0]), 1.0) ** (1 / 3)
    contact_radius = brentq(
        lambda trial: pressed_to(ball, trial, radius).normal_force - normal_force,
        1.01 * radius,
        highest,
        xtol=1e-14 * highest,
    )
    return pressed_to(ball, contact_radius, radius)


def _profile(x: np.ndarray, ball_radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return g(x), and its derivative."""
    logarithm = np.log((ball_radius + x) / (ball_radius - x)) / 2
    return x * logarithm, logarithm + x * ball_radius / (ball_radius**2 - x**2)
