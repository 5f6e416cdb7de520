"""Gauss-Legendre rules, computed once each."""

from __future__ import annotations

from functools import cache

import numpy as np

from ringwear.meshes.radial import Array


@cache
def gauss(count: int) -> tuple[Array, Array]:
    """Gauss points and weights on (-1, 1); not to be written to."""
    node, weight = np.polynomial.legendre.leggauss(count)
    return node, weight


def unit_gauss(count: int) -> tuple[Array, Array]:
    """Gauss points and weights on (0, 1), where singularities are substituted away at one end."""
    node, weight = gauss(count)
    return (1 + node) / 2, weight / 2
