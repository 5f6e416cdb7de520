"""Faces with closed forms: balls, truncated cones, rounded rims, dishes; two elastic bodies.

With the one-dimensional profile g of Eq. 3, ``d = g(c)`` and ``F = 2 int_0^c (d - g) dx``.
"""

import numpy as np
import pytest
from groups import nightly_but
from natural import natural
from scipy.integrate import quad
from scipy.optimize import brentq

from ringwear import run

FLAT = 0.3


def ball(x, radius=2.0):
    """Return the one-dimensional profile of Sneddon's ball, ``g = x artanh(x / R)``."""
    return x * np.arctanh(x / radius)


def truncated_cone(x, slope=0.2):
    return slope * x * np.arccos(FLAT / x) if x > FLAT else 0.0


def truncated_paraboloid(x, radius=1.5):
    return x * np.sqrt(x**2 - FLAT**2) / radius if x > FLAT else 0.0


def lightly_rounded(radius, mean_pressure):
    """Return a flat face whose edge is rounded over a width of twice the radius of the rounding.

    M. Ciavarella, Indentation by nominally flat or conical indenters with rounded corners, Int. J.
    Solids Struct. 36 (1999) 4149; first by G. Schubert, Ing.-Arch. 13 (1942) 132.
    """
    flat = 1 - 2 * radius

    def g(x):
        if x <= flat:
            return 0.0
        return x * (np.sqrt(x**2 - flat**2) - flat * np.arccos(flat / x)) / radius

    profile = {"kind": "rounded_rim", "flat_radius": flat, "curvature_radius": radius}
    return profile, g, flat, np.pi * mean_pressure


# profile of each kind of face, which may be a function, too; its one-dimensional profile, the
# radius at which that has a kink, and a force
PROFILES = {
    "ball": ({"kind": "ball", "ball_radius": 2.0}, ball, FLAT, 0.05),
    "truncated cone": (
        *({"kind": "truncated_cone", "flat_radius": FLAT, "slope": 0.2}, truncated_cone),
        *(FLAT, 0.05),
    ),
    "truncated paraboloid": (
        {"kind": "truncated_paraboloid", "flat_radius": FLAT, "curvature_radius": 1.5},
        *(truncated_paraboloid, FLAT, 0.05),
    ),
    "function, cone": (lambda r: 0.2 * np.maximum(r - FLAT, 0), truncated_cone, FLAT, 0.05),
    "function, paraboloid": (
        lambda r: np.maximum(r - FLAT, 0) * (r + FLAT) / (2 * 1.5),
        *(truncated_paraboloid, FLAT, 0.05),
    ),
    **{
        f"rounded by {radius} under {mean_pressure}": lightly_rounded(radius, mean_pressure)
        for radius in (0.003, 0.01, 0.03, 0.1)
        for mean_pressure in (1e-5, 1e-4, 1e-3)
    },
}
CHOSEN = (
    *("ball", "truncated cone", "function, paraboloid"),
    *("rounded by 0.01 under 0.0001", "rounded by 0.03 under 0.001"),
)


def pressed(profile, methods="mdr fem", force=0.05, rtol=1e-3, **changes):
    """Return a scene of a face that is a table of a scene or a function."""
    is_function = callable(profile)
    punch = {"wear_coefficient": 1.0} | ({} if is_function else {"profile": profile})
    scene = natural(punch, rtol=rtol, methods=methods, load={"normal_force": force})
    return (scene.with_heights(profile) if is_function else scene).changed(**changes)


@pytest.mark.slow
# without gmsh, the start of finite elements is as accurate as the march
@pytest.mark.gmsh
@pytest.mark.parametrize("name", nightly_but(CHOSEN, PROFILES))
def test_starts_against_closed_forms(name):
    profile, g, kink, force = PROFILES[name]

    def force_on(contact):
        accuracy = {"points": [min(kink, contact)], "epsabs": 0.0, "epsrel": 1e-11}
        area, _ = quad(lambda x: g(contact) - g(x), 0.0, contact, **accuracy)
        return 2 * area

    contact = brentq(lambda radius: force_on(radius) - force, 1e-3, 0.999, xtol=1e-14)
    result = run(pressed(profile, force=force))
    assert result.verdict == "agree"
    assert not any("the start cannot be fitted" in note for note in result.notes)
    for solver in ("mdr", "fem"):
        start = result.dataset.sel(solver=solver).isel(time=0)
        within = (1e-9 if solver == "mdr" else 1e-8) if kink == FLAT else 1e-6
        assert float(start.indentation) == pytest.approx(g(contact), rel=within)
        assert float(start.contact_radius) == pytest.approx(contact, rel=1e-6)


@pytest.mark.parametrize(("part", "full"), [(1.001, True), (0.9, False)])
def test_a_dish_is_in_full_contact_above_barbers_force(part, full):
    """Barber: contact is full for ``F >= 16/3 E* a h``; ``d = h + (F - 4/3 E* a h) / (2 a E*)``."""
    depth = 0.1
    force = part * 16 / 3 * depth
    dish = {"kind": "concave", "depth": depth}
    start = run(pressed(dish, "mdr", force, 1e-4)).dataset.isel(solver=0, time=0)
    touches = bool((start.contact[:-1] > 0).all())
    assert touches == full
    if full:
        exact = depth + force / 2 - 2 * depth / 3
        assert float(start.indentation) == pytest.approx(exact, rel=1e-4)


def test_two_elastic_bodies_have_a_combined_modulus():
    """Compliances add up: ``1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2``."""
    both = {"youngs_modulus": 2.0, "punch_youngs_modulus": 3.0, "punch_poisson_ratio": 0.2}
    modulus = 1 / ((1 - 0.3**2) / 2.0 + (1 - 0.2**2) / 3.0)
    flat = natural({"wear_coefficient": 1.0}, rtol=1e-6, methods="mdr", half_space=both)
    result = run(flat)
    assert float(result.dataset.indentation[0, 0]) == pytest.approx(0.5 / modulus, rel=1e-8)
    assert any(line.startswith("two elastic bodies") for line in result.summary["modelled"])


@pytest.mark.slow
@pytest.mark.gmsh
def test_the_inside_extends_to_the_output_depth(tmp_path):
    """Displacements are continuous at the end of the mesh; far away, a point force's."""
    import meshio

    punch = {"radius": 1.0, "wear_coefficient": 1.0}
    scene = pressed(PROFILES["ball"][0], "fem", 1.0, 1e-4, punch=punch, output__depth=60.0)
    run(scene).save(tmp_path / "out")
    mesh = meshio.read(tmp_path / "out" / "half_space.vtu")
    radius, height, _ = mesh.points.T
    moved = mesh.point_data["displacement t=0"][:, 1]
    distance = np.hypot(radius, height)
    assert distance.max() == pytest.approx(60.0)
    at_edge = np.flatnonzero(np.abs(distance - 2.5) < 1e-9)
    order = np.argsort(radius[at_edge])
    near, values = radius[at_edge][order], moved[at_edge][order]
    together = np.flatnonzero(np.diff(near) < 1e-9)
    assert len(together) > 3
    assert np.abs(np.diff(values)[together]).max() <= 1e-4 * np.abs(moved).max()
    deepest = np.argmin(height)
    shear = (1 - 0.3) / 2  # of plane strain modulus 1
    point_force = (2 * (1 - 0.3) + 1) / (4 * np.pi * shear * 60.0)
    assert -moved[deepest] == pytest.approx(point_force, rel=1e-3)
