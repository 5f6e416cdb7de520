"""Displacements and stresses inside the half-space against closed forms, on all elements."""

from functools import cache
from itertools import product

import numpy as np
import pytest
from closed_forms import flat_punch, potentials
from groups import nightly, slow
from matplotlib.text import Text
from scipy.spatial import ConvexHull

from ringwear import Scene, run

# indentation and mean pressure under the flat punch, F = a = E* = 1
DEPTH, MEAN = 1 / 2, 1 / np.pi
# distance from edges, in radii of the contact, within which stresses have no error estimate
NEAR = 0.2
MESHERS = [*(pytest.param(name, marks=pytest.mark.gmsh) for name in ("quads", "gmsh")), "bisection"]


def round_face(r, z, poisson_ratio, contact, depth_rate):
    """Return displacements and stresses under a face in contact on a disc, E* = 1.

    The contact is a sum of flat punches: the radius x adds the depth ``g'(x) dx`` and the force ``2
    x g'(x) dx`` (Popov and Hess, Method of Dimensionality Reduction, chapter 3). The path of
    integration is a half circle of complex radii, which avoids the singular rims of these punches.
    `depth_rate` is g', the slope of the one-dimensional profile.
    """
    node, weight = np.polynomial.legendre.leggauss(60)
    turned = np.exp(1j * np.pi * (1 - node) / 2)
    radii, steps = contact * (1 + turned) / 2, -1j * np.pi * contact * turned / 4 * weight
    fields = [
        [
            depth_rate(radius) * step / np.pi * field
            for field in potentials(r, z, poisson_ratio, radius)
        ]
        for radius, step in zip(radii, steps, strict=True)
    ]
    return (sum(parts).imag for parts in zip(*fields, strict=True))


def sphere(r, z, poisson_ratio, contact):
    """Return the fields under a sphere ``r^2 / 2``, for which ``g = x^2``."""
    return round_face(r, z, poisson_ratio, contact, lambda x: 2 * x)


def cone(r, z, poisson_ratio, contact):
    """Return the fields under a cone ``f = r``, for which ``g = pi x / 2``."""
    return round_face(r, z, poisson_ratio, contact, lambda _: np.pi / 2)


def half_space_under(scene):
    """Return the fields inside for a scene."""
    return run(scene, methods=["fem"]).inside()


def von_mises(stress):
    """Return the von Mises stress (n,) from stresses rr, zz, rz, hoop (n, 4)."""
    rr, zz, rz, hoop = stress.T
    differences = (rr - zz) ** 2 + (zz - hoop) ** 2 + (hoop - rr) ** 2
    return np.sqrt(differences / 2 + 3 * rz**2)


@cache
def inside(poisson_ratio, rtol=1e-4, **fem):
    """Return the fields inside under the flat punch at t = 0, and their true errors."""
    scene = Scene.load("flat_punch").changed(
        half_space__poisson_ratio=poisson_ratio,
        wear__times=[0.0],
        accuracy={"rtol": rtol, "fem": fem},
    )
    fields = half_space_under(scene)
    r, z = fields.points
    far = np.hypot(r - 1, z) > NEAR
    assert (r[far] == 0).any()
    assert (z[far] == 0).any()
    exact = flat_punch(r[far], z[far], poisson_ratio)
    return fields, true_errors(fields, far, exact, DEPTH, MEAN)


