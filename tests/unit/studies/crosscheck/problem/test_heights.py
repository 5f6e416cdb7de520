"""Heights of every kind of profile, by formulas of their own, and errors of heights.

Anchors read the scale of heights a second time, but evaluate the same functions.
"""

import numpy as np
import pytest
from natural import natural
from scipy.interpolate import pchip_interpolate

from ringwear.studies.crosscheck.problem.fields import KINDS, ProfileSection
from ringwear.studies.crosscheck.problem.quantities import QUANTITIES

RADIUS = 1.5
POINTS = {"radii": [0.0, 0.3, 0.35, 1.0, 1.5], "heights": [0.1, 0.0, 0.2, 0.2, 0.7]}


def integral(radii, slope):
    """Return the integral of a slope from the axis, by a fine midpoint rule."""
    grid = np.linspace(0.0, RADIUS, 300_001)
    parts = np.diff(grid) * slope((grid[1:] + grid[:-1]) / 2)
    return np.interp(radii, grid, np.append(0.0, np.cumsum(parts)))


# for each kind: its keys, and its heights over the radius, most of them as integrals of slopes
FORMULAS = {
    "parabola": ({"curvature_radius": 4.0}, lambda r: integral(r, lambda x: x / 4.0)),
    "ball": ({"ball_radius": 2.0}, lambda r: 4.0 * np.sin(np.arcsin(r / 2.0) / 2) ** 2),
    "cone": ({"slope": 0.2}, lambda r: integral(r, lambda x: np.full(x.shape, 0.2))),
    "truncated_cone": (
        {"slope": 0.2, "flat_radius": 0.5},
        lambda r: integral(r, lambda x: np.where(x > 0.5, 0.2, 0.0)),
    ),
    "truncated_paraboloid": (
        {"curvature_radius": 4.0, "flat_radius": 0.5},
        lambda r: integral(r, lambda x: np.where(x > 0.5, x / 4.0, 0.0)),
    ),
    "concave": ({"depth": 0.3}, lambda r: 0.3 - integral(r, lambda x: 0.6 * x / RADIUS**2)),
    "power": (
        {"coefficient": 0.3, "exponent": 3.5},
        lambda r: integral(r, lambda x: 0.3 * 3.5 * x**2.5 / RADIUS**3.5),
    ),
    "rounded_rim": (
        {"flat_radius": 0.5, "curvature_radius": 4.0},
        lambda r: integral(r, lambda x: np.maximum(x - 0.5, 0.0) / 4.0),
    ),
    "table": (POINTS, lambda r: pchip_interpolate(POINTS["radii"], POINTS["heights"], r)),
}


def test_every_kind_has_a_formula():
    kinds = {name for name, section in KINDS.items() if issubclass(section, ProfileSection)}
    assert kinds == FORMULAS.keys()


@pytest.mark.parametrize("kind", FORMULAS)
def test_heights(kind):
    keys, formula = FORMULAS[kind]
    radii = np.linspace(0.0, RADIUS, 1001)
    heights = KINDS[kind](kind=kind, **keys).height_over(RADIUS)(radii)
    np.testing.assert_allclose(heights, formula(radii), atol=1e-9 * heights.max())


@pytest.mark.parametrize("plane", [0.0, 3.0])
@pytest.mark.parametrize("face", ["face", "sampled_face"])
def test_errors_of_heights_count_from_the_first_touch(plane, face):
    """An error of a tenth of each depth, wherever the plane of the face is.

    Even wear of 5 and the rest of the depth, 2, have this error, too.
    """
    problem = natural({"wear_coefficient": 1.0, "recess": [plane]}).problem
    face = problem.face if face == "face" else problem.sampled_face(np.linspace(0, 1, 9))
    depth, even_wear = np.array([1.0, 2.0]), np.array([0.0, 5.0])
    reference = {"indentation": plane + depth + even_wear, "depth": depth, "even_wear": even_wear}
    theirs = {"indentation": plane + 1.1 * (depth + even_wear)}
    errors = QUANTITIES["indentation"].difference(theirs, reference, face)
    np.testing.assert_allclose(errors, 0.1, rtol=1e-12)
