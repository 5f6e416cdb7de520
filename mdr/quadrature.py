"""Gauss-Legendre on (0, 1), where singularities are substituted away at one end."""

from __future__ import annotations

import numpy as np

from meshes.radial import Array


def unit_gauss(count: int) -> tuple[Array, Array]:
    """Gauss points and weights on (0, 1)."""
    node, weight = np.polynomial.legendre.leggauss(count)
    return (1 + node) / 2, weight / 2