def true_errors(fields, far, exact, indentation, mean_pressure):
    """Return the greatest errors at the start, relative to the scales of their estimates."""
    moved, stress = exact
    parts = {
        "displacement": (moved, indentation),
        "stress": (stress, mean_pressure),
        "von_mises": (von_mises(stress), mean_pressure),
    }
    return {
        name: float(np.abs(getattr(fields, name)[0, far] - values).max() / scale)
        for name, (values, scale) in parts.items()
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("face", "force", "poisson_ratio"),
    [
        *((sphere, 1e-4, 0.3), (sphere, 0.3, 0.5), (cone, 0.3, 0.3)),
        *nightly((sphere, 0.3, 0.0), (sphere, 0.3, 0.3), (cone, 0.3, 0.0)),
    ],
)
def test_stresses_under_round_faces(face, force, poisson_ratio):
    """Errors, except near edges and at the tip of a cone, are below the estimates."""
    contact = (3 * force / 4) ** (1 / 3) if face is sphere else (2 * force / np.pi) ** 0.5
    scene = Scene.load("sphere").changed(
        load__normal_force=force,
        half_space__poisson_ratio=poisson_ratio,
        output__field_times=[0.0],
        wear__times=[0.0],
    )
    if face is cone:
        scene = scene.changed(punch__profile={"kind": "cone", "slope": 1.0})
    fields = half_space_under(scene)
    assert fields.labels == ("t=0", "steady")
    assert fields.reach[0] == pytest.approx(contact, rel=0.02)
    assert fields.creases.tolist() == [0.0] * (face is cone)
    r, z = fields.points
    far = (np.hypot(r - contact, z) > NEAR * contact) & (np.hypot(r - 1, z) > NEAR * contact)
    # stresses are singular at a tip, and no estimate is valid there
    far &= (face is sphere) | (np.hypot(r, z) > NEAR * contact)
    exact = (part / force for part in face(r[far], z[far], poisson_ratio, contact))
    errors = true_errors(fields, far, exact, 1 / (2 * contact), 1 / (np.pi * contact**2))
    assert errors["stress"] < (2e-2 if poisson_ratio == 0.5 else 1e-3)
    assert face is sphere or fields.errors["stress"][0] < 0.02
    # at nu = 0.5, the estimate compares with a degree that locks and is therefore larger
    assert_estimated(fields, errors, most=100 if poisson_ratio == 0.5 else 50)


@pytest.mark.parametrize(
    ("profile", "creases"),
    [
        ({"kind": "cone", "slope": 1e-3}, [0.0]),
        ({"kind": "truncated_cone", "flat_radius": 0.2, "slope": 0.5}, [0.2]),
        ({"kind": "rounded_rim", "flat_radius": 0.2, "curvature_radius": 3.0}, []),
        ({"kind": "power", "coefficient": 1.0, "exponent": 1.0}, [0.0]),
        ({"kind": "power", "coefficient": 1.0, "exponent": 2.5}, []),
        ({"kind": "table", "radii": [0, 0.3, 0.4, 1.0], "heights": [0, 0.1, 0.5, 0.6]}, []),
    ],
    ids=str,
)
def test_creases_are_radii_at_which_the_slope_jumps(profile, creases):
    problem = Scene.load("sphere").changed(punch__profile=profile).problem
    assert problem.profile.creases == pytest.approx(creases)


def test_creases_of_functions_are_found():
    scene = Scene.load("flat_punch").with_heights(lambda radii: np.maximum(radii - 0.37, 0))
    assert scene.problem.profile.creases == pytest.approx([0.37], abs=1e-6)


def test_the_singular_stresses_at_a_tip_are_said_in_the_scope_and_below_the_figure():
    scene = Scene.load("cone").changed(methods=["fem"], wear__times=[0.0], wear__steady=False)
    result = run(scene)
    reason = result.summary["left_out"]["errors of stresses near r = 0"]
    assert "singular" in reason
    figure = result.plot("stress")
    texts = [text.get_text() for text in figure.findobj(Text)]
    assert any("tip" in text and "singular" in text for text in texts)
    # the title of the panel states the error
    (title,) = [text for text in texts if "errors up to" in text]
    assert float(title.split("errors up to ")[1].split(" %")[0]) < 5


@pytest.mark.slow
def test_stresses_under_a_worn_sphere_carry_the_pressure_of_mdr():
    scene = Scene.load("sphere").changed(wear__times=[0.0, 3.0], output__field_times=[3.0])
    result = run(scene, methods=["mdr", "fem"])
    mdr, fields = result.solutions["mdr"], result.inside()
    (r, z), edge = fields.points, float(mdr.results["contact_radius"][1])
    far = (z == 0) & (np.abs(r - edge) > NEAR * edge) & (np.abs(r - 1) > NEAR * edge)
    expected = np.interp(r[far], scene.problem.face.radii, mdr.compared["pressure"][1])
    missed = np.abs(fields.stress[0, far, 1] + expected).max() / (MEAN / edge**2)
    assert missed < fields.errors["stress"][0] < 0.1


def assert_estimated(fields, errors, least=1.0, most=50):
    for name, error in errors.items():
        assert least * error <= fields.errors[name][0] <= most * error


@pytest.mark.gmsh
@pytest.mark.parametrize(
    ("rtol", "poisson_ratio"),
    [
        *((1e-2, 0.3), (1e-4, 0.0), (1e-4, 0.3)),
        *slow((1e-2, 0.5), (1e-6, 0.49)),
        *nightly((1e-4, 0.49), *product((1e-6,), (0.0, 0.3, 0.5))),
    ],
)
def test_stresses_under_the_flat_punch(rtol, poisson_ratio):
    """Errors, except near the rim, are at most 10 rtol of the mean pressure and the estimates."""
    fields, errors = inside(poisson_ratio, rtol)
    assert fields.errors["stress"][0] <= 10 * rtol
    assert errors["stress"] <= 10 * rtol
    assert_estimated(fields, errors)


@pytest.mark.slow
@pytest.mark.gmsh
@pytest.mark.parametrize(
    ("fem", "poisson_ratio", "least", "most"),
    [
        *(({"mesher": of}, ratio, 1, 50) for of in ("gmsh", "bisection") for ratio in (0.3, 0.5)),
        *nightly(*(({"mesher": of}, 0.0, 1, 50) for of in ("gmsh", "bisection"))),
        # the mesh is refined, and the displacement is more accurate than its estimate shows
        *nightly(*(({"mesher": of}, 0.49, 1, 80) for of in ("gmsh", "bisection"))),
        ({"far_field": "fixed"}, 0.3, 0.95, 50),
        *(({"poles": count}, 0.3, 1, 50) for count in (1, 2)),
    ],
    ids=str,
)
def test_estimates_bound_stress_errors_of_other_elements(fem, poisson_ratio, least, most):
    """Triangles have their highest degree already; a user may choose the truncation."""
    fields, errors = inside(poisson_ratio, **fem)
    assert errors["stress"] > 1e-3 or "mesher" in fem
    assert_estimated(fields, errors, least, most)


@pytest.mark.gmsh
def test_a_given_degree_is_used_inside():
    assert inside(0.3, degree=5)[0].degree == 5


@pytest.mark.parametrize("mesher", MESHERS)
def test_samples_fill_the_half_space_and_agree_on_facets(mesher):
    fields, _ = inside(0.3, mesher=mesher)
    points, moved = fields.points, fields.displacement[0]
    corner, *others = points[:, fields.triangles].transpose(1, 0, 2)
    (r1, z1), (r2, z2) = (other - corner for other in others)
    sizes = np.abs(r1 * z2 - r2 * z1) / 2
    assert sizes.min() > 0
    # the samples fill a convex polygon
    assert sizes.sum() == pytest.approx(ConvexHull(points.T).volume, rel=1e-12)
    # points on facets belong to both elements, of different degrees: the displacement is one
    off_rim = np.flatnonzero(np.hypot(points[0] - 1, points[1]) > 1e-3)
    place = np.round(points[:, off_rim].T, 9)
    _, first, same = np.unique(place, axis=0, return_index=True, return_inverse=True)
    assert len(first) < 0.9 * len(place)
    np.testing.assert_allclose(moved[off_rim], moved[off_rim[first]][same], atol=1e-7)
